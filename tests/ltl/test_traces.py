"""Text of formulas and words of finite traces."""

from __future__ import annotations

import random

import pytest
from random_ltl import random_with_past, random_word

from ltlc.errors import InvalidArgumentError, LtlSyntaxError
from ltlc.ltl import (
    LAST,
    Always,
    And,
    Formula,
    Implies,
    LassoWord,
    Next,
    Not,
    Proposition,
    WeakNext,
    nnf,
    parse,
    parse_trace,
    satisfies,
    satisfies_trace,
    truth_by_position,
)

a, b, last = map(Proposition, ("a", "b", "last"))


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("X a", Next(a)),
        ("X[!] a", Next(a)),
        ("X [ ! ] a", Next(a)),
        ("WX a", WeakNext(a)),
        ("N a", WeakNext(a)),
        ("weak_next(a)", WeakNext(a)),
        ("G(a -> WX b)", Always(Implies(a, WeakNext(b)))),
        ("last", LAST),
        ("a & last", And(a, LAST)),
        ('"last"', last),
        ("!WX!a", Not(WeakNext(Not(a)))),
    ],
)
def test_formulas(text: str, formula: Formula) -> None:
    assert parse(text, finite=True) is formula  # a warning is an error
    assert parse(str(formula), finite=True) is formula


def test_negation() -> None:
    assert nnf(Not(Next(a)), finite=True) is WeakNext(Not(a))
    assert nnf(Not(WeakNext(a)), finite=True) is Next(Not(a))
    assert nnf(WeakNext(a)) is Next(a)
    assert nnf(Not(WeakNext(Not(a)))) is Next(a)


def test_weak_next_on_infinite_words_is_next() -> None:
    word = LassoWord([{"b"}], [{"a"}])
    assert satisfies(WeakNext(a), word)
    assert not satisfies(LAST, word)


def test_traces() -> None:
    assert parse_trace("a; b & !a;1") == ({"a"}, {"b"}, set())
    assert parse_trace(" a ") == ({"a"},)
    assert satisfies_trace(parse("F(a & last)", finite=True), [["b"], ["a"]])
    with pytest.raises(InvalidArgumentError, match="a letter is a set"):
        satisfies_trace(a, ["a"])


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("", 1, "the trace is empty"),
        ("a;", 3, "the trace ends too early: a letter is missing"),
        ("a;; b", 3, "a letter is missing before ';'"),
        ("a; cycle{b}", 4, "a finite trace has no cycle"),
        ("cycle{b", 1, "a finite trace has no cycle"),
        ("cycle{", 1, "a finite trace has no cycle"),
        ("a | b", 1, "a letter is a conjunction of literals"),
        ("a; b }", 6, "unexpected '}'"),
    ],
)
def test_wrong_traces(text: str, column: int, message: str) -> None:
    with pytest.raises(LtlSyntaxError, match=message.replace("|", r"\|")) as caught:
        parse_trace(text)
    assert caught.value.column == column
    assert caught.value.hint


def test_truth_by_position() -> None:
    """What holds at position i is what holds after i steps."""
    rng = random.Random(3)
    for _ in range(60):
        formula = random_with_past(rng, rng.randint(1, 7), ("a", "b"))
        word = random_word(rng, ("a", "b"))
        table, start = truth_by_position(formula, word)
        assert start is not None
        assert len(table[formula]) == start + len(word.cycle)
        finite, nowhere = truth_by_position(formula, word.letters)
        assert nowhere is None
        for part, row in table.items():
            later = part
            for i, holds in enumerate(row):
                assert satisfies(later, word) == holds, (str(part), str(word), i)
                if i < len(word.letters):
                    assert satisfies_trace(later, word.letters) == finite[part][i], (str(part), str(word), i)
                later = Next(later)
    with pytest.raises(InvalidArgumentError, match="at least one letter"):
        truth_by_position(a, [])
