"""A user's reward scheme, from a module of their own, is treated like those of the package."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.faithful import default_candidates
from ltlc.rewards import SCHEMES, arguments_of, get_scheme, register_scheme
from ltlc.rewards.two_discount import TwoDiscount
from ltlc.task import Task

MODULE = """
from dataclasses import dataclass
from ltlc.rewards import register_scheme
from ltlc.rewards.two_discount import TwoDiscount

@register_scheme
@dataclass(frozen=True)
class Patient(TwoDiscount):
    name = "patient"
    gamma: float = 0.9999999
"""


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(MODULE)
    sys.modules.pop("mine", None)  # of another test
    yield tmp_path
    SCHEMES.remove("patient")
    sys.modules.pop("mine", None)


def test_by_module_and_by_name(mine: Path) -> None:
    assert Task("F a", "mine:Patient").scheme.parameters == {"gamma_accept": 0.99, "gamma": 0.9999999}
    assert get_scheme("patient").parameters["gamma"] == 0.9999999
    assert "patient" in list(SCHEMES)
    assert any(candidate.scheme.name == "patient" for candidate in default_candidates())


def test_what_was_never_registered_is_named_by_its_module() -> None:
    class Unknown(TwoDiscount):
        name = "unknown"

    name, parameters = arguments_of(Unknown(gamma=0.5))
    assert name == f"{__name__}:{Unknown.__qualname__}"
    assert parameters == {"gamma": 0.5}


@pytest.mark.parametrize("part", [3, "text".upper, TwoDiscount(), dict])
def test_what_is_no_scheme(part: object) -> None:
    with pytest.raises(InvalidArgumentError):
        register_scheme(part)  # type: ignore[arg-type]


def test_names_are_taken_once_and_suggested() -> None:
    class Copy(TwoDiscount):
        pass

    with pytest.raises(InvalidArgumentError, match="is taken"):
        register_scheme(Copy)
    with pytest.raises(UnknownNameError, match="two-discount"):
        get_scheme("two-discont")


@pytest.mark.slow
def test_on_the_command_line(mine: Path) -> None:
    Path("world.py").write_text("def labels(state, info):\n    return {'goal'} if state == 15 else set()\n")
    command = [sys.executable, "-m", "ltlc", "solve", "F goal", "--env", "FrozenLake-v1", "--labels", "world:labels"]
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [*command, "--reward", "mine:Patient", "--set", "gamma_accept=0.9", "--json"],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(root)},
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["optimal"]["satisfaction"] == pytest.approx(14 / 17, abs=1e-3)
