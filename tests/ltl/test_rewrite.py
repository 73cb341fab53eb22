"""Negation normal form and simplification: each rule and each law against the oracle."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator

import pytest
from random_ltl import random_formula, random_word

from ltlc.ltl import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    fold,
    is_pure_eventuality,
    is_pure_universality,
    nnf,
    parse,
    postorder,
    propositions,
    satisfies,
    simplify,
)
from ltlc.ltl.implication import Implications
from ltlc.ltl.rewrite import RULES, candidates
from ltlc.ltl.rule import Rule

LITERALS = [Proposition("a"), Not(Proposition("a")), Proposition("b"), Not(Proposition("b"))]
NNF_OPERATORS = (And, Or, Next, Eventually, Always, Until, WeakUntil, Release, StrongRelease)


def assert_equivalent(left: Formula, right: Formula, rng: random.Random, words: int = 12) -> None:
    names = propositions(And(left, right)) or ("a",)
    for _ in range(words):
        word = random_word(rng, names)
        assert satisfies(left, word) == satisfies(right, word), f"{left}  and  {right}  differ on  {word}"


def test_nnf_keeps_the_meaning_and_has_the_form() -> None:
    rng = random.Random(1)
    for _ in range(300):
        formula = random_formula(rng, rng.randint(1, 14))
        normal = nnf(formula)
        assert_equivalent(formula, normal, rng, words=6)
        for node in postorder(normal):
            if isinstance(node, Not):
                assert isinstance(node.args[0], Proposition)
            assert not node.args or isinstance(node, (Not, *NNF_OPERATORS))
        assert nnf(normal) is normal


@pytest.mark.slow
def test_simplify_keeps_the_meaning_and_is_idempotent() -> None:
    rng = random.Random(2)
    for _ in range(1500):
        formula = random_formula(rng, rng.randint(1, 16))
        simple = simplify(formula)
        assert_equivalent(formula, simple, rng, words=6)
        assert simplify(simple) is simple


def test_a_formula_and_its_negation_simplify_to_opposites() -> None:
    rng = random.Random(3)
    for _ in range(200):
        formula = random_formula(rng, rng.randint(1, 12))
        assert_equivalent(simplify(Not(formula)), Not(simplify(formula)), rng, words=6)


# --- one rule at a time -----------------------------------------------------------------------------------------------


def _fill(rng: random.Random, letter: str) -> Formula:
    """A random formula of the kind that a letter stands for in the laws."""
    if letter == "p":
        return rng.choice(LITERALS)
    plain = nnf(random_formula(rng, rng.randint(1, 5), ("a", "b"), constants=0.0))
    if letter == "e":
        return rng.choice(
            (Eventually(plain), Until(rng.choice(LITERALS), Eventually(plain)), Always(Eventually(plain)))
        )
    if letter == "u":
        return rng.choice((Always(plain), Release(rng.choice(LITERALS), Always(plain)), Eventually(Always(plain))))
    if letter == "s":
        return rng.choice((Always(Eventually(plain)), Eventually(Always(plain))))
    return plain


def _instances(rng: random.Random, law: str, count: int) -> Iterator[tuple[Formula, Formula]]:
    """Both sides of a law with random formulas for its letters, which meet its condition."""
    equation, _, condition = law.partition(" if ")
    left, right = (parse(side) for side in equation.split(" = "))
    letters = propositions(And(left, right))
    for _ in range(count):
        filled = {letter: _fill(rng, letter) for letter in letters}
        if condition:
            narrow, wide = (parse(side) for side in re.split(r" -> ", condition))
            _make_true(narrow, wide, filled)
        yield _substitute(left, filled), _substitute(right, filled)


def _make_true(narrow: Formula, wide: Formula, filled: dict[str, Formula]) -> None:
    """Changes one filling so that narrow -> wide holds: of a plain letter on either side, or a negated one."""
    value = nnf(_substitute(wide, filled))
    if isinstance(narrow, Proposition):
        filled[narrow.name] = And(filled[narrow.name], value)
    elif isinstance(narrow, Not):
        filled[propositions(narrow)[0]] = nnf(Or(filled[propositions(narrow)[0]], Not(value)))
    else:
        filled[propositions(wide)[0]] = Or(filled[propositions(wide)[0]], nnf(_substitute(narrow, filled)))


def _substitute(formula: Formula, filled: dict[str, Formula]) -> Formula:
    def value(node: Formula, args: list[Formula]) -> Formula:
        return filled[node.name] if isinstance(node, Proposition) else node.with_args(tuple(args))

    return nnf(fold(formula, {}, value))


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_laws_hold_and_their_rule_rewrites_them(rule: Rule) -> None:
    rng = random.Random(rule.name)
    for law in rule.laws:
        fired = 0
        for left, right in _instances(rng, law, 30):
            assert_equivalent(left, right, rng, words=8)
            result = rule.apply(left, Implications()) if isinstance(left, rule.operators) else None
            if result is not None:
                fired += 1
                assert result is not left
                assert rule.apply in candidates(left), f"{left} is kept from the rule"
                assert_equivalent(left, result, rng, words=8)
        assert fired >= 10, f"{law}: rewritten {fired} times in 30"


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_rules_keep_the_meaning_of_any_formula_and_its_size(rule: Rule) -> None:
    rng = random.Random(rule.name)
    for _ in range(250):
        operator = rng.choice(rule.operators)
        size = 1 if operator in (Next, Eventually, Always) else rng.randint(2, 4) if operator in (And, Or) else 2
        operands = [simplify(random_formula(rng, rng.randint(1, 6), ("a", "b"))) for _ in range(size)]
        formula = operator(*operands)
        if not isinstance(formula, rule.operators) or (result := rule.apply(formula, Implications())) is None:
            continue
        assert rule.apply in candidates(formula), f"{formula} is kept from the rule"
        assert_equivalent(formula, result, rng)
        if not rule.grows:
            assert result.size <= formula.size, f"{formula} grew to {result}"


def test_rule_names_are_unique_and_every_law_parses() -> None:
    assert len({rule.name for rule in RULES}) == len(RULES)
    for rule in RULES:
        assert rule.laws
        for law in rule.laws:
            left, right = law.partition(" if ")[0].split(" = ")
            assert isinstance(parse(left), rule.operators), law
            parse(right)


# --- purity and implication -------------------------------------------------------------------------------------------


def test_purity_is_sound() -> None:
    rng = random.Random(4)
    seen = {"eventual": 0, "universal": 0}
    for _ in range(2000):
        formula = random_formula(rng, rng.randint(2, 9))
        word = random_word(rng)
        if not word.prefix:
            continue
        suffix = type(word)(word.prefix[1:], word.cycle)
        if is_pure_eventuality(formula):
            seen["eventual"] += 1
            assert satisfies(formula, word) or not satisfies(formula, suffix), f"{formula} on {word}"
        if is_pure_universality(formula):
            seen["universal"] += 1
            assert satisfies(formula, suffix) or not satisfies(formula, word), f"{formula} on {word}"
    assert min(seen.values()) > 100


def test_implication_is_sound() -> None:
    rng = random.Random(5)
    found = 0
    for _ in range(2500):
        known = Implications()
        f, g = (nnf(random_formula(rng, rng.randint(1, 6), ("a", "b"))) for _ in range(2))
        if f is not g and known.implies(f, g):
            found += 1
            for _ in range(6):
                word = random_word(rng, ("a", "b"))
                assert satisfies(g, word) or not satisfies(f, word), f"{f} -> {g} on {word}"
    assert found > 100


# --- examples ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "simple"),
    [
        ("F F a", "F a"),
        ("G F G a", "F G a"),
        ("F(a) | F(b)", "F(a | b)"),
        ("G a & G b", "G(a & b)"),
        ("GF a | GF b", "GF(a | b)"),
        ("FG a & FG b", "FG(a & b)"),
        ("GF a & GF b", "GF a & GF b"),
        ("X a & X b", "X(a & b)"),
        ("G F X a", "GF a"),
        ("a U (a U b)", "a U b"),
        ("F(a U b)", "F b"),
        ("G(a R b)", "G b"),
        ("a U F b", "F b"),
        ("a & (a | b)", "a"),
        ("a & F a", "a"),
        ("G a & F !a", "false"),
        ("G(a & F b)", "G a & GF b"),
        ("G(a -> a)", "true"),
        ("(a & b) | (a & !b)", "a"),
        ("(a U b) | G a", "a W b"),
        ("!(a W b)", "!a M !b"),
        ("F(A & F B) & G!C & FG T", "F(A & F B) & G !C & FG T"),
        ("G !c & F(b & !c)", "G !c & F b"),
        ("G(a & (b | F a))", "G a"),
        ("GF(a & GF b)", "GF a & GF b"),
        ("GF a & G(a -> F b) & G(b -> F c)", "GF a & GF c & GF b"),
        ("GF a & G(b -> F c)", "GF a & G(!b | F c)"),
        ("a <-> a", "true"),
        ("a xor true", "!a"),
    ],
)
def test_examples(text: str, simple: str) -> None:
    assert simplify(parse(text)) is parse(simple)


def test_constants() -> None:
    assert simplify(parse("G true -> X false")) is FALSE
    assert simplify(parse("F(a | !a)")) is TRUE


def test_the_result_does_not_depend_on_what_was_simplified_before() -> None:
    rng = random.Random(6)
    formulas = [random_formula(rng, 12) for _ in range(50)]
    first = [str(simplify(formula)) for formula in formulas]
    assert [str(simplify(formula)) for formula in reversed(formulas)] == first[::-1]


def test_nesting_does_not_double_over_and_over() -> None:
    text = "".join(f"(G a{i}) U (c{i} & X " for i in range(14)) + "b" + ")" * 14
    assert simplify(parse(text)).size < 3 * parse(text).size
    text = "".join(f"G(a{i} U X(c{i} & " for i in range(14)) + "b" + "))" * 14
    assert simplify(parse(text)).size < 10 * parse(text).size


def test_mostly_smaller_never_much_larger() -> None:
    rng = random.Random(7)
    before = after = 0
    for _ in range(300):
        formula = nnf(random_formula(rng, 12))
        before += formula.size
        after += simplify(formula).size
    assert after < 0.75 * before
