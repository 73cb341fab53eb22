"""Exact minimisation: lower bounds, collapsing to residuals, and the search by SAT."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from random_automata import random_automata

from ltlc.automata import DRA, equivalent
from ltlc.automata.rabin import AcceptanceKind
from ltlc.budget import time_limit
from ltlc.errors import MissingProgramError
from ltlc.ltl import parse
from ltlc.minimize import collapse, lower_bound, merge_by_trial, minimize
from ltlc.minimize.lower_bound import part_lower_bound
from ltlc.minimize.residuals import Part, residuals
from ltlc.minimize.safe_classes import least_by_safe_edges
from ltlc.translate import Options, translate

PHI = {
    "phi_1": "F(A & F B) & G!C & FG T",
    "phi_2": "F(A & F(B & F T)) & GF A & GF B & G !C",
    "phi_3": "F(A & F(B & F T))",
    "phi_4": "F(A & F(B & F T)) & GF A & GF B",
}


def compiled(text: str, acceptance: AcceptanceKind = "transition", translator: str = "auto") -> DRA:
    return translate(parse(text), Options(acceptance=acceptance, translator=translator))


@pytest.fixture
def sat() -> None:
    pytest.importorskip("pysat.solvers", reason='python-sat is missing: pip install "ltlc[sat]"')


@pytest.mark.parametrize(
    ("text", "states"),
    [
        ("true", 1),
        ("G F a & G F b", 2),
        ("G F a & G F b & G F c", 3),
        ("G F a | G F b", 1),
        ("(F G a & G F b) | (F G c & G F d)", 1),
        ("G F a <-> G F b", 2),
        ("a U b", 3),
        ("G F (a & X b) & G F (c & X d)", 4),
        ("G F (a & X X X a)", 8),
        ("G F (a & X b) & G(c -> F d)", 5),
        ("F G (a | X X b) & F G (c | X X X d)", 32),
        ("G F (a & X b) & F G (c | X X d)", 8),
        ("G F (a & X b) | G F (c & X X d) & F G e", 8),
        (" & ".join(f"G(a{i} -> F b{i})" for i in range(6)), 193),
        # Emerson-Lei automata for these have fewer states: 1, 1, 5, 4 and 16.
        ("G F a & G F b & G F c", 3),
        ("(F G a | G F b) & (F G c | G F a) & (F G d | G F c)", 4),
        ("G F a & (a | G F b) & (c | G F d) & (F G a | G F c)", 14),
        ("G F(!a & b) & G F(a & X b) & G F(!a & X X b)", 7),
        ("G F a & F G(b | X c) & G F(d & X X X e)", 18),
    ],
)
def test_lower_bound_is_tight(text: str, states: int) -> None:
    automaton = compiled(text)
    assert lower_bound(automaton) == automaton.n_states == states


@pytest.mark.parametrize(
    ("text", "states"),
    [
        ("F G (a <-> X a)", 1),
        ("(F G (a <-> X a)) & F G (b <-> X b)", 1),
        ("F((a | !b) & (G a | G b | G c))", 3),
    ],
)
def test_collapse_keeps_one_state_per_residual(text: str, states: int) -> None:
    automaton = compiled(text, translator="safra")
    result = collapse(automaton)
    assert equivalent(result.automaton, automaton)
    assert result.is_proven
    assert result.automaton.n_states == states


@pytest.mark.parametrize(
    "text",
    ["G F (a & X X X !a) | G F (!a & X X a)", "G(a -> X F(b & X b)) & G F c", "F a & G F (b & X c) | G F (d & X a)"],
)
def test_lower_bound_of_recurrence_depends_on_the_language_alone(text: str) -> None:
    bounds = [lower_bound(compiled(text, translator=name)) for name in ("product", "safra", "dual-safra", "auto")]
    assert len(set(bounds)) == 1
    assert 1 < bounds[0] <= compiled(text).n_states


@pytest.mark.slow
def test_lower_bound_is_below_what_any_construction_finds() -> None:
    for automaton in random_automata(150):
        bounds = [lower_bound(other) for other in (automaton, collapse(automaton).automaton)]
        assert max(bounds) <= min(automaton.n_states, merge_by_trial(automaton).n_states)


@pytest.mark.parametrize("text", ["F G a | F G b", "F G (a | X b) | F G (c | X d)", "F G (a | X X b) | F G (!a & X c)"])
def test_lower_bound_of_persistence_leaves_room_for_pairs(text: str) -> None:
    bounds = [lower_bound(compiled(text, translator=name)) for name in ("product", "safra", "dual-safra", "auto")]
    assert max(bounds) <= compiled(text).n_states


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [None, "(F G a | F G b) & (F G b | G F !a)", "G F (a & X b) & F G (a | X X !b)", "G F (a & X X b) | F G (b & X a)"],
)
def test_nothing_is_below_the_lower_bound(sat: None, text: str | None) -> None:
    from ltlc.minimize.sat_search import Search

    if text is None:
        automata = list(random_automata(800))
    else:
        automata = [compiled(text, translator=name) for name in ("product", "safra", "dual-safra")]
    for part in (part for automaton in automata for part in residuals(automaton).parts):
        bound = part_lower_bound(part, part.acceptance)
        assert bound <= len(part.states)
        if len(part.residuals) < bound < 6:
            assert Search(part, bound - 1).run() is None


def test_safe_languages_that_differ_late_are_told_apart_soon() -> None:
    n = 490
    ring, marks = tuple([((q + 1) % n, q or 1) for q in range(n)]), tuple([(int(q == 0), 2) for q in range(n)])
    part = Part((0,), ((0, 0),), tuple(range(n)), (0,) * n, ring, marks, (0, 1), n_pairs=1, acceptance="transition")
    with time_limit("", 8):
        assert least_by_safe_edges(part) == n


@pytest.mark.slow
def test_collapse_keeps_language_and_acceptance_and_never_grows() -> None:
    for automaton in random_automata(150):
        result = collapse(automaton)
        assert equivalent(result.automaton, automaton)
        assert result.automaton.acceptance == automaton.acceptance
        assert result.lower_bound == lower_bound(automaton) <= result.automaton.n_states <= automaton.n_states


def test_labels_of_states_on_separate_rejected_cycles_can_be_accepted_together() -> None:
    automaton = compiled("G(a | X!a | X((a | X!a) U (!b & X b)))", "state")
    result = collapse(automaton)
    assert equivalent(result.automaton, automaton)


def test_minimize_keeps_language_and_acceptance_and_never_grows(sat: None) -> None:
    for automaton in random_automata(60, max_states=4):
        result = minimize(automaton)
        assert result.is_proven
        assert equivalent(result.automaton, automaton)
        assert result.automaton.acceptance == automaton.acceptance
        assert lower_bound(automaton) <= result.automaton.n_states <= collapse(automaton).automaton.n_states


@pytest.mark.parametrize(
    ("text", "acceptance"),
    [
        ("G F (a & X b)", "transition"),
        ("G F (a & X b)", "state"),
        ("F G a | F (b & X b)", "state"),
        ("G F a & F G b", "state"),
        ("G F (a & X a) | F G b", "transition"),
    ],
)
def test_one_size_from_all_constructions(sat: None, text: str, acceptance: AcceptanceKind) -> None:
    results = [minimize(compiled(text, acceptance, name)) for name in ("product", "safra", "dual-safra")]
    assert all(result.is_proven for result in results)
    assert len({result.automaton.n_states for result in results}) == 1


@pytest.mark.parametrize(
    ("text", "acceptance", "states"),
    [
        ("F G (a | X X b)", "transition", 4),
        ("G F (a & X X a) & G F a", "transition", 4),
        ("G F (a & X b)", "state", 3),
        ("G F a & G F b", "state", 3),
    ],
)
def test_known_minima(sat: None, text: str, acceptance: AcceptanceKind, states: int) -> None:
    result = minimize(compiled(text, acceptance))
    assert (result.automaton.n_states, result.lower_bound) == (states, states)


@pytest.mark.parametrize(("name", "states"), [("phi_1", 4), ("phi_2", 6), ("phi_3", 4), ("phi_4", 5)])
def test_thesis_formulas_are_smallest_on_transitions(name: str, states: int) -> None:
    automaton = compiled(PHI[name])
    assert automaton.n_states == lower_bound(automaton) == states


@pytest.mark.parametrize(("name", "states"), [("phi_1", 5), ("phi_2", 7), ("phi_3", 4), ("phi_4", 6)])
def test_thesis_formulas_are_smallest_on_states(sat: None, name: str, states: int) -> None:
    automaton = compiled(PHI[name], "state")
    result = minimize(automaton)
    assert automaton.n_states == result.automaton.n_states == result.lower_bound == states


def test_timeout_keeps_what_is_known(sat: None) -> None:
    automaton = compiled("G F (a & X b) & G F (c & X d)")
    result = minimize(automaton, timeout=0)
    assert equivalent(result.automaton, automaton)
    assert lower_bound(automaton) <= result.lower_bound <= result.automaton.n_states <= automaton.n_states


def test_missing_package_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pysat.solvers", None)
    with pytest.raises(MissingProgramError, match=r'pip install "ltlc\[sat\]"'):
        minimize(compiled("F G (a | X b) | F G (c | X d)"))


@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_an_automaton_without_pairs_is_minimized(acceptance: AcceptanceKind) -> None:
    marks = np.zeros((0, 2) if acceptance == "state" else (0, 2, 2), dtype=bool)
    automaton = DRA(("a",), np.array([[0, 1], [1, 0]]), np.array([0, 1]), marks, marks, acceptance=acceptance)
    assert minimize(automaton).automaton.n_states == collapse(automaton).automaton.n_states == 1
