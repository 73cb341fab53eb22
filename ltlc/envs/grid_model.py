"""Grid worlds as exact models and as maps to draw on."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import sparse

from ltlc.board import Board
from ltlc.envs.grid_map import ACTIONS, GridMap
from ltlc.mdp import LabelledMDP


def grid_model(layout: GridMap) -> LabelledMDP:
    """The exact model of a grid world; states are cells."""
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


@lru_cache(maxsize=16)
def grid_board(layout: GridMap) -> Board:
    """The map of a grid world."""
    return Board(layout.text, layout.start, ACTIONS[: layout.n_actions], _meaning_of(layout))


def _meaning_of(layout: GridMap) -> dict[str, str]:
    """What the marked cells of a grid world show, with probabilities where they are not 1."""
    meaning = {}
    for cell, character in enumerate("".join(layout.text)):
        if character in ".#" or character in meaning:
            continue
        shown = [
            " ".join(name for i, name in enumerate(layout.propositions) if letter >> i & 1)
            + (f" with probability {p:.2g}" if p < 1 else "")
            for letter, p in layout.cell_labels[cell]
            if letter
        ]
        meaning[character] = " or ".join(shown) or "nothing"
    return meaning
