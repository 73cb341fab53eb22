"""Merge states of one language by trial: redirect, and keep the result if nothing changed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from operator import add
from typing import NamedTuple

from ltlc import graph
from ltlc.arrays import IntArray, np
from ltlc.automata.acceptance import exactly_one
from ltlc.automata.canonical import CANONICAL, canonical
from ltlc.automata.columns import letter_classes
from ltlc.automata.emptiness import accepting_walk
from ltlc.automata.languages import can_decide_languages, equivalent_states
from ltlc.automata.partition import number_blocks
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time
from ltlc.errors import TimeLimitExceeded
from ltlc.minimize.similar import edge_codes, most_similar
from ltlc.minimize.words import Word, Words, accepts, entered_states

EFFORT = 800_000
"""default bound on the number of product edges looked at in vain,"""
_SHARE_AT_FIRST = 16
"""of which this part, 1 / 16, may be looked at before the first merging: mostly there is none later."""
_EDGES_PER_PAIR = 64
"""nor more than so many of the default bound for each pair of states: the first merging was found within a fifth."""
_SHARE_FOR_READING = 4
"""and of which the edges of the automaton may be this part, 1 / 4: reading more costs more than merging gains."""
_COST_OF_WORD = 20
"""a candidate refuted by a known word takes about as long as this many product edges."""
_FIRST_LOOK = 16
"""nodes of a product after which it is looked at for the first time."""


def merge_by_trial(
    automaton: DRA,
    effort: int = EFFORT,
    *,
    reference: DRA | None = None,
    least: int = 1,
    split_from: DRA | None = None,
    words: Words | None = None,
) -> DRA:
    """Replace states by others with the same language, as long as the automaton keeps its language.

    Unlike `merge_equivalent` this merges inside a strong component, where equal languages are not enough: a run could
    be redirected for ever. So each replacement is tried, most similar states first, and decided exactly. States keep
    their languages on the way, because what can follow a prefix is fixed by the language of the whole. So only cycles
    that are redirected can go wrong, and another automaton of the language can tell which do. Where the time of the
    call is over, what is merged stays so.

    Args:
        automaton: any Rabin automaton.
        effort: number of product edges, looked at in vain, after which no more is tried, or a part of them if nothing
            has been merged by then; nothing is tried in an automaton with more than a quarter as many edges.
        reference: an equivalent automaton over the same propositions, the smaller the better; by default itself.
        least: no equivalent automaton has fewer states, so that nothing is tried once it is reached.
        split_from: the automaton whose states were split into those of this one, if none of the copies of one state
            can replace another: they are not tried.
        words: what told replacements apart in other automata of the language; these words are asked first, and those
            that are found here are added.
    """
    result = automaton
    with suppress(TimeLimitExceeded):
        for smaller in _merging(automaton, effort, reference, split_from, [] if words is None else words):
            result = smaller
            if result.n_states <= least:
                break
    return result


def _merging(automaton: DRA, effort: int, reference: DRA | None, split_from: DRA | None, words: Words) -> Iterator[DRA]:
    """The automaton in canonical form, and after each merging.

    What was refuted is not tried again after the next merging: hardly ever does that make a difference.
    """
    current = automaton if CANONICAL in automaton.forms else canonical(automaton)
    yield current
    if current.n_states * current.n_classes * _SHARE_FOR_READING > effort:
        return
    language = current.languages if can_decide_languages(current) else equivalent_states(current, effort)
    trial = _Trial(current, current if reference is None else reference, words)
    names = list(range(current.n_states))  # of the states, in the first automaton
    origin = names if split_from is None else twins(current, split_from)
    refuted: set[tuple[int, int]] = set()
    until = min(effort // _SHARE_AT_FIRST, effort * _EDGES_PER_PAIR * current.n_states**2 // EFFORT)
    merged = True
    while merged:
        merged = False
        for old, new in most_similar(trial.codes, language):
            known = names[old], names[new]
            if known in refuted or origin[known[0]] == origin[known[1]]:
                continue
            if trial.n_edges >= until:
                return
            check_time()
            refuted.add(known)
            before = trial.n_edges
            if trial.is_refuted(old, new) or trial.finds_word(old, new):
                continue
            trial.n_edges = before + current.n_states * current.n_classes  # what is not in vain may cost more
            entered = np.arange(current.n_states, dtype=np.int32)
            entered[old] = new
            kept = graph.reachable(entered[current.delta], [int(entered[current.initial_state])])
            language, names = language[kept], [names[q] for q in kept]
            current, merged, until = canonical(current, entered.tolist()), True, effort
            trial.goes_on(current, kept)
            yield current
            break


class _Columns(NamedTuple):
    """Of the letters that do the same in some strong components, in both automata, one; and where it leads.

    Moves are integers such that the sum of one of each automaton is an edge of the product: its target times the power
    of two above all marks, and its marks.
    """

    letters: list[int]
    ours: dict[int, list[int]]
    theirs: dict[int, list[int]]


class _Trial:
    """Decides redirections by another automaton of the language.

    Args:
        automaton: canonical.
        reference: an automaton of the same language over the same propositions.
        words: see `merge_by_trial`.

    Attributes:
        codes: of the automaton, by `edge_codes`.
        n_edges: number of product edges looked at so far, and what else takes as long.
    """

    def __init__(self, automaton: DRA, reference: DRA, words: Words) -> None:
        self._found = words
        self.words = [Word(letters) for letters in words]
        self.n_edges = 0
        self._asks(reference, automaton)
        self.goes_on(automaton, range(automaton.n_states))

    def _asks(self, reference: DRA, automaton: DRA) -> None:
        """Decide by this automaton of the language from now on."""
        self.reference = reference
        self._reference_codes = edge_codes(reference)
        _, self.letters = letter_classes([automaton.letter_class, reference.letter_class], len(automaton.letter_class))
        self.twin = twins(automaton, reference)
        self._shift = 2 * automaton.n_pairs
        self._n_marks = self._shift + 2 * reference.n_pairs
        self._differ = exactly_one(automaton.n_pairs, reference.n_pairs, 1 << self._n_marks)
        for word in self.words:
            word.accepted = {}

    def goes_on(self, automaton: DRA, states: Iterable[int]) -> None:
        """Go on with a smaller automaton, which has these states of the one before, in this order.

        It is an automaton of the language itself, and the one to ask once it is the smaller one.
        """
        self.automaton = automaton
        self.codes = edge_codes(automaton)
        self.twin = [self.twin[q] for q in states]
        if automaton.n_states < self.reference.n_states:
            self._asks(automaton, automaton)
        self._known: dict[tuple[int, int], _Columns] = {}
        for word in self.words:
            word.classes = self._classes(automaton, word)
            word.entered = {}

    def is_refuted(self, old: int, new: int) -> bool:
        """Whether entering `new` instead of `old` changes the verdict on a known word; that word moves to the front."""
        twin = self.twin[new]
        self.n_edges += _COST_OF_WORD
        entered = int(self.automaton.marks[new]) if self.automaton.acceptance == "state" else None
        for position, word in enumerate(self.words):
            if new not in word.entered:
                word.entered[new] = entered_states(self.automaton, new, word.classes)
            if not word.entered[new] >> old & 1:
                continue
            if twin not in word.accepted:
                word.accepted[twin] = accepts(self.reference, twin, self._classes(self.reference, word))
            if accepts(self.automaton, new, word.classes, old, entered) != word.accepted[twin]:
                self.words.insert(0, self.words.pop(position))
                return True
        return False

    def _classes(self, automaton: DRA, word: Word) -> tuple[list[int], list[int]]:
        prefix, cycle = [automaton.letter_class[letters].tolist() for letters in word.letters]
        return prefix, cycle

    def finds_word(self, old: int, new: int) -> bool:
        """Whether there is a word whose verdict changes if `new` is entered in place of `old`; it is known afterwards.

        Cycles that are not redirected keep their verdicts, and the others pass through `new`. Most redirections go
        wrong soon, so cycles are looked for before all of the product is known.
        """
        scc = self.automaton.scc
        first, last = scc[new], scc[old]
        if first > last:  # nothing leads back
            return False
        letters, ours, theirs = self._columns(first, last)
        n_others, n_marks, shift = self.reference.n_states, self._n_marks, self._shift
        entered = int(self.automaton.marks[new]) if self.automaton.acceptance == "state" else None
        redirected = 1 << n_marks
        nodes = [new * n_others + self.twin[new]]
        number = {nodes[0]: 0}
        along: list[dict[tuple[int, int], int]] = []  # per node, its edges and a letter on each
        edge_of: dict[int, tuple[int, int] | None] = {}  # per move; None where it leads out
        enough = _FIRST_LOOK
        for source in nodes:  # grows while it is read
            state, other = divmod(source, n_others)
            edges: dict[tuple[int, int], int] = {}
            for move, letter in dict(zip(map(add, ours[state], theirs[other]), letters, strict=True)).items():
                if move not in edge_of:
                    node, marks = move >> n_marks, move & redirected - 1
                    target, twin = divmod(node, n_others)
                    edge_of[move] = None
                    if target == old:
                        node = new * n_others + twin
                        marks = redirected | (marks if entered is None else marks >> shift << shift | entered)
                    elif not first <= scc[target] <= last:
                        continue
                    if node not in number:
                        number[node] = len(nodes)
                        nodes.append(node)
                    edge_of[move] = number[node], marks
                edge = edge_of[move]
                if edge is not None:
                    edges[edge] = letter
            along.append(edges)
            self.n_edges += len(letters)
            if len(along) == enough or len(along) == len(nodes):
                enough *= 4
                rows = [sorted(edges) for edges in along] + [[]] * (len(nodes) - len(along))
                walk = accepting_walk(rows, self._differ, 0, is_reachable=True)
                if walk is not None:
                    prefix, cycle = [[along[source][target, m] for source, target, m in part] for part in walk]
                    word = Word((prefix, cycle))
                    word.classes = self._classes(self.automaton, word)
                    self.words.insert(0, word)
                    self._found.insert(0, word.letters)
                    return True
        return False

    def _columns(self, first: int, last: int) -> _Columns:
        """The columns for these strong components of the automaton."""
        if (first, last) not in self._known:
            automaton, reference = self.automaton, self.reference
            inside = {q for q in range(automaton.n_states) if first <= automaton.scc[q] <= last}
            others = set(range(reference.n_states))
            if reference.has_languages:
                language = reference.languages.tolist()
                residuals = {language[self.twin[q]] for q in inside}
                others = {r for r in others if language[r] in residuals}
            kinds = (
                _kinds_of_columns(automaton, self.codes, inside),
                _kinds_of_columns(reference, self._reference_codes, others),
            )
            columns: dict[tuple[int, int], tuple[int, int, int]] = {}
            classes = automaton.letter_class[self.letters], reference.letter_class[self.letters], self.letters
            for c, d, letter in zip(*(entries.tolist() for entries in classes), strict=True):
                columns.setdefault((kinds[0][c], kinds[1][d]), (c, d, letter))
            kept = list(columns.values())
            ours, theirs, letters = [c for c, _, _ in kept], [d for _, d, _ in kept], [letter for *_, letter in kept]
            self._known[first, last] = _Columns(
                letters,
                _moves(automaton, inside, ours, reference.n_states << self._n_marks, 1),
                _moves(reference, others, theirs, 1 << self._n_marks, 1 << self._shift),
            )
        return self._known[first, last]


def _moves(automaton: DRA, states: Iterable[int], columns: list[int], target: int, mark: int) -> dict[int, list[int]]:
    """Per state and column: next state and marks, each times a factor, added."""
    return {
        q: [row[c] * target + marks[c] * mark for c in columns]
        for q, row, marks in ((q, automaton.rows[q], automaton.edge_marks[q]) for q in states)
    }


def _kinds_of_columns(automaton: DRA, codes: IntArray, inside: set[int]) -> list[int]:
    """Per letter class a number, the same for those that do the same as long as the run stays in these states."""
    states = sorted(inside)
    stays = np.zeros(automaton.n_states, dtype=np.bool_)
    stays[states] = True
    columns = np.where(stays[automaton.delta[states]], codes[states] + 1, 0).T
    kinds: list[int] = number_blocks(map(np.ndarray.tobytes, columns)).tolist()
    return kinds


def twins(automaton: DRA, other: DRA) -> list[int]:
    """A state of the same language for each state, in an equivalent automaton over the same propositions.

    Args:
        automaton: all of its states can be reached.
        other: the equivalent automaton.
    """
    ours, theirs = automaton.alphabet.classes, other.alphabet.classes
    if isinstance(ours, list) and isinstance(theirs, list):
        first: dict[int, int] = {}
        for c, their_class in zip(ours, theirs, strict=True):
            first.setdefault(c, their_class)
        columns = [first[c] for c in range(automaton.n_classes)]
    else:
        columns = other.letter_class[automaton.alphabet.first_letter].tolist()
    twin = {automaton.initial_state: other.initial_state}
    order = [automaton.initial_state]
    successors = automaton.successors
    for state in order:  # grows while it is read
        row = successors[state]
        firsts = columns if len(row) == len(columns) else [columns[(automaton.delta[state] == t).argmax()] for t in row]
        for target, c in zip(row, firsts, strict=True):
            if target not in twin:
                row_of_twin = other.rows[twin[state]] if other.is_listed else other.delta[twin[state]]
                twin[target] = int(row_of_twin[c])
                order.append(target)
    return [twin[q] for q in range(automaton.n_states)]
