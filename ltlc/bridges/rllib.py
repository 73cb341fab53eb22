"""RLlib, the new API stack: environments by name, the discount of each step for DQN, and P(sat) as a metric.

    env = register_task("lake-task", make)  # make() returns an environment in an LTLWrapper
    config = DQNConfig().environment(env).training(replay_buffer_config=replay(10_000))
    config = config.callbacks(judged(make, every=10))

RLlib pins a version of Gymnasium, so it is best installed in an environment of its own. PPO and other agents without a
replay buffer have one discount for all steps: take the rewards "zeta-reach" and gamma=1 there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ltlc.envs import LTLWrapper
from ltlc.envs.wrapper import warn_discount_varies
from ltlc.errors import InvalidArgumentError, MissingProgramError
from ltlc.judging import Judgement, judge

try:
    import torch
    from ray.rllib.core.columns import Columns
    from ray.rllib.env.utils.infinite_lookback_buffer import InfiniteLookbackBuffer
    from ray.rllib.utils.replay_buffers.episode_replay_buffer import EpisodeReplayBuffer
    from ray.tune.registry import register_env
except ImportError as error:
    raise MissingProgramError.of_library("ray[rllib]", "rllib", error) from error

METRIC = "satisfaction"
"""name of the metric, below `ltlc` in the results of an iteration."""


def register_task(name: str, make: Callable[[], Any]) -> str:
    """Make an environment with a task known to RLlib by a name.

    Args:
        name: of the environment.
        make: returns an environment in an `LTLWrapper`, with `observation="flat"` as default networks need, and
            `warn_discount=False` where the agent honours the discount of each step, see `replay`.

    Returns:
        The name.
    """
    register_env(name, lambda config: make())
    return name


def _wrapper(env: Any) -> LTLWrapper:
    """The wrapper with the task."""
    inner = env
    while not isinstance(inner, LTLWrapper):
        if getattr(inner, "env", inner) is inner:
            raise InvalidArgumentError(f"{env} is not wrapped in an LTLWrapper")
        inner = inner.env
    return inner


class TaskEpisodeReplayBuffer(EpisodeReplayBuffer):
    """An episode replay buffer of RLlib whose steps have the discounts of a task.

    DQN weighs what follows a step by gamma ** n_step, and n_step is set so that this is the discount of the step.
    """

    def sample(self, *arguments: Any, gamma: float = 0.99, **keywords: Any) -> Any:
        """Draw steps, with the infos that hold their discounts.

        Raises:
            InvalidArgumentError: gamma is 0 or 1, of which no power is anything else; or steps are drawn several at a
                time.
        """
        if not 0 < gamma < 1:
            raise InvalidArgumentError(f"gamma is {gamma}; take one between 0 and 1, such as 0.99")
        if keywords.get("n_step") not in (None, 1):
            raise InvalidArgumentError(
                f"n_step is {keywords['n_step']}; steps with discounts of their own need n_step=1"
            )
        episodes = super().sample(*arguments, **keywords | {"gamma": gamma, "include_infos": True})
        for episode in episodes:
            length = len(episode)
            discounts = [max(info["ltl"]["discount"], 1e-12) for info in episode.get_infos(slice(1, length + 1))]
            powers = np.log(np.array(discounts)) / math.log(gamma)
            episode.extra_model_outputs["n_step"] = InfiniteLookbackBuffer(powers.astype(np.float32), lookback=0)
        return episodes


def replay(capacity: int = 50_000) -> dict[str, Any]:
    """The `replay_buffer_config` of a DQN that honours the discount of each step.

    Args:
        capacity: steps that are kept.
    """
    return {"type": f"{__name__}.{TaskEpisodeReplayBuffer.__name__}", "capacity": capacity}


def warn_of_one_discount(config: Any, env: Any) -> None:
    """Warn where an agent has one discount for all steps, and the task one for each.

    Args:
        config: of the agent.
        env: in an `LTLWrapper`.

    Warns:
        RewardWarning: the agent has no replay buffer, or not that of `replay`.
    """
    buffer = getattr(config, "replay_buffer_config", None) or {}
    kind = buffer.get("type", "")
    if TaskEpisodeReplayBuffer.__name__ not in (str(kind).rpartition(".")[2], getattr(kind, "__name__", "")):
        warn_discount_varies(_wrapper(env).task)


def judged_module(module: Any, env: Any, **how: Any) -> Judgement:
    """Judge a module of RLlib, such as `algorithm.get_module()`, by its best actions.

    Args:
        module: of one agent, for flat observations and discrete actions.
        env: in an `LTLWrapper`, as it was for the training.
        how: further arguments of `ltlc.judge`.
    """
    _wrapper(env).warn_discount = False
    return judge(_Greedy(module, env.action_space), env, **how)


class _Greedy:
    """A module as a model with `predict`."""

    def __init__(self, module: Any, space: Any) -> None:
        self.module, self.space = module, space

    def predict(self, observations: Any, deterministic: bool = True) -> tuple[Any, None]:
        """The best action in each observation."""
        with torch.no_grad():
            found = self.module.forward_inference({Columns.OBS: torch.as_tensor(np.asarray(observations))})
        if Columns.ACTIONS in found:
            return found[Columns.ACTIONS].cpu().numpy(), None
        return found[Columns.ACTION_DIST_INPUTS].argmax(dim=-1).cpu().numpy(), None


def judged(make: Callable[[], Any], every: int = 1, **how: Any) -> Any:
    """A callback class that reports the satisfaction probability in the results of every so many iterations.

    Args:
        make: as of `register_task`.
        every: iterations from one judgement to the next.
        how: further arguments of `ltlc.judge`.

    Returns:
        The class, for `config.callbacks`; it calls `warn_of_one_discount`, too. Results have
        `result["ltlc"]["satisfaction"]`, and its bounds.
    """
    from ray.rllib.callbacks.callbacks import RLlibCallback

    class Judged(RLlibCallback):
        """Judges the module after an iteration, and warns where the agent does not honour the task's discounts."""

        def on_algorithm_init(self, *, algorithm: Any, **_: Any) -> None:
            """Look at how the agent discounts."""
            warn_of_one_discount(algorithm.config, make())

        def on_train_result(self, *, algorithm: Any, result: dict[str, Any], **_: Any) -> None:
            """Judge, where it is time."""
            if algorithm.training_iteration % every == 0:
                found = judged_module(algorithm.get_module(), make(), **how)
                result["ltlc"] = {METRIC: found.satisfaction, "low": found.bounds[0], "high": found.bounds[1]}

    return Judged
