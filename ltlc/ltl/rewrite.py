"""Simplification: the named rules of `RULES`, applied bottom-up until none applies."""

from __future__ import annotations

from functools import cache

from ltlc.budget import check_time
from ltlc.ltl.formula import Formula
from ltlc.ltl.implication import Implications
from ltlc.ltl.normal import nnf
from ltlc.ltl.recall import without_past
from ltlc.ltl.rule import Rewrite, Rule
from ltlc.ltl.rules_binary import BINARY_RULES
from ltlc.ltl.rules_boolean import BOOLEAN_RULES
from ltlc.ltl.rules_informed import INFORMED_RULES
from ltlc.ltl.rules_unary import UNARY_RULES
from ltlc.ltl.shape import LITERAL, NO_PAST

RULES: tuple[Rule, ...] = (*BOOLEAN_RULES, *INFORMED_RULES, *UNARY_RULES, *BINARY_RULES)
"""In the order in which they are tried on a node."""

STEPS_PER_NODE = 50
MAX_TREE = 100_000
"""Rewriting steps: so many for each node of the input, of at most so many nodes; then what was reached is the result.

No rule is known to undo another, so this is a safety net only.
"""


def simplify(formula: Formula, done: dict[Formula, Formula] | None = None) -> Formula:
    """An equivalent formula in negation normal form that is easier to translate, mostly a smaller one.

    Args:
        formula: any.
        done: what subformulas became in earlier calls; it grows. For those who rewrite one formula again and again.

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
    if root.flags & NO_PAST:
        return _simplified(root, {} if done is None else done)
    recalled = without_past(root)  # as far as the rules know, what the past says is a proposition
    return recalled.together(_simplified(recalled.future, {}))


def _simplified(root: Formula, done: dict[Formula, Formula]) -> Formula:
    known = Implications()
    steps = STEPS_PER_NODE * min(root.size, MAX_TREE)
    # Each entry is an original node and what it has become so far; it waits there until the operands are done.
    stack = [(root, root)]
    while stack:
        origin, node = stack[-1]
        if node in done:
            done[origin] = done[node]
            stack.pop()
            continue
        height = len(stack)
        same = True
        for child in node.args:
            simple = done.get(child)
            if simple is not None:
                same = same and simple is child
            elif child.flags & LITERAL:
                done[child] = child
            else:
                stack.append((child, child))
        if len(stack) > height:
            continue
        if not steps & 15:
            check_time()
        better: Formula | None
        if same:
            better = _first_rewrite(node, known) if steps > 0 else None
            steps -= 1
        else:
            better = node.with_args(tuple([done[child] for child in node.args]))
        if better is None:
            done[node] = node
        else:
            stack[-1] = (origin, better)
    return done[root]


def _first_rewrite(node: Formula, known: Implications) -> Formula | None:
    for apply in candidates(node):
        result = apply(node, known)
        if result is not None:
            return result
    return None


def candidates(node: Formula) -> tuple[Rewrite, ...]:
    """The rules that may apply to a node, by the classes of its operands and the propositions they share."""
    shared = False
    met = 0
    for arg in node.args:
        either = arg.literal_mask | arg.negated_literal_mask
        shared = shared or bool(either & met)
        met |= either
    # mypy takes a class, as the argument of a cached function, for one of its instances.
    return _candidates(type(node), frozenset(map(type, node.args)), shared)  # type: ignore[arg-type]


@cache
def _candidates(operator: type[Formula], operands: frozenset[type[Formula]], shared: bool) -> tuple[Rewrite, ...]:
    return tuple(
        rule.apply
        for rule in RULES
        if operator in rule.operators and (not rule.having or rule.having & operands) and (shared or not rule.shared)
    )
