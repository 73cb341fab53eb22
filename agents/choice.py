"""Which agent fits an environment, where nobody names one."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from typing import Any, NamedTuple

from gymnasium.vector import VectorEnv

from .encoder import ObservationEncoder
from .fitted_q.agent import why_no_table
from .registry import AGENTS, DOUBLE_DQN, FITTED_Q
from .training.collect import Interface


class Choice(NamedTuple):
    """An agent that was chosen, and why.

    Attributes:
        agent: its name.
        reason: half a sentence.
    """

    agent: str
    reason: str

    def __str__(self) -> str:
        return f"{self.agent}, since {self.reason}"


def choose_agent(env: VectorEnv[Any, Any, Any], given: Collection[str] = ()) -> Choice:
    """Choose fitted Q iteration where observations can be numbered and the table fits, else double DQN.

    Args:
        env: the environment.
        given: names of hyperparameters that somebody asked for; where fitted Q iteration has no such, a network it is.

    Raises:
        InvalidArgumentError: no agent can take the environment.
    """
    theirs = {field.name for field in dataclasses.fields(AGENTS[FITTED_Q].defaults)}
    foreign = [name for name in given if name not in theirs]
    if foreign:
        return Choice(DOUBLE_DQN, f"{', '.join(foreign)} was given, which {FITTED_Q} does not have")
    interface = Interface.of(env)
    n_states = 1 if interface.tables is None else interface.tables.n_states
    encoder = ObservationEncoder(interface.space)
    note = f"; texts are left out: {', '.join(encoder.ignored)}" if encoder.ignored else ""
    obstacle = why_no_table(encoder, n_states, interface.n_actions)
    if obstacle:
        return Choice(DOUBLE_DQN, obstacle + note)
    return Choice(FITTED_Q, f"the {encoder.n_observations} observations can be numbered{note}")
