"""What every construction is given: a simplified formula, its letters, and which constructions are worth trying."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ltlc.automata.emerson_lei import EmersonLei, reduced
from ltlc.budget import Budget
from ltlc.errors import DepthLimitExceeded, UnknownNameError
from ltlc.ltl import Formula, propositions, simplify
from ltlc.ltl.shape import NO_PAST
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS, Construction, FormulaKind, in_portfolio
from ltlc.translate.letters import Letters, letters_of
from ltlc.translate.limits import in_the_limit
from ltlc.translate.mixtures import is_low, n_nodes, without_mixtures
from ltlc.translate.options import Options

if TYPE_CHECKING:
    from ltlc.minimize.words import Words
    from ltlc.translate.memory import Memory

_BY_PARTS = ("auto", "product")
"""Where parts are translated one by one, the formula is taken apart before."""
OF_THE_WHOLE = ("safra", "dual-safra")
"""By what translates it as a whole, the formula is taken as it was before."""
_MUCH = 2
"""A formula has grown if it has more times as many subformulas after it was taken apart."""
PATIENCE = 2
"""A further construction is given up once it has this many times the states of the best automaton so far,"""
SLACK = 14
"""plus these."""


class Problem(NamedTuple):
    """What every construction is given."""

    formula: Formula
    """simplified, in negation normal form, and taken apart where parts are translated one by one."""
    whole: Formula
    """the formula before it was taken apart."""
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

    @property
    def has_grown(self) -> bool:
        """Whether the formula became much larger when it was taken apart."""
        return self.formula is not self.whole and n_nodes(self.formula) > _MUCH * n_nodes(self.whole)

    def undivided(self, budget: Budget) -> Problem:
        """The problem of the formula as it was before it was taken apart, which can have made it large."""
        if self.whole is self.formula:
            return self
        return _problem(self.whole, self.whole, self.letters.aps, self.options, self.words, budget)


def problem_of(formula: Formula, options: Options, budget: Budget) -> Problem:
    """What every construction is given."""
    whole = simplify(formula)
    whole_is_divided = options.translator not in _BY_PARTS or is_low(whole)
    divided = whole if whole_is_divided else without_mixtures(in_the_limit(whole))
    return _problem(divided, whole, propositions(formula), options, [], budget)


def _problem(
    formula: Formula, whole: Formula, aps: tuple[str, ...], options: Options, words: Words, budget: Budget
) -> Problem:
    letters = letters_of(formula, aps, options.possible)
    memory: Memory | None = None
    if not formula.flags & NO_PAST:
        from ltlc.translate.memory import Memory

        memory = Memory(formula, letters, budget)
    return Problem(formula, whole, letters, options, words, memory)


def built(construction: Construction, problem: Problem, budget: Budget, closure: Closure) -> EmersonLei:
    """What a construction builds, reduced, over the letters of the formula."""
    emerson_lei = reduced(construction.build(closure, budget))
    return emerson_lei if problem.memory is None else reduced(problem.memory.product(emerson_lei, budget))


def worth_trying(closure: Closure, options: Options) -> tuple[str, ...]:
    """Names of constructions, the most promising first."""
    if options.translator != "auto":
        return (options.translator,)
    names = in_portfolio(_kind(closure, options))
    return names[:1] if options.effort == "fast" else names


def worth_trying_if_large(closure: Closure, options: Options) -> tuple[str, ...]:
    """Names of constructions for the undivided formula, for the case that the first one gives many states."""
    if options.translator != "auto" or options.effort == "fast" or _kind(closure, options) == "fair":
        return ()
    return in_portfolio("large")


def first_is_best_if_small(closure: Closure, options: Options) -> bool:
    """Whether no other construction is worth trying where the first one gives few states."""
    return _kind(closure, options) == "mixed"


def _kind(closure: Closure, options: Options) -> FormulaKind:
    root = closure.root
    if options.effort == "default" and (closure.is_fair_obligation(root) or closure.is_limit(root)):
        return "fair"
    if not closure.is_low(root):
        return "high"
    if closure.is_low(root, "pi"):
        return "recurrence"
    return "persistence" if closure.is_low(root, "sigma") or options.effort == "best" else "mixed"


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
