"""Episodes of a policy, and what their words say about the formula."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.envs.success import Success
from ltlc.judging.places import Place
from ltlc.judging.policies import Actor
from ltlc.mdp.estimate import Estimate, probability


@dataclass(frozen=True)
class Sample:
    """Episodes by what is known of their words.

    Attributes:
        satisfied: whose words satisfy the formula whatever follows, or are over: then the last letter is for ever.
        violated: whose words violate it, likewise.
        undecided: that were cut before either was known.
        confidence: of the interval, in (0, 1).

    Example:
        >>> print(Sample(satisfied=60, violated=30, undecided=10).satisfaction)
        0.6 [0.4244, 0.8412] (95%, n = 100)
    """

    satisfied: int = 0
    violated: int = 0
    undecided: int = 0
    confidence: float = 0.95

    @property
    def episodes(self) -> int:
        """How many there are."""
        return self.satisfied + self.violated + self.undecided

    @property
    def satisfaction(self) -> Estimate:
        """The satisfaction probability: the part of the episodes that surely satisfy, and an interval.

        It holds for all numbers of episodes at once, so one may stop when one likes what one sees. Undecided episodes
        may be either: they count against its lower end and for its upper end. Each end errs with half of what the
        confidence leaves.

        Raises:
            InvalidArgumentError: there are no episodes.
        """
        each, n = (1 + self.confidence) / 2, self.episodes
        good = probability(self.satisfied, n, confidence=each, method="anytime")
        bad = probability(self.violated, n, confidence=each, method="anytime")
        return Estimate(good.value, good.low, 1 - bad.low, self.confidence, n)


def sample(
    place: Place,
    actor: Actor,
    *,
    episodes: int,
    max_steps: int,
    precision: float,
    confidence: float,
    seed: int,
) -> Sample:
    """Run episodes until their interval is at most `precision` wide, or there are so many.

    The task ends none of them, whatever its rewards do; Ctrl-C ends the sampling after one episode at least.

    Args:
        place: where.
        actor: the policy.
        episodes: at most.
        max_steps: after which an episode is cut.
        precision: 0: run all episodes.
        confidence: of the interval.
        seed: of the environment in the first episode, and of draws of actions.
    """
    random, found = np.random.default_rng(seed), Sample(confidence=confidence)
    outcome = _Outcomes(place)
    stops, place.wrapper.stops = place.wrapper.stops, False
    try:
        for episode in range(episodes):
            word = outcome.of_episode(actor, max_steps, random, seed if episode == 0 else None)
            found = replace(found, **{word: getattr(found, word) + 1})
            if precision and found.satisfaction.high - found.satisfaction.low <= precision:
                break
    except KeyboardInterrupt:
        if not found.episodes:
            raise
    finally:
        place.wrapper.stops = stops
    return found


class _Outcomes:
    """Runs episodes and says what their words do."""

    def __init__(self, place: Place) -> None:
        self.place = place
        automaton = place.task.automaton
        self.won, self.lost = set(automaton.accepting_sinks), set(automaton.deadlocks)
        self.word = Success(automaton, place.wrapper.initial_label == "skip")

    def of_episode(self, actor: Actor, max_steps: int, random: np.random.Generator, seed: int | None) -> str:
        """The name of the field of `Sample` that the episode belongs to."""
        env, wrapper = self.place.env, self.place.wrapper
        observation, info = env.reset(seed=seed)
        actor.reset()
        holds = self.word.read(info["ltl"]["label"], True)
        for _ in range(max_steps):
            if int(self.word.state) in self.won:
                return "satisfied"
            if int(self.word.state) in self.lost:
                return "violated"
            masks = wrapper.action_masks()[None] if actor.n_actions else None
            action = _drawn(actor.act([observation], masks)[0], actor, random)
            observation, _, terminated, truncated, info = env.step(action)
            holds = self.word.read(info["ltl"]["label"])
            if terminated:
                return "satisfied" if holds else "violated"
            if truncated:
                break
        state = int(self.word.state)
        return "satisfied" if state in self.won else "violated" if state in self.lost else "undecided"


def _drawn(answer: npt.NDArray[Any], actor: Actor, random: np.random.Generator) -> Any:
    if not actor.n_actions:
        return answer
    if not np.ndim(answer):
        return int(answer)
    return actor.first + int(random.choice(actor.n_actions, p=answer))
