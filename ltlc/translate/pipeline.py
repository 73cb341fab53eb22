"""From a formula to the smallest Rabin automaton that the constructions find.

What makes an automaton smaller is imported where it is used: to load it takes longer than to translate a small formula.
"""

from __future__ import annotations

from contextlib import ExitStack, suppress
from functools import partial, reduce
from operator import or_
from typing import NamedTuple

from ltlc.arrays import np
from ltlc.automata.canonical import CANONICAL, canonical
from ltlc.automata.emerson_lei import EmersonLei
from ltlc.automata.languages import can_decide_languages
from ltlc.automata.rabin import DRA
from ltlc.automata.rabin_pairs import Way, to_rabin
from ltlc.budget import (
    Budget,
    Overtime,
    TimeLimit,
    check_time,
    overtime,
    time_left,
    time_limit,
)
from ltlc.errors import (
    LimitExceeded,
    StateLimitExceeded,
    TimeLimitExceeded,
)
from ltlc.ltl import Formula
from ltlc.translate.closure import Closure
from ltlc.translate.constructions import CONSTRUCTIONS, Construction
from ltlc.translate.letters import Letters
from ltlc.translate.options import Options
from ltlc.translate.problem import (
    OF_THE_WHOLE,
    PATIENCE,
    SLACK,
    Problem,
    built,
    check_known,
    first_is_best_if_small,
    problem_of,
    too_deep,
    worth_trying,
    worth_trying_if_large,
)

_DEFAULTS = Options()
_ROUNDS = (500, 2_000, 10_000)
"""of states: all constructions are tried with few, before one is tried with many;"""
_FIRST = 4
"""the first one may have this many times as many, since it wins most often; in later rounds it is the last one."""
_FEW = 60
"""Where the formula has grown when it was taken apart, there is a round of so few before, and the first one has no more
than others: what is large takes long for each state."""
_HOPELESS = 1.25
"""A candidate with this many times the states of the best one,"""
_CLOSE = 4
"""and these, is not tried to be merged into fewer: that never helped."""
_LARGE, _SMALL = 100, 20
"""With more states than the first number, the automaton of the first construction waits for those of the undivided
formula; with no more than the second one, it is good enough for some."""
_CROWDED = 12
"""With more states than this for each language, it waits for the other constructions: many pairs of states would be
tried, and others often have fewer to begin with."""
_MANY_PAIRS = 4
"""Fewer states are not worth more Rabin pairs than this."""
_SPARE_SHARE = 0.7
"""Making a candidate smaller takes this share of the time that is left, if its states are to be split afterwards."""
_SAT_SECONDS = 30.0
_SAT_SHARE = 0.9
"""The search for a smaller automaton goes on for this time at most, and this share of what is left."""


class Candidate(NamedTuple):
    """What a construction found: transition-based, canonically numbered."""

    automaton: DRA
    translator: str
    weak: bool
    least: int
    """no automaton for the language has fewer states."""
    emerson_lei: EmersonLei
    """what its pairs were formed from."""
    letters: Letters
    """those of `emerson_lei`."""
    is_bounded: bool = False
    """whether more than the number of languages was asked for `least`."""

    @property
    def smallest(self) -> bool:
        """Whether no automaton for the language has fewer states, for sure."""
        return self.automaton.n_states <= self.least


def translate(formula: Formula, options: Options = _DEFAULTS, *, text: str | None = None) -> DRA:
    """A deterministic Rabin automaton that accepts exactly the words satisfying the formula.

    1. Simplify the formula, which brings it to negation normal form; pull temporal operators out of each other; group
       the letters it cannot tell apart.
    2. Build a deterministic automaton with Emerson-Lei acceptance (a construction) and reduce it.
    3. Form Rabin pairs, strong component by strong component; reduce again; split states for state-based acceptance.
    4. With "auto": try the next construction, unless the result is proven smallest, and keep the smallest.

    Args:
        formula: any LTL formula.
        options: kind of acceptance, constructions and limits.
        text: what to call the formula in messages and in the result; by default its own text.

    Returns:
        A complete automaton over the propositions of the formula in order of appearance, canonically numbered: the same
        formula gives the same automaton, bit for bit.

    Raises:
        UnknownNameError: no such translator.
        InvalidArgumentError: the translator does not apply to the formula, or an option is out of range.
        StateLimitExceeded, TimeLimitExceeded, AlphabetLimitExceeded, DepthLimitExceeded: a budget ran out.
        MissingProgramError: effort "best" needs the package python-sat.
    """
    options = options.checked()
    if options.translator != "auto":
        check_known(options.translator)
    text = str(formula) if text is None else text
    with time_limit(text, options.timeout) as limit:
        budget = Budget(text, options.max_states)
        try:
            problem = problem_of(formula, options, budget)
            best = _best(problem, budget)
            automaton = best.automaton
            if not best.weak and options.acceptance == "transition":
                automaton = _normalized(automaton)
            if options.acceptance == "state":
                automaton = _state_based(best._replace(automaton=automaton), problem, budget)
        except RecursionError:  # rewriting and the nodes of a closure recurse, each level in a few calls
            raise too_deep(budget) from None
        budget.check_states(automaton.n_states)
        if options.effort == "best":
            from ltlc.minimize import minimize

            left = _SAT_SECONDS if limit.remaining is None else _SAT_SHARE * limit.remaining
            automaton = minimize(automaton, timeout=min(_SAT_SECONDS, left)).automaton
        return automaton.named(text, best.translator)


def _normalized(automaton: DRA) -> DRA:
    """The automaton in the normal form of `ltlc.minimize.reduce`, also at the deadline."""
    from ltlc.minimize.reduce import NORMALIZED, normalized

    if NORMALIZED in automaton.forms:
        return automaton
    with overtime(Overtime.REDUCE):
        return normalized(automaton)


def _state_based(best: Candidate, problem: Problem, budget: Budget) -> DRA:
    """The candidate with marks on states."""
    automaton = best.automaton
    if best.weak:
        if automaton.is_listed:
            marks = [reduce(or_, row) for row in automaton.edge_marks]
        else:
            marks = np.bitwise_or.reduce(automaton.marks, axis=1).tolist()
        return automaton.with_marks(marks, automaton.n_pairs, "state")
    from ltlc.automata.marks import SIMPLE_MARKS
    from ltlc.minimize import to_state_based
    from ltlc.minimize.merge_by_trial import EFFORT

    others = []
    if automaton.n_pairs > 1:
        from ltlc.automata.parity import to_parity

        # Many pairs on few states split into many: the chain of marks of a parity condition may split into fewer.
        with suppress(LimitExceeded):
            if automaton.n_states < best.emerson_lei.n_states:
                parity = canonical(to_parity(automaton, max_states=budget.max_states).automaton)
            else:
                parity = _paired(best.emerson_lei, best.letters, budget, "cycles")
            others.append(parity.annotated(SIMPLE_MARKS))
    effort = 0 if problem.options.effort == "fast" else EFFORT
    return to_state_based(automaton, effort=effort, budget=budget, others=others, least=best.least, words=problem.words)


def _best(problem: Problem, budget: Budget) -> Candidate:
    """The smallest result; constructions that explode are stopped early as long as others may succeed.

    If the first one gives many states, or more than it may have, further constructions for the undivided formula come
    next, before its states are merged: those are cheap to build, and that is not.
    """
    closure = problem.closure(budget)
    pristine: Closure | None = closure
    names, grown = worth_trying(closure, problem.options), problem.has_grown
    further = partial(_further, problem, closure, budget)
    rounds = [n for n in (_FEW, *_ROUNDS)[not grown :] if n < budget.max_states] if len(names) > 1 else []
    with ExitStack() as spare:
        for limit in (*rounds, budget.max_states):
            best: Candidate | None = None
            postponed: list[Candidate] = []
            waiting = [(name, problem.undivided(budget) if name in OF_THE_WHOLE else problem) for name in names]
            if rounds[:1] != [limit]:
                waiting.append(waiting.pop(0))
            while waiting:
                name, task = waiting.pop(0)
                is_promising = name == names[0] and task is problem
                cap = limit * _FIRST if is_promising and not grown else limit
                if task is problem and pristine is not None:
                    closure, pristine = pristine, None
                else:
                    closure = task.closure(budget)
                if best is not None and problem.options.effort != "best":
                    cap = min(limit, PATIENCE * best.automaton.n_states + SLACK)
                try:
                    found = _build(CONSTRUCTIONS[name], task, budget.within(cap), closure)
                    is_first, best = best is None, _smaller(best or found, found)
                    if is_first:
                        spare.enter_context(_spare_time(problem))
                    check_time()
                    n_states = found.automaton.n_states if is_promising else 0
                    is_small = 0 < n_states <= _SMALL and first_is_best_if_small(closure, problem.options)
                    is_large = n_states > _LARGE and bool(further())
                    if is_large:
                        postponed.append(found)
                        waiting[:0] = further()
                        continue
                    if waiting and not is_small and n_states > _CROWDED * found.least:
                        found = _proven(found, problem)
                        best = _smaller(best, found)
                        postponed.append(found)
                    else:
                        best = _tried(found, best, problem)
                except TimeLimitExceeded:
                    if best is None:
                        raise
                    break
                except StateLimitExceeded:
                    if is_promising:
                        waiting[:0] = further()
                    if limit == budget.max_states and best is None and not waiting:
                        raise
                    continue
                if best.smallest or is_small:
                    break
            if best is not None:
                with suppress(TimeLimitExceeded):
                    for found in () if best.smallest else postponed:
                        best = _tried(found, best, problem)
                return best
    raise AssertionError("the last round returns or raises")


def _further(problem: Problem, closure: Closure, budget: Budget) -> list[tuple[str, Problem]]:
    """What comes next where the first construction gives many states: others, of the undivided formula."""
    names = worth_trying_if_large(closure, problem.options)
    undivided = problem.undivided(budget) if names else problem
    return [(name, undivided) for name in names] if undivided is not problem else []


def _tried(found: Candidate, best: Candidate, problem: Problem) -> Candidate:
    """The smaller one of the best candidate and what another one can be made into, unless that is hopeless."""
    hopeless = found.automaton.n_states > _HOPELESS * best.automaton.n_states + _CLOSE
    if problem.options.effort == "fast" or hopeless:
        return best
    return _smaller(best, _improved(found._replace(least=best.least, is_bounded=best.is_bounded), problem))


def _spare_time(problem: Problem) -> TimeLimit:
    """The time for making a candidate smaller; where its states are to be split, some is left for that."""
    left = time_left()
    return time_limit("", None if left is None or problem.options.acceptance == "transition" else _SPARE_SHARE * left)


def _smaller(old: Candidate, new: Candidate) -> Candidate:
    """The candidate with fewer states, or as many and fewer pairs, with what is known from both."""
    chosen = min(old, new, key=lambda c: (c.automaton.n_states, c.automaton.n_pairs))
    return chosen._replace(least=max(old.least, new.least), is_bounded=old.is_bounded or new.is_bounded)


def _build(construction: Construction, problem: Problem, budget: Budget, closure: Closure) -> Candidate:
    """The automaton of a construction, with as few states as merging those of one language gives."""
    emerson_lei = built(construction, problem, budget, closure)
    automaton = _paired(emerson_lei, problem.letters, budget)
    if emerson_lei.is_weak:  # minimized exactly
        return Candidate(automaton, construction.name, True, automaton.n_states, emerson_lei, problem.letters)
    from ltlc.minimize.reduce import normalized

    with _spare_time(problem):
        automaton = normalized(automaton)
    try:
        least = automaton.n_languages if can_decide_languages(automaton) else 1
    except TimeLimitExceeded:
        least = 1
    return Candidate(automaton, construction.name, False, least, emerson_lei, problem.letters)


def _paired(emerson_lei: EmersonLei, letters: Letters, budget: Budget, way: Way = "smaller") -> DRA:
    """Rabin pairs for what a construction built, which is numbered breadth-first."""
    automaton = to_rabin(emerson_lei, letters.aps, letters.letter_class, budget, way=way, possible=letters.possible)
    return automaton.annotated(CANONICAL)


def _proven(found: Candidate, problem: Problem) -> Candidate:
    """The candidate with a bound on smaller ones, and with fewer states if these cost pairs only that do not matter.

    It is looked for once, since it depends on the language alone. Many pairs split states if the acceptance of the
    automaton is to be on states.
    """
    automaton = found.automaton
    if found.is_bounded or found.smallest:
        return found
    from ltlc.minimize import collapse
    from ltlc.minimize.lower_bound import is_readable

    if not is_readable(automaton):
        return found

    collapsed = collapse(automaton)
    if collapsed.automaton.n_pairs <= automaton.n_pairs or (
        problem.options.acceptance == "transition" and _is_worth_its_pairs(collapsed.automaton, automaton)
    ):
        automaton = collapsed.automaton
    return found._replace(automaton=automaton, least=max(found.least, collapsed.lower_bound), is_bounded=True)


def _improved(found: Candidate, problem: Problem) -> Candidate:
    """The candidate with fewer states, if that is possible by trial; it is not normalized again."""
    found = _proven(found, problem)
    if found.smallest:
        return found
    from ltlc.minimize import merge_by_trial

    return found._replace(automaton=merge_by_trial(found.automaton, least=found.least, words=problem.words))


def _is_worth_its_pairs(smaller: DRA, larger: DRA) -> bool:
    """Whether an agent that may have to choose a pair has less to learn, and other tools still read the automaton."""
    return smaller.n_pairs <= _MANY_PAIRS and smaller.n_states * smaller.n_pairs < larger.n_states * larger.n_pairs
