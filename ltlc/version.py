"""The version of the package and how it was built; the build reads it without importing the rest."""

__version__ = "0.1.0"


def is_compiled() -> bool:
    """Whether the hot modules of this installation are compiled; a wheel is pure Python unless built otherwise."""
    from importlib.machinery import ExtensionFileLoader
    from importlib.util import find_spec

    spec = find_spec("ltlc.graph")
    return spec is not None and isinstance(spec.loader, ExtensionFileLoader)
