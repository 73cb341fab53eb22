"""What a rewrite rule is."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ltlc.ltl.formula import Formula
from ltlc.ltl.implication import Implications

MAX_PAIRWISE = 40
"""Rules that compare operands pair by pair leave longer conjunctions and disjunctions alone."""
MAX_COPIED = 60
"""Rules that write an operand twice leave one of more nodes alone, so that nesting cannot double it over and over."""

Rewrite = Callable[[Formula, Implications], Formula | None]


class Rule(NamedTuple):
    """One way to make a formula simpler.

    A rule looks at one node in negation normal form, whose operands are simplified already, and returns an equivalent
    formula or None. In the laws a b c d are any formulas, e is a pure eventuality, u a pure universality, s both, and
    p a literal.
    """

    name: str
    laws: tuple[str, ...]
    """each `left = right`, perhaps `if condition`; the left side is what the rule rewrites."""
    operators: tuple[type[Formula], ...]
    """the operators of the nodes it is tried on."""
    apply: Rewrite
    having: frozenset[type[Formula]] = frozenset()
    """if not empty, some operand of the node has to be of one of these classes."""
    shared: bool = False
    """whether two operands of the node have to have a proposition in common, or one of them a constant."""
    grows: bool = False
    """whether the result may be larger; it is then of a shape that gives smaller automata."""


class RuleBook(list[Rule]):
    """Rules in the order in which they are tried."""

    def rule(
        self,
        *operators: type[Formula],
        name: str,
        laws: str,
        having: tuple[type[Formula], ...] = (),
        shared: bool = False,
        grows: bool = False,
    ) -> Callable[[Rewrite], Rewrite]:
        """Registers the decorated function; `laws` are separated by semicolons."""

        def register(apply: Rewrite) -> Rewrite:
            texts = tuple(law.strip() for law in laws.split(";"))
            self.append(Rule(name, texts, operators, apply, frozenset(having), shared, grows))
            return apply

        return register


def operands(formula: Formula, connective: type[Formula]) -> tuple[Formula, ...]:
    """The operands of an & or |, or the formula alone if it is no such one."""
    return formula.args if type(formula) is connective else (formula,)


def factor_out(
    operand: Formula, flags: int, wrap: Callable[[Formula], Formula], around: Formula | None = None
) -> Formula | None:
    """Splits an & or | into wrap(the parts that stay) and the parts with all the flags, each under `around`."""
    moved = [part for part in operand.args if part.flags & flags == flags]
    if not moved or (len(moved) == len(operand.args) and around is None):
        return None
    stay = [part for part in operand.args if part.flags & flags != flags]
    connective = type(operand)
    return connective(
        wrap(connective(*stay)), *(part if around is None else around.with_args((part,)) for part in moved)
    )
