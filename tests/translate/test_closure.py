"""Closures and the normal form of formulas against the formulas themselves."""

from __future__ import annotations

from functools import reduce as fold
from itertools import combinations

import pytest
from closures import letters_of, random_closures
from formula_of_node import closure_of, formula_of_node, formula_of_obligation
from random_ltl import random_word

from ltlc.errors import StateLimitExceeded
from ltlc.ltl import LassoWord, parse, satisfies
from ltlc.translate.normal_form import normal_form


def test_letter_classes_are_those_the_formula_tells_apart() -> None:
    closure = closure_of(parse("G(a & b) | F c"))
    assert closure.letters.n_classes == 4
    assert closure_of(parse("G(a1 & a2 & a3 & a4 & a5)")).letters.n_classes == 2
    assert closure_of(parse("true")).letters.n_classes == 1


def test_what_remains_after_a_letter() -> None:
    """a.w satisfies f iff w satisfies after(f, a); the derivative has one obligation for each letter."""
    for rng, formula, closure in random_closures(1, 120):
        closure.register(closure.root)
        derivative = closure.after(closure.obligation(closure.root))
        assert fold(int.__or__, derivative.values()) == closure.letters.all
        assert all(not x & y for x, y in combinations(derivative.values(), 2))
        for _ in range(8):
            word = random_word(rng, closure.letters.aps)
            letter = random_word(rng, closure.letters.aps).cycle[0]
            (number,), _ = letters_of(closure, LassoWord([letter], [letter]))
            remaining = next(f for f, letters in derivative.items() if letters >> number & 1)
            longer = LassoWord((letter, *word.prefix), word.cycle)
            assert satisfies(formula, longer) == satisfies(formula_of_obligation(closure, remaining), word)


@pytest.mark.slow
def test_obligations_are_equivalent_to_their_nodes() -> None:
    for rng, formula, closure in random_closures(2, 150):
        closure.register(closure.root)
        for node in range(len(closure.nodes)):
            obligation = formula_of_obligation(closure, closure.obligation(node))
            for _ in range(4):
                word = random_word(rng, closure.letters.aps)
                truth = satisfies(formula_of_node(closure, node), word)
                assert satisfies(obligation, word) == truth, f"{formula}: node {closure.nodes[node]}"


@pytest.mark.slow
def test_syntactic_implication_is_sound_and_transitively_closed() -> None:
    found = 0
    for rng, formula, closure in random_closures(3, 120, size=14):
        closure.register(closure.root)
        closure.register_finite_parts(closure.root)
        nodes = [formula_of_node(closure, node) for node in range(len(closure.nodes))]
        words = [random_word(rng, closure.letters.aps) for _ in range(12)]
        truth = [[satisfies(f, word) for word in words] for f in nodes]
        for f in range(len(nodes)):
            for g in range(len(nodes)):
                if f != g and closure.implies(f, g):
                    found += 1
                    wrong = [str(w) for w, x, y in zip(words, truth[f], truth[g], strict=True) if x and not y]
                    assert not wrong, f"{nodes[f]} does not imply {nodes[g]} on {wrong[0]} ({formula})"
            if closure.obligation(f) == (1 << f,):
                implied = closure.closed(1 << f)
                assert closure.closed(implied) == implied
    assert found > 1000


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("a & X b", "sigma1"),
        ("F(a & X(b U c))", "sigma1"),
        ("a M b", "sigma1"),
        ("G(a | X b)", "pi1"),
        ("(G a) W b", "pi1"),
        ("F G a", "sigma2"),
        ("a U G b", "sigma2"),
        ("(a W b) & F c", "sigma2"),
        ("G(a | F b)", "pi2"),
        ("G F a", "pi2"),
        ("(F a) R b", "pi2"),
        ("G(F G a | b)", ""),
        ("F(G F a & b)", ""),
        ("G F a | F G b", ""),
    ],
)
def test_level_in_the_hierarchy(text: str, level: str) -> None:
    closure = closure_of(parse(text))
    assert closure.level(closure.root) == level


@pytest.mark.parametrize(
    ("text", "obligation", "fair", "low"),
    [
        ("G a | F b & G c", True, True, True),
        ("G F a & G b", False, True, True),
        ("G F X a & G b", False, False, True),
        ("G(a | F b) | F G c", False, False, True),
        ("G(F a | G b)", False, False, True),
        ("G(F G a | F b)", False, False, False),
    ],
)
def test_shapes(text: str, obligation: bool, fair: bool, low: bool) -> None:
    closure = closure_of(parse(text))
    root = closure.root
    assert closure.is_obligation(root) == obligation
    assert closure.is_fair_obligation(root) == fair
    assert closure.is_low(root) == low


def test_constants_are_folded() -> None:
    closure = closure_of(parse("G(a | F b) & c"))
    true, false = closure.constant(True), closure.constant(False)
    a, b = (closure.node("letters", letters=letters) for letters in (1, 2))
    make = closure.make
    for kind in "&|XFGURWM":
        args = [a] if kind in "XFG" else [a, b]
        assert closure.nodes[make(kind, *args)].kind in (kind, "letters")
    assert make("&", a, false) == false and make("|", a, true) == true
    assert make("&") == true and make("|") == false
    assert make("&", a, a, true) == a
    for kind, left, right, expected in [
        ("U", a, true, true),
        ("U", a, false, false),
        ("U", true, a, make("F", a)),
        ("U", false, a, a),
        ("W", a, true, true),
        ("W", a, false, make("G", a)),
        ("W", true, a, true),
        ("W", false, a, a),
        ("R", a, true, true),
        ("R", a, false, false),
        ("R", true, a, a),
        ("R", false, a, make("G", a)),
        ("M", a, true, make("F", a)),
        ("M", a, false, false),
        ("M", true, a, a),
        ("M", false, a, false),
    ]:
        assert make(kind, left, right) == expected, (kind, left, right)


@pytest.mark.slow
def test_folding_and_negation_keep_the_meaning() -> None:
    for rng, _, closure in random_closures(4, 150):
        rebuilt: dict[int, int] = {}
        for node in range(len(closure.nodes)):
            kind, args, _ = closure.nodes[node]
            rebuilt[node] = node if kind == "letters" else closure.make(kind, *(rebuilt[arg] for arg in args))
        for _ in range(6):
            word = random_word(rng, closure.letters.aps)
            truth = satisfies(formula_of_node(closure, closure.root), word)
            assert satisfies(formula_of_node(closure, rebuilt[closure.root]), word) == truth
            assert satisfies(formula_of_node(closure, closure.negation(closure.root)), word) != truth


@pytest.mark.slow
def test_normal_form_is_equivalent_and_low() -> None:
    rewritten = 0
    for rng, formula, closure in random_closures(5, 300):
        try:
            node = normal_form(closure, closure.root)
        except StateLimitExceeded:
            continue
        rewritten += node != closure.root
        assert closure.is_low(node)
        normal = formula_of_node(closure, node)
        for _ in range(10):
            word = random_word(rng, closure.letters.aps)
            assert satisfies(normal, word) == satisfies(formula, word), f"{formula} on {word}"
    assert rewritten > 50
