"""How probably a policy satisfies its task: with proof where the environment is known, by episodes elsewhere."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from ltlc.automata import DFA, DRA
from ltlc.envs.labels import LabelSource
from ltlc.errors import InvalidArgumentError
from ltlc.judging.places import Place, place_of
from ltlc.judging.policies import Actor, actor_of
from ltlc.judging.sampled import Sample, sample
from ltlc.ltl import Formula
from ltlc.mdp import Judge, PolicyVerdict
from ltlc.mdp.estimate import Estimate
from ltlc.mdp.figures import exact_lines, figure_text, verdict_values
from ltlc.notebook import bar, fragment
from ltlc.prism import Exported, export_policy
from ltlc.task import Task

_ASKED_TWICE = 200
"""pairs of states that a policy is asked about twice, to see whether it answers alike."""


@dataclass(frozen=True)
class Judgement:
    """What is known of how probably a policy satisfies its task.

    Attributes:
        task: the task.
        judge: of the task in the known environment; None: that is not known, or the policy cannot be tabulated.
        policy: the policy as a table that `judge` takes; None where there is no judge.
        verdict: exact figures; None where there is no judge.
        sample: episodes; None where the figures are exact.
        why_sampled: why they are not.
    """

    task: Task
    judge: Judge | None = None
    policy: npt.NDArray[Any] | None = None
    verdict: PolicyVerdict | None = None
    sample: Sample | None = None
    why_sampled: str = ""

    @property
    def exact(self) -> bool:
        """Whether the bounds are proved."""
        return self.verdict is not None

    @property
    def satisfaction(self) -> float:
        """The satisfaction probability, in [0, 1]; of a sample, the part of the episodes that surely satisfy."""
        if self.verdict is not None:
            return self.verdict.satisfaction
        assert self.sample is not None
        return self.sample.satisfaction.value

    @property
    def bounds(self) -> tuple[float, float]:
        """Proved bounds on the satisfaction probability, or those that hold with the confidence of the sample."""
        if self.verdict is not None:
            return self.verdict.satisfaction_bounds
        assert self.sample is not None
        estimate = self.sample.satisfaction
        return estimate.low, estimate.high

    def export(self, folder: str | os.PathLike[str]) -> Exported:
        """Write the Markov chain that the policy induces, with the formula, for PRISM and Storm.

        Raises:
            InvalidArgumentError: the environment is not known, or the formula.
            OSError: a file cannot be written.
        """
        if self.judge is None or self.policy is None:
            raise InvalidArgumentError(f"there is no Markov chain to write: {self.why_sampled}")
        mdp = self.judge.rewards.mdp
        return export_policy(mdp, self.task, self.policy, folder, initial_label=self.judge.initial_label)

    def to_dict(self) -> dict[str, Any]:
        """The figures as JSON values."""
        values: dict[str, Any] = {"exact": self.exact, "satisfaction": self.satisfaction, "bounds": list(self.bounds)}
        if self.verdict is not None and self.judge is not None:
            best = self.judge.maximum
            values |= {
                "maximum_satisfaction": [best.lower, best.probability, best.upper],
                "learned": verdict_values(self.verdict),
            }
        if self.sample is not None:
            values |= {
                name: getattr(self.sample, name) for name in ("satisfied", "violated", "undecided", "confidence")
            }
            values["why_sampled"] = self.why_sampled
        return values

    def _repr_html_(self) -> str:
        """The verdict for a notebook: the sentence, a bar, and the exact figures, if they are."""
        best = None if self.judge is None else self.judge.maximum.probability
        (low, high), optimum = self.bounds, None if self.judge is None else self.judge.optimum
        rows = []
        if self.verdict is not None:
            rows = [
                (
                    line.title,
                    figure_text(float(line.learned), line.learned_bounds),
                    "" if line.optimum is None else figure_text(line.optimum, line.optimum_bounds),
                )
                for line in exact_lines(self.verdict, optimum)
                if not isinstance(line.learned, Estimate)
            ]
        titles = ("", "this policy", "best for the rewards") if rows else ()
        return fragment(str(self), rows, titles=titles, picture=bar(low, self.satisfaction, high, best))

    def __str__(self) -> str:
        what = f"satisfies {self.task.formula or 'the task'}"
        if self.judge is not None:
            best = self.judge.maximum
            learned, most = figure_text(self.satisfaction, self.bounds), (best.lower, best.upper)
            return f"{what} with probability {learned} (the best policy: {figure_text(best.probability, most)})"
        assert self.sample is not None
        seen, (low, high) = self.sample, self.bounds
        return (
            f"{what} with a probability between {low:.4g} and {high:.4g} ({seen.confidence:.0%}; of {seen.episodes} "
            f"episodes, {seen.satisfied} satisfy it, {seen.violated} violate it, {seen.undecided} were cut before "
            "that was known)"
        )


def judge(
    policy: Any,
    env: gym.Env[Any, Any] | str,
    task: Task | Formula | str | DRA | DFA | None = None,
    *,
    labels: LabelSource = None,
    deterministic: bool = True,
    exact: bool | None = None,
    episodes: int = 1000,
    max_steps: int = 10_000,
    precision: float = 0.0,
    confidence: float = 0.95,
    seed: int = 0,
) -> Judgement:
    """Judge a policy of any kind: how probably does the word of an endless run satisfy the formula?

    Where the dynamics of the environment are known and the policy sees their states, the answer is exact, with proved
    bounds: the policy is asked once for each pair of environment and automaton state. Elsewhere episodes are sampled.
    Their interval holds whenever one stops (`Sample.satisfaction`), and words that were cut before their end are
    counted on neither side. A violation is final, whatever the rewards do on a deadlock.

    Args:
        policy: a function, a model with `predict` (as of Stable-Baselines3), a network of PyTorch, see `actor_of`; or
            an array of actions, int, shape (n_mdp_states, n_table_states), or of probabilities, with a last axis more;
            or an agent of `ltlc.agents`.
        env: an environment that is wrapped in an `LTLWrapper`, as the policy saw it in its training; or one that is
            not, and then the policy sees the state of the automaton as its `observation_space` says: in a flat
            observation if it is a network, else in a dict (`ltlc.envs.observation`). Or its name in Gymnasium's
            registry.
        task: what is to be satisfied, if the environment is not wrapped.
        labels: as an `LTLWrapper` takes them, if the environment is not wrapped.
        deterministic: see `actor_of`.
        exact: True: raise an error where the answer cannot be exact; False: sample in any case.
        episodes: to sample, at most.
        max_steps: of an episode, besides the limit of the environment itself.
        precision: sample no more where the interval is so narrow; 0: sample all episodes.
        confidence: of the interval, in (0, 1).
        seed: of the sampling.

    Raises:
        InvalidArgumentError: something does not go together, or the answer cannot be exact and should be.
        UnknownNameError: the formula speaks of something that no label produces.

    Example:
        >>> lake = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}
        >>> always_right = judge(lambda observation: 2, "FrozenLake-v1", "F goal & G !hole", labels=lake)
        >>> print(always_right)
        satisfies F goal & G !hole with probability 0.0315 (the best policy: 0.8235)
    """
    if episodes < 1 or max_steps < 1:
        raise InvalidArgumentError(f"episodes is {episodes} and max_steps is {max_steps}; both must be at least 1")
    if not 0 < confidence < 1:
        raise InvalidArgumentError(f"confidence is {confidence}, expected a number between 0 and 1")
    table = _as_table(policy)

    def acting(made: Any) -> Actor:
        return actor_of(policy, made.action_space, deterministic=deterministic)

    place, actor = place_of(env, task, labels, acting if table is None else lambda made: Actor(made.action_space))
    why = "it was asked for" if exact is False else place.why_not
    if place.mdp is not None and exact is not False:
        found = Judge(place.mdp, place.task, initial_label=place.wrapper.initial_label)
        if table is None:
            table, why = _tabulated(found, place, actor)
        if table is not None:
            return Judgement(place.task, found, table, found.judge(table))
    if exact or isinstance(policy, np.ndarray | list):
        raise InvalidArgumentError(f"the policy cannot be judged exactly: {why}")
    if table is not None:  # of an agent, which acts as well
        place, actor = place_of(env, task, labels, acting)
    drawn = sample(
        place, actor, episodes=episodes, max_steps=max_steps, precision=precision, confidence=confidence, seed=seed
    )
    return Judgement(place.task, sample=drawn, why_sampled=why)


def _as_table(policy: Any) -> npt.NDArray[Any] | None:
    if isinstance(policy, np.ndarray | list):
        return np.asarray(policy)
    numbered = hasattr(policy, "policy_table") and policy.encoder.n_observations > 0
    return np.asarray(policy.policy_table()) if numbered else None


def _tabulated(judge: Judge, place: Place, actor: Actor) -> tuple[npt.NDArray[Any] | None, str]:
    """What the policy does in each pair of environment and table state; or None, and why there is no such table."""
    if actor.remembers:
        return None, "what the policy does may depend on what it saw before"
    if not actor.n_actions:
        return None, f"its actions are {actor.space}"
    mdp, n_states = judge.rewards.mdp, place.task.tables.n_states
    matters = judge.reached.copy()
    words, inside = judge.words, judge.words.machine_state < n_states
    matters[words.mdp_state[inside], words.machine_state[inside]] = True
    pairs = np.argwhere(matters)
    shown = [place.observation(state, q) for state, q in pairs.tolist()]
    choices = place.wrapper.choices.mask
    assert choices is not None
    masks = choices[pairs[:, 1]] & np.tile(mdp.available, choices.shape[1] // mdp.n_actions)[pairs[:, 0]]
    answers = actor.act(shown, masks)
    again = actor.act(shown[:_ASKED_TWICE], masks[:_ASKED_TWICE])
    if not np.allclose(answers[:_ASKED_TWICE], again, atol=1e-6):
        return None, "the policy does different things where it sees the same; it is random or remembers something"
    table = np.zeros((*matters.shape, *answers.shape[1:]), dtype=answers.dtype)
    table[...] = _fallback(mdp.available, answers)
    table[matters] = answers
    return table, ""


def _fallback(available: npt.NDArray[np.bool_], answers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The first action that each state offers, in the form of the answers, for pairs that are never visited."""
    first = available.argmax(axis=1)
    return np.asarray(first[:, None] if answers.ndim == 1 else np.eye(answers.shape[1])[first][:, None])
