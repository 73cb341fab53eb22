"""What a rewrite rule is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ltlc.ltl.formula import Formula
from ltlc.ltl.implication import Implications

MAX_PAIRWISE = 40
"""Rules that compare operands pair by pair leave longer conjunctions and disjunctions alone."""

Rewrite = Callable[[Formula, Implications], Formula | None]


@dataclass(frozen=True)
class Rule:
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
    grows: bool = False
    """whether the result may be larger; it is then of a shape that gives smaller automata."""


class RuleBook(list[Rule]):
    """Rules in the order in which they are tried."""

    def rule(
        self, *operators: type[Formula], name: str, laws: str, grows: bool = False
    ) -> Callable[[Rewrite], Rewrite]:
        """Registers the decorated function; `laws` are separated by semicolons."""

        def register(apply: Rewrite) -> Rewrite:
            self.append(Rule(name, tuple(law.strip() for law in laws.split(";")), operators, apply, grows))
            return apply

        return register


def operands(formula: Formula, connective: type[Formula]) -> tuple[Formula, ...]:
    """The operands of an & or |, or the formula alone if it is no such one."""
    return formula.args if type(formula) is connective else (formula,)
