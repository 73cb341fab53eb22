"""An episode of what was learned, step by step."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete
from gymnasium.vector import VectorWrapper

from ltlc.agents.agent import Agent
from ltlc.agents.training.collect import Collector, Interface
from ltlc.agents.training.run_folder import RunFolder
from ltlc.board import Board

MOST_STEPS = 300
"""steps of an episode that are shown."""


class _Overheard(VectorWrapper[Any, Any, Any]):
    """Keeps what the environment said last."""

    said: Any = None

    def reset(self, **options: Any) -> Any:
        observations, infos = self.env.reset(**options)
        self.said = observations, None, None, None, infos
        return observations, infos

    def step(self, actions: Any) -> Any:
        self.said = self.env.step(actions)
        return self.said


def episode_of(run: RunFolder, agent: Agent, board: Board | None, seed: int = 0) -> list[dict[str, Any]]:
    """The first letter and the steps of one episode, as JSON values.

    Args:
        run: the run.
        agent: what it has learned.
        board: the map, whose cells observations number; None: there is none.
        seed: of the environment and of what the policy draws.

    Returns:
        For each letter its `names`, the automaton state `q` and the table state `t` after it; from the second on the
        `action` before, `reward`, and whether the step was `accepting` or `violated`; the `cell` on the map, or `seen`,
        the observation as text; in the last one how the episode has `ended`.
    """
    task = run.learned_task
    with closing(run.config.env_spec.vector(task, 1)) as envs:
        heard = _Overheard(envs)
        interface = Interface.of(heard)
        collector = Collector(interface, agent.encoder)
        collector.reset(seed)
        agent.reseed(seed)
        numbered = isinstance(interface.space, Discrete) and board is not None
        names = board.actions if board is not None else ()

        def letter() -> dict[str, Any]:
            observations, *_, infos = heard.said
            shown = interface.base(observations)
            place = {"cell": int(shown[0])} if numbered else {"seen": _text(shown)}
            state = int(infos["ltl"]["state"][0])
            return {"names": sorted(infos["ltl"]["label_names"][0]), "t": state,
                    "q": int(task.tables.automaton_state[state]), **place}  # fmt: skip

        steps = [letter()]
        for _ in range(MOST_STEPS):
            action = collector.follow(agent).action
            _, rewards, terminated, truncated, infos = heard.said
            number = int(action[0]) % interface.n_actions
            steps.append({
                **letter(),
                "action": names[number] if number < len(names) else str(number),
                "reward": float(rewards[0]),
                "accepting": bool(infos["ltl"]["accepting"][0]),
                "violated": bool(infos["ltl"]["violated"][0]),
            })  # fmt: skip
            if terminated[0] or truncated[0]:
                steps[-1]["ended"] = "terminated" if terminated[0] else "cut"
                break
        return steps


def _text(observations: Any) -> str:
    """The first of a batch of observations, in one line."""
    if isinstance(observations, dict):
        return ", ".join(f"{key}: {_text(column)}" for key, column in observations.items())
    if isinstance(observations, tuple):
        return str(observations[0])
    own = np.asarray(observations)[0]
    text = np.array2string(own, precision=3, suppress_small=True, threshold=12, edgeitems=2, separator=", ")
    text = " ".join(text.split())
    return text if len(text) <= 160 else f"{text[:159]}…"
