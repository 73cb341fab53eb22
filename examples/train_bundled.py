"""Train the bundled agent on a task in temporal logic, and judge what it has learned: exactly, and by watching it.

    python examples/train_bundled.py

The robot slips with probability 0.2. It has to visit A and then B, and must not enter C before.
"""

from __future__ import annotations

import ltlc
from ltlc.agents import FittedQConfig, Progress, greedy_policy, rollout, train
from ltlc.envs import GridWorld, LTLVectorWrapper, VectorGridWorld, labelled_mdp

MAP = """
S....
.CC..
.....
..C..
A...B
"""
TASK = ltlc.Task("!C U (A & (!C U B))")
ARROWS = "↑→↓←·"


def show(progress: Progress) -> None:
    row = progress.row
    print(f"{row.steps:7} steps   return {row.episode_return:8.1f}   violations {row.violations:.2f} per episode")


def main() -> None:
    env = LTLVectorWrapper(VectorGridWorld(MAP, num_envs=32, slip=0.2, max_episode_steps=100), TASK)
    config = FittedQConfig(total_steps=40_000, epsilon_steps=10_000, log_every=10_000, seed=0)
    result = train(env, config, callback=show)

    print(f"\n{result}. The greedy policy, by state of the automaton:")
    world = GridWorld(MAP, slip=0.2)
    policy = greedy_policy(result.agent)
    for state in result.agent.tensor_tables.learned.tolist():
        rows = policy[:, state].reshape(world.layout.rows, world.layout.columns)
        print(f"\nq{state}\n" + "\n".join(" ".join(ARROWS[action] for action in row) for row in rows))

    judge = ltlc.Judge(labelled_mdp(world), TASK)
    verdict = judge.judge(policy)
    print(f"\nexactly:  return {verdict.discounted_return:.4g}, optimum {judge.value:.4g}, ", end="")
    print(f"regret {judge.regret(policy):.2%}; violations per episode {verdict.violations_per_episode:.3f}")
    seen = rollout(result.agent, env, n_episodes=500, seed=1)
    print(f"watched:  violations per episode {seen.violations_per_episode}; satisfied {seen.satisfied}")


if __name__ == "__main__":
    main()
