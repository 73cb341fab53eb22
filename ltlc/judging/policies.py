"""Policies of other people's, all asked in one way: functions, models with `predict`, networks of PyTorch."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ltlc.envs.held_actions import HeldActions
from ltlc.envs.labels import described, shown
from ltlc.envs.observation import observer
from ltlc.errors import InvalidArgumentError, LtlcError

Array = npt.NDArray[Any]


class Actor:
    """Something that acts, on several observations at once.

    Args:
        space: of one action.
        observation_space: of one observation, as it was made for; None: it does not say.

    Attributes:
        remembers: whether what it does may depend on what came before, since `reset`.
        mode: how it wants to see the state of the automaton where nothing else is said; see `ltlc.envs.observation`.

    Example:
        >>> from gymnasium.spaces import Discrete
        >>> actor_of(lambda observation: observation % 2, Discrete(2)).act([0, 1, 2], None).tolist()
        [0, 1, 0]
    """

    remembers = False
    mode = "dict"

    def __init__(self, space: spaces.Space[Any], observation_space: spaces.Space[Any] | None = None) -> None:
        self.space, self.observation_space = space, observation_space

    def reset(self) -> None:
        """Begin an episode."""

    def act(self, observations: Sequence[Any], masks: Array | None) -> Array:
        """What it does on each observation.

        Args:
            observations: n of them, single ones.
            masks: which actions there are, bool, shape (n, n_actions); None: actions cannot be counted.

        Returns:
            Actions, shape (n, ...), or where they are discrete the probability of each, float, shape (n, n_actions).
        """
        raise NotImplementedError

    @property
    def n_actions(self) -> int:
        """How many actions there are; 0: they cannot be counted."""
        return int(self.space.n) if isinstance(self.space, spaces.Discrete) else 0

    @property
    def first(self) -> int:
        """The first action; nearly always 0."""
        return int(self.space.start) if isinstance(self.space, spaces.Discrete) else 0


def actor_of(policy: Any, space: spaces.Space[Any], *, deterministic: bool = True) -> Actor:
    """A policy as an actor.

    * a network of PyTorch maps flat observations, float32, shape (n, width), to scores of the actions, (n, n_actions);
    * a model has a method `predict(observation, state=None, episode_start=None, deterministic=...)`, as those of
      Stable-Baselines3 have; one that asks for `action_masks` is given them;
    * a function of (observation) or of (observation, mask) returns an action, or the probability of each. If it has a
      method `reset`, that is called where an episode begins, and it may remember what it saw;
    * an agent of `ltlc.agents` sees the state of the automaton in a dict (`ltlc.envs.observation`).

    Args:
        policy: one of these.
        space: of one action.
        deterministic: whether a model takes its most probable action, and a network the one with the best score, or
            draws one, from the softmax of the scores.

    Raises:
        InvalidArgumentError: it is none of these.
    """
    torch = sys.modules.get("torch")  # where it is not loaded, nothing is one of its networks
    if hasattr(policy, "policy_table"):
        return _Agent(policy, space)
    if hasattr(policy, "predict"):
        return _Model(policy, space, deterministic)
    if torch is not None and isinstance(policy, torch.nn.Module):
        return _Network(policy, space, deterministic)
    if callable(policy):
        return _Function(policy, space)
    advice = "take its attribute agent; " if hasattr(policy, "agent") else ""
    raise InvalidArgumentError(
        f"policy is of type {type(policy).__name__}; {advice}it must be a function of an observation, a model with "
        "a method predict, a network of PyTorch, or an array over pairs of environment and automaton state"
    )


class _Agent(Actor):
    """An agent of `ltlc.agents`; draws what it draws from the beginning."""

    def __init__(self, agent: Any, space: spaces.Space[Any]) -> None:
        seen, n_states = agent.encoder.space, agent.tables.n_states
        super().__init__(space, observer("dict", seen, n_states).space)
        self.agent = agent
        self.remembers = agent.action_repeat > 1
        self._held = HeldActions(agent.action_repeat, agent.n_actions)
        agent.reseed(0)

    def reset(self) -> None:
        self._held.clear()

    def act(self, observations: Sequence[Any], masks: Array | None) -> Array:
        states = np.array([seen["automaton"] for seen in observations])
        deciding, actions = self._held.deciding(len(states)), np.zeros(len(states), dtype=np.int64)
        if deciding.any():
            actions = self.agent.policy(_stacked([seen["observation"] for seen in observations]), states)
        actions = self._held.keep(actions, deciding)
        self._held.advance(np.arange(len(actions)), np.zeros(len(actions), dtype=np.bool_))
        return np.asarray(self.first + actions)


class _Function(Actor):
    def __init__(self, function: Callable[..., Any], space: spaces.Space[Any]) -> None:
        super().__init__(space, getattr(function, "observation_space", None))
        self.function: Any = function
        self.remembers = callable(getattr(function, "reset", None))
        try:
            parameters = inspect.signature(function).parameters.values()
        except (TypeError, ValueError):  # some functions in C do not tell
            parameters = {}.values()
        given = (p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD))
        self.masked = sum(p.default is p.empty for p in given) > 1

    def reset(self) -> None:
        if self.remembers:
            self.function.reset()

    def act(self, observations: Sequence[Any], masks: Array | None) -> Array:
        more = [()] * len(observations) if not self.masked else [(None,)] * len(observations)
        if self.masked and masks is not None:
            more = [(mask,) for mask in masks]
        answers = [self._answer(seen, *mask) for seen, mask in zip(observations, more, strict=True)]
        if not self.n_actions:
            return np.stack([np.asarray(answer) for answer in answers])
        shapes = {np.shape(answer) for answer in answers}
        if shapes == {(self.n_actions,)}:
            return np.stack([np.asarray(answer, dtype=np.float64) for answer in answers])
        if any(np.size(answer) != 1 for answer in answers):
            raise InvalidArgumentError(
                f"the policy returns something of shape {sorted(shapes)[0]}; it must return an action, or the "
                f"probabilities of all {self.n_actions}"
            )
        return np.array([self._action(np.asarray(answer).reshape(-1)[0]) for answer in answers], dtype=np.int64)

    def _answer(self, observation: Any, *mask: Any) -> Any:
        try:
            return self.function(observation, *mask)
        except (LtlcError, KeyboardInterrupt):
            raise
        except (Exception, SystemExit) as error:  # the function is the user's, so anything may happen
            raise InvalidArgumentError(
                f"{described(self.function)}, the policy, fails on the observation {shown(observation)} with "
                f"{type(error).__name__}: {error}"
            ) from error

    def _action(self, answer: Any) -> int:
        if not np.issubdtype(type(answer), np.number) or int(answer) != answer:
            raise InvalidArgumentError(f"the policy returns {answer!r}; an action here is a whole number")
        if not self.space.contains(np.int64(answer)):
            raise InvalidArgumentError(f"the policy returns the action {int(answer)}; actions here are {self.space}")
        return int(answer)


class _Model(Actor):
    """A model of Stable-Baselines3, or one with the same method."""

    def __init__(self, model: Any, space: spaces.Space[Any], deterministic: bool) -> None:
        super().__init__(space, getattr(model, "observation_space", None))
        self.model, self.deterministic = model, deterministic
        parameters = inspect.signature(model.predict).parameters
        self.masked = "action_masks" in parameters
        self.keywords = {"deterministic": deterministic} if "deterministic" in parameters else {}
        self.remembers = hasattr(getattr(model, "policy", None), "lstm_actor")
        self.state: Any = None
        normaliser = getattr(model, "get_vec_normalize_env", lambda: None)()
        self.normalised: Callable[[Any], Any] = (
            (lambda batch: batch) if normaliser is None else normaliser.normalize_obs
        )

    def reset(self) -> None:
        self.state = None

    def act(self, observations: Sequence[Any], masks: Array | None) -> Array:
        batch = self.normalised(_stacked(observations))
        if not self.deterministic and self.n_actions and not self.masked and not self.remembers:
            probabilities = self._probabilities(batch)
            if probabilities is not None:
                return probabilities
        keywords: dict[str, Any] = dict(self.keywords)
        if self.masked and masks is not None:
            keywords["action_masks"] = masks
        if self.remembers:
            start = np.full(len(observations), self.state is None)
            actions, self.state = self.model.predict(batch, state=self.state, episode_start=start, **keywords)
        else:
            actions, _ = self.model.predict(batch, **keywords)
        actions = np.asarray(actions)
        return actions.astype(np.int64).reshape(len(observations)) if self.n_actions else actions

    def _probabilities(self, batch: Any) -> Array | None:
        """Of all actions, shape (n, n_actions); None where the model does not tell."""
        policy: Any = getattr(self.model, "policy", None)
        if not hasattr(policy, "get_distribution"):
            return None
        tensors, _ = policy.obs_to_tensor(batch)
        probabilities = policy.get_distribution(tensors).distribution.probs
        return _distribution(probabilities.detach().cpu().numpy())


class _Network(Actor):
    mode = "flat"

    def __init__(self, network: Any, space: spaces.Space[Any], deterministic: bool) -> None:
        super().__init__(space)
        self.network, self.deterministic = network, deterministic
        if not self.n_actions:
            raise InvalidArgumentError(
                f"a network of PyTorch scores discrete actions, and those here are {space}; pass a function instead"
            )

    def act(self, observations: Sequence[Any], masks: Array | None) -> Array:
        import torch

        batch = np.stack([np.asarray(observation, dtype=np.float32).ravel() for observation in observations])
        first = next(self.network.parameters(), torch.zeros(0))
        with torch.no_grad():
            scores = self.network(torch.from_numpy(batch).to(first.device)).cpu().double().numpy()
        if scores.shape != (len(observations), self.n_actions):
            raise InvalidArgumentError(
                f"the network returns scores of shape {scores.shape}; expected {(len(observations), self.n_actions)}"
            )
        if masks is not None:
            scores = np.where(masks, scores, -np.inf)
        if self.deterministic:
            return np.asarray(self.first + scores.argmax(axis=1))
        weights = np.exp(scores - scores.max(axis=1, keepdims=True))
        return _distribution(weights)


def _distribution(weights: Array) -> Array:
    """Rows that are not negative, as probabilities that sum to 1 in double precision."""
    weights = weights.astype(np.float64)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _stacked(observations: Sequence[Any]) -> Any:
    first = observations[0]
    if isinstance(first, dict):
        return {key: _stacked([one[key] for one in observations]) for key in first}
    return np.stack([np.asarray(one) for one in observations])
