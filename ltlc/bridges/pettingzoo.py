"""PettingZoo: a task for each agent, or one task for all of them, in parallel and in turn-based environments.

    env = LTLParallelWrapper(simple_spread_v3.parallel_env(), {"agent_0": "F a", "agent_1": "G !b"}, labels)
    env = LTLParallelWrapper(simple_spread_v3.parallel_env(), "F(a & F b)", labels)

With a task for each agent, its automaton reads the label of what that agent observes: after every step in a parallel
environment, and at each turn of the agent in a turn-based one. With one task for all, there is one word, whose letters
are labels of the dict of all observations; it has a letter for each step of the environment, and every agent sees the
state of the automaton and is paid.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from ltlc.automata.finite import spoken
from ltlc.envs import LTLWrapper
from ltlc.envs.labeller import Labeller, labeller_for
from ltlc.envs.observation import ObservationMode, observer
from ltlc.errors import InvalidArgumentError, MissingProgramError, UnknownNameError
from ltlc.task import Task

try:
    from pettingzoo.utils.wrappers import BaseParallelWrapper, BaseWrapper
except ImportError as error:
    raise MissingProgramError.of_library("pettingzoo", "pettingzoo", error) from error

Result = tuple[Any, float, bool, bool, dict[str, Any]]


class _Relay(gym.Env[Any, Any]):
    """What one agent sees of an environment, as an environment: it returns what it is told to return."""

    def __init__(
        self, observations: spaces.Space[Any], actions: spaces.Space[Any], propositions: tuple[str, ...] | None
    ) -> None:
        self.observation_space, self.action_space = observations, actions
        if propositions is not None:
            self.propositions = propositions
        self.told: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        observation, info = self.told
        return observation, dict(info)

    def step(self, action: Any) -> Result:
        observation, reward, terminated, truncated, info = self.told
        return observation, reward, terminated, truncated, dict(info)


class _Seats:
    """The automata of all agents.

    Args:
        env: of PettingZoo.
        task: for each agent by name, agents without one being left as they are; or one for all.
        labels: see `LTLWrapper`; for each agent by name, or the same for all. With one task for all, of the dict of all
            observations.
        keywords: of an `LTLWrapper`.

    Attributes:
        shared: whether there is one task for all.
        seats: the wrapper of each agent; with one task for all, that of the first stands for all.
    """

    def __init__(self, env: Any, task: Any, labels: Any, keywords: dict[str, Any]) -> None:
        agents = list(env.possible_agents)
        self.shared = not isinstance(task, Mapping)
        self.joint: Labeller | None = None
        tasks = dict.fromkeys(agents, _task(task)) if self.shared else {name: _task(one) for name, one in task.items()}
        for name in tasks:
            if name not in agents:
                raise UnknownNameError("agent", name, agents)
        propositions = None
        if self.shared and agents:
            one = tasks[agents[0]]
            if one.tables.n_choices:
                raise InvalidArgumentError(
                    "the task has a choice between Rabin pairs, and agents may choose differently; take the rewards "
                    '"parity", or a task for each agent'
                )
            propositions = spoken(one.tables.aps)
            self.joint, labels = labeller_for(labels, propositions, env, keywords.get("extra_labels", "error")), None
        own = isinstance(labels, Mapping) and bool(labels) and set(labels) <= set(agents)
        self.seats: dict[Any, LTLWrapper] = {}
        for name, one in tasks.items():
            relay = _Relay(env.observation_space(name), env.action_space(name), propositions)
            self.seats[name] = LTLWrapper(relay, one, labels.get(name) if own else labels, **keywords)
        self._seeded = False

    def begin(self, agent: Any, observation: Any, info: dict[str, Any], seed: int | None) -> tuple[Any, dict[str, Any]]:
        """The first letter of an agent."""
        seat = self.seats[agent]
        seat.env.told = observation, info  # type: ignore[attr-defined]
        return seat.reset(seed=seed)

    def seeds(self, seed: int | None) -> dict[Any, int | None]:
        """Of the draws by which tasks end episodes: equal for one task, and new ones only where they are asked for."""
        if seed is None and self._seeded:
            return dict.fromkeys(self.seats)
        self._seeded = True
        first = int(np.random.SeedSequence(seed).generate_state(1)[0])
        return {agent: first + (0 if self.shared else i) for i, agent in enumerate(self.seats)}

    def base_action(self, agent: Any, action: Any) -> Any:
        """What the environment is to do."""
        seat = self.seats.get(agent)
        if seat is None or not seat.choices.active:
            return action
        return seat.choices.split(action, seat._state)[0]

    def after(self, agent: Any, action: Any, told: Result) -> Result:
        """What an agent is told of a step."""
        seat = self.seats.get(agent)
        if seat is None:
            return told
        seat.env.told = told  # type: ignore[attr-defined]
        return seat.step(action)

    def labelled(self, observations: Mapping[Any, Any], infos: Mapping[Any, Any]) -> dict[Any, dict[str, Any]]:
        """The infos, with the common letter where there is one task for all."""
        if self.joint is None:
            return {agent: dict(info) for agent, info in infos.items()}
        letter = self.joint.letter(observations, infos)
        return {agent: {**info, "labels": letter} for agent, info in infos.items()}


class LTLParallelWrapper(BaseParallelWrapper):
    """Runs the automata of tasks beside a parallel environment, and pays the rewards of the tasks.

    Each agent sees what an `LTLWrapper` would show it; `infos[agent]["ltl"]` are its infos. Where a task ends the
    episode of one agent, that agent has terminated and the others are truncated, because the environment goes on with
    all of them or none.

    Args:
        env: a parallel environment.
        task: a task, formula or automaton for each agent by name (agents without one are left as they are); or one for
            all of them.
        labels: see `LTLWrapper`; of what an agent observes, for each agent by name or the same for all; with one task
            for all, of the dict of all observations.
        observation: see `LTLWrapper`.
        keywords: further ones of an `LTLWrapper`.

    Raises:
        UnknownNameError: there is no such agent, or a label and the formula do not go together.
        InvalidArgumentError: one task for all leaves the choice of a Rabin pair to the policy.
    """

    def __init__(
        self, env: Any, task: Any, labels: Any = None, *, observation: ObservationMode = "dict", **keywords: Any
    ) -> None:
        super().__init__(env)
        self.ltl = _Seats(env, task, labels, {"observation": observation, **keywords})
        self._over = False

    @property
    def agents(self) -> list[Any]:
        """The agents whose episodes go on."""
        return [] if self._over else list(self.env.agents)

    def observation_space(self, agent: Any) -> Any:
        """What an agent sees."""
        return _space(self.ltl.seats.get(agent), self.env, agent, "observation_space")

    def action_space(self, agent: Any) -> Any:
        """What an agent does."""
        return _space(self.ltl.seats.get(agent), self.env, agent, "action_space")

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, Any]:
        """Begin an episode; the automata read the labels of the first observations."""
        self._over = False
        observations, infos = self.env.reset(seed=seed, options=options)
        infos, seeds = self.ltl.labelled(observations, infos), self.ltl.seeds(seed)
        for agent in self.ltl.seats:
            if agent in observations:
                begun = self.ltl.begin(agent, observations[agent], infos.get(agent, {}), seeds[agent])
                observations[agent], infos[agent] = begun
        return observations, infos

    def step(self, actions: dict[Any, Any]) -> tuple[Any, Any, Any, Any, Any]:
        """Step the environment, then the automata."""
        base = {agent: self.ltl.base_action(agent, action) for agent, action in actions.items()}
        observations, rewards, terminated, truncated, infos = self.env.step(base)
        infos = self.ltl.labelled(observations, infos)
        ended = False
        for agent in list(observations):
            told = observations[agent], rewards[agent], terminated[agent], truncated[agent], infos.get(agent, {})
            found = self.ltl.after(agent, actions[agent], told)
            ended |= found[2] and not terminated[agent]
            observations[agent], rewards[agent], terminated[agent], truncated[agent], infos[agent] = found
        if ended:
            self._over = True
            truncated = {agent: bool(cut or not terminated[agent]) for agent, cut in truncated.items()}
        return observations, rewards, terminated, truncated, infos


class LTLAECWrapper(BaseWrapper):
    """The same for turn-based environments.

    With a task for each agent, its automaton reads a letter at each of its turns; with one for all, it reads one after
    each step, and what is paid between two turns of an agent is weighed by the discounts of the steps since its action:
    `infos[agent]["ltl"]` holds their product as `discount`.

    Args: as those of `LTLParallelWrapper`.
    """

    def __init__(
        self, env: Any, task: Any, labels: Any = None, *, observation: ObservationMode = "dict", **keywords: Any
    ) -> None:
        super().__init__(env)
        self.ltl = _Seats(env, task, labels, {"observation": observation, **keywords})
        self._shown = {
            agent: observer(observation, env.observation_space(agent), seat.task.tables.n_states)
            for agent, seat in self.ltl.seats.items()
        }

    def observation_space(self, agent: Any) -> Any:
        """What an agent sees."""
        return _space(self.ltl.seats.get(agent), self.env, agent, "observation_space")

    def action_space(self, agent: Any) -> Any:
        """What an agent does."""
        return _space(self.ltl.seats.get(agent), self.env, agent, "action_space")

    def observe(self, agent: Any) -> Any:
        """What an agent sees now; the state of its automaton is that of its last letter."""
        seen = self.env.observe(agent)
        seat = self.ltl.seats.get(agent)
        return seen if seat is None else self._shown[agent].single(seen, seat._state)

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode."""
        super().reset(seed=seed, options=options)
        self._ended: Any = None  # who ended the episode by its task
        self._begun: set[Any] = set()
        self._owed: dict[Any, Any] = {}  # actions of agents whose automata have not yet read what followed
        self._seeds = self.ltl.seeds(seed)
        self.agents = list(self.env.agents)
        self._ltl_infos: dict[Any, Any] = {}
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self._weight = dict.fromkeys(self.agents, 1.0)
        if self.ltl.shared:
            infos = self._joint_infos()
            for agent in self.agents:
                self._begin(agent, infos[agent])
        self._mirror({})
        self._arrive()

    def step(self, action: Any) -> None:
        """Step the environment for the agent whose turn it is, then the automata."""
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            self._bury(agent, action)
            return
        self._cumulative_rewards[agent], self._weight[agent] = 0.0, 1.0
        self.env.step(self.ltl.base_action(agent, action))
        paid: dict[Any, float] = {}
        if self.ltl.shared:
            infos = self._joint_infos()
            for other in [name for name in self.agents if name in self.env.agents]:
                paid[other] = self._read(other, action, infos[other])
        else:
            self._owed[agent] = action
        self._mirror(paid)
        self._arrive()

    def _joint_infos(self) -> dict[Any, dict[str, Any]]:
        present = {agent: self.env.observe(agent) for agent in self.env.agents}
        return self.ltl.labelled(present, {agent: self.env.infos[agent] for agent in self.env.agents})

    def _begin(self, agent: Any, info: dict[str, Any]) -> None:
        self._begun.add(agent)
        if agent in self.ltl.seats:
            _, found = self.ltl.begin(agent, self.env.observe(agent), info, self._seeds[agent])
            self._ltl_infos[agent] = found

    def _read(self, agent: Any, action: Any, info: dict[str, Any]) -> float:
        """Let the automaton of an agent read what it observes; what that pays."""
        env = self.env
        dead = bool(env.terminations[agent]), bool(env.truncations[agent])
        told = env.observe(agent), float(env._cumulative_rewards[agent]), *dead, info
        _, reward, terminated, _, found = self.ltl.after(agent, action, told)
        if terminated and not dead[0] and self._ended is None:
            self._ended = agent
        if agent in self.ltl.seats:
            ltl = found["ltl"]
            reward *= self._weight[agent]
            self._cumulative_rewards[agent] += reward
            self._weight[agent] *= ltl["discount"]
            found["ltl"] = {**ltl, "discount": self._weight[agent]}
            self._ltl_infos[agent] = found
        else:
            self._cumulative_rewards[agent] = reward
        return float(reward)

    def _arrive(self) -> None:
        """Let the automaton of the agent whose turn it is read, if it has a task of its own."""
        agent = self.agent_selection
        if self.ltl.shared or not self.agents:
            return
        if agent not in self._begun:
            self._begin(agent, dict(self.env.infos[agent]))
            self._mirror({})
        elif agent in self._owed:
            self._mirror({agent: self._read(agent, self._owed.pop(agent), dict(self.env.infos[agent]))})

    def _mirror(self, paid: Mapping[Any, float]) -> None:
        """Say of all agents what the environment says, and what the automata add to it."""
        env = self.env
        if self._ended is None:
            self.agents, self.agent_selection = list(env.agents), env.agent_selection
        self.rewards = {agent: paid.get(agent, 0.0) for agent in self.agents}
        self.infos = {agent: self._ltl_infos.get(agent, env.infos.get(agent, {})) for agent in self.agents}
        self.terminations = {agent: bool(env.terminations.get(agent, False)) for agent in self.agents}
        self.truncations = {agent: bool(env.truncations.get(agent, False)) for agent in self.agents}
        if self._ended is not None:
            for agent in self.agents:
                own = self.ltl.shared or agent == self._ended
                self.terminations[agent] |= own
                self.truncations[agent] |= not self.terminations[agent]

    def _bury(self, agent: Any, action: Any) -> None:
        if self._ended is None:
            self.env.step(action)
            self._mirror({})
            self._arrive()
            return
        if action is not None:
            raise InvalidArgumentError(f"the episode of {agent} is over; its last action is None")
        self.agents = [name for name in self.agents if name != agent]
        if self.agents:
            self.agent_selection = self.agents[0]
        self._mirror({})


def _task(task: Any) -> Task:
    return task if isinstance(task, Task) else Task(task)


def _space(seat: LTLWrapper | None, env: Any, agent: Any, name: str) -> Any:
    return getattr(env, name)(agent) if seat is None else getattr(seat, name)
