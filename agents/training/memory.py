"""How much memory there is, asked before much of it is taken."""

from __future__ import annotations

import os
from pathlib import Path

import torch

from ltlc.errors import MemoryLimitExceeded

_CONTROL_GROUP = Path("/sys/fs/cgroup")
_KERNEL = Path("/proc/meminfo")


def check_memory(what: str, needed: int, device: str, advice: str, allowed: float | None = None) -> None:
    """Check that something fits before it is allocated.

    Args:
        what: it is, for the message.
        needed: bytes.
        device: where it is to live.
        advice: what to do where it does not fit.
        allowed: gigabytes; None: what is free on the device.

    Raises:
        MemoryLimitExceeded: it does not.
    """
    limit = free_memory(device) if allowed is None else int(allowed * 1e9)
    if limit is not None and needed > limit:
        whose = f"are free on {device}" if allowed is None else "are allowed (max_memory)"
        raise MemoryLimitExceeded(f"{what} would take {size_text(needed)}, and {size_text(limit)} {whose}; {advice}")


def free_memory(device: str) -> int | None:
    """Bytes that can be taken on a device without driving anything out; None where the system does not say."""
    if torch.device(device).type == "cuda":
        return int(torch.cuda.mem_get_info(device)[0])
    if torch.device(device).type != "cpu":
        return None
    found = [free for free in (_of_control_group(), _of_kernel()) if free is not None]
    if found:
        return min(found)
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def size_text(size: float) -> str:
    """Bytes for a person, in powers of 1000."""
    for unit in ("bytes", "kB", "MB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:,.1f} GB"


def _of_control_group() -> int | None:
    """What the control group of a container leaves; file pages that can be dropped count as free."""
    try:
        limit, used = ((_CONTROL_GROUP / f"memory.{name}").read_text() for name in ("max", "current"))
        cached = dict(line.split() for line in (_CONTROL_GROUP / "memory.stat").read_text().splitlines())
        return int(limit) - int(used) + int(cached.get("inactive_file", 0))
    except (OSError, ValueError):  # no such group, or its limit is "max"
        return None


def _of_kernel() -> int | None:
    try:
        rows = dict(line.split(":", 1) for line in _KERNEL.read_text().splitlines())
        return int(rows["MemAvailable"].split()[0]) * 1024
    except (OSError, ValueError, KeyError, IndexError):
        return None
