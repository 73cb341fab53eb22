"""Parity form: recognised on the structure, made with a record of pairs, and compared with plain appearance records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from random_automata import random_automata

from ltlc import compile
from ltlc.automata import DRA, canonical, equivalent, parity_colours, to_parity, to_transition_based
from ltlc.errors import StateLimitExceeded


def one_state(fin: list[list[int]], inf: list[list[int]]) -> DRA:
    """One state; marks by pair and letter."""
    n_aps = len(fin[0]).bit_length() - 1
    return DRA(
        tuple("abcd"[:n_aps]),
        np.zeros((1, 2**n_aps), dtype=int),
        range(2**n_aps),
        np.array(fin)[:, None],
        np.array(inf)[:, None],
        acceptance="transition",
    )


def chain(automaton: DRA, colours: np.ndarray) -> DRA:
    """The structure with the acceptance that colours say: the largest one seen infinitely often is odd."""
    odd = np.arange(1, int(colours.max()) + 2, 2)[:, None, None]
    return replace(automaton, fin=colours > odd, inf=colours == odd, acceptance="transition")


def appearance_records(automaton: DRA) -> DRA:
    """The index appearance record construction as Loeding gives it, on all pairs and the whole automaton."""
    automaton = to_transition_based(automaton)
    start = (automaton.initial_state, tuple(range(automaton.n_pairs)))
    number, order, delta, colours = {start: 0}, [start], [], []
    for state, record in order:
        row, seen = [], []
        for c in range(automaton.n_classes):
            fin, inf = automaton.fin[:, state, c], automaton.inf[:, state, c]
            colour = max([0, *(2 * k + (2 if fin[i] else 1) for k, i in enumerate(record) if fin[i] or inf[i])])
            moved = (*(i for i in record if fin[i]), *(i for i in record if not fin[i]))
            target = (int(automaton.delta[state, c]), moved)
            if target not in number:
                number[target] = len(order)
                order.append(target)
            row.append(number[target])
            seen.append(colour)
        delta.append(row)
        colours.append(seen)
    marked = replace(
        automaton,
        delta=np.array(delta),
        fin=np.zeros((1, *np.shape(delta)), dtype=bool),
        inf=np.zeros((1, *np.shape(delta)), dtype=bool),
        initial_state=0,
        state_names=None,
    )
    return chain(marked, np.array(colours))


@pytest.mark.slow
def test_parity_form_keeps_the_language_and_leads_back() -> None:
    products = 0
    for automaton in random_automata(250):
        result = to_parity(automaton)
        parity, origin = result.automaton, result.origin
        assert equivalent(automaton, parity)
        assert not result.select_pair.size
        assert origin[parity.initial_state] == automaton.initial_state
        assert (origin[parity.delta] == automaton.delta[origin]).all()
        colours = parity_colours(parity)
        assert colours is not None
        assert equivalent(automaton, chain(parity, colours))
        reference = appearance_records(automaton)
        assert equivalent(automaton, reference)
        assert parity.n_states <= reference.n_states
        recognised = parity_colours(automaton)
        if recognised is not None:
            assert equivalent(automaton, chain(automaton, recognised))
            assert parity.n_states <= automaton.n_states
        products += recognised is None
    assert products > 20


def test_structures_without_parity_colours_have_two_cycles_judged_alike_whose_union_is_not() -> None:
    """FG a | FG b on one state: rest on {a}, rest on {b}, and both in turn."""
    automaton = one_state([[1, 0, 1, 0], [1, 1, 0, 0]], [[1] * 4, [1] * 4])
    assert parity_colours(automaton) is None
    assert to_parity(automaton).automaton.n_states == 2


@pytest.mark.parametrize("k", [2, 3, 4])
def test_one_of_k_promises_needs_k_records_and_not_k_factorial(k: int) -> None:
    letters = np.arange(2**k)
    fin = [((letters >> i & 1) == 0).astype(int).tolist() for i in range(k)]
    automaton = one_state(fin, [[1] * 2**k] * k)
    result = to_parity(automaton).automaton
    assert result.n_states == k
    assert appearance_records(automaton).n_states > k or k == 2
    assert equivalent(automaton, result)


@pytest.mark.parametrize(("formula", "colours"), [
    ("GF a", {0, 1}),
    ("FG a", {1, 2}),
    ("GF a & GF b", {0, 1}),
    ("FG a & FG b", {1, 2}),
    ("GF a & FG b", {0, 1, 2}),
    ("GF a | FG b", {1, 2, 3}),
])  # fmt: skip
def test_fewest_colours(formula: str, colours: set[int]) -> None:
    found = parity_colours(compile(formula, acceptance="transition"))
    assert found is not None
    assert set(np.unique(found)) <= colours
    assert found.max() == max(colours)


@pytest.mark.parametrize("formula", ["GF a", "GF a & GF b", "G (a -> F b)", "a U b", "FG a", "FG a | F b"])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_buchi_and_cobuchi_type_do_not_depend_on_how_pairs_are_written(formula: str, acceptance: str) -> None:
    automaton = to_transition_based(compile(formula, acceptance=acceptance))  # type: ignore[arg-type]
    colours = parity_colours(automaton)
    assert colours is not None
    # split the Inf marks over two pairs, and add a pair that accepts nothing
    fin, inf = automaton.edge_fin[0], automaton.edge_inf[0]
    even = (np.arange(automaton.n_states) % 2 == 0)[:, None]
    rewritten = replace(
        automaton, fin=np.stack((fin, fin, ~fin)), inf=np.stack((inf & even, inf & ~even, np.zeros_like(inf)))
    )
    assert automaton.n_pairs == 1
    again = parity_colours(rewritten)
    assert again is not None
    assert (again == colours).all()
    buchi = formula not in ("FG a", "FG a | F b")
    assert (colours.max() <= 1) == buchi


def test_real_formulas_of_two_pairs() -> None:
    for formula in ("(FG a | FG b) & G !c", "(GF a -> GF b) & (GF b -> GF c)", "(FG a & GF b) | (FG b & GF c)"):
        for acceptance in ("state", "transition"):
            automaton = compile(formula, acceptance=acceptance)  # type: ignore[arg-type]
            parity = to_parity(automaton).automaton
            assert equivalent(automaton, parity)
            assert canonical(parity).n_states == parity.n_states


def test_a_limit_on_states_is_kept() -> None:
    automaton = one_state([[1, 0, 1, 0], [1, 1, 0, 0]], [[1] * 4, [1] * 4])
    with pytest.raises(StateLimitExceeded, match="raise max_states"):
        to_parity(automaton, max_states=1)
