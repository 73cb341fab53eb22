"""Smaller automata of the same language, automata with marks on states, and proofs that none is smaller.

Examples: docs/examples.md.
"""

from ltlc.minimize.collapse import Minimized, collapse
from ltlc.minimize.lower_bound import lower_bound
from ltlc.minimize.merge_by_trial import merge_by_trial
from ltlc.minimize.reduce import merge_bisimilar, merge_equivalent, reduce
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
