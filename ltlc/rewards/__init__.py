"""Reward schemes: from a deterministic Rabin automaton to tables of rewards and discounts."""

from ltlc.rewards.registry import RECOMMENDED, SCHEMES, arguments_of, get_scheme, register_scheme
from ltlc.rewards.scheme import OnDeadlock, RewardScheme
from ltlc.rewards.shaping import Shaped, shape
from ltlc.rewards.tables import OnTermination, RewardTables

__all__ = [
    "RECOMMENDED",
    "SCHEMES",
    "OnDeadlock",
    "OnTermination",
    "RewardScheme",
    "RewardTables",
    "Shaped",
    "arguments_of",
    "get_scheme",
    "register_scheme",
    "shape",
]
