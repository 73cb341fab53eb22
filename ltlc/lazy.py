"""Packages whose names are imported on first use (PEP 562): a program loads what it needs, and no more."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec


def on_first_use(package: str, homes: Mapping[str, str]) -> Callable[[str], object]:
    """Make the `__getattr__` of a package.

    A name that is also that of a module of the package must not be among them: once anything has imported the module,
    it would be the value of the name.

    Args:
        package: its `__name__`.
        homes: the module of each name, absolute, or relative to the package.
    """

    def get(name: str) -> object:
        if name not in homes:
            # a module is an attribute, whether or not anything has imported it yet
            if not name.startswith("_") and find_spec(f"{package}.{name}") is not None:
                return import_module(f"{package}.{name}")
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value: object = getattr(import_module(homes[name], package), name)
        setattr(sys.modules[package], name, value)
        return value

    return get
