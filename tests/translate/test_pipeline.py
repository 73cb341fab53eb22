"""The whole translation: known sizes, canonical output, budgets, errors, and formulas at the edges."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import ltlc
from ltlc.automata import DRA, canonical, equivalent
from ltlc.automata.emerson_lei import reduced
from ltlc.automata.rabin import AcceptanceKind
from ltlc.automata.rabin_pairs import Way, to_rabin
from ltlc.budget import Budget, time_limit
from ltlc.errors import (
    InvalidArgumentError,
    StateLimitExceeded,
    UnknownNameError,
)
from ltlc.formats import to_json
from ltlc.ltl import parse, propositions, simplify
from ltlc.minimize import merge_by_trial
from ltlc.translate import TRANSLATORS, Options, translate
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS
from ltlc.translate.letters import letters_of

THESIS = {
    "F(A & F B) & G!C & FG T": (5, 4),
    "F(A & F(B & F T)) & GF A & GF B & G!C": (7, 6),
    "F(A & F(B & F T))": (4, 4),
    "F(A & F(B & F T)) & GF A & GF B": (6, 5),
}
"""formula -> states with acceptance on states and on transitions, deadlock included."""

SAMPLE = (
    *THESIS,
    "true",
    "a U (b R c)",
    "G(a -> F b) & (c W d)",
    "(GF a | FG b) & (GF c | FG d)",
    "GF a & GF b & GF c",
    "(GF a -> GF b) & (GF c -> GF d)",
    "G(a | F(b & X c)) -> F(d U a)",
    "F(a & X(b U G c))",
    "G((F a & F b) | G c)",
    "(a xor X b) U (F c <-> G a)",
)
PLACES = "abcdeghijklm"  # f would read as a doubtful false
EXCLUSIVE = " & ".join(f"G !({p} & {q})" for p, q in combinations(PLACES, 2))


def build(text: str, acceptance: AcceptanceKind = "transition", translator: str = "auto") -> DRA:
    return translate(parse(text), Options(acceptance=acceptance, translator=translator))


@pytest.mark.parametrize(("text", "sizes"), THESIS.items())
def test_sizes_of_the_thesis_formulas(text: str, sizes: tuple[int, int]) -> None:
    automata = build(text, "state"), build(text, "transition")
    assert tuple(a.n_states for a in automata) == sizes
    assert [a.n_pairs for a in automata] == [1, 1]


def digest(text: str) -> str:
    """Of every array that any construction makes of the formula."""
    summary = hashlib.sha256()
    forms: list[tuple[str, AcceptanceKind]] = [("auto", "state"), *((t, "transition") for t in ("auto", *TRANSLATORS))]
    for translator, acceptance in forms:
        try:
            a = translate(parse(text), Options(translator=translator, acceptance=acceptance, max_states=100))
        except (InvalidArgumentError, StateLimitExceeded) as error:
            summary.update(str(error).encode())
            continue
        for array in (a.delta, a.letter_class, a.fin, a.inf):
            summary.update(f"{array.dtype}{array.shape}".encode() + array.tobytes())
        summary.update(f"{a.aps}{a.initial_state}{a.translator}{a.formula}".encode())
    return summary.hexdigest()


@pytest.mark.parametrize("translator", TRANSLATORS)
def test_constructions_number_states_breadth_first(translator: str) -> None:
    """What `translate` takes for granted."""
    for text in SAMPLE:
        formula = simplify(parse(text))
        letters = letters_of(formula, propositions(formula))
        budget = Budget(text, 60)
        try:
            found = reduced(CONSTRUCTIONS[translator].build(Closure(formula, letters, budget), budget))
        except (InvalidArgumentError, StateLimitExceeded):
            continue
        ways: tuple[Way, ...] = ("smaller", "cycles")
        for automaton in [to_rabin(found, letters.aps, letters.letter_class, budget, way=way) for way in ways]:
            again = canonical(automaton)
            for name in ("delta", "letter_class", "fin", "inf"):
                assert np.array_equal(getattr(again, name), getattr(automaton, name))


@pytest.mark.slow
def test_the_same_bytes_on_every_run() -> None:
    """Under any hash seed, and whatever was translated before in the same process."""
    program = (
        "import sys, test_pipeline as t\n"
        "order = t.SAMPLE if sys.argv[1] == 'forward' else t.SAMPLE[::-1]\n"
        "found = {text: t.digest(text) for text in order}\n"
        "print(*(found[text] for text in t.SAMPLE), sep='\\n')"
    )
    here = Path(__file__).parent
    paths = [str(here), str(here.parent / "oracles"), str(Path(ltlc.__file__).parents[1])]
    runs = []
    for seed, order in (("0", "forward"), ("1", "backward"), ("4242", "forward")):
        environment = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(paths)}
        command = [sys.executable, "-c", program, order]
        runs.append(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)
    assert runs[0] == runs[1] == runs[2]
    assert len(set(runs[0].split())) == len(SAMPLE)


# -- what is refused --------------------------------------------------------------------------------------------------


def test_an_unknown_translator_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown translator 'saffra'. Did you mean safra"):
        build("a", translator="saffra")


def test_an_unknown_acceptance_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match=r"'edge'; it can be 'state' or 'transition'"):
        build("a", "edge")  # type: ignore[arg-type]


def test_obligation_applies_to_obligations_only() -> None:
    assert build("F a & G b | X c", translator="obligation").translator == "obligation"
    with pytest.raises(InvalidArgumentError, match="use another translator"):
        build("G F a", translator="obligation")


# -- formulas at the edges --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("acceptance", ["state", "transition"])
@pytest.mark.parametrize("translator", ["auto", *TRANSLATORS])
def test_constants_have_one_state(translator: str, acceptance: AcceptanceKind) -> None:
    for text, accepted, aps in [
        ("true", True, ()),
        ("false", False, ()),
        ("a | !a", True, ("a",)),
        ("F a & G !a", False, ("a",)),
        ("G(true U true)", True, ()),
        ("X X false", False, ()),
    ]:
        automaton = build(text, acceptance, translator)
        assert automaton.n_states == 1, text
        assert automaton.n_pairs == 1
        assert automaton.aps == aps
        assert automaton.accepts() == accepted
        assert automaton.deadlocks == (() if accepted else (0,))
        assert automaton.accepting_sinks == ((0,) if accepted else ())


@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_many_propositions(acceptance: AcceptanceKind) -> None:
    every = build("G(" + " & ".join(f"a{i}" for i in range(1, 21)) + ")", acceptance)
    assert (every.n_states, every.n_classes, len(every.aps)) == (2, 2, 20)
    assert every.accepts([], [every.aps])
    assert not every.accepts([every.aps[1:]], [every.aps])

    some = build(" | ".join(f"F a{i}" for i in range(20)), acceptance)
    assert (some.n_states, some.n_classes) == (2, 2)


@pytest.mark.slow
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_families_at_the_size_that_is_promised(acceptance: AcceptanceKind) -> None:
    reach = build(" & ".join(f"F a{i}" for i in range(1, 9)), acceptance)
    assert reach.n_states == 2**8
    assert reach.accepts([{f"a{i}"} for i in range(1, 9)], [()])
    assert not reach.accepts([{f"a{i}"} for i in range(1, 8)], [()])

    patrol = build(" & ".join(f"GF a{i}" for i in range(1, 7)), acceptance)
    assert patrol.n_states == (7 if acceptance == "state" else 6)
    assert patrol.accepts([], [{f"a{i}"} for i in range(1, 7)])
    assert not patrol.accepts([], [{f"a{i}"} for i in range(1, 6)])

    until = build(" U (".join(f"a{i}" for i in range(1, 13)) + ")" * 11, acceptance)
    assert until.n_states == 13
    assert until.accepts([{f"a{i}"} for i in range(1, 13)], [()])
    assert not until.accepts([{"a2"}, {"a1"}], [{"a12"}])


@pytest.mark.parametrize(
    ("task", "state_based", "transition_based"),
    [("F(a & F(b & F c)) & G !d", 5, 5), ("GF a & GF b & (!c U d)", 5, 4), ("F(a & F(b & F c)) & G(e -> F g)", 9, 9)],
)
def test_twelve_exclusive_places(task: str, state_based: int, transition_based: int) -> None:
    text = f"{EXCLUSIVE} & {task}"
    assert build(text, "state").n_states <= state_based
    automaton = build(text, "transition")
    assert automaton.n_states <= transition_based
    assert automaton.n_classes <= 13
    assert not automaton.accepts([{"a", "b"}], [{"c"}])


def test_propositions_keep_their_order_even_if_they_do_not_matter() -> None:
    automaton = build("(b | !b) & F a & (c -> c)")
    assert automaton.aps == ("b", "a", "c")
    assert automaton.n_classes == 2


def test_what_every_construction_gives_up_is_given_up() -> None:
    """The normal form comes first here, and among what comes next where the first one has too many states."""
    text = "F(!((c <-> F(F b M (d xor F c)) xor X(a W !G b)) W b) <-> F(a W c) W (c | !d))"
    with pytest.raises(StateLimitExceeded):
        translate(parse(text), Options(max_states=2, timeout=60))


def test_deep_formulas_translate() -> None:
    assert build("X " * 200 + "a").n_states == 203
    assert build("F(a & X " * 30 + "F b" + ")" * 30).n_states == 32
    assert build(" & ".join(["G a"] * 300)).n_states == 2


def test_registry() -> None:
    assert list(TRANSLATORS) == [c.name for c in TRANSLATORS.values()]
    for construction in TRANSLATORS.values():
        assert construction.description.endswith(".")
        assert construction.citation


def test_a_construction_of_a_users_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is used by name, listed, and leaves what "auto" does as it is."""
    monkeypatch.chdir(tmp_path)
    Path("trees_of_mine.py").write_text(
        "from ltlc.translate import TRANSLATORS, Construction, register_construction\n"
        "trees = register_construction(Construction('trees', 'As safra.', 'as safra', TRANSLATORS['safra'].build))\n"
    )
    formula = parse("F G a | G F b")
    before = to_json(translate(formula))
    try:
        automaton = translate(formula, Options(translator="trees_of_mine:trees"))
        assert automaton.translator == "trees"
        assert equivalent(automaton, translate(formula))
        assert "trees" in list(TRANSLATORS)
        assert to_json(translate(formula)) == before
        with pytest.raises(UnknownNameError, match="Did you mean auto"):
            translate(formula, Options(translator="autos"))
        with pytest.raises(InvalidArgumentError, match="is no ltlc"):
            translate(formula, Options(translator="trees_of_mine:TRANSLATORS"))
    finally:
        TRANSLATORS.remove("trees")


def test_merging_by_trial_can_be_stopped() -> None:
    automaton = translate(
        parse("F G(a | X X X a) & F G(!a | X X X !a)"), Options(acceptance="transition", effort="fast")
    )
    with time_limit("", 0):
        assert merge_by_trial(automaton).n_states == automaton.n_states
    assert merge_by_trial(automaton).n_states < automaton.n_states


def test_components_answer_the_same_when_they_are_asked_again() -> None:
    formula = parse("X X(F c -> b) <-> X F(G b xor a)")  # its closure learns atoms between two explorations
    automaton = translate(formula, Options(acceptance="transition"))
    assert equivalent(automaton, translate(formula, Options(acceptance="transition", translator="safra")))
