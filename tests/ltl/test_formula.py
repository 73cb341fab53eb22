"""Nodes: one object for one formula, for as long as somebody has it, and the facts that it carries."""

from __future__ import annotations

import gc
import random
import weakref
from concurrent.futures import ThreadPoolExecutor
from functools import reduce
from operator import or_

import pytest
from random_ltl import random_formula

from ltlc.ltl import TRUE, And, Formula, Iff, Implies, Next, Not, Or, Proposition, Xor, nnf, parse, postorder
from ltlc.ltl.shape import LITERAL, NORMAL


def test_formulas_are_immutable() -> None:
    formula = parse("a U b")
    for name in (*Formula.__slots__, "other"):
        with pytest.raises(AttributeError, match="immutable"):
            setattr(formula, name, 1)
    with pytest.raises(TypeError, match="parse"):
        Formula()


@pytest.mark.slow
def test_a_node_goes_with_its_last_reference() -> None:
    formula: Formula = Proposition("only_here")
    nodes = [formula, *(formula := Next(formula) for _ in range(5))]
    watch = [weakref.ref(node) for node in nodes]
    del nodes
    gc.collect()
    assert all(node() is not None for node in watch)
    assert parse("X X X X X only_here") is formula
    del formula
    gc.collect()
    assert [node() for node in watch] == [None] * 6
    assert str(parse("X X only_here")) == "X X only_here"


def test_threads_get_the_same_node() -> None:
    def build(_: int) -> list[Formula]:
        rng = random.Random(1)
        return [random_formula(rng, 15, [f"thread_{i}" for i in range(4)]) for _ in range(200)]

    with ThreadPoolExecutor(8) as pool:
        first, *others = pool.map(build, range(8))
    assert all(ours is theirs for other in others for ours, theirs in zip(first, other, strict=True))


def test_size_counts_the_nodes_of_the_tree() -> None:
    assert parse("a U (b & c & !a)").size == 7
    doubled = parse("a")
    for _ in range(100):
        doubled = Iff(doubled, doubled)
    assert doubled.size == 2**101 - 1


def test_normal_form_is_recognised() -> None:
    rng = random.Random(2)
    for _ in range(500):
        for node in postorder(random_formula(rng, 12)):
            literal = isinstance(node, Proposition) or (isinstance(node, Not) and isinstance(node.args[0], Proposition))
            assert bool(node.flags & LITERAL) == literal
            nodes = list(postorder(node))
            odd = any(isinstance(n, (Implies, Iff, Xor)) or (isinstance(n, Not) and n.args[0].args) for n in nodes)
            odd = odd or any(isinstance(n, Not) and not n.args[0].flags & LITERAL for n in nodes)
            assert bool(node.flags & NORMAL) != odd, str(node)


def test_signs_are_those_of_the_literals() -> None:
    rng = random.Random(3)
    for _ in range(500):
        formula = nnf(random_formula(rng, 12, constants=0))
        literals = [node for node in postorder(formula) if node.flags & LITERAL]
        # A proposition under a negation is met on the way to it, but does not occur by itself.
        negated = {node.args[0] for node in literals if node.args}
        plain = {arg for node in postorder(formula) if not isinstance(node, Not) for arg in node.args} | {formula}
        occurring = [node for node in literals if node.args or node in plain or node not in negated]
        assert formula.literal_mask == reduce(or_, (literal.literal_mask for literal in occurring))
        assert nnf(Not(formula)).literal_mask == formula.negated_literal_mask
        assert nnf(Not(formula)).negated_literal_mask == formula.literal_mask
    assert parse("a & b").literal_mask & parse("!a | b").negated_literal_mask
    assert Or(Proposition("a"), TRUE).literal_mask & And(Proposition("b"), Not(Proposition("c"))).literal_mask
