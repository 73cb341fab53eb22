"""Operators of the past: their text, their meaning, and where they cannot stand."""

from __future__ import annotations

import pickle
import random

import pytest
from random_ltl import random_past, random_with_past, random_word
from textbook import holds

from ltlc.errors import InvalidArgumentError, LtlSyntaxError
from ltlc.ltl import (
    Always,
    Eventually,
    Formula,
    Historically,
    Implies,
    Next,
    Not,
    Once,
    Proposition,
    Since,
    Triggered,
    Until,
    WeakYesterday,
    Yesterday,
    classify,
    nnf,
    parse,
    satisfies,
    simplify,
    to_text,
)
from ltlc.ltl.formula import And
from ltlc.ltl.recall import without_past
from ltlc.ltl.shape import NO_FUTURE, NO_PAST, NORMAL

a, b, S, T, Y, H = map(Proposition, ("a", "b", "S", "T", "Y", "H"))


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("Y a", Yesterday(a)),
        ("Z a", WeakYesterday(a)),
        ("O a", Once(a)),
        ("H a", Historically(a)),
        ("a S b", Since(a, b)),
        ("a T b", Triggered(a, b)),
        ("yesterday a", Yesterday(a)),
        ("previously a", Yesterday(a)),
        ("weak_yesterday a", WeakYesterday(a)),
        ("once a", Once(a)),
        ("historically (a)", Historically(a)),
        ("a since b", Since(a, b)),
        ("a triggered b", Triggered(a, b)),
        ("GO a", Always(Once(a))),
        ("!Y !a", Not(Yesterday(Not(a)))),
        ("G(b -> O a)", Always(Implies(b, Once(a)))),
        ("Y Y a S b", Since(Yesterday(Yesterday(a)), b)),
        ("a S b T a", Since(a, Triggered(b, a))),
        ("a U b S a", Until(a, Since(b, a))),
        # names that stand where operators cannot
        ("F S & T", And(Eventually(S), T)),
        ("S S T", Since(S, T)),
        ("T T T", Triggered(T, T)),
        ("Y T", Yesterday(T)),
        ("Y S b", Since(Y, b)),
        ("H H", Historically(H)),
        ("H H a", Historically(Historically(a))),
        ("X S U T", Until(Next(S), T)),
    ],
)
@pytest.mark.filterwarnings("ignore::ltlc.ltl.LtlSyntaxWarning")
def test_reading(text: str, formula: Formula) -> None:
    assert parse(text) is formula
    assert parse(str(formula)) is formula
    assert pickle.loads(pickle.dumps(formula)) is formula


@pytest.mark.parametrize("seed", range(3))
def test_text_reads_back_without_warnings(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(400):
        formula = random_with_past(rng, rng.randint(1, 10), ("a", "S", "T", "Y", "once", "since", "H b"))
        for syntax in ("plain", "unicode"):
            assert parse(to_text(formula, syntax)) is formula  # type: ignore[arg-type]
        assert to_text(formula, "latex")


def test_tools_without_the_past_are_not_given_it() -> None:
    for syntax in ("spot", "prism", "lbt"):
        with pytest.raises(InvalidArgumentError, match="give"):
            to_text(parse("G(b -> O a)"), syntax)  # type: ignore[arg-type]


def test_meaning() -> None:
    rng = random.Random(7)
    verdicts = []
    for _ in range(700):
        formula = random_with_past(rng, rng.randint(1, 9))
        simple, normal = simplify(formula), nnf(formula)
        assert normal.flags & NORMAL
        assert simple.flags & NORMAL
        for _ in range(8):
            word = random_word(rng, longest=5)
            expected = holds(formula, word.letters, len(word.prefix))
            assert satisfies(formula, word) == expected, (str(formula), str(word))
            assert satisfies(simple, word) == expected, (str(formula), str(simple), str(word))
            assert satisfies(normal, word) == expected, (str(formula), str(word))
            verdicts.append(expected)
    assert 0.3 < sum(verdicts) / len(verdicts) < 0.7


@pytest.mark.parametrize(
    ("past", "future"),
    [
        ("G(b -> Y a)", "!b & G(X b -> a)"),
        ("G(b -> Z a)", "G(X b -> a)"),
        ("G(b -> O a)", "!b W a"),
        ("G(b -> H a)", "G(!a -> G !b)"),
        ("G(c -> (a S b))", "(!c W b) & G(!a & !b -> (!c W b))"),
        ("G(c -> (a T b))", "G(!b -> (!c W (a & b)))"),
    ],
)
def test_laws_of_the_literature(past: str, future: str) -> None:
    rng = random.Random(5)
    verdicts = set()
    for _ in range(500):
        word = random_word(rng)
        assert satisfies(parse(past), word) == satisfies(parse(future), word), word
        verdicts.add(satisfies(parse(past), word))
    assert verdicts == {True, False}


def test_shape() -> None:
    rng = random.Random(8)
    for _ in range(200):
        formula = random_past(rng, rng.randint(1, 9))
        assert formula.flags & NO_FUTURE
        assert bool(formula.flags & NO_PAST) == (not set(str(formula)) & set("YZOHST"))
    assert not parse("O a & F b").flags & (NO_PAST | NO_FUTURE)
    assert [classify(parse(t)).value for t in ("G(b -> O a)", "F(b & Y a)", "G F(a S b)")] == [
        "safety",
        "co-safety",
        "recurrence",
    ]


def test_a_subformula_and_its_negation_are_recalled_once() -> None:
    recalled = without_past(nnf(parse("G(O a -> b) & F O a & F H !a")))
    assert list(map(str, recalled.meaning.values())) == ["H !a"]
    assert recalled.together(recalled.future) is nnf(parse("G(O a -> b) & F O a & F H !a"))


@pytest.mark.parametrize("operator", [Yesterday, WeakYesterday, Once, Historically])
def test_the_past_of_the_future_is_refused(operator: type[Yesterday]) -> None:
    with pytest.raises(InvalidArgumentError, match="cannot stand over F a, which speaks about the future: write"):
        operator(Eventually(a))
    with pytest.raises(InvalidArgumentError, match="the future"):
        Since(a, operator(Next(b)))


def test_long_operands_are_not_quoted_in_errors() -> None:
    with pytest.raises(LtlSyntaxError, match="over a formula of 201 operators and names"):
        parse("b & O(" + "X " * 200 + "a)")


@pytest.mark.slow
def test_nesting_is_limited_by_memory_alone() -> None:
    formula = parse("a S " * 20_000 + "b")
    assert parse(str(formula)) is formula
    assert simplify(Not(formula)) is nnf(Not(formula))
