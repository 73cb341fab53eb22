"""Simplification: the named rules of `RULES`, applied bottom-up until none applies."""

from __future__ import annotations

from functools import cache

from ltlc.ltl.formula import Formula
from ltlc.ltl.implication import Implications
from ltlc.ltl.normal import nnf
from ltlc.ltl.rule import Rule
from ltlc.ltl.rules_boolean import BOOLEAN_RULES
from ltlc.ltl.rules_temporal import TEMPORAL_RULES

RULES: tuple[Rule, ...] = (*BOOLEAN_RULES, *TEMPORAL_RULES)
"""In the order in which they are tried on a node."""

STEPS_PER_NODE = 50
MAX_TREE = 100_000
"""Rewriting steps: so many for each node of the input, of at most so many nodes; then what was reached is the result.

No rule is known to undo another, so this is a safety net only.
"""


def simplify(formula: Formula) -> Formula:
    """An equivalent formula in negation normal form that is easier to translate, mostly a smaller one.

    >>> from ltlc.ltl import parse
    >>> simplify(parse("F a | G F(b & F c) | X F a | F(d U a)"))
    parse('F a | G F b & G F c')

    References:
        Kousha Etessami and Gerard Holzmann, Optimizing Buchi automata, CONCUR 2000, doi:10.1007/3-540-44618-4_13.
        Fabio Somenzi and Roderick Bloem, Efficient Buchi automata from LTL formulae, CAV 2000,
        doi:10.1007/10722167_21.
        Tomas Babiak, Mojmir Kretinsky, Vojtech Rehak and Jan Strejcek, LTL to Buchi automata translation: fast and
        more deterministic, TACAS 2012, doi:10.1007/978-3-642-28756-5_8.
    """
    root = nnf(formula)
    known = Implications()
    done: dict[Formula, Formula] = {}
    steps = STEPS_PER_NODE * min(known.size(root), MAX_TREE)
    # Each entry is an original node and what it has become so far; it waits there until the operands are done.
    stack = [(root, root)]
    while stack:
        origin, node = stack[-1]
        missing = [] if node in done else [child for child in node.args if child not in done]
        if missing:
            stack.extend((child, child) for child in missing)
            continue
        if node in done:
            done[origin] = done[node]
            stack.pop()
            continue
        better: Formula | None = node.with_args(tuple(done[child] for child in node.args))
        if better is node:
            better = _first_rewrite(node, known) if steps > 0 else None
            steps -= 1
        if better is None:
            done[node] = node
        else:
            stack[-1] = (origin, better)
    return done[root]


def _first_rewrite(node: Formula, known: Implications) -> Formula | None:
    for rule in _rules_by_operator().get(type(node), ()):
        result = rule.apply(node, known)
        if result is not None:
            return result
    return None


@cache
def _rules_by_operator() -> dict[type[Formula], list[Rule]]:
    table: dict[type[Formula], list[Rule]] = {}
    for rule in RULES:
        for operator in rule.operators:
            table.setdefault(operator, []).append(rule)
    return table
