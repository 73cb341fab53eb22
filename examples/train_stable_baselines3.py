"""Train stable-baselines3's DQN on a wrapped grid world, and judge the policy exactly.

Needs stable-baselines3 (`pip install stable-baselines3`). The replay buffer honours the discount of each step, and
shows each step in all states of the automaton. Run with `python examples/train_stable_baselines3.py [--steps N]`.
"""

from __future__ import annotations

import argparse
import sys

from gymnasium.wrappers import TimeLimit

import ltlc
from ltlc.envs import GridWorld
from ltlc.errors import MissingProgramError

STEPS = 10_000
MAP = ("S..k", ".##.", "..x.", "...g")
LABELS = {"k": "key", "g": "goal", "x": "pit"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=STEPS, help="environment steps to train for")
    steps = parser.parse_args().steps
    try:
        from ltlc.bridges.stable_baselines3 import replay
    except MissingProgramError as error:
        sys.exit(str(error))
    from stable_baselines3 import DQN

    task = ltlc.Task("!pit U (key & (!pit U goal))").for_horizon(50)  # discounts that a network can learn with
    world = GridWorld(MAP, labels=LABELS, slip=0.1, actions=4)
    env = TimeLimit(ltlc.LTLWrapper(world, task, observation="flat", success_key=True), 50)
    model = DQN(
        "MlpPolicy",
        env,
        learning_rate=1e-3,
        learning_starts=500,
        train_freq=1,
        target_update_interval=200,
        exploration_fraction=0.7,
        policy_kwargs={"net_arch": [64]},
        seed=0,
        device="cpu",
        **replay(env, counterfactual=True),
    )
    print(f"before: {ltlc.judge(model, env)}")
    model.learn(steps)
    print(f"after:  {ltlc.judge(model, env)}")


if __name__ == "__main__":
    main()
