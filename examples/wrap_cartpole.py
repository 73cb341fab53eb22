"""CartPole with a task of its own: swing between two places for ever and never fall.

The propositions are predicates on the observation; a hand-written controller reads the automaton's state to know where
to go next. Run with `python examples/wrap_cartpole.py`; takes a second.
"""

from __future__ import annotations

import gymnasium as gym
import numpy as np

from ltlc.envs import LTLWrapper
from ltlc.task import Task

LABELS = {
    "left": lambda observation: observation[0] < -0.5,
    "right": lambda observation: observation[0] > 0.5,
    "falling": lambda observation: abs(observation[2]) > 0.19,
}
GAINS = np.array([1.0, 1.7, 35.0, 10.0])
"""linear-quadratic feedback on position, speed, angle and angular speed."""


def main() -> None:
    task = Task("G(F left & F right) & G !falling", reward="eventual")
    cart = gym.make("CartPole-v1", max_episode_steps=3000)
    env = LTLWrapper(cart, task, LABELS, observation="dict", warn_discount=False)  # nothing is learned here
    print(f"task        {task.formula}: {task.automaton.n_states} automaton states")
    observation, info = env.reset(seed=0)
    target, visits, violations, total = 0.8, 0, 0, 0.0
    terminated = truncated = False
    while not (terminated or truncated):
        error = observation["observation"] - np.array([target, 0, 0, 0])
        observation, reward, terminated, truncated, info = env.step(int(GAINS @ error > 0))
        for side, opposite in (("left", 0.8), ("right", -0.8)):
            if side in info["ltl"]["label_names"]:
                target = opposite
        visits += info["ltl"]["accepting"]
        violations += info["ltl"]["violated"]
        total += reward
    print(f"rounds      {visits} acceptances in 3000 steps, {violations} violations")
    print(f"reward      {total:.0f}, {'ended by the task' if terminated else 'still going'}")


if __name__ == "__main__":
    main()
