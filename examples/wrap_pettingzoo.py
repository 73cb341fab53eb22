"""Give two agents of PettingZoo (`pip install pettingzoo`) one task for both; each learns its part by Q-learning."""

import sys
from collections import defaultdict

import numpy as np
from gymnasium.spaces import Discrete, MultiDiscrete
from pettingzoo import ParallelEnv

from ltlc.bridges.pettingzoo import LTLParallelWrapper

PLACES, MOVES = MultiDiscrete([5, 5]), Discrete(3)


class Corridor(ParallelEnv):
    """Two walkers on five cells: one goes to the left end, then both meet in the middle, and none goes right."""

    metadata, render_mode, possible_agents = {"name": "corridor_v0", "render_modes": []}, None, ["walker_0", "walker_1"]
    observation_space, action_space = staticmethod(lambda agent: PLACES), staticmethod(lambda agent: MOVES)

    def reset(self, seed=None, options=None):
        self.agents, self.steps, self.places = list(self.possible_agents), 0, np.array([1, 3])
        return dict.fromkeys(self.agents, self.places), {agent: {} for agent in self.agents}

    def step(self, actions):
        self.places = np.clip(self.places + [actions[agent] - 1 for agent in self.agents], 0, 4)
        self.steps, now, over = self.steps + 1, self.agents, self.steps == 19
        self.agents = [] if over else now
        seen, paid, none, cut = (dict.fromkeys(now, value) for value in (self.places, 0.0, False, over))
        return seen, paid, none, cut, {agent: {} for agent in now}


def labels(observations):
    seen = tuple(observations["walker_0"].tolist())
    return {name for name, holds in (("key", 0 in seen), ("goal", seen == (2, 2)), ("pit", 4 in seen)) if holds}


def main(episodes=2000, task="!pit U (key & (!pit U goal))"):
    env = LTLParallelWrapper(Corridor(), task, labels, warn_discount=False)
    random, values, met = np.random.default_rng(0), defaultdict(lambda: np.ones(3)), 0
    row = lambda agent, seen: values[agent, *seen["observation"].tolist(), seen["automaton"]]  # noqa: E731
    for episode in range(episodes):
        seen, _ = env.reset(seed=episode)
        while env.agents:
            exploring = 0.2 if episode < episodes - 100 else 0.0
            actions = {agent: int(row(agent, seen[agent]).argmax()) for agent in env.agents}
            actions = {a: int(random.integers(3)) if random.random() < exploring else c for a, c in actions.items()}
            after, rewards, ended, _, infos = env.step(actions)
            for agent, reward in rewards.items():
                follows = 0.0 if ended[agent] else infos[agent]["ltl"]["discount"] * row(agent, after[agent]).max()
                value, action = row(agent, seen[agent]), actions[agent]
                value[action] += 0.2 * (reward + follows - value[action])
            seen = after
        met += not exploring and infos["walker_0"]["ltl"]["accepting"]
    print(f"the task was satisfied in {met} of the last 100 episodes")
    return met / 100


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
