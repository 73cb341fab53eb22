"""What stable-baselines3's DQN learns with one discount for all steps, with that of each step, and with both replays.

    python benchmarks/bridges.py                       # three tasks, five seeds
    python benchmarks/bridges.py detour --seeds 2 --steps 2000 --json bridges.json

All three have the same network, the same rewards (two-discount, gamma_accept 0.5, gamma 0.99) and as many steps; what
they learn is judged exactly. One discount for all steps is that of stable-baselines3, 0.99.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.wrappers import TimeLimit
from suite_tasks import load_suite

import ltlc
from ltlc.bridges.stable_baselines3 import replay
from ltlc.mdp import LabelledMDP
from ltlc.rewards import get_scheme

STEPS, EPISODE_STEPS = 3000, 50
WAYS: dict[str, dict[str, bool] | None] = {
    "one discount": None,
    "of each step": {"counterfactual": False},
    "counterfactual": {"counterfactual": True},
}


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


def learned(mdp: LabelledMDP, formula: str, way: dict[str, bool] | None, seed: int, steps: int) -> float:
    """The exact satisfaction probability of what DQN has learned."""
    from stable_baselines3 import DQN

    task = ltlc.Task(formula, get_scheme("two-discount", gamma_accept=0.5, gamma=0.99))
    env = TimeLimit(ltlc.LTLWrapper(Model(mdp), task, observation="flat", warn_discount=False), EPISODE_STEPS)
    more = {} if way is None else replay(env, **way)
    model = DQN(
        "MlpPolicy", env, learning_rate=1e-3, learning_starts=200, train_freq=1, target_update_interval=50,
        exploration_fraction=0.8, exploration_final_eps=0.1, policy_kwargs={"net_arch": [64]}, seed=seed, device="cpu",
        **more,
    )  # fmt: skip
    return ltlc.judge(model.learn(steps), env, exact=True).satisfaction


def main() -> None:
    known = tasks()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", choices=[*known, []], default=list(known))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    torch.set_num_threads(1)
    found: dict[str, dict[str, list[float]]] = {}
    for name in given.tasks:
        for label, way in WAYS.items():
            values = [learned(*known[name], way, seed, given.steps) for seed in range(given.seeds)]
            found.setdefault(name, {})[label] = values
            shown = " ".join(f"{value:.3f}" for value in values)
            print(f"{name:12} {label:15} mean {np.mean(values):.3f}   {shown}", flush=True)
    if given.json is not None:
        given.json.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
