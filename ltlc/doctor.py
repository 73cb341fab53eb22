"""What of ltlc works here: versions, packages that are needed, extras, and programs that it can use."""

from __future__ import annotations

import importlib
import platform
import re
import shutil
import sys
import warnings
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from importlib import metadata
from typing import Any, Literal

from ltlc.version import __version__, is_compiled

State = Literal["ok", "missing", "old", "broken"]

PROGRAMS = {
    "dot": (
        "pictures of automata",
        "install Graphviz: apt install graphviz, brew install graphviz, choco install graphviz",
    ),
    "storm": ("a second opinion on exact answers", "see stormchecker.org; the package stormpy does as well"),
    "prism": ("a second opinion on exact answers", "see prismmodelchecker.org"),
}
"""what programs are for, and where they come from; none of them is needed."""
EXTRAS = {
    "pictures": "pictures of automata, without Graphviz",
    "sat": "exact minimisation",
    "sb3": "Stable-Baselines3",
    "pettingzoo": "PettingZoo",
    "torchrl": "TorchRL",
    "rllib": "RLlib",
    "ray": "sweeps on Ray",
    "tensorboard": "learning curves in TensorBoard",
}
"""what the extras of the package are for; those for its own development are left out."""
_MODULES = {"graphviz-pure": None, "python-sat": "pysat"}
"""of packages that are imported by another name, or not at all."""


@dataclass(frozen=True)
class Finding:
    """What is known of one package or program.

    Attributes:
        name: of the package or program.
        kind: what it is.
        purpose: what it is for.
        state: whether it works, is not there, is older or newer than it may be, or cannot be imported.
        version: that is installed; None: none, or it does not say.
        advice: what to do; empty where nothing is to be done.

    Example:
        >>> Finding("dot", "program", "pictures", "missing", advice="install Graphviz").works
        False
    """

    name: str
    kind: Literal["needed", "extra", "program"]
    purpose: str
    state: State
    version: str | None = None
    advice: str = ""

    @property
    def works(self) -> bool:
        """Whether it can be used."""
        return self.state == "ok"


@dataclass(frozen=True)
class Health:
    """What works here.

    Attributes:
        version: of ltlc.
        compiled: whether parts of it are machine code.
        python: version and implementation.
        system: name, release and processor.
        findings: packages and programs.
        devices: that networks can be trained on.
    """

    version: str
    compiled: bool
    python: str
    system: str
    findings: tuple[Finding, ...]
    devices: tuple[str, ...] = field(default=("cpu",))

    @property
    def works(self) -> bool:
        """Whether everything that is needed works."""
        return all(finding.works for finding in self.findings if finding.kind == "needed")

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        return {"works": self.works, **asdict(self), "findings": [asdict(finding) for finding in self.findings]}


def examine() -> Health:
    """Look at everything that ltlc uses, and import what is installed, which takes some seconds.

    Example:
        >>> examine().works
        True
    """
    findings = [*_packages(), *_programs()]
    devices = _devices() if any(one.name == "torch" and one.works for one in findings) else ()
    return Health(
        __version__,
        is_compiled(),
        f"{platform.python_version()} ({platform.python_implementation()})",
        f"{platform.system()} {platform.release()} ({platform.machine()})",
        tuple(findings),
        devices,
    )


def _packages() -> Iterable[Finding]:
    try:
        required = metadata.requires("ltlc") or []
    except metadata.PackageNotFoundError:  # a checkout on the path, which is not installed
        required = []
    for text in required:
        match = re.match(r"([\w.-]+)(\[[^]]*\])?\s*([^;]*)(?:;.*extra == [\"']([\w-]+)[\"'])?", text)
        assert match is not None
        name, part, bounds, extra = match[1], match[2] or "", match[3].strip(" ()"), match[4]
        if extra is None:
            yield _package(name, bounds, "needed", "everything", f"pip install '{name}{bounds}'")
        elif extra in EXTRAS:
            found = _package(name, bounds, "extra", EXTRAS[extra], f"pip install 'ltlc[{extra}]'")
            yield replace(found, name=name + part)


def _package(name: str, bounds: str, kind: Literal["needed", "extra"], purpose: str, install: str) -> Finding:
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return Finding(name, kind, purpose, "missing", advice=install)
    if not fits(version, bounds):
        return Finding(name, kind, purpose, "old", version, f"{bounds} is needed: {install}")
    module = _MODULES.get(name, name.replace("-", "_"))
    if module is not None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                importlib.import_module(module)
        except Exception as error:  # somebody else's code, so anything may happen
            return Finding(name, kind, purpose, "broken", version, f"{type(error).__name__}: {error}; {install}")
    return Finding(name, kind, purpose, "ok", version)


def fits(version: str, bounds: str) -> bool:
    """Whether a version is within bounds such as ">=1.1.9,<1.4"; compared are the numbers at its beginning.

    Example:
        >>> fits("1.10.2", ">=1.9,<2"), fits("2.0rc1", "<2"), fits("0.28.1", ">=0.28,<0.29")
        (True, False, True)
    """
    numbers = _numbers(version)
    for bound in filter(None, map(str.strip, bounds.split(","))):
        operator, limit = re.match(r"([<>=!~]*)(.*)", bound).groups()  # type: ignore[union-attr]
        other = _numbers(limit)
        width = max(len(numbers), len(other))
        mine, theirs = (row + (0,) * (width - len(row)) for row in (numbers, other))
        kept = {
            ">=": mine >= theirs,
            ">": mine > theirs,
            "<": mine < theirs,
            "<=": mine <= theirs,
            "==": mine == theirs,
        }
        if not kept.get(operator, True):
            return False
    return True


def _numbers(version: str) -> tuple[int, ...]:
    match = re.match(r"\d+(\.\d+)*", version)
    return tuple(map(int, match[0].split("."))) if match else ()


def _programs() -> Iterable[Finding]:
    for name, (purpose, advice) in PROGRAMS.items():
        found = shutil.which(name) is not None
        yield Finding(name, "program", purpose, "ok" if found else "missing", advice="" if found else advice)


def _devices() -> tuple[str, ...]:
    torch = sys.modules["torch"]
    cuda = [f"cuda:{i} ({torch.cuda.get_device_name(i)})" for i in range(torch.cuda.device_count())]
    mps = ["mps"] if torch.backends.mps.is_available() else []
    return ("cpu", *cuda, *mps)
