"""Deep Q-learning in a single file, in the manner of CleanRL; only the two marked lines know of the task."""

import sys

import numpy as np
import torch
from torch import nn

import ltlc
from ltlc.envs import GridWorld, VectorGridWorld

MAP, LABELS = ("S..k", ".##.", "..x.", "...g"), {"k": "key", "g": "goal", "x": "pit"}
TASK = "!pit U (key & (!pit U goal))"  # or an automaton
N_ENVS, SIZE, BATCH = 8, 20_000, 64


def main(total=12_000, task=TASK):
    torch.manual_seed(0)
    torch.set_num_threads(1)
    random = np.random.default_rng(0)
    task = ltlc.Task(task).for_horizon(50)
    world = VectorGridWorld(MAP, N_ENVS, labels=LABELS, slip=0.1, actions=4, max_episode_steps=50)
    envs = ltlc.LTLVectorWrapper(world, task, observation="flat", warn_discount=False)  # 1: the task around the world
    width, n_actions = envs.single_observation_space.shape[0], int(envs.single_action_space.n)

    def network():
        return nn.Sequential(nn.Linear(width, 64), nn.ReLU(), nn.Linear(64, n_actions))

    q, target = network(), network()
    target.load_state_dict(q.state_dict())
    optimizer = torch.optim.Adam(q.parameters(), lr=1e-3)
    before, after = (np.zeros((SIZE, width), dtype=np.float32) for _ in range(2))
    actions, rewards, follows = np.zeros(SIZE, np.int64), np.zeros(SIZE, np.float32), np.zeros(SIZE, np.float32)
    seen, _ = envs.reset(seed=0)
    kept = 0
    for step in range(total // N_ENVS):
        epsilon = max(0.05, 1 - step / (0.7 * total / N_ENVS))
        with torch.no_grad():
            acts = q(torch.from_numpy(seen)).argmax(1).numpy()
        acts = np.where(random.random(N_ENVS) < epsilon, random.integers(n_actions, size=N_ENVS), acts)
        now, reward, terminated, _, infos = envs.step(acts)
        real = np.flatnonzero(infos["ltl"]["valid"])  # others have only begun a new episode
        at = (kept + np.arange(len(real))) % SIZE
        before[at], after[at], actions[at], rewards[at] = seen[real], now[real], acts[real], reward[real]
        follows[at] = np.where(terminated, 0, infos["ltl"]["discount"])[real]  # 2: instead of a constant gamma
        kept, seen = kept + len(real), now
        for _ in range(N_ENVS if kept > 500 else 0):
            rows = random.integers(min(kept, SIZE), size=BATCH)
            with torch.no_grad():
                best = target(torch.from_numpy(after[rows])).max(1).values
            value = q(torch.from_numpy(before[rows])).gather(1, torch.from_numpy(actions[rows])[:, None])[:, 0]
            goal = torch.from_numpy(rewards[rows]) + torch.from_numpy(follows[rows]) * best
            loss = nn.functional.smooth_l1_loss(value, goal)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
        if step % 25 == 0:
            target.load_state_dict(q.state_dict())
    found = ltlc.judge(q, GridWorld(MAP, labels=LABELS, slip=0.1, actions=4), task)
    print(found)
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
