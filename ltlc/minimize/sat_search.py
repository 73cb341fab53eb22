"""Search, by SAT, for a component with few states that carries a Rabin condition for a component of the residuals.

Each state of the wanted component is a *copy* of a residual. Variables say where the columns lead; then words that
repeat for ever, with their verdicts, constrain the cycles that they take. Instead of a number of pairs, each accepted
cycle chooses labels of its own, and no rejected cycle inside it may have one of them; this is possible iff some number
of Rabin pairs is. Words come one by one, from conflicts of the last candidate with the language, until a candidate
carries a condition or there is none.

References:
    R. Ehlers: Minimising deterministic Buchi automata precisely using SAT solving. SAT 2010, doi
    10.1007/978-3-642-14186-7_28.
    S. Baarir, A. Duret-Lutz: SAT-based minimization of deterministic omega-automata. LPAR 2015, doi
    10.1007/978-3-662-48899-7_6 (both encode the whole product with the given automaton instead of words).
    E. Clarke, O. Grumberg, S. Jha, Y. Lu, H. Veith: Counterexample-guided abstraction refinement. CAV 2000, doi
    10.1007/10722167_15.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise, permutations, product
from typing import NamedTuple

from ltlc import graph
from ltlc.automata.rabin_type import Conflict, rabin_condition, smallest_conflict
from ltlc.budget import check_time
from ltlc.minimize.cnf import Cnf, Row
from ltlc.minimize.collapse import Structure, with_simple_marks
from ltlc.minimize.residuals import Part

_MAX_PERMUTED = 4
"""numbers of copies up to which all permutations are looked at."""


class Word(NamedTuple):
    """Columns that lead from a residual back to it, repeated for ever."""

    residual: int
    columns: tuple[int, ...]
    accepted: bool


class _Run(NamedTuple):
    """The run of a word from one copy of its residual, provided that it comes back to this copy."""

    returns: int
    """variable; true at least if it comes back."""
    labels: dict[int, int]
    """per label that may be on the cycle, a variable: it is."""
    kinds: frozenset[int]
    """labels with copies of one residual taken together."""


class Search:
    """Whether some component with at most `n_states` states will do.

    Args:
        part: what it must cover.
        n_states: at least the number of residuals of the part.
        words: words to start with, for instance those of an earlier search; `words` of the search has the new ones too.

    Raises:
        MissingProgramError: python-sat is not installed.
    """

    def __init__(self, part: Part, n_states: int, words: Iterable[Word] = ()) -> None:
        self.part, self.on_states = part, part.acceptance == "state"
        self.n_extra = n_states - len(part.residuals)
        self.n_copies = self.n_extra + 1
        self.words: dict[Word, None] = {}
        self._cnf = Cnf()
        self._true = self._cnf.true
        self._used = [self._cnf.variables(self.n_copies) for _ in part.residuals]
        self._delta: dict[tuple[int, int, int], Row] = {}
        self._active: list[int] = []
        self._numbered: set[int] = set()
        self._accepted: list[tuple[_Run, dict[int, int]]] = []
        self._rejected: list[_Run] = []
        self._declare()
        for word in words:
            for column in word.columns:
                self._activate(column)
            self._add(word)

    def run(self) -> Structure | None:
        """A component, or None if there is none.

        Raises:
            TimeLimitExceeded: the time of the call is over.
        """
        while self._cnf.solve():
            candidate = self._candidate()
            cycles = self.part.cycle_graph(candidate.step, candidate.residual_of, self.on_states)
            found = rabin_condition(cycles)
            check_time()
            if not isinstance(found, Conflict):
                return self._strong(candidate)
            # Short words over few columns exclude most.
            inactive = [c for c in range(self.part.n_columns) if c not in self._active]
            conflict = smallest_conflict(cycles, found, [*inactive, *self._active])
            walks = [cycles.accepted_cycle(conflict.accepted), *map(cycles.rejected_cycle, conflict.rejected)]
            n_known = len(self.words)
            for walk in walks:
                residual = candidate.residual_of[cycles.runs[walk[0][0]][0]]
                columns = cycles.columns_along(walk)
                for c in columns:
                    self._activate(c)
                self._add(_normal(self.part, residual, columns))
            assert len(self.words) > n_known
        return None

    # The component

    def _declare(self) -> None:
        """Used copies, and one next copy per copy and column; copies that are not used lead to first copies."""
        for used in self._used:
            self._cnf.clause(used[0])
            for one, following in pairwise(used):
                self._cnf.clause(-following, one)
        self._cnf.at_most([literal for used in self._used for literal in used[1:]], self.n_extra)

    def _activate(self, column: int) -> None:
        """From each copy, the column leads to exactly one next copy; words of one or two columns are added."""
        if column in self._active:
            return
        self._active.append(column)
        for r, row in enumerate(self.part.step):
            target = row[column]
            if target < 0:
                continue
            for i in range(self.n_copies):
                following = [self._true] if self.n_copies == 1 else self._cnf.variables(self.n_copies)
                self._delta[r, i, column] = following
                self._cnf.exactly_one(following)
                for used, literal in zip(self._used[target], following, strict=True):
                    self._cnf.clause(-literal, used)
                self._cnf.clause(self._used[r][i], following[0])
            if target == r and r not in self._numbered:
                self._numbered.add(r)
                self._number_copies(r, column)
        for other in self._active:
            for columns in dict.fromkeys([(column,), (column, other)]):
                for residual in range(len(self.part.residuals)):
                    if self.part.after(residual, columns) == residual:
                        self._add(_normal(self.part, residual, columns))

    def _number_copies(self, residual: int, column: int) -> None:
        """Copies can be permuted: what a column that stays in the residual does with them is the first of its kind."""
        lead = [self._delta[residual, i, column] for i in range(self.n_copies)]
        if self.n_copies > _MAX_PERMUTED:
            for i, literals in enumerate(lead):
                for literal in literals[i + 2 :]:
                    self._cnf.clause(-literal)
            return
        used = [*self._used[residual], -self._true]
        for n in range(2, self.n_copies + 1):
            orders = list(permutations(range(n)))
            for images in product(range(n), repeat=n):
                if any(_renamed(images, order) < images for order in orders):
                    steps = (-lead[i][j] for i, j in enumerate(images))
                    self._cnf.clause(-used[n - 1], used[n], *steps)

    def _candidate(self) -> Structure:
        """What the solver found; columns that are not active lead to first copies."""
        true = self._cnf.model()
        order = [(r, i) for r, used in enumerate(self._used) for i, literal in enumerate(used) if literal in true]
        number = {copy: q for q, copy in enumerate(order)}

        def following(r: int, i: int, c: int) -> int:
            target = self.part.step[r][c]
            if target < 0 or c not in self._active:
                return number[target, 0] if target >= 0 else -1
            return number[target, next(j for j, literal in enumerate(self._delta[r, i, c]) if literal in true)]

        step = tuple(tuple(following(r, i, c) for c in range(self.part.n_columns)) for r, i in order)
        return Structure(tuple(r for r, _ in order), step, ())

    def _strong(self, structure: Structure) -> Structure:
        """Its last strong component, with pairs."""
        component = graph.strong_components([[t for t in row if t >= 0] for row in structure.step])
        kept = [q for q in range(len(component)) if component[q] == max(component)]
        index = {q: i for i, q in enumerate(kept)} | {-1: -1}
        residual_of = tuple(structure.residual_of[q] for q in kept)
        step = tuple(tuple(index[t] for t in structure.step[q]) for q in kept)
        pairs = rabin_condition(self.part.cycle_graph(step, residual_of, self.on_states))
        assert isinstance(pairs, list)
        return with_simple_marks(self.part, residual_of, step, pairs)

    # Words

    def _add(self, word: Word) -> None:
        """The cycles of a word have its verdict."""
        if word in self.words:
            return
        self.words[word] = None
        for run in self._runs(word):
            if word.accepted:
                chosen = {label: self._cnf.variable() for label in run.labels}
                self._cnf.clause(-run.returns, *chosen.values())
                for label, literal in chosen.items():
                    self._cnf.clause(-literal, run.labels[label])
                for other in self._rejected:
                    self._keep_apart(run, chosen, other)
                self._accepted.append((run, chosen))
            else:
                for accepted, chosen in self._accepted:
                    self._keep_apart(accepted, chosen, run)
                self._rejected.append(run)

    def _keep_apart(self, accepted: _Run, chosen: dict[int, int], rejected: _Run) -> None:
        """A rejected cycle that has a chosen label of an accepted one has a label that the accepted one has not."""
        if not rejected.kinds <= accepted.kinds:
            return
        check_time()
        outside = []
        for label, literal in rejected.labels.items():
            differs = self._cnf.variable()
            self._cnf.clause(-differs, literal)
            if label in accepted.labels:
                self._cnf.clause(-differs, -accepted.labels[label])
            outside.append(differs)
        both = (-accepted.returns, -rejected.returns)
        for label, literal in chosen.items():
            if label in rejected.labels:
                self._cnf.clause(*both, -literal, -rejected.labels[label], *outside)

    def _runs(self, word: Word) -> Iterator[_Run]:
        """From each copy of the residual, as many rounds as a cycle may have."""
        for i in range(self.n_copies):
            occurs: dict[int, dict[int, None]] = {}
            back = []
            residual, here = word.residual, [self._true if j == i else -self._true for j in range(self.n_copies)]
            for _ in range(self.n_copies):
                for c in word.columns:
                    check_time()
                    target = self.part.step[residual][c]
                    following = self._next(residual, here, c)
                    if not self.on_states:
                        for j, literal in enumerate(here):
                            occurs.setdefault(self._label(residual, j, c), {})[literal] = None
                    else:
                        for j, literal in enumerate(following):
                            occurs.setdefault(self._label(target, j), {})[literal] = None
                    residual, here = target, following
                back.append(here[i])
            labels = {label: self._cnf.some(list(literals)) for label, literals in occurs.items()}
            yield _Run(self._cnf.some(back), labels, frozenset(label // self.n_copies for label in labels))

    def _label(self, residual: int, copy: int, column: int = 0) -> int:
        return (residual * self.part.n_columns + column) * self.n_copies + copy

    def _next(self, residual: int, here: Row, column: int) -> Row:
        """Where one is after a column, per copy; `here` and the result have exactly one true literal."""
        if self.n_copies == 1:
            return here
        if here.count(self._true) == 1:
            return self._delta[residual, here.index(self._true), column]
        following = self._cnf.variables(self.n_copies)
        for j, literal in enumerate(here):
            for k, target in enumerate(self._delta[residual, j, column]):
                self._cnf.clause(-literal, -target, following[k])
                self._cnf.clause(-literal, -following[k], target)
        return following


def _renamed(images: Sequence[int], order: Sequence[int]) -> tuple[int, ...]:
    """The function with i renamed to order[i]."""
    renamed = [0] * len(order)
    for i, j in enumerate(images):
        renamed[order[i]] = order[j]
    return tuple(renamed)


def _normal(part: Part, residual: int, columns: Sequence[int]) -> Word:
    """The same cycle, written once and from its smallest point."""
    columns = tuple(columns)
    for length in range(1, len(columns) + 1):
        once = columns[:length]
        if once * (len(columns) // length) == columns and part.after(residual, once) == residual:
            columns = once
            break
    rotations = []
    for turn in range(len(columns)):
        rotations.append((residual, columns[turn:] + columns[:turn]))
        residual = part.step[residual][columns[turn]]
    residual, columns = min(rotations)
    return Word(residual, columns, part.accepts(residual, columns))
