"""Smaller automata of the same language, automata with marks on states, and proofs that none is smaller.

Examples: docs/examples.md.
"""

from typing import TYPE_CHECKING

from ltlc.lazy import on_first_use
from ltlc.minimize.collapse import Minimized, collapse
from ltlc.minimize.lower_bound import lower_bound
from ltlc.minimize.merge_by_trial import merge_by_trial
from ltlc.minimize.reduce import merge_bisimilar, merge_equivalent, reduce

if TYPE_CHECKING:
    from ltlc.minimize.sat_minimize import minimize
    from ltlc.minimize.state_based import to_state_based

__all__ = [
    "Minimized",
    "collapse",
    "lower_bound",
    "merge_bisimilar",
    "merge_by_trial",
    "merge_equivalent",
    "minimize",
    "reduce",
    "to_state_based",
]

_HOME = {
    "minimize": "ltlc.minimize.sat_minimize",
    "to_state_based": "ltlc.minimize.state_based",
}

if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = on_first_use(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
