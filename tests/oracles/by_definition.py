"""Random formulas and words on which automata, evaluation and monitors are compared with the textbook's definition.

Each function yields one answer for each comparison: None where both say the same, and else what is wrong.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

from bounded import Bounded, bounded_holds, random_bounded
from random_ltl import random_formula, random_with_past, random_word
from textbook import holds

import ltlc
from ltlc import Monitor, Verdict
from ltlc.automata import DRA, is_empty
from ltlc.errors import LimitExceeded
from ltlc.ltl import Formula, Next, Not, WeakNext, fold, nnf, parse, satisfies, satisfies_trace
from ltlc.translate import Effort, Options, translate, translate_finite

Trace = list[frozenset[str]]
Answers = Iterator[str | None]

LONGEST = 5
_LIMIT = 2000
"""states of the automata of bounded formulas, which can be many; formulas with more are left out."""


def random_finite(rng: random.Random, size: int, names: str) -> Formula:
    """A formula in which some of the next operators are weak, and some leaves are about the past."""
    formula = (random_with_past if rng.random() < 0.5 else random_formula)(rng, size, tuple(names))

    def weakened(node: Formula, args: list[Formula]) -> Formula:
        return WeakNext(*args) if isinstance(node, Next) and rng.random() < 0.5 else node.with_args(tuple(args))

    return fold(formula, {}, weakened)


def random_traces(rng: random.Random, names: str, n: int) -> Iterator[Trace]:
    """So many traces of at most eight letters."""
    for _ in range(n):
        yield [frozenset(name for name in names if rng.random() < 0.5) for _ in range(rng.randint(1, 8))]


def finite(rng: random.Random, n_formulas: int, n_traces: int) -> Answers:
    """Formulas on traces: their automata, their evaluation and that of their normal form."""
    for _ in range(n_formulas):
        names = "abc"[: rng.randint(1, 3)]
        formula = random_finite(rng, rng.randint(1, 11), names)
        assert parse(str(formula), finite=True) is formula
        automaton, normal = translate_finite(formula), nnf(formula, finite=True)
        for trace in random_traces(rng, names, n_traces):
            known = [letter & set(automaton.aps) for letter in trace]
            found = {automaton.accepts(known), satisfies_trace(formula, trace), satisfies_trace(normal, trace)}
            yield None if found == {holds(formula, trace, None)} else f"{formula} on {trace}"


def past(rng: random.Random, n_formulas: int, n_words: int, effort: Effort = "default") -> Answers:
    """Formulas with a past on infinite words: their automata and their evaluation."""
    for _ in range(n_formulas):
        formula = random_with_past(rng, rng.randint(1, 9), "abc"[: rng.randint(1, 3)])
        automaton = translate(formula, Options(acceptance=rng.choice(("state", "transition")), effort=effort))
        if "past" in " ".join(automaton.aps):
            yield f"{formula} over {automaton.aps}"
        for _ in range(n_words):
            word = random_word(rng, automaton.aps, longest=LONGEST)
            found = {automaton.accepts(word.prefix, word.cycle), satisfies(formula, word)}
            yield None if found == {holds(formula, word.letters, len(word.prefix))} else f"{formula} on {word}"


def bounded(rng: random.Random, n_formulas: int, n_words: int, *, automata: bool = True) -> Answers:
    """Formulas with bounds on infinite words and on traces: their evaluation and, where small, their automata."""
    for _ in range(n_formulas):
        formula = random_bounded(rng, rng.choice((2, 3)), "ab")
        on_words, on_traces = parse(str(formula)), parse(str(formula), finite=True)
        infinite = traces = None
        if automata:
            with suppress(LimitExceeded):
                infinite = translate(on_words, Options(acceptance="transition", effort="fast", max_states=_LIMIT))
            with suppress(LimitExceeded):
                traces = translate_finite(on_traces, max_states=_LIMIT)
        for _ in range(n_words):
            word = random_word(rng, ("a", "b"))
            letters = list(word.letters)
            found = {satisfies(on_words, word)}
            if infinite is not None:
                own = [[letter & set(infinite.aps) for letter in part] for part in (word.prefix, word.cycle)]
                found.add(infinite.accepts(*own))
            yield _differs(formula, letters, len(word.prefix), found)
            found = {satisfies_trace(on_traces, letters)}
            if traces is not None:
                found.add(traces.accepts([letter & set(traces.aps) for letter in letters]))
            yield _differs(formula, letters, None, found)


def _differs(formula: Bounded, letters: Trace, loop: int | None, found: set[bool]) -> str | None:
    return None if found == {bounded_holds(formula, letters, loop)} else f"{formula} on {letters}, loop {loop}"


def verdicts(rng: random.Random, n_formulas: int) -> Answers:
    """The verdicts of monitors, decided again by emptiness and by the definition on finite traces; 35 a formula."""
    for _ in range(n_formulas):
        names = "abc"[: rng.randint(1, 3)]
        formula = (random_with_past if rng.random() < 0.5 else random_formula)(rng, rng.randint(1, 9), tuple(names))
        monitor = Monitor(formula)
        both = [ltlc.compile(side, effort="fast") for side in (formula, Not(formula))]
        empty = [_lost(automaton) for automaton in both]
        for _ in range(5):
            monitor.reset()
            states = [automaton.initial_state for automaton in both]
            word: Trace = []
            for _ in range(7):
                word.append(frozenset(name for name in monitor.aps if rng.random() < 0.5))
                states = [automaton.step(q, word[-1]) for automaton, q in zip(both, states, strict=True)]
                if empty[0][states[0]]:
                    expected = Verdict.VIOLATED
                elif empty[1][states[1]]:
                    expected = Verdict.SATISFIED
                elif holds(formula, word, None):
                    expected = Verdict.PRESUMABLY_SATISFIED
                else:
                    expected = Verdict.PRESUMABLY_VIOLATED
                yield None if monitor.step(word[-1]) is expected else f"{formula} after {word}: not {expected}"


def _lost(automaton: DRA) -> list[bool]:
    return [is_empty(replace(automaton, initial_state=q)) for q in range(automaton.n_states)]
