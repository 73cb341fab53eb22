"""A Boolean formula in conjunctive normal form, handed to a SAT solver clause by clause."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from itertools import combinations
from threading import Timer
from typing import Any

from ltlc.budget import check_time, time_left
from ltlc.errors import MissingProgramError

_SOLVER = "glucose4"
_CONFLICTS = 2000
"""conflicts after which the solver gives Python a chance to be interrupted."""

Row = list[int]
"""literals: variables, or their negatives."""


class Cnf:
    """Variables and clauses; `true` is a variable that is.

    Raises:
        MissingProgramError: python-sat is not installed.
    """

    def __init__(self) -> None:
        self._n_variables = 0
        self._solver = _solver()
        self.true = self.variable()
        self.clause(self.true)

    def solve(self) -> bool:
        """Whether all clauses can be true together.

        Raises:
            TimeLimitExceeded: the time of the call is over.
        """
        while True:
            self._solver.conf_budget(_CONFLICTS)
            answer = self._interruptible()
            if answer is not None:
                return bool(answer)
            check_time()

    def _interruptible(self) -> bool | None:
        """What the solver finds within its conflicts and the time of the call, or None."""
        seconds = time_left()
        if seconds is None:
            answer: bool | None = self._solver.solve_limited()
            return answer
        timer = Timer(seconds, self._solver.interrupt)
        timer.start()
        try:
            answer = self._solver.solve_limited(expect_interrupt=True)
            return answer
        finally:
            timer.cancel()
            timer.join()
            self._solver.clear_interrupt()

    def variable(self) -> int:
        """A new variable, which is a literal, too."""
        self._n_variables += 1
        return self._n_variables

    def variables(self, count: int) -> Row:
        """New variables."""
        return [self.variable() for _ in range(count)]

    def clause(self, *literals: int) -> None:
        """At least one of the literals is true."""
        self._solver.add_clause(literals)

    def some(self, literals: Sequence[int]) -> int:
        """A variable that is true iff one of the literals is."""
        if len(literals) == 1:
            return literals[0]
        some = self.variable()
        for literal in literals:
            self.clause(-literal, some)
        self.clause(-some, *literals)
        return some

    def exactly_one(self, literals: Sequence[int]) -> None:
        """Exactly one of the literals is true."""
        self.clause(*literals)
        for one, other in combinations(literals, 2):
            self.clause(-one, -other)

    def at_most(self, literals: Sequence[int], bound: int) -> None:
        """At most `bound` of the literals are true.

        References:
            C. Sinz: Towards an optimal CNF encoding of Boolean cardinality constraints. CP 2005, doi
            10.1007/11564751_73.
        """
        if len(literals) <= bound:
            return
        before: Row = []
        for literal in literals:
            count = self.variables(bound)
            if bound:
                self.clause(-literal, count[0])
            for k, reached in enumerate(before):
                self.clause(-reached, count[k])
                if k + 1 < bound:
                    self.clause(-reached, -literal, count[k + 1])
            if before or not bound:
                self.clause(-literal, *(-reached for reached in before[-1:]))
            before = count

    def model(self) -> set[int]:
        """The variables that are true in what `solve` found."""
        return {literal for literal in self._solver.get_model() if literal > 0}


def _solver() -> Any:
    try:
        return import_module("pysat.solvers").Solver(name=_SOLVER)
    except ModuleNotFoundError as error:
        raise MissingProgramError('exact minimisation needs the package python-sat: pip install "ltlc[sat]"') from error
