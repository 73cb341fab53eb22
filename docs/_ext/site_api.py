"""The reference of the Python interface: a page for each package, from what it exports and the docstrings of that."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import ltlc

ROOT = Path(ltlc.__file__).parents[1]
PACKAGES = sorted(
    f"ltlc.{path.parent.name}"
    for path in [*ROOT.glob("ltlc/*/__init__.py"), *ROOT.glob("agents/__init__.py")]
    if path.parent.name != "cli"  # has its own pages
)
MODULES = ("ltlc.errors", "ltlc.faithful", "ltlc.registry", "ltlc.judging.reasons")
"""whose public names are meant for users, and which no package exports."""


def exports() -> dict[str, dict[str, object]]:
    """What each page describes: by package or module, its names and their objects; each object once."""
    modules = {name: importlib.import_module(name) for name in dict.fromkeys((*PACKAGES, *MODULES))}
    offered = {name: _names(module) for name, module in modules.items()}
    found: dict[str, dict[str, object]] = {name: {} for name in ("ltlc", *offered) if name == "ltlc" or offered[name]}
    taken: set[int] = set()
    for own in (True, False):  # first where the code of an object is, then wherever it is exported
        for package, names in offered.items():
            for name in names:
                part = getattr(modules[package], name)
                home = getattr(part, "__module__", None) or package
                if id(part) not in taken and (not own or home.startswith(package)):
                    taken.add(id(part))
                    found[package][name] = part
    found["ltlc"] = {
        n: getattr(ltlc, n) for n in ltlc.__all__ if id(getattr(ltlc, n)) not in taken and n != "__version__"
    }
    return {package: names for package, names in found.items() if names}


def _names(module: ModuleType) -> list[str]:
    if hasattr(module, "__all__"):
        return list(module.__all__)
    here = module.__name__
    return [n for n, part in vars(module).items() if n[0] != "_" and getattr(part, "__module__", None) == here]


def api_pages() -> Iterator[tuple[str, str]]:
    """Every page of the Python interface: its path, and its text."""
    pages = exports()
    home = {id(part): f"{package}.{name}" for package, names in pages.items() for name, part in names.items()}
    rows = [
        f"| {{py:obj}}`~{home[id(part)]}` | {summary(part)} |"
        for part in (getattr(ltlc, name) for name in ltlc.__all__ if name != "__version__")
    ]
    yield (
        "api/index.md",
        "\n".join(
            [
                "# Python interface",
                "\n`import ltlc` offers the names below, each imported when it is first used. The pages of the "
                "packages hold these and all others for users. [Examples of every name](../../examples.md) run as "
                "tests.\n",
                "| name | what it is or does |",
                "|---|---|",
                *rows,
                "\n```{toctree}\n:hidden:",
                *pages,
                "```",
                "\n| page | holds |",
                "|---|---|",
                *(f"| [{package}]({package}.md) | {_heading(package)} |" for package in pages),
                "",
            ]
        ),
    )
    for package, names in pages.items():
        parts = [f"# {package}\n\n{_heading(package)}\n\n```{{eval-rst}}"]
        parts += [f".. {_directive(names[name])}:: {package}.{name}\n" for name in sorted(names, key=str.lower)]
        yield f"api/{package}.md", "\n".join([*parts, "```\n"])


def _heading(package: str) -> str:
    return (importlib.import_module(package).__doc__ or "").strip().partition("\n")[0].replace("|", "\\|")


def _directive(part: object) -> str:
    if inspect.isclass(part):
        return "autoexception" if issubclass(part, BaseException) else "autoclass"
    return "autofunction" if inspect.isroutine(part) else "autodata"


def summary(part: object) -> str:
    """The first line of a docstring, for a cell of a table."""
    return (inspect.getdoc(part) or "").partition("\n")[0].replace("|", "\\|")
