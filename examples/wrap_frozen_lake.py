"""FrozenLake with a formula instead of a reward: wrap it, learn it with tabular Q-learning, judge the policy exactly.

Run with `python examples/wrap_frozen_lake.py`; takes some seconds.
"""

from __future__ import annotations

import gymnasium as gym
import numpy as np

from ltlc.envs import LTLWrapper, labelled_mdp
from ltlc.mdp import Product, max_satisfaction_probability, satisfaction_probability
from ltlc.task import Task

LABELS = {
    "goal": lambda state: state == 15,
    "hole": lambda state: state in (5, 7, 11, 12),
}


def learn(env: gym.Env, steps: int, seed: int) -> np.ndarray:
    """Tabular Q-learning on (cell, automaton state) numbers; the discount of each step comes with the step."""
    rng = np.random.default_rng(seed)
    q = np.zeros((env.observation_space.n, env.action_space.n))
    visits = np.zeros_like(q)
    state, _ = env.reset(seed=seed)
    for _ in range(steps):
        action = int(rng.integers(4)) if rng.random() < 0.5 else int(q[state].argmax())
        after, reward, terminated, truncated, info = env.step(action)
        visits[state, action] += 1
        target = reward + (0.0 if terminated else info["ltl"]["discount"] * q[after].max())
        q[state, action] += (target - q[state, action]) / visits[state, action] ** 0.65
        state = env.reset()[0] if terminated or truncated else after
    return q.argmax(axis=1)


def main() -> None:
    task = Task("F goal & G !hole")
    env = LTLWrapper(gym.make("FrozenLake-v1"), task, LABELS, observation="index", warn_discount=False)
    print(f"task        {task.formula}, rewards {task.scheme.name}: {task.scheme.guarantee}")
    policy = learn(env, steps=150_000, seed=1)
    product = Product(labelled_mdp(env), task.automaton)
    learned = satisfaction_probability(product, product.lift(policy.reshape(16, -1)))
    best = max_satisfaction_probability(product)
    print(f"learned     P(sat) = {learned.probability:.4f}")
    print(f"possible    Pmax   = {best.probability:.4f} (= 14/17)")
    for row in policy.reshape(16, -1)[:, task.automaton.initial_state].reshape(4, 4):
        print("            " + " ".join("←↓→↑"[action] for action in row))


if __name__ == "__main__":
    main()
