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

import time
from collections.abc import Iterable, Iterator, Sequence
from importlib import import_module
from itertools import combinations, product
from typing import Any, NamedTuple

from ltlc import graph
from ltlc.automata.rabin_type import Conflict, LabelPair, rabin_condition, smallest_conflict
from ltlc.automata.residuals import Part
from ltlc.errors import MissingProgramError, TimeLimitExceeded

_SOLVER = "glucose4"
_CONFLICTS = 2000
"""conflicts after which the solver looks at the clock."""
_MAX_FIRST_WORDS = 40

Row = list[int]


class Structure(NamedTuple):
    """A component that covers a part of the residual automaton."""

    residual_of: tuple[int, ...]
    """residual of the part, per state."""
    step: tuple[tuple[int, ...], ...]
    """per state and column: the next state; -1 where the part is left."""
    pairs: tuple[LabelPair, ...]
    """labels as in `Part.cycle_graph`."""


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


class Search:
    """Whether some component with at most `n_states` states will do.

    Args:
        part: what it must cover.
        n_states: at least the number of residuals of the part.
        on_states: whether acceptance is on states.
        words: words to start with, for instance those of an earlier search; `words` of the search has the new ones too.

    Raises:
        MissingProgramError: python-sat is not installed.
    """

    def __init__(self, part: Part, n_states: int, on_states: bool, words: Iterable[Word] = ()) -> None:
        self.part, self.on_states = part, on_states
        self.n_extra = n_states - len(part.residuals)
        self.n_copies = self.n_extra + 1
        self.words: dict[Word, None] = {}
        self._n_variables = 0
        self._solver = _solver()
        self._true = self._variable()
        self._clause(self._true)
        self._used = [self._variables(self.n_copies) for _ in part.residuals]
        self._delta: dict[tuple[int, int, int], Row] = {}
        self._functions: dict[tuple[int, tuple[int, ...]], list[Row]] = {}
        self._accepted: list[tuple[_Run, dict[int, int]]] = []
        self._rejected: list[_Run] = []
        self._declare()
        for word in words or _first_words(part):
            self._add(word)

    def run(self, deadline: float | None = None) -> Structure | None:
        """A component, or None if there is none.

        Raises:
            TimeLimitExceeded: the deadline, as of `time.monotonic`, is over.
        """
        while self._solve(deadline):
            candidate = self._candidate()
            cycles = self.part.cycle_graph(candidate.step, candidate.residual_of, self.on_states)
            found = rabin_condition(cycles)
            if not isinstance(found, Conflict):
                return candidate._replace(pairs=tuple(found or ()))
            conflict = smallest_conflict(cycles, found)
            walks = [cycles.accepted_cycle(conflict.accepted), *map(cycles.rejected_cycle, conflict.rejected)]
            n_known = len(self.words)
            for walk in walks:
                residual = candidate.residual_of[cycles.runs[walk[0][0]][0]]
                self._add(_normal(self.part, residual, cycles.columns_along(walk)))
            assert len(self.words) > n_known
        return None

    def _solve(self, deadline: float | None) -> bool:
        while True:
            self._solver.conf_budget(_CONFLICTS)
            answer = self._solver.solve_limited()
            if answer is not None:
                return bool(answer)
            if deadline is not None and time.monotonic() > deadline:
                raise TimeLimitExceeded("no smaller automaton found, and none excluded, in the time given")

    # Variables and clauses

    def _variable(self) -> int:
        self._n_variables += 1
        return self._n_variables

    def _variables(self, count: int) -> Row:
        return [self._variable() for _ in range(count)]

    def _clause(self, *literals: int) -> None:
        self._solver.add_clause(literals)

    def _some(self, literals: Sequence[int]) -> int:
        """A variable that is true iff one of the literals is."""
        if len(literals) == 1:
            return literals[0]
        some = self._variable()
        for literal in literals:
            self._clause(-literal, some)
        self._clause(-some, *literals)
        return some

    def _exactly_one(self, literals: Sequence[int]) -> None:
        self._clause(*literals)
        for one, other in combinations(literals, 2):
            self._clause(-one, -other)

    def _at_most(self, literals: Sequence[int], bound: int) -> None:
        """At most `bound` of the literals are true.

        References:
            C. Sinz: Towards an optimal CNF encoding of Boolean cardinality constraints. CP 2005, doi 10.1007/11564751_73.
        """
        if len(literals) <= bound:
            return
        before: Row = []
        for literal in literals:
            count = self._variables(bound)
            if bound:
                self._clause(-literal, count[0])
            for k, reached in enumerate(before):
                self._clause(-reached, count[k])
                if k + 1 < bound:
                    self._clause(-reached, -literal, count[k + 1])
            if before or not bound:
                self._clause(-literal, *(-reached for reached in before[-1:]))
            before = count

    # The component

    def _declare(self) -> None:
        """Used copies, and one next copy per copy and column; copies that are not used lead to first copies."""
        for used in self._used:
            self._clause(used[0])
            for one, following in zip(used, used[1:], strict=False):
                self._clause(-following, one)
        self._at_most([literal for used in self._used for literal in used[1:]], self.n_extra)
        for r, row in enumerate(self.part.step):
            for i, c in product(range(self.n_copies), range(self.part.n_columns)):
                if row[c] < 0:
                    continue
                following = [self._true] if self.n_copies == 1 else self._variables(self.n_copies)
                self._delta[r, i, c] = following
                self._exactly_one(following)
                for j, literal in enumerate(following):
                    self._clause(-literal, self._used[row[c]][j])
                self._clause(self._used[r][i], following[0])
        if len(self.part.residuals) == 1:
            self._number_breadth_first()

    def _number_breadth_first(self) -> None:
        """The copies of the only residual are numbered in the order in which a breadth-first search finds them."""
        columns = range(self.part.n_columns)
        columns = [c for c in columns if self.part.step[0][c] >= 0]
        n = self.n_copies
        leads = {(i, j): self._some([self._delta[0, i, c][j] for c in columns]) for i, j in product(range(n), repeat=2)}
        parent: dict[tuple[int, int], int] = {}
        for j in range(1, n):
            for i in range(j):
                parent[i, j] = self._variable()
                self._clause(-parent[i, j], leads[i, j])
                for k in range(i):
                    self._clause(-parent[i, j], -leads[k, j])
            self._clause(-self._used[0][j], *(parent[i, j] for i in range(j)))
        for j in range(1, n - 1):
            for i, k in product(range(j), range(j + 1)):
                if k < i:
                    self._clause(-parent[i, j], -parent[k, j + 1])
            for i in range(j):
                for position, c in enumerate(columns):  # j + 1 is not met by a column before the first one to j
                    earlier = [self._delta[0, i, d][j] for d in columns[:position]]
                    self._clause(-parent[i, j], -parent[i, j + 1], -self._delta[0, i, c][j + 1], *earlier)

    def _candidate(self) -> Structure:
        """A last strong component of what the solver found."""
        model = self._solver.get_model()
        order = [(0, 0)]
        number = {order[0]: 0}
        step: list[list[int]] = []
        for r, i in order:  # grows while it is read
            row = []
            for c, target in enumerate(self.part.step[r]):
                if target < 0:
                    row.append(-1)
                    continue
                copy = (target, next(j for j, literal in enumerate(self._delta[r, i, c]) if model[literal - 1] > 0))
                if copy not in number:
                    number[copy] = len(order)
                    order.append(copy)
                row.append(number[copy])
            step.append(row)
        component = graph.strong_components([[t for t in row if t >= 0] for row in step])
        kept = [q for q in range(len(order)) if component[q] == max(component)]
        index = {q: i for i, q in enumerate(kept)} | {-1: -1}
        return Structure(tuple(order[q][0] for q in kept), tuple(tuple(index[t] for t in step[q]) for q in kept), ())

    # Words

    def _add(self, word: Word) -> None:
        """The cycles of a word have its verdict."""
        if word in self.words:
            return
        self.words[word] = None
        for run in self._runs(word):
            if word.accepted:
                chosen = {label: self._variable() for label in run.labels}
                self._clause(-run.returns, *chosen.values())
                for label, literal in chosen.items():
                    self._clause(-literal, run.labels[label])
                for other in self._rejected:
                    self._keep_apart(run, chosen, other)
                self._accepted.append((run, chosen))
            else:
                for accepted, chosen in self._accepted:
                    self._keep_apart(accepted, chosen, run)
                self._rejected.append(run)

    def _keep_apart(self, accepted: _Run, chosen: dict[int, int], rejected: _Run) -> None:
        """A rejected cycle that has a chosen label of an accepted one has a label that the accepted one has not."""
        outside = []
        for label, literal in rejected.labels.items():
            differs = self._variable()
            self._clause(-differs, literal)
            if label in accepted.labels:
                self._clause(-differs, -accepted.labels[label])
            outside.append(differs)
        both = (-accepted.returns, -rejected.returns)
        for label, literal in chosen.items():
            if label in rejected.labels:
                self._clause(*both, -literal, -rejected.labels[label], *outside)

    def _runs(self, word: Word) -> Iterator[_Run]:
        """From each copy of the residual, as many rounds as a cycle may have."""
        for i in range(self.n_copies):
            occurs: dict[int, dict[int, None]] = {}
            back = []
            residual, here = word.residual, [self._true if j == i else -self._true for j in range(self.n_copies)]
            for _ in range(self.n_copies):
                for c in word.columns:
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
            yield _Run(self._some(back), {label: self._some(list(literals)) for label, literals in occurs.items()})

    def _label(self, residual: int, copy: int, column: int = 0) -> int:
        return (residual * self.n_copies + copy) * self.part.n_columns + column

    def _next(self, residual: int, here: Row, column: int) -> Row:
        """Where one is after a column, per copy; `here` and the result have exactly one true literal."""
        if self.n_copies == 1:
            return here
        if here.count(self._true) == 1:
            return self._delta[residual, here.index(self._true), column]
        following = self._variables(self.n_copies)
        for j, literal in enumerate(here):
            for k, target in enumerate(self._delta[residual, j, column]):
                self._clause(-literal, -target, following[k])
                self._clause(-literal, -following[k], target)
        return following


def _first_words(part: Part) -> list[Word]:
    """Words of one and two columns."""
    found: dict[Word, None] = {}
    for length in (1, 2):
        for residual in range(len(part.residuals)):
            for columns in product(range(part.n_columns), repeat=length):
                if part.after(residual, columns) == residual:
                    found[_normal(part, residual, columns)] = None
                    if len(found) >= _MAX_FIRST_WORDS:
                        return list(found)
    return list(found)


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


def _solver() -> Any:
    try:
        return import_module("pysat.solvers").Solver(name=_SOLVER)
    except ModuleNotFoundError as error:
        raise MissingProgramError('exact minimisation needs the package python-sat: pip install "ltlc[sat]"') from error
