"""Devices that PyTorch can use here."""

from __future__ import annotations

import torch

from ltlc.errors import InvalidArgumentError


def available(device: str) -> bool:
    """Whether there are numbers on a device; on one like `meta` there are none."""
    try:
        torch.zeros(1, device=device).item()
    except (RuntimeError, AssertionError):
        return False
    return True


def check_device(device: str) -> None:
    """Check that a device can be used.

    Raises:
        InvalidArgumentError: it cannot.
    """
    if not available(device):
        raise InvalidArgumentError(f'PyTorch cannot use the device {device!r} on this machine; try device="cpu"')
