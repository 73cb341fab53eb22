"""Merge states of one language by trial: redirect, and keep the result if nothing changed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ltlc import graph
from ltlc.automata.canonical import canonical
from ltlc.automata.compare import distinguishing_letters
from ltlc.automata.languages import can_decide_languages, equivalent_states
from ltlc.automata.partition import IntArray, number_blocks, pairs_within
from ltlc.automata.rabin import RabinAutomaton
from ltlc.budget import check_time
from ltlc.errors import TimeLimitExceeded

EFFORT = 200_000
"""default bound on the number of product edges looked at."""
_COST_OF_WORD = 20
"""a candidate refuted by a known word takes about as long as this many product edges."""


def merge_by_trial(automaton: RabinAutomaton, effort: int = EFFORT) -> RabinAutomaton:
    """Replace states by others with the same language, as long as the automaton keeps its language.

    Unlike `merge_equivalent` this merges inside a strong component, where equal languages are not enough: a run could
    be redirected for ever. So each replacement is tried, most similar states first, and decided exactly. States keep
    their languages on the way, because what can follow a prefix is fixed by the language of the whole. Where the time
    of the call is over, what is merged stays so.

    Args:
        automaton: any Rabin automaton.
        effort: number of product edges after which no more is tried; 0 tries nothing.
    """
    result = automaton
    with suppress(TimeLimitExceeded):
        for smaller in _merging(automaton, effort):
            result = smaller
    return result


def _merging(automaton: RabinAutomaton, effort: int) -> Iterator[RabinAutomaton]:
    """The automaton in canonical form, and after each merging."""
    current = canonical(automaton)
    yield current
    if effort <= 0:
        return
    language = current.languages if can_decide_languages(current) else equivalent_states(current, effort)
    words: list[_Word] = []
    merged = True
    while merged:
        merged = False
        for old, new in _candidates(current, language):
            effort -= _COST_OF_WORD
            if effort < 0:
                return
            check_time()
            if _refuted(current, old, new, words):
                continue
            effort -= current.n_states * current.n_classes
            attempt = _redirected(current, old, new)
            found = distinguishing_letters(attempt, current)
            if found is None:
                language = language[graph.reachable(attempt.delta, [attempt.initial_state])]
                current, merged = canonical(attempt.keeping_languages(current)), True
                yield current
                break
            words.insert(0, _word(current, *found))


class _Word(NamedTuple):
    """A lasso word in letters of the automaton, and whether it is in the language."""

    prefix: list[int]
    cycle: list[int]
    accepted: bool


def _word(automaton: RabinAutomaton, aps: Sequence[str], prefix: list[int], cycle: list[int]) -> _Word:
    """The word given over other propositions."""
    bits = [automaton.letter([name]) for name in aps]
    prefix, cycle = [
        [sum(bit for i, bit in enumerate(bits) if letter >> i & 1) for letter in letters] for letters in (prefix, cycle)
    ]
    return _Word(prefix, cycle, automaton.accepts_letters(prefix, cycle))


def _refuted(automaton: RabinAutomaton, old: int, new: int, words: list[_Word]) -> bool:
    """Whether entering `new` instead of `old` changes the verdict on a word; that word moves to the front."""
    for position, word in enumerate(words):
        if _accepts_redirected(automaton, old, new, word) != word.accepted:
            words.insert(0, words.pop(position))
            return True
    return False


def _accepts_redirected(automaton: RabinAutomaton, old: int, new: int, word: _Word) -> bool:
    """Whether the automaton with every way into `old` leading into `new` accepts the word."""
    rows, marks, letter_class = automaton.rows, automaton.edge_marks, automaton.letter_class
    entered_new = int(automaton.marks[new]) if automaton.acceptance == "state" else None

    def run(state: int, letters: list[int]) -> tuple[int, int]:
        seen = 0
        for letter in letters:
            c = letter_class[letter]
            target = rows[state][c]
            if target != old:
                seen |= marks[state][c]
                state = target
            else:
                seen |= marks[state][c] if entered_new is None else entered_new
                state = new
        return state, seen

    state, _ = run(new if automaton.initial_state == old else automaton.initial_state, word.prefix)
    trail: dict[int, int] = {}
    while state not in trail:
        source = state
        state, trail[source] = run(state, word.cycle)
    rounds = list(trail)
    seen = 0
    for source in rounds[rounds.index(state) :]:
        seen |= trail[source]
    return any(seen >> 2 * i & 3 == 2 for i in range(automaton.n_pairs))


def _candidates(automaton: RabinAutomaton, language: IntArray) -> list[tuple[int, int]]:
    """Pairs (to be replaced, replacement) of states with the same language, the most similar rows first."""
    old, new = pairs_within(language)
    marks = number_blocks(mark for row in automaton.edge_marks for mark in row).reshape(automaton.delta.shape)
    differences = (automaton.delta[old] != automaton.delta[new]) | (marks[old] != marks[new])
    order = np.lexsort((new, -old, differences.sum(axis=1)))
    return list(zip(old[order].tolist(), new[order].tolist(), strict=True))


def _redirected(automaton: RabinAutomaton, old: int, new: int) -> RabinAutomaton:
    """Every way into `old` leads into `new`."""
    target = np.arange(automaton.n_states, dtype=np.int32)
    target[old] = new
    return replace(automaton, delta=target[automaton.delta], initial_state=int(target[automaton.initial_state]))
