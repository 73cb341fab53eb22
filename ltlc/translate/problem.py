"""What every construction is given: a simplified formula, its letters, and which constructions are worth trying."""

from __future__ import annotations

from typing import NamedTuple

from ltlc.automata.emerson_lei import EmersonLei, reduced
from ltlc.budget import Budget
from ltlc.errors import DepthLimitExceeded, UnknownNameError
from ltlc.ltl import Formula, propositions, simplify
from ltlc.ltl.shape import NO_PAST
from ltlc.minimize.words import Words
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS, Construction, in_portfolio
from ltlc.translate.letters import Letters, letters_of
from ltlc.translate.limits import in_the_limit
from ltlc.translate.memory import Memory
from ltlc.translate.mixtures import without_mixtures
from ltlc.translate.options import Options

_BY_PARTS = ("auto", "product")
"""Where parts are translated one by one, the formula is taken apart before."""
PATIENCE = 2
"""A further construction is given up once it has this many times the states of the best automaton so far,"""
SLACK = 60
"""plus these."""


class Problem(NamedTuple):
    """What every construction is given."""

    formula: Formula
    """simplified, in negation normal form."""
    letters: Letters
    options: Options
    words: Words
    """what told states apart so far; see `merge_by_trial`."""
    memory: Memory | None
    """of the past, if the formula has one."""

    def closure(self, budget: Budget) -> Closure:
        """A fresh closure: what a construction leaves in it must not depend on the constructions before."""
        if self.memory is None:
            return Closure(self.formula, self.letters, budget)
        return Closure(self.memory.future, self.memory.letters, budget)


def problem_of(formula: Formula, options: Options, budget: Budget) -> Problem:
    """What every construction is given."""
    simple = simplify(formula)
    if options.translator in _BY_PARTS:
        simple = without_mixtures(in_the_limit(simple))
    letters = letters_of(simple, propositions(formula), options.possible)
    memory = None if simple.flags & NO_PAST else Memory(simple, letters, budget)
    return Problem(simple, letters, options, [], memory)


def built(construction: Construction, problem: Problem, budget: Budget, closure: Closure) -> EmersonLei:
    """What a construction builds, reduced, over the letters of the formula."""
    emerson_lei = reduced(construction.build(closure, budget))
    return emerson_lei if problem.memory is None else reduced(problem.memory.product(emerson_lei, budget))


def worth_trying(closure: Closure, options: Options) -> tuple[str, ...]:
    """Names of constructions, the most promising first."""
    if options.translator != "auto":
        return (options.translator,)
    root = closure.root
    if options.effort == "default" and (closure.is_fair_obligation(root) or closure.is_limit(root)):
        names = in_portfolio("fair")
    else:
        names = in_portfolio("low" if closure.is_low(root) else "high")
    return names[:1] if options.effort == "fast" else names


def check_known(translator: str) -> None:
    """Raise UnknownNameError, with "auto" among the names, if there is no such construction."""
    try:
        CONSTRUCTIONS[translator]
    except UnknownNameError as error:
        if error.kind != CONSTRUCTIONS.kind:
            raise
        raise UnknownNameError(error.kind, translator, ("auto", *CONSTRUCTIONS)) from None


def too_deep(budget: Budget) -> DepthLimitExceeded:
    """The error that a formula is nested too deeply."""
    return DepthLimitExceeded(
        f"{budget.name} is nested too deeply: split the formula, or raise Python's limit by sys.setrecursionlimit"
    )
