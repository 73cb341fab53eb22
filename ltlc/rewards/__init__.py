"""Reward schemes: from a deterministic Rabin automaton to tables of rewards and discounts.

Examples: docs/examples.md.
"""

from ltlc.rewards.bounds import ValueBounds, value_bounds
from ltlc.rewards.buchi_scheme import BuchiScheme, discounted_acceptances
from ltlc.rewards.registry import RECOMMENDED, SCHEMES, arguments_of, get_scheme, register_scheme
from ltlc.rewards.scheme import OnDeadlock, RewardScheme, StepRewards
from ltlc.rewards.shaping import Shaped, shape
from ltlc.rewards.tables import OnTermination, RewardTables

__all__ = [
    "RECOMMENDED",
    "SCHEMES",
    "BuchiScheme",
    "OnDeadlock",
    "OnTermination",
    "RewardScheme",
    "RewardTables",
    "Shaped",
    "StepRewards",
    "ValueBounds",
    "arguments_of",
    "discounted_acceptances",
    "get_scheme",
    "register_scheme",
    "shape",
    "value_bounds",
]
