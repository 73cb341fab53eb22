"""Environments whose dynamics are known, as labelled Markov decision processes for the judge."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from ltlc.envs.grid_map import ACTIONS, GridMap
from ltlc.envs.labels import LabelSource, Source, described, names_of
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import LabelledMDP


def labelled_mdp(env: Any, labels: LabelSource = None) -> LabelledMDP:
    """The exact model of a grid world, or of an environment with a transition table `P`.

    Gymnasium's FrozenLake, Taxi and CliffWalking have such a table. Their terminal states become absorbing: the word
    of an episode goes on with the last label for ever. Limits on the length of episodes are left out.

    Args:
        env: the environment, wrapped or not; of an `LTLWrapper` the labels are taken.
        labels: for an environment with a table: a dict of predicates on the state, or a function of (state) or
            (state, info) (called with an empty info) whose labels are names, or the text `module:name` of either; grid
            worlds bring their own.

    Raises:
        InvalidArgumentError: the dynamics are not known, there are no labels, they look at more than the state, or one
            is of a wrong type.

    Example:
        >>> import gymnasium
        >>> lake = gymnasium.make("FrozenLake-v1")
        >>> labelled_mdp(lake, {"goal": lambda state: state == 15}).n_states
        16
    """
    base = env.unwrapped
    if labels is None:
        labels = _labels_of_wrapper(env)
    layout = getattr(base, "layout", None)
    if isinstance(layout, GridMap):
        return _of_grid(layout)
    table = getattr(base, "P", None)
    if table is None:
        raise InvalidArgumentError(
            f"the dynamics of {type(base).__name__} are not known: it is no grid world and has no transition table P"
        )
    if labels is None:
        raise InvalidArgumentError(f"pass labels=...: the states of {type(base).__name__} carry none")
    n = len(table)
    source = Source(labels)
    if source.arity > 2:
        raise InvalidArgumentError(
            f"labels: {described(source.function)} asks for the environment, so what holds in a state is not known; "
            "the labels of a model are a function of the state"
        )
    named = [_names(source, state) for state in range(n)]
    aps = sorted({name for label in named for name in label})
    start = getattr(base, "initial_state_distrib", None)
    initial: dict[str, Any] = {}
    if start is not None:
        initial = {"initial_state": int(np.argmax(start)), "initial_distribution": np.asarray(start, dtype=np.float64)}
    holds = [[name for name, here in label.items() if here] for label in named]
    return LabelledMDP.from_table(table, aps=aps, labels=holds, **initial)


def _labels_of_wrapper(env: Any) -> LabelSource:
    while env is not getattr(env, "env", env):
        found: LabelSource = getattr(env, "labels", None) if hasattr(env, "labeller") else None
        if found is not None:
            return found
        env = env.env
    return None


def _names(source: Source, state: int) -> dict[str, bool]:
    arguments: tuple[Any, ...] = (state, {})[: source.arity]
    return {**dict.fromkeys(source.propositions or (), False), **names_of(source.function(*arguments))}


def _of_grid(layout: GridMap) -> LabelledMDP:
    n = layout.n_cells
    transitions = []
    for action in range(layout.n_actions):
        moves = [(cell, *move) for cell in range(n) for move in layout.move_probability(cell, action).items()]
        source, target, probability = (np.array(column) for column in zip(*moves, strict=True))
        transitions.append(sparse.csr_array((probability, (source, target)), shape=(n, n)))
    shown = [(cell, letter, p) for cell, label in enumerate(layout.cell_labels) for letter, p in label]
    cells, drawn, probability = (np.array(column) for column in zip(*shown, strict=True))
    letters, column = np.unique(drawn, return_inverse=True)
    return LabelledMDP(
        aps=layout.propositions,
        transitions=tuple(transitions),
        letters=letters,
        label_probability=sparse.csr_array((probability, (cells, column)), shape=(n, len(letters))),
        initial_state=layout.start,
        state_names=tuple(f"({row}, {column})" for row, column in layout.coordinates.tolist()),
        action_names=ACTIONS[: layout.n_actions],
    )
