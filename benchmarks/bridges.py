"""What DQN of Stable-Baselines3 or RLlib learns with one discount for all steps, and with that of each step.

    python benchmarks/bridges.py                       # Stable-Baselines3: three tasks, five seeds
    python benchmarks/bridges.py detour --seeds 2 --steps 2000 --json bridges.json
    .venv-rllib/bin/python benchmarks/bridges.py --host rllib  # the environment that make test-rllib makes

All ways of a host have the same network, rewards (two-discount, gamma_accept 0.5, gamma 0.99) and number of steps;
what they learn is judged exactly. One discount for all steps is that of both hosts, 0.99.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.wrappers import TimeLimit
from suite_tasks import load_suite

import ltlc
from ltlc.mdp import LabelledMDP
from ltlc.rewards import get_scheme

STEPS, EPISODE_STEPS = 3000, 50
WAYS = {"sb3": ("one discount", "of each step", "counterfactual"), "rllib": ("one discount", "of each step")}


class Model(gym.Env[Any, Any]):
    """A labelled process as an environment; observations are its states."""

    def __init__(self, mdp: LabelledMDP) -> None:
        self.mdp, self.propositions = mdp, mdp.aps
        self.observation_space, self.action_space = (
            gym.spaces.Discrete(mdp.n_states),
            gym.spaces.Discrete(mdp.n_actions),
        )
        self._rows = [matrix.toarray() for matrix in mdp.transitions]
        self._label = mdp.label_probability.toarray().argmax(axis=1)

    def labelled_mdp(self) -> LabelledMDP:
        """The process."""
        return self.mdp

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        """Begin in the initial state."""
        super().reset(seed=seed)
        self.state = self.mdp.initial_state
        return self.state, self._info()

    def step(self, action: Any) -> tuple[int, float, bool, bool, dict[str, Any]]:
        """Draw the next state."""
        self.state = int(self.np_random.choice(self.mdp.n_states, p=self._rows[int(action)][self.state]))
        return self.state, 0.0, False, False, self._info()

    def _info(self) -> dict[str, Any]:
        return {"labels": int(self.mdp.letters[self._label[self.state]])}


def detour() -> LabelledMDP:
    """A goal that is won for ever with probability .7, or visited for sure once in a round of six steps."""
    gamble, round_trip = np.zeros((9, 9)), np.zeros((9, 9))
    for state in range(1, 9):  # 1: won, 2: lost, 3 to 8: the round
        following = state if state < 3 else 3 + (state - 2) % 6
        gamble[state, following] = round_trip[state, following] = 1
    gamble[0, 1:3] = 0.7, 0.3
    round_trip[0, 3] = 1
    return LabelledMDP.from_arrays(np.stack([gamble, round_trip]), aps=["g"], labels={1: ["g"], 8: ["g"]})


def tasks() -> dict[str, tuple[LabelledMDP, str]]:
    """The processes by name, each with its formula."""
    suite = load_suite()
    return {
        "risk-reward": (suite["risk-reward"].model, suite["risk-reward"].formula),
        "devious": (suite["devious"].model, suite["devious"].formula),
        "detour": (detour(), "G F g"),
    }


def wrapped(mdp: LabelledMDP, formula: str) -> gym.Env[Any, Any]:
    task = ltlc.Task(formula, get_scheme("two-discount", gamma_accept=0.5, gamma=0.99))
    return TimeLimit(ltlc.LTLWrapper(Model(mdp), task, observation="flat", warn_discount=False), EPISODE_STEPS)


def learned_by_sb3(mdp: LabelledMDP, formula: str, way: str, seed: int, steps: int) -> float:
    """The exact satisfaction probability of what DQN of Stable-Baselines3 has learned."""
    from stable_baselines3 import DQN

    from ltlc.bridges.stable_baselines3 import replay

    env = wrapped(mdp, formula)
    more = {} if way == "one discount" else replay(env, counterfactual=way == "counterfactual")
    model = DQN(
        "MlpPolicy", env, learning_rate=1e-3, learning_starts=200, train_freq=1, target_update_interval=50,
        exploration_fraction=0.8, exploration_final_eps=0.1, policy_kwargs={"net_arch": [64]}, seed=seed, device="cpu",
        **more,
    )  # fmt: skip
    return ltlc.judge(model.learn(steps), env, exact=True).satisfaction


def learned_by_rllib(mdp: LabelledMDP, formula: str, way: str, seed: int, steps: int) -> float:
    """The exact satisfaction probability of what DQN of RLlib has learned; it updates every fourth step."""
    from ray.rllib.algorithms.dqn import DQNConfig

    from ltlc.bridges.rllib import judged_module, register_task, replay

    plain = {"type": "EpisodeReplayBuffer", "capacity": 20_000}
    config = (
        DQNConfig()
        .environment(register_task("task", lambda: wrapped(mdp, formula)))
        .env_runners(num_env_runners=0, rollout_fragment_length=4)
        .training(
            gamma=0.99, lr=1e-3, train_batch_size_per_learner=64, training_intensity=64, n_step=1, num_atoms=1,
            num_steps_sampled_before_learning_starts=200, target_network_update_freq=50, double_q=True, dueling=False,
            epsilon=[(0, 1.0), (int(0.8 * steps), 0.1)],
            replay_buffer_config=plain if way == "one discount" else replay(20_000),
        )
        .rl_module(model_config={"fcnet_hiddens": [64], "fcnet_activation": "relu", "head_fcnet_hiddens": []})
        .reporting(min_sample_timesteps_per_iteration=1000, min_time_s_per_iteration=0)
        .debugging(seed=seed, log_level="ERROR")
    )  # fmt: skip
    algorithm = config.build_algo()
    while int(algorithm.train()["num_env_steps_sampled_lifetime"]) < steps:
        pass
    found = judged_module(algorithm.get_module(), wrapped(mdp, formula), exact=True).satisfaction
    algorithm.stop()
    return found


HOSTS: dict[str, Callable[[LabelledMDP, str, str, int, int], float]] = {
    "sb3": learned_by_sb3,
    "rllib": learned_by_rllib,
}


def main() -> None:
    known = tasks()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", choices=[*known, []])
    parser.add_argument("--host", choices=list(HOSTS), default="sb3")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    torch.set_num_threads(1)
    found: dict[str, dict[str, list[float]]] = {}
    for name in given.tasks or known:
        for label in WAYS[given.host]:
            values = [HOSTS[given.host](*known[name], label, seed, given.steps) for seed in range(given.seeds)]
            found.setdefault(name, {})[label] = values
            shown = " ".join(f"{value:.3f}" for value in values)
            print(f"{name:12} {label:15} mean {np.mean(values):.3f}   {shown}", flush=True)
    if given.json is not None:
        given.json.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
