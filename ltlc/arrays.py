"""Arrays of numpy, which is imported when the first one is made: `ltlc compile` of a small formula needs none.

Modules below this one say `from ltlc.arrays import np`; what they define when they are imported must not use it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int32]
    BoolArray = npt.NDArray[np.bool_]
    Numbers = list[int] | IntArray
else:

    class _OnFirstUse:
        """Stands for a module; what has been asked for once is an attribute of its own, and found as quickly."""

        def __init__(self, name: str) -> None:
            self._name = name

        def __getattr__(self, name: str) -> object:
            value = getattr(import_module(self._name), name)
            setattr(self, name, value)
            return value

    np, npt = _OnFirstUse("numpy"), _OnFirstUse("numpy.typing")
    IntArray = BoolArray = Numbers = Any

__all__ = ["BoolArray", "IntArray", "Numbers", "np", "npt"]
