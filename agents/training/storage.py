"""Files of tensors and plain values: complete or not there, checked when read, and never executed."""

from __future__ import annotations

import hashlib
import io
import os
import sys
import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import spaces

from ltlc.atomic import atomic_write
from ltlc.errors import FileFormatError
from ltlc.graph import bits
from ltlc.rewards import RewardTables

from .contents import Content, check_plain

CHECKPOINT_FILE = "checkpoint.ltlc"
POLICY_FILE = "policy.ltlc"
_MAGIC = "ltlc"
_VERSION = 1


def write_file(path: str | os.PathLike[str], kind: str, content: dict[str, Any], run: str = "") -> Path:
    """Write nested dicts, lists, tensors, numbers and texts, with a checksum; equal contents give the same bytes.

    Args:
        path: of the file.
        kind: what it holds, a word.
        content: what it holds.
        run: identity of the training run that it belongs to, a word; empty: of none.

    Raises:
        OSError: the folder is missing, not writable or full; an older file is as it was.
    """
    stream = io.BytesIO()  # the only copy of what may be gigabytes: the checksum in its head is filled in afterwards
    head = f"{_MAGIC} {kind} {_VERSION} {{}} {run}".rstrip() + "\n"
    start = stream.write(head.format(_checksum(b"", run)).encode("ascii"))
    torch.save(_canonical(content), stream)
    whole = stream.getbuffer()
    whole[:start] = head.format(_checksum(whole[start:], run)).encode("ascii")
    try:
        return atomic_write(path, whole)
    except OSError as error:
        what = f"cannot write the {kind} ({error.strerror}); what was there before is unharmed"
        raise OSError(error.errno, what, os.fspath(path)) from error


def run_of(path: str | os.PathLike[str]) -> str:
    """The identity of the run that a file was written for; empty where there is none.

    Raises:
        FileFormatError: the file is damaged, or not one of `write_file`.
        OSError: the file is missing or not readable.
    """
    with Path(path).open("rb") as stream:
        words = stream.readline(500).decode("ascii", "replace").split()
    if words[:1] != [_MAGIC] or len(words) not in (4, 5):
        raise FileFormatError(f"{os.fspath(path)}: this is not a file of ltlc, or its first line is damaged")
    return "".join(words[4:])


def read_file(path: str | os.PathLike[str], kind: str) -> Content:
    """Read what `write_file` wrote; tensors come to the CPU, and nothing in the file is executed.

    Raises:
        FileFormatError: the file is damaged, of another kind or of a later version, or holds something else than plain
            values and tensors.
        OSError: the file is missing or not readable.
    """
    head, _, payload = Path(path).read_bytes().partition(b"\n")
    words = head.decode("ascii", "replace").split()
    if len(words) not in (4, 5) or words[0] != _MAGIC or words[1] != kind:
        raise FileFormatError(f"{os.fspath(path)}: this is not a {kind} file of ltlc, or its first line is damaged")
    if words[2] != str(_VERSION):
        raise FileFormatError(f"{os.fspath(path)}: {kind} of format {words[2]}; this version reads format {_VERSION}")
    if _checksum(payload, "".join(words[4:])) != words[3]:
        raise FileFormatError(
            f"{os.fspath(path)}: the {kind} is damaged (its checksum does not fit, {len(payload)} bytes); "
            "restore it from a backup, or start again"
        )
    try:
        with zipfile.ZipFile(io.BytesIO(payload)) as archive:
            if sum(part.file_size for part in archive.infolist()) > len(payload):
                raise FileFormatError("it unpacks to more than it is")
        content = torch.load(io.BytesIO(payload), map_location="cpu", weights_only=True)
    except MemoryError:
        raise
    except Exception as error:  # PyTorch promises none in particular; nothing was executed
        reason = str(error).partition("\n")[0][:200]
        raise FileFormatError(f"{os.fspath(path)}: the {kind} was not written by ltlc: {reason}") from None
    return check_plain(content, os.fspath(path), len(payload))


def _canonical(value: Any) -> Any:
    """The same value with every text there once: pickle writes equal texts in other bytes than a text met again."""
    match value:
        case dict():
            return {_canonical(key): _canonical(entry) for key, entry in value.items()}
        case list():
            return [_canonical(entry) for entry in value]
        case tuple():
            return tuple(_canonical(entry) for entry in value)
        case str():
            return sys.intern(str(value))
    return value


def _checksum(payload: bytes | memoryview, run: str) -> str:
    digest = hashlib.sha256(run.encode("utf-8"))
    digest.update(payload)
    return digest.hexdigest()


def tables_to_tensors(tables: RewardTables) -> dict[str, Any]:
    """Reward tables as values that `write_file` takes; `contents.tables_of` is the inverse."""
    values = {field.name: getattr(tables, field.name) for field in fields(tables)}
    if tables.possible is not None:
        values["possible"] = [[bits(mask) for mask in part] for part in tables.possible]
    return {
        name: torch.from_numpy(value.copy()) if isinstance(value, np.ndarray) else value
        for name, value in values.items()
    }


def same_tables(one: RewardTables, other: RewardTables) -> bool:
    """Whether two tables agree in every entry."""
    names = [field.name for field in fields(one) if field.name != "possible"]
    return one.possible == other.possible and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in names
    )


def plain_space(space: spaces.Space[Any]) -> dict[str, Any]:
    """A space the agent can take, as values that `write_file` takes; `contents.space_of` is the inverse."""
    match space:
        case spaces.Discrete():
            return {"kind": "Discrete", "n": int(space.n), "start": int(space.start)}
        case spaces.MultiDiscrete():
            return {"kind": "MultiDiscrete", "nvec": space.nvec.tolist(), "start": space.start.tolist()}
        case spaces.MultiBinary():
            return {"kind": "MultiBinary", "n": space.n if isinstance(space.n, int) else list(space.n)}
        case spaces.Box():
            bounds = {"low": torch.from_numpy(space.low.copy()), "high": torch.from_numpy(space.high.copy())}
            return {"kind": "Box", "dtype": np.dtype(space.dtype).name, **bounds}
        case spaces.Text():
            return {"kind": "Text"}
        case spaces.Dict():
            return {"kind": "Dict", "parts": {key: plain_space(part) for key, part in space.spaces.items()}}
        case spaces.Tuple():
            return {"kind": "Tuple", "parts": [plain_space(part) for part in space.spaces]}
    raise TypeError(space)  # the encoder has refused it
