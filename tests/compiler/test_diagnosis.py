"""What is known of a task before anything is learned."""

from __future__ import annotations

import numpy as np
import pytest
from mdp_cases import thesis_world
from suite_tasks import RIGHT, STAY, grid

from ltlc import compile
from ltlc.cli.app import run
from ltlc.diagnosis import Diagnostic, diagnose, shortest_satisfaction
from ltlc.mdp import LabelledMDP, Product, max_satisfaction_probability


def kinds(diagnostics: tuple[Diagnostic, ...]) -> list[tuple[str, str | None]]:
    return [(diagnostic.kind, diagnostic.proposition) for diagnostic in diagnostics]


def corridor(n: int = 6) -> LabelledMDP:
    """From the left to the right, one cell a step; g at the end, s everywhere, n nowhere."""
    labels = {(0, column): ["s"] for column in range(n)} | {(0, n - 1): ["g", "s"]}
    return grid(1, n, [{RIGHT: 1.0}, {STAY: 1.0}], labels, aps="gsn")


def test_formulas_that_say_nothing() -> None:
    assert kinds(diagnose(compile("F a & G !a"))) == [("unsatisfiable", None)]
    assert kinds(diagnose(compile("F a | G !a"))) == [("valid", None)]
    assert diagnose(compile("G F a")) == ()
    assert "F a & G !a" in diagnose(compile("F a & G !a"))[0].text


def test_propositions_without_a_say() -> None:
    assert kinds(diagnose(compile("F g & G s & G !n"), corridor())) == [("always", "s"), ("never", "n")]
    unreachable = LabelledMDP.from_arrays([np.eye(2)], aps=("g",), labels={1: "g"})
    assert kinds(diagnose(compile("F g"), unreachable)) == [("never", "g"), ("impossible", None)]


@pytest.mark.parametrize(("formula", "probability"), [
    ("F(A & F B) & G !C & F G T", 0), ("F(A & F(B & F T))", 1), ("!C U A", None),
])  # fmt: skip
def test_a_maximum_of_zero(formula: str, probability: float | None) -> None:
    found = kinds(diagnose(compile(formula), thesis_world(10)))
    assert found == ([("impossible", None)] if probability == 0 else [])


def test_a_small_maximum() -> None:
    p = np.zeros((3, 3))
    p[0, [1, 2]] = 0.001, 0.999
    p[1, 1] = p[2, 2] = 1
    mdp = LabelledMDP.from_arrays([p], aps=("g",), labels={1: "g"})
    assert kinds(diagnose(compile("F g"), mdp)) == [("improbable", None)]


@pytest.mark.parametrize(("formula", "steps"), [("F g", 5), ("F G g", 6), ("G F g", 6), ("G s", 0)])
def test_episodes_that_are_too_short(formula: str, steps: int) -> None:
    product = Product(corridor(), compile(formula))
    shortest = shortest_satisfaction(product, max_satisfaction_probability(product))
    assert steps <= shortest <= steps + 1  # where the marks are is up to the automaton
    automaton = compile(formula)
    if shortest > 1:
        short = diagnose(automaton, corridor(), episode_steps=shortest - 1)
        assert ("short-episodes", None) in kinds(short)
        assert str(shortest) in short[-1].text
    assert ("short-episodes", None) not in kinds(diagnose(automaton, corridor(), episode_steps=shortest))


@pytest.mark.slow
def test_commands_say_it_once(capsys: pytest.CaptureFixture[str]) -> None:
    task = ["F(A & F B) & G !C & F G T", "--env", "ltlc/Thesis10x10-v0"]
    for command in (["solve", *task], ["faithful", *task, "-r", "thesis"]):
        assert run(command) == 0
        assert capsys.readouterr().err.count("no accepting end component") == 1
