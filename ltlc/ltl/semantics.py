"""Truth of formulas on ultimately periodic words and finite traces: slow, simple, exact, without any translation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from ltlc.budget import check_time
from ltlc.errors import InvalidArgumentError, check_type
from ltlc.ltl.finite import WeakNext
from ltlc.ltl.formula import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
)
from ltlc.ltl.past import PAST, Historically, Once, Since, Triggered, WeakYesterday, Yesterday
from ltlc.ltl.shape import NO_PAST
from ltlc.ltl.traversal import fold, postorder

Letter = frozenset[str]


@dataclass(frozen=True)
class LassoWord:
    """The infinite word that reads `prefix` once and then `cycle` for ever.

    Attributes:
        prefix, cycle: letters; a letter is the set of propositions that hold, and any iterable of names is taken.

    >>> str(LassoWord(prefix=[{"a"}, {"b"}], cycle=[set()]))
    'a & !b; !a & b; cycle{!a & !b}'

    Raises:
        InvalidArgumentError: the cycle is empty, or a letter is no set of names, such as a bare string.
    """

    prefix: tuple[Letter, ...]
    cycle: tuple[Letter, ...]

    def __init__(self, prefix: Iterable[Iterable[str]], cycle: Iterable[Iterable[str]]) -> None:
        for name, letters in (("prefix", prefix), ("cycle", cycle)):
            check_type(letters, Iterable, name, "a sequence of letters")
        object.__setattr__(self, "prefix", tuple(map(_letter, prefix)))
        object.__setattr__(self, "cycle", tuple(map(_letter, cycle)))
        if not self.cycle:
            raise InvalidArgumentError("the cycle of a lasso word needs at least one letter")

    def __str__(self) -> str:
        names = sorted({name for letter in self.letters for name in letter})
        texts = [
            " & ".join(str(Proposition(name)) if name in letter else f"!{Proposition(name)}" for name in names) or "1"
            for letter in self.letters
        ]
        head = "".join(f"{text}; " for text in texts[: len(self.prefix)])
        return f"{head}cycle{{{'; '.join(texts[len(self.prefix) :])}}}"

    @property
    def letters(self) -> tuple[Letter, ...]:
        """The prefix and one round of the cycle."""
        return self.prefix + self.cycle


def _letter(names: Iterable[str]) -> Letter:
    if isinstance(names, str):
        raise InvalidArgumentError(f"a letter is a set of propositions: write {{{names!r}}} instead of {names!r}")
    check_type(names, Iterable, "a letter", "a set of names")
    letter = tuple(names)
    for name in letter:
        check_type(name, str, "a proposition", "a name")
    return frozenset(letter)


def satisfies(formula: Formula, word: LassoWord) -> bool:
    """Whether the word, from its first letter on, is a model of the formula.

    Every distinct subformula is evaluated at every position of the lasso, in time and space linear in both. The
    temporal operators are least (F U M) or greatest (G W R) fixpoints of their expansion laws, such as
    a U b = b | (a & X(a U b)); two rounds of the cycle reach them. The past is read forwards, until it repeats itself.

    >>> from ltlc.ltl import parse, parse_word
    >>> satisfies(parse("G(a -> F b)"), parse_word("a; b; cycle{!a}"))
    True

    Raises:
        InvalidArgumentError: one of the two is something else.

    References:
        Nicolas Markey and Philippe Schnoebelen, Model checking a path, CONCUR 2003, doi:10.1007/978-3-540-45187-7_17.
    """
    check_type(formula, Formula, "formula", "what parse returns")
    check_type(word, LassoWord, "word", "a LassoWord, or what parse_word returns")
    return _unrolled(formula, word)[formula][0]


def satisfies_trace(formula: Formula, trace: Sequence[Iterable[str]]) -> bool:
    """Whether a finite trace, from its first letter on, is a model of the formula.

    X claims that there is a next position, and WX does not; a trace has at least one letter.

    >>> from ltlc.ltl import parse, parse_trace
    >>> satisfies_trace(parse("F(a & WX b)", finite=True), parse_trace("b; a"))
    True

    Raises:
        InvalidArgumentError: one of the two is something else, or the trace is empty.

    References:
        Giuseppe De Giacomo and Moshe Y. Vardi, Linear temporal logic and linear dynamic logic on finite traces, IJCAI
        2013.
    """
    check_type(formula, Formula, "formula", "what parse returns")
    check_type(trace, Iterable, "trace", "a sequence of letters")
    letters = tuple(map(_letter, trace))
    if not letters:
        raise InvalidArgumentError("a trace has at least one letter")
    return _evaluate(formula, letters, None)[formula][0]


def truth_by_position(
    formula: Formula, word: LassoWord | Sequence[Iterable[str]]
) -> tuple[dict[Formula, tuple[bool, ...]], int | None]:
    """Where on a word each subformula holds.

    >>> from ltlc.ltl import parse, parse_word
    >>> table, start = truth_by_position(parse("a U b"), parse_word("a; a; b; cycle{1}"))
    >>> {str(part): row for part, row in table.items()}["a U b"], start
    ((True, True, True, False), 3)

    Args:
        formula: any formula.
        word: a lasso word, or the letters of a finite trace.

    Returns:
        The truth of each subformula, operands first, at the letters of the trace, or of the prefix and of one round of
        the cycle; and where the cycle begins. With operators of the past there are more rounds before, until what they
        say repeats itself.

    Raises:
        InvalidArgumentError: one of the two is something else.
    """
    check_type(formula, Formula, "formula", "what parse returns")
    start: int | None = None
    if isinstance(word, LassoWord):
        values = _unrolled(formula, word)
        start = len(values[formula]) - len(word.cycle)
    else:
        satisfies_trace(formula, word)
        values = _evaluate(formula, tuple(map(_letter, word)), None)
    return {part: tuple(row) for part, row in values.items()}, start


def _unrolled(formula: Formula, word: LassoWord) -> dict[Formula, Sequence[bool]]:
    rounds = _depth_of_past(formula)
    start = len(word.prefix) + len(word.cycle) * rounds
    return _evaluate(formula, word.prefix + word.cycle * (rounds + 1), start)


def _evaluate(formula: Formula, letters: Sequence[Letter], start: int | None) -> dict[Formula, Sequence[bool]]:
    """Truth of every subformula at every position.

    Args:
        formula: on all distinct subformulas of which positions are evaluated.
        letters: of a trace, or as many of an infinite word as there are before what it says repeats itself.
        start: the position that follows the last one, or None where a trace ends.
    """
    values: dict[Formula, Sequence[bool]] = {}
    for node in postorder(formula):
        check_time()
        operands = [values[child] for child in node.args]
        if isinstance(node, Proposition):
            values[node] = [node.name in letter for letter in letters]
        elif isinstance(node, Constant):
            values[node] = [node.value] * len(letters)
        elif isinstance(node, Next | WeakNext):
            after_last = isinstance(node, WeakNext) if start is None else operands[0][start]
            values[node] = [*operands[0][1:], after_last]
        elif isinstance(node, PAST):
            values[node] = _remembered(node, operands[0], operands[-1])
        elif type(node) in _FIXPOINTS:
            greatest, law = _FIXPOINTS[type(node)]
            values[node] = _fixpoint(law, operands[0], operands[-1], greatest, start)
        else:
            connective = _CONNECTIVES[type(node)]
            values[node] = [connective(row) for row in zip(*operands, strict=True)]
    return values


def _depth_of_past(formula: Formula) -> int:
    """The number of rounds of a cycle after which what the past says repeats itself.

    Once the operands of an operator repeat themselves, so does it after one round more: what a round makes of the truth
    value at its beginning is a constant or that value.
    """
    if formula.flags & NO_PAST:
        return 0
    return fold(formula, {}, lambda node, depths: max(depths, default=0) + isinstance(node, PAST))


def _remembered(node: Formula, left: Sequence[bool], right: Sequence[bool]) -> Sequence[bool]:
    """The values of an operator of the past, from the first position on."""
    before, law = _MEMORIES[type(node)]
    values: list[bool] = []
    for a, b in zip(left, right, strict=True):
        value, before = law(a, b, before)
        values.append(value)
    return values


def _fixpoint(
    law: Callable[[bool, bool, bool], bool],
    left: Sequence[bool],
    right: Sequence[bool],
    greatest: bool,
    start: int | None,
) -> Sequence[bool]:
    """Solves value[i] = law(left[i], right[i], value[i + 1]) on the word, from the last position backwards.

    What would follow the end of a trace is what the fixpoint begins with.
    """
    size = len(left)
    values = [greatest] * size
    following = greatest
    for first in (0,) if start is None else (start, 0):  # once around the cycle to settle what follows its end
        for i in range(size - 1, first - 1, -1):
            following = values[i] = law(left[i], right[i], following)
        following = values[start or 0]
    return values


# operator -> (is it the greatest fixpoint?, its expansion law on left, right and its own value at the next position)
_FIXPOINTS: dict[type[Formula], tuple[bool, Callable[[bool, bool, bool], bool]]] = {
    Eventually: (False, lambda a, _, after: a or after),
    Always: (True, lambda a, _, after: a and after),
    Until: (False, lambda a, b, after: b or (a and after)),
    WeakUntil: (True, lambda a, b, after: b or (a and after)),
    Release: (True, lambda a, b, after: b and (a or after)),
    StrongRelease: (False, lambda a, b, after: b and (a or after)),
}
# operator of the past -> (what it recalls at the first position, from left, right and what it recalls: its value and
# what it recalls at the next position)
_MEMORIES: dict[type[Formula], tuple[bool, Callable[[bool, bool, bool], tuple[bool, bool]]]] = {
    Yesterday: (False, lambda a, _, before: (before, a)),
    WeakYesterday: (True, lambda a, _, before: (before, a)),
    Once: (False, lambda a, _, before: (a or before,) * 2),
    Historically: (True, lambda a, _, before: (a and before,) * 2),
    Since: (False, lambda a, b, before: (b or (a and before),) * 2),
    Triggered: (True, lambda a, b, before: (b and (a or before),) * 2),
}
_CONNECTIVES: dict[type[Formula], Callable[[Sequence[bool]], bool]] = {
    Not: lambda row: not row[0],
    And: all,
    Or: any,
    Implies: lambda row: not row[0] or row[1],
    Iff: lambda row: row[0] == row[1],
    Xor: lambda row: row[0] != row[1],
}
