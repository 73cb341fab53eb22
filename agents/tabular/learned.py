"""What a tabular learner has come to, during training and in the end."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from ..training.shortcomings import Seen


@dataclass(frozen=True, eq=False)
class Learned:
    """A policy and how it came about.

    `ltlc.mdp.Product.lift` and `RewardProduct.lift` make the policy one on the states of a product, to be judged.
    """

    policy: npt.NDArray[Any] | None
    """an action (int, shape (n_env_states, n_q)) or probabilities of actions (float, a last axis more) for each pair of
    environment state and state q of the automaton (of the reward tables, for Q-learning); None: there is none."""
    message: str
    """one sentence on how training ended, or why there is no policy."""
    steps: int
    """environment steps, all sub-environments together."""
    seconds: float
    """of learning and planning; callbacks do not count."""
    product_states: int
    """product states built (learners of a model), or visited (Q-learning)."""
    accepting_components: int | None
    """accepting maximal end components of the learned product; None for learners that do not look for them."""
    value: float
    """the learner's own estimate of its objective from the start: a probability, or a return."""
    seen: Seen | None = None
    """what the steps came across; None for learners of a model, whose `message` tells what they look for."""
    counterfactual: bool = False
    """whether each step taught every state of the reward tables."""


Callback = Callable[[Learned], bool | None]
"""called with what has been learned so far; training stops where it returns True."""


class Stopwatch:
    """Seconds of training, with the time in callbacks taken out."""

    def __init__(self) -> None:
        self._start = time.perf_counter()

    @property
    def seconds(self) -> float:
        """Seconds so far."""
        return time.perf_counter() - self._start

    def report(self, callback: Callback | None, learned: Learned) -> bool:
        """Call back, off the clock; whether training is to stop."""
        if callback is None:
            return False
        before = time.perf_counter()
        stop = bool(callback(learned))
        self._start += time.perf_counter() - before
        return stop
