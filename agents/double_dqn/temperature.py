"""The temperature of a policy, chosen by what the policy does when the steps of training are over."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..training.collect import Collector, Interface
from ..value_agent import ValueAgent
from .config import DRAWN

BoolArray = npt.NDArray[np.bool_]
_OTHERS = (0.0, 0.3)
"""those tried where episodes fail at that one: what has to be balanced forgives no drawing, a wide world much of it."""
_EPISODES, _PART, _SURE = 100, 5, 2.0
"""episodes that are enough; part of a training's steps that a temperature is tried for at most; and by how many
standard deviations another one has to be better."""


@dataclass(frozen=True)
class Trial:
    """What a policy did at a temperature.

    Attributes:
        temperature: of the policy.
        successes: episodes that satisfied; of those that ended undecided, that accepted at least once.
        episodes: all of them.
    """

    temperature: float
    successes: int
    episodes: int

    @property
    def part(self) -> float:
        """Of the episodes, that succeeded."""
        return self.successes / self.episodes

    def surely_better(self, other: Trial) -> bool:
        """Whether more succeed by more than chance explains."""
        both = (self.successes + other.successes) / (self.episodes + other.episodes)
        deviation = math.sqrt(both * (1 - both) * (1 / self.episodes + 1 / other.episodes))
        return self.part - other.part > _SURE * deviation

    def __str__(self) -> str:
        return f"{self.successes} of {self.episodes} at {self.temperature:g}"


def try_temperatures(
    at: Callable[[float], ValueAgent], interface: Interface, total_steps: int, seed: int, stop: Callable[[], bool]
) -> list[Trial]:
    """Try temperatures in the environment, others than `DRAWN` only where episodes fail at it.

    The steps for that are no part of the training, and a fifth of it at most for each temperature. Whole episodes are
    tried, since those that are cut would speak for what is quick.

    Args:
        at: gives the agent a temperature, and returns it.
        interface: of the environment, which is reset.
        total_steps: of the training.
        seed: of the environment, and of what the policy draws.
        stop: whether to give up.

    Returns:
        The one to take first; nothing where it was given up, or there are too few steps for an episode of each copy.
    """
    trials: list[Trial] = []
    for temperature in (DRAWN, *_OTHERS):
        good = _successes(at(temperature), interface, total_steps // _PART // interface.env.num_envs, seed, stop)
        if good is None or not (len(good) or trials):
            return []
        if len(good):
            trials.append(Trial(temperature, int(good.sum()), len(good)))
            if good.all():
                break
    first = max(trials, key=lambda trial: (trial is trials[0] or trial.surely_better(trials[0])) * trial.part)
    return [first, *(trial for trial in trials if trial is not first)]


def _successes(
    agent: ValueAgent, interface: Interface, rounds: int, seed: int, stop: Callable[[], bool]
) -> BoolArray | None:
    """Whether each whole episode of a policy succeeds, in at most so many steps of each copy; None: it was given up."""
    collector, n = Collector(interface, agent.encoder), interface.env.num_envs
    tables, (won, lost, ended) = agent.tables, _outcomes(agent)
    found: list[BoolArray] = []
    agent.reseed(seed)
    while rounds and n * len(found) < _EPISODES:
        collector.reset(seed + len(found))
        good, accepted, over = np.zeros((3, n), dtype=np.bool_)
        while rounds and not over.all():
            if stop():
                return None
            steps, rounds = collector.follow(agent), rounds - 1
            who, at = steps.copy, (steps.state, steps.letter_class)
            accepted[who] |= tables.accepted[at]
            so_far = np.where(steps.terminated & (tables.on_termination == "repeat"), ended[at], accepted[who])
            good[who] = np.where(over[who], good[who], won[at] | (so_far & ~lost[at]))
            over[who] |= steps.ended | won[at] | lost[at]
        found += [good] if over.all() else []
    return np.concatenate([np.zeros(0, dtype=np.bool_), *found])


def _outcomes(agent: ValueAgent) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Which steps satisfy surely, which lose surely, and which satisfy if the world ends with them.

    Returns:
        Each of shape (n_states, n_classes).
    """
    tables = agent.tables
    least, largest = (part.cpu().numpy() for part in (agent.tensor_tables.least, agent.tensor_tables.largest))
    after, middle = tables.next_state, largest.max() / 2
    lost = tables.violated | (largest[after] <= 0) | (tables.terminal & ~tables.accepted)
    return (least[after] > middle) & ~tables.violated, lost, tables.final_value > middle  # its last letter, for ever
