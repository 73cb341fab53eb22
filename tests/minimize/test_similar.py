"""The order in which pairs of states are tried to be merged."""

from __future__ import annotations

import numpy as np
import pytest

from ltlc.automata.rabin import DRA
from ltlc.ltl import parse
from ltlc.minimize import merge_by_trial
from ltlc.minimize.similar import edge_codes, most_similar
from ltlc.translate import Options, translate


@pytest.mark.parametrize(("n_states", "n_columns", "n_values"), [(1, 5, 2), (9, 3, 2), (40, 90, 2), (30, 200, 3)])
def test_pairs_come_in_the_order_of_their_differences(n_states: int, n_columns: int, n_values: int) -> None:
    rng = np.random.default_rng(n_states)
    for n_blocks in (1, 3):
        codes = rng.integers(0, n_values, (n_states, n_columns), dtype=np.int32)
        codes[n_states // 2 :] = codes[: n_states - n_states // 2]  # some do not differ at all, or in few columns
        codes[:: max(1, n_states // 4), -1] += 1
        block = rng.integers(0, n_blocks, n_states, dtype=np.int32)
        expected = sorted(
            (int((codes[p] != codes[q]).sum()), -p, q)
            for p in range(n_states)
            for q in range(n_states)
            if p != q and block[p] == block[q]
        )
        assert list(most_similar(codes, block)) == [(-p, q) for _, p, q in expected]


def coded(automaton: DRA) -> list[list[tuple[int, int]]]:
    rows = zip(automaton.rows, automaton.edge_marks, strict=True)
    return [list(zip(targets, marks, strict=True)) for targets, marks in rows]


@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_codes_tell_edges_apart_by_next_state_and_marks(acceptance: str) -> None:
    for text in ("F G a", "(F G a | G F b) & (F G c | G F d)", "X X a"):
        automaton = translate(parse(text), Options(acceptance=acceptance))  # type: ignore[arg-type]
        edges = [edge for row in coded(automaton) for edge in row]
        codes = edge_codes(automaton).ravel().tolist()
        assert len(set(zip(edges, codes, strict=True))) == len(set(edges)) == len(set(codes))


def test_many_pairs_of_marks_do_not_overflow() -> None:
    automaton = translate(parse("F G a | G F b"), Options(acceptance="transition"))
    tables = [np.repeat(marks, 20, axis=0) for marks in (automaton.fin, automaton.inf)]
    many = DRA(automaton.aps, automaton.delta, automaton.letter_class, *tables, acceptance="transition")

    assert len(np.unique(edge_codes(many))) == len({edge for row in coded(automaton) for edge in row})
    assert merge_by_trial(many).n_states <= many.n_states


def test_wide_automata_are_not_tried() -> None:
    automaton = translate(
        parse("F G(a | X X X a) & F G(!a | X X X !a)"), Options(acceptance="transition", effort="fast")
    )
    n_edges = automaton.n_states * automaton.n_classes
    assert merge_by_trial(automaton, 4 * n_edges - 1).n_states == automaton.n_states
    assert merge_by_trial(automaton).n_states < automaton.n_states
