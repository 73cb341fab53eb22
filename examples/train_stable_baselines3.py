"""Train stable-baselines3's DQN on a wrapped grid world, and judge the policy exactly.

Needs stable-baselines3 (`pip install stable-baselines3`). Its agents know one discount for all steps, so this takes a
scheme whose discount is constant. Run with `python examples/train_stable_baselines3.py [--steps N]`.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

from ltlc.envs import GridWorld, LTLWrapper, labelled_mdp
from ltlc.mdp import RewardProduct, expected_return, expected_violations, optimal_return
from ltlc.task import Task

STEPS = 10_000
MAP = ("S..k", ".##.", "..x.", "...g")
LABELS = {"k": "key", "g": "goal", "x": "pit"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=STEPS, help="environment steps to train for")
    steps = parser.parse_args().steps
    try:
        from gymnasium.wrappers import TimeLimit
        from stable_baselines3 import DQN
    except ImportError:
        sys.exit("this example needs stable-baselines3: pip install stable-baselines3")

    task = Task("F(key & F goal) & G !pit", reward="thesis", shaping=10.0)
    world = GridWorld(MAP, labels=LABELS, slip=0.1, actions=4)
    env = LTLWrapper(world, task, observation="flat")
    gamma = task.discount
    assert gamma is not None, "stable-baselines3 knows one discount for all steps; take a scheme that does too"
    print(f"task        {task.formula}, thesis rewards, shaped by distance to acceptance")
    model = DQN(
        "MlpPolicy",
        TimeLimit(env, 100),
        gamma=gamma,
        learning_rate=1e-3,
        train_freq=2,
        learning_starts=500,
        target_update_interval=200,
        exploration_fraction=0.7,
        policy_kwargs={"net_arch": [64]},
        seed=0,
        device="cpu",
    )
    model.learn(steps)

    tables = Task(task.automaton, reward="thesis").tables  # judged without the shaping
    product = RewardProduct(labelled_mdp(world), tables)
    pairs = zip(product.mdp_state.tolist(), product.machine_state.tolist(), strict=True)
    observations = np.stack([env.observer.single(cell, q) for cell, q in pairs])
    policy, _ = model.predict(observations, deterministic=True)
    best = optimal_return(product).policy
    for name, actions in (("learned", policy.astype(np.int64)), ("optimal", best)):
        value = expected_return(product, actions, discount=gamma)
        print(f"{name}     return {value:8.2f}, violations per episode {expected_violations(product, actions):.3f}")


if __name__ == "__main__":
    main()
