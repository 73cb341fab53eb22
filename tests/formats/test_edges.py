"""Edges of wide tables are those of narrow ones, whatever there is to group by."""

from __future__ import annotations

import numpy as np
import pytest

from ltlc.automata import DRA
from ltlc.formats import edges as module
from ltlc.formats.edges import edges


@pytest.mark.parametrize("n_pairs", [0, 1, 3, 16, 17, 40])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_sorting_groups_as_going_one_by_one(n_pairs: int, acceptance: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(n_pairs)
    shape = (n_pairs, 5) if acceptance == "state" else (n_pairs, 5, 128)
    fin, inf = (rng.random(shape) < 0.05 for _ in range(2))
    delta, letter_class = rng.integers(5, size=(5, 128)), rng.permutation(128)
    automaton = DRA(tuple("abcdefg"), delta, letter_class, fin, inf, acceptance=acceptance)  # type: ignore[arg-type]
    found = edges(automaton)
    monkeypatch.setattr(module, "_WIDE", 1000)
    assert edges(automaton) == found
    first = automaton.alphabet.first_letter
    for edge in found:
        assert [*edge.classes] == sorted(edge.classes, key=lambda c: first[c])
        for c in edge.classes:
            assert delta[edge.source, c] == edge.target
            if acceptance == "transition":
                assert edge.fin == tuple(np.flatnonzero(fin[:, edge.source, c]))
                assert edge.inf == tuple(np.flatnonzero(inf[:, edge.source, c]))
    assert sum(len(edge.classes) for edge in found) == 5 * 128
