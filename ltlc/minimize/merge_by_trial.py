"""Merge states of one language by trial: redirect, and keep the result if nothing changed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ltlc import graph
from ltlc.automata.acceptance import exactly_one, rabin_accepts, recurring_marks
from ltlc.automata.alphabet import letter_classes
from ltlc.automata.canonical import CANONICAL, canonical
from ltlc.automata.emptiness import accepting_walk
from ltlc.automata.languages import can_decide_languages, equivalent_states
from ltlc.automata.partition import IntArray, number_blocks, pairs_within
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time
from ltlc.errors import TimeLimitExceeded

EFFORT = 200_000
"""default bound on the number of product edges looked at."""
_COST_OF_WORD = 20
"""a candidate refuted by a known word takes about as long as this many product edges."""
_FIRST_LOOK = 16
"""nodes of a product after which it is looked at for the first time."""


def merge_by_trial(automaton: DRA, effort: int = EFFORT, *, reference: DRA | None = None, least: int = 1) -> DRA:
    """Replace states by others with the same language, as long as the automaton keeps its language.

    Unlike `merge_equivalent` this merges inside a strong component, where equal languages are not enough: a run could
    be redirected for ever. So each replacement is tried, most similar states first, and decided exactly. States keep
    their languages on the way, because what can follow a prefix is fixed by the language of the whole. So only cycles
    that are redirected can go wrong, and another automaton of the language can tell which do. Where the time of the
    call is over, what is merged stays so.

    Args:
        automaton: any Rabin automaton.
        effort: number of product edges after which no more is tried; 0 tries nothing.
        reference: an equivalent automaton over the same propositions, the smaller the better; by default itself.
        least: no equivalent automaton has fewer states, so that nothing is tried once it is reached.
    """
    result = automaton
    with suppress(TimeLimitExceeded):
        for smaller in _merging(automaton, effort, reference):
            result = smaller
            if result.n_states <= least:
                break
    return result


def _merging(automaton: DRA, effort: int, reference: DRA | None) -> Iterator[DRA]:
    """The automaton in canonical form, and after each merging."""
    current = automaton if CANONICAL in automaton.forms else canonical(automaton)
    yield current
    if effort <= 0:
        return
    if current.has_languages or can_decide_languages(current):
        language = current.languages
    else:
        language = equivalent_states(current, effort)
    judge = _Judge(current, current if reference is None else reference)
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
            found = judge.wrong_word(current, old, new)
            if found is None:
                entered = np.arange(current.n_states, dtype=np.int32)
                entered[old] = new
                kept = graph.reachable(entered[current.delta], [int(entered[current.initial_state])])
                language = language[kept]
                judge.keep(kept)
                current, merged = canonical(current, entered), True
                yield current
                break
            words.insert(0, found)


class _Judge:
    """Decides redirections by another automaton of the language.

    Args:
        automaton: canonical; its states may become fewer.
        reference: an automaton of the same language over the same propositions.
    """

    def __init__(self, automaton: DRA, reference: DRA) -> None:
        self.reference = reference
        _, self.letters = letter_classes([automaton.letter_class, reference.letter_class], len(automaton.letter_class))
        self.twin = twins(automaton, reference)
        self._known: dict[tuple[int, int], list[tuple[int, int, int]]] = {}

    def keep(self, states: list[int]) -> None:
        """Only these states are left, in this order."""
        self.twin = [self.twin[q] for q in states]
        self._known = {}

    def wrong_word(self, automaton: DRA, old: int, new: int) -> _Word | None:
        """A word whose verdict changes if `new` is entered in place of `old`, a state of the same language.

        Cycles that are not redirected keep their verdicts, and the others pass through `new`. Most redirections go
        wrong soon, so cycles are looked for before all of the product is known.
        """
        scc = automaton.scc
        if scc[new] > scc[old]:  # nothing leads back
            return None
        columns = self._columns(automaton, scc[new], scc[old])
        differ = exactly_one(automaton.n_pairs, self.reference.n_pairs)
        entered_new = int(automaton.marks[new]) if automaton.acceptance == "state" else None
        shift = 2 * automaton.n_pairs
        nodes = [(new, self.twin[new])]
        number = {nodes[0]: 0}
        along: list[dict[tuple[int, int], int]] = []  # per node, its edges and a letter on each
        enough = _FIRST_LOOK
        for state, other in nodes:  # grows while it is read
            row, marks = automaton.rows[state], automaton.edge_marks[state]
            row_of_other, marks_of_other = self.reference.rows[other], self.reference.edge_marks[other]
            edges: dict[tuple[int, int], int] = {}
            for c, d, letter in columns:
                target, seen = row[c], marks[c]
                if target == old:
                    target, seen = new, seen if entered_new is None else entered_new
                elif not scc[new] <= scc[target] <= scc[old]:
                    continue
                node = (target, row_of_other[d])
                if node not in number:
                    number[node] = len(nodes)
                    nodes.append(node)
                edges.setdefault((number[node], seen | marks_of_other[d] << shift), letter)
            along.append(edges)
            if len(along) == enough or len(along) == len(nodes):
                enough *= 4
                rows = [sorted(edges) for edges in along] + [[]] * (len(nodes) - len(along))
                walk = accepting_walk(rows, differ, 0)
                if walk is not None:
                    prefix, cycle = [[along[source][target, m] for source, target, m in part] for part in walk]
                    prefix = _way(automaton, new) + prefix
                    return _Word(prefix, cycle, automaton.accepts_letters(prefix, cycle))
        return None

    def _columns(self, automaton: DRA, first: int, last: int) -> list[tuple[int, int, int]]:
        """Of the letters that do the same in these strong components, in both automata, one; with its classes."""
        if (first, last) not in self._known:
            inside = {q for q in range(automaton.n_states) if first <= automaton.scc[q] <= last}
            others = set(range(self.reference.n_states))
            if self.reference.has_languages:
                language = self.reference.languages.tolist()
                residuals = {language[self.twin[q]] for q in inside}
                others = {r for r in others if language[r] in residuals}
            kinds = _kinds_of_columns(automaton, inside), _kinds_of_columns(self.reference, others)
            columns: dict[tuple[int, int], tuple[int, int, int]] = {}
            classes = automaton.letter_class[self.letters], self.reference.letter_class[self.letters], self.letters
            for c, d, letter in zip(*(entries.tolist() for entries in classes), strict=True):
                columns.setdefault((kinds[0][c], kinds[1][d]), (c, d, letter))
            self._known[first, last] = list(columns.values())
        return self._known[first, last]


def _kinds_of_columns(automaton: DRA, inside: set[int]) -> list[int]:
    """Per letter class a number, the same for those that do the same as long as the run stays in these states."""
    kinds: dict[tuple[tuple[int, int], ...], int] = {}
    tables = [list(zip(automaton.rows[q], automaton.edge_marks[q], strict=True)) for q in sorted(inside)]
    columns = (tuple(edge if edge[0] in inside else (-1, 0) for edge in column) for column in zip(*tables, strict=True))
    return [kinds.setdefault(column, len(kinds)) for column in columns]


def twins(automaton: DRA, other: DRA) -> list[int]:
    """A state of the same language for each state, in an equivalent automaton over the same propositions.

    Args:
        automaton: all of its states can be reached.
        other: the equivalent automaton.
    """
    columns = other.letter_class[automaton.alphabet.first_letter].tolist()
    twin = {automaton.initial_state: other.initial_state}
    order = [automaton.initial_state]
    for state in order:  # grows while it is read
        for target, c in zip(automaton.rows[state], columns, strict=True):
            if target not in twin:
                twin[target] = other.rows[twin[state]][c]
                order.append(target)
    return [twin[q] for q in range(automaton.n_states)]


def _way(automaton: DRA, state: int) -> list[int]:
    """Letters that lead from the initial state to another one."""
    came: dict[int, tuple[int, int]] = {}
    order = [automaton.initial_state]
    for source in order:  # grows while it is read
        for c, target in enumerate(automaton.rows[source]):
            if target not in came and target != automaton.initial_state:
                came[target] = source, int(automaton.alphabet.first_letter[c])
                order.append(target)
    letters = []
    while state != automaton.initial_state:
        state, letter = came[state]
        letters.append(letter)
    return letters[::-1]


class _Word(NamedTuple):
    """A lasso word in letters of the automaton, and whether it is in the language."""

    prefix: list[int]
    cycle: list[int]
    accepted: bool


def _refuted(automaton: DRA, old: int, new: int, words: list[_Word]) -> bool:
    """Whether entering `new` instead of `old` changes the verdict on a word; that word moves to the front."""
    for position, word in enumerate(words):
        if _accepts_redirected(automaton, old, new, word) != word.accepted:
            words.insert(0, words.pop(position))
            return True
    return False


def _accepts_redirected(automaton: DRA, old: int, new: int, word: _Word) -> bool:
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
    return rabin_accepts(automaton.n_pairs, recurring_marks(state, lambda start: run(start, word.cycle)))


def _candidates(automaton: DRA, language: IntArray) -> list[tuple[int, int]]:
    """Pairs (to be replaced, replacement) of states with the same language, the most similar rows first."""
    old, new = pairs_within(language)
    marks = number_blocks(mark for row in automaton.edge_marks for mark in row).reshape(automaton.delta.shape)
    differences = (automaton.delta[old] != automaton.delta[new]) | (marks[old] != marks[new])
    order = np.lexsort((new, -old, differences.sum(axis=1)))
    return list(zip(old[order].tolist(), new[order].tolist(), strict=True))
