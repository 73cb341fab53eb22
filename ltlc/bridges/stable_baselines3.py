"""Stable-Baselines3: replay buffers with the discount of each step and counterfactual replay, and saved models.

An `LTLWrapper` is an environment that its agents take as it is. What they do not know by themselves is that a step may
have a discount of its own, and that each step of the environment tells what would have happened in the other states of
the automaton:

    env = TimeLimit(LTLWrapper(world, task, observation="flat", success_key=True), 200)
    model = DQN("MlpPolicy", env, **replay(env, counterfactual=True))
    print(ltlc.judge(model.learn(20_000), env))

DQN, SAC, TD3 and others with a replay buffer use it. PPO and A2C have one discount for all steps: take the rewards
"zeta-reach" and `gamma=1` there. Masks are read by MaskablePPO of sb3-contrib from the environment as it is.
"""

from __future__ import annotations

import json
import os
import warnings
import zipfile
from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.bridges.counterfactual import JointObservations
from ltlc.envs import LTLWrapper
from ltlc.errors import FileFormatError, InvalidArgumentError, MissingProgramError, RewardWarning

try:
    import stable_baselines3
    from gymnasium import spaces
    from stable_baselines3.common.buffers import DictReplayBuffer, ReplayBuffer
    from stable_baselines3.common.type_aliases import DictReplayBufferSamples, ReplayBufferSamples
except ImportError as error:
    raise MissingProgramError.of_library("stable-baselines3", "sb3", error) from error


class _TaskReplay:
    """What both replay buffers have in common; goes before one of Stable-Baselines3 in a class."""

    def __init__(
        self, *arguments: Any, joint: JointObservations, counterfactual: bool = False, **keywords: Any
    ) -> None:
        super().__init__(*arguments, **keywords)
        if keywords.get("optimize_memory_usage"):
            raise InvalidArgumentError("optimize_memory_usage=True keeps no next observations, which are needed here")
        self.joint, self.counterfactual = joint, counterfactual
        shape: tuple[int, int] = (self.buffer_size, self.n_envs)  # type: ignore[attr-defined]
        self.letter_classes = np.zeros(shape, dtype=np.int32)
        self.ended = np.zeros(shape, dtype=np.bool_)
        self.base_rewards = np.zeros(shape, dtype=np.float32)

    def add(self, obs: Any, next_obs: Any, action: Any, reward: Any, done: Any, infos: list[dict[str, Any]]) -> None:
        """Keep a step of each environment, with what its info says of the automaton."""
        at = self.pos  # type: ignore[attr-defined]
        ltl = [info["ltl"] for info in infos]
        self.letter_classes[at] = [entry["letter_class"] for entry in ltl]
        self.ended[at] = [entry["base_terminated"] for entry in ltl]
        paid = np.array([entry["reward"] for entry in ltl], dtype=np.float32)
        self.base_rewards[at] = np.asarray(reward, dtype=np.float32) - paid  # exactly 0 where there are none
        super().add(obs, next_obs, action, reward, done, infos)  # type: ignore[misc]

    def _sampled(self, indices: npt.NDArray[Any], env: Any) -> tuple[Any, ...]:
        """Observations, actions, next observations, ends, rewards and discounts of some steps, as tensors."""
        at = (indices, np.random.randint(0, high=self.n_envs, size=len(indices)))  # type: ignore[attr-defined]
        before, after = _taken(self.observations, at), _taken(self.next_observations, at)  # type: ignore[attr-defined]
        actions = self.actions[at]  # type: ignore[attr-defined]
        states, ended = self.joint.states(before), self.ended[at]
        if self.counterfactual:
            states = self.joint.drawn(states, actions, np.random)
            before = self.joint.moved(before, states)
        outcome = self.joint.step(states, actions, self.letter_classes[at], ended)
        after = self.joint.moved(after, outcome.next_state)
        rewards = (outcome.reward + self.base_rewards[at]).astype(np.float32)
        columns = ended.astype(np.float32), rewards, outcome.discount.astype(np.float32)
        done, reward, discount = (column.reshape(-1, 1) for column in columns)
        return (
            self._tensors(before, env),
            self.to_torch(actions),  # type: ignore[attr-defined]
            self._tensors(after, env),
            self.to_torch(done),  # type: ignore[attr-defined]
            self.to_torch(self._normalize_reward(reward, env)),  # type: ignore[attr-defined]
            self.to_torch(discount),  # type: ignore[attr-defined]
        )

    def _tensors(self, observations: Any, env: Any) -> Any:
        shown = self._normalize_obs(observations, env)  # type: ignore[attr-defined]
        if isinstance(shown, dict):
            return {key: self.to_torch(column) for key, column in shown.items()}  # type: ignore[attr-defined]
        return self.to_torch(shown)  # type: ignore[attr-defined]


class TaskReplayBuffer(_TaskReplay, ReplayBuffer):
    """A replay buffer of Stable-Baselines3 whose steps have the discounts of a task; `replay` says how it is used.

    Rewards, ends and discounts are those of the reward tables, in the mean over whether the task ends the episode.

    Args:
        joint: how observations hold the state of the automaton.
        counterfactual: whether each step is seen as it would have been in a state of the automaton that is drawn
            anew whenever the step is.
        arguments, keywords: of the replay buffer.

    References:
        R. Toro Icarte, T. Klassen, R. Valenzano, S. McIlraith, Reward machines: exploiting reward function structure
        in reinforcement learning, JAIR 73, 2022, DOI 10.1613/jair.1.12440 (counterfactual experiences).
    """

    def _get_samples(self, batch_inds: npt.NDArray[Any], env: Any = None) -> Any:
        return ReplayBufferSamples(*self._sampled(batch_inds, env))


class TaskDictReplayBuffer(_TaskReplay, DictReplayBuffer):
    """The same for observations that are dicts."""

    def _get_samples(self, batch_inds: npt.NDArray[Any], env: Any = None) -> Any:
        return DictReplayBufferSamples(*self._sampled(batch_inds, env))


def replay(env: Any, *, counterfactual: bool = False) -> dict[str, Any]:
    """Arguments with which an agent with a replay buffer honours the discount of each step of a task.

    Args:
        env: the environment, or one of those that are stepped together; the warning of its `LTLWrapper` about
            discounts is switched off.
        counterfactual: whether each step teaches all states of the automaton.

    Returns:
        `replay_buffer_class` and `replay_buffer_kwargs`, for the constructor of the agent.

    Warns:
        RewardWarning: the task leaves the choice of a Rabin pair to the policy, and agents with a replay buffer do not
            know which choices there are.

    Raises:
        InvalidArgumentError: the environment is not wrapped in an `LTLWrapper`, or does not show the automaton's state.
    """
    joint = JointObservations.of(env)
    wrapper = env
    while not isinstance(wrapper, LTLWrapper):
        wrapper = wrapper.env
    wrapper.warn_discount = False
    if joint.tables.n_choices:
        warnings.warn(
            RewardWarning(
                "the task has a choice between Rabin pairs, which is part of the actions, and agents with a replay "
                'buffer take actions that do not exist; take the rewards "parity", or MaskablePPO'
            ),
            stacklevel=2,
        )
    kind = TaskDictReplayBuffer if isinstance(env.observation_space, spaces.Dict) else TaskReplayBuffer
    return {
        "replay_buffer_class": kind,
        "replay_buffer_kwargs": {"joint": joint, "counterfactual": counterfactual},
    }


def load_model(path: str | os.PathLike[str]) -> Any:
    """A model that an agent of Stable-Baselines3 or sb3-contrib has saved, ready to be judged.

    Its file is unpickled, which can run any code: load only files that you trust.

    Raises:
        FileFormatError: it is no such file, or its algorithm cannot be told.
        MissingProgramError: it is a model of sb3-contrib, which is not installed.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            fields = json.loads(archive.read("data"))
    except (zipfile.BadZipFile, KeyError, ValueError) as error:
        raise FileFormatError(f"{path} is not a model of Stable-Baselines3: {error}") from error
    return _algorithm(fields, path).load(path, device="cpu")


def _algorithm(fields: dict[str, Any], path: str | os.PathLike[str]) -> Any:
    """The class that saved a model: nothing in the file names it, but each has fields that the others have not."""
    maskable = "sb3_contrib.common.maskable" in str(fields.get("policy_class", {}))
    recurrent = "sb3_contrib.common.recurrent" in str(fields.get("policy_class", {}))
    if maskable or recurrent or "n_quantiles" in str(fields.get("policy_class", {})):
        try:
            import sb3_contrib
        except ImportError as error:
            raise MissingProgramError.of_library("sb3-contrib", "sb3", error) from error
        return sb3_contrib.MaskablePPO if maskable else sb3_contrib.RecurrentPPO if recurrent else sb3_contrib.QRDQN
    for name, field in (("PPO", "clip_range"), ("SAC", "target_entropy"), ("TD3", "policy_delay"),
                        ("DQN", "exploration_fraction"), ("A2C", "gae_lambda")):  # fmt: skip
        if field in fields:
            return getattr(stable_baselines3, name)
    raise FileFormatError(f"{path} does not say which algorithm of Stable-Baselines3 saved it; load it in Python")


def _taken(arrays: Any, at: tuple[npt.NDArray[Any], ...]) -> Any:
    """Rows of an array, or of each array in a dict; copies."""
    if isinstance(arrays, dict):
        return {key: column[at] for key, column in arrays.items()}
    return arrays[at]
