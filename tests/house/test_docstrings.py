"""What `help()` tells of the public names."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ["ltlc", *sorted(f"ltlc.{path.parent.name}" for path in ROOT.glob("ltlc/*/__init__.py"))]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
DOCUMENTS = [path for path in DOCUMENTS if "generated" not in path.parts]  # by a build of the site


def public() -> dict[str, Any]:
    """The classes and functions that packages offer, each by its first address."""
    found = {}
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in getattr(module, "__all__", ()):
            part = getattr(module, name)
            if getattr(part, "__module__", "").startswith("ltlc") and part not in found.values():
                found[f"{package}.{name}"] = part
    return found


PUBLIC = public()


@pytest.mark.parametrize("name", [name for name, part in PUBLIC.items() if dataclasses.is_dataclass(part)])
def test_fields_are_described(name: str) -> None:
    texts = [inspect.cleandoc(base.__doc__ or "") for base in PUBLIC[name].__mro__ if base is not object]
    described = re.findall(r"(?m)^    (\w+(?:, \w+)*): \S", "\n".join(texts))
    assert {field.name for field in dataclasses.fields(PUBLIC[name])} <= set(", ".join(described).split(", "))


def test_every_public_name_has_an_example() -> None:
    # In its own docstring, or in a document, where examples are run.
    blocks = [
        block
        for path in DOCUMENTS
        for block in re.findall(r"(?ms)^```(?:pycon|python)\n(.*?)^```", path.read_text(encoding="utf-8"))
    ]
    shown = set(re.findall(r"\w+", "\n".join(blocks)))
    assert not [
        name for name, part in PUBLIC.items() if ">>>" not in (part.__doc__ or "") and name.split(".")[-1] not in shown
    ]


@pytest.mark.parametrize("package", PACKAGES[1:])
def test_packages_say_where_examples_are(package: str) -> None:
    module = importlib.import_module(package)
    assert not getattr(module, "__all__", ()) or "docs/examples.md" in (module.__doc__ or "")
