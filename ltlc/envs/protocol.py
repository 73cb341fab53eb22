"""What an environment may offer beyond Gymnasium's interface: an exact model, and maps to draw on.

An environment with the method `labelled_mdp` gets exact verdicts, one with `board` pictures of policies, and one with
`scene` pictures of trajectories, from `ltlc solve`, `train` and `evaluate` as from the library. Wrappers are looked
through: the methods belong to the environment itself (`env.unwrapped`).

An environment may also say which letters are possible in it, in an attribute `exclusive` (groups of propositions of
which at most one holds at a time) or `possible_letters` (all letters that occur): formulas that become tasks in it are
compiled over these letters alone; see `ltlc.envs.declared`.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from ltlc.board import Board
from ltlc.mdp import LabelledMDP
from ltlc.scene import Scene


@runtime_checkable
class ModelledEnv(Protocol):
    """An environment that knows its own dynamics.

    Example:
        >>> import gymnasium
        >>> class Switch(gymnasium.Env):
        ...     observation_space, action_space = gymnasium.spaces.Discrete(2), gymnasium.spaces.Discrete(1)
        ...     def labelled_mdp(self):
        ...         return LabelledMDP.from_arrays([[[0.5, 0.5], [0, 1]]], aps=["on"], labels=[[], ["on"]])
        >>> isinstance(Switch(), ModelledEnv)
        True
    """

    def labelled_mdp(self) -> LabelledMDP:
        """The exact model: state i is what observation i shows, time limits left out.

        A model without propositions takes the labels that are given with the environment; one with propositions labels
        itself.
        """
        ...


@runtime_checkable
class MappedEnv(Protocol):
    """An environment whose states are cells of a map."""

    def board(self) -> Board:
        """The map; cell i is state i of the model."""
        ...


@runtime_checkable
class DrawnEnv(Protocol):
    """An environment in the plane, of which trajectories can be drawn."""

    def scene(self, copy: int = 0) -> Scene:
        """The world and who moves in it, now; of a vector environment, those of one copy."""
        ...
