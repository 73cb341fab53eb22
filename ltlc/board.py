"""A map on which policies are drawn: what environments hand out and pictures read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ltlc.errors import InvalidArgumentError

DIRECTIONS = {"UP": (0, -1), "RIGHT": (1, 0), "DOWN": (0, 1), "LEFT": (-1, 0), "NONE": (0, 0)}
"""columns and rows that an action goes on by, by its name."""
TINTS = ("#f2c57c", "#9fc7a5", "#e59a8c", "#a9b8de", "#d6a9d0", "#8fc7cf", "#cfcf8a", "#c9b199")
"""colours of marked cells."""


@dataclass(frozen=True, eq=False)
class Board:
    """A map whose cells are the states of an environment, row by row.

    Attributes:
        text: a string per row, all of one length: `.` free, `#` wall, any other character a marked cell.
        start: the cell where episodes begin.
        actions: what each action does: UP, RIGHT, DOWN, LEFT or NONE.
        meaning: what each character stands for.
        final: cells where the environment ends the episode.
        colours: of some characters; the others get one of `TINTS` each.

    Raises:
        InvalidArgumentError: there are no cells, rows differ in length, the start is no cell, or an action is none of
            the five.

    Example:
        >>> Board(("..", ".G"), start=0, actions=("RIGHT", "DOWN"), meaning={"G": "goal"}).tints
        {'G': '#f2c57c'}
    """

    text: tuple[str, ...]
    start: int
    actions: tuple[str, ...]
    meaning: Mapping[str, str] = field(default_factory=dict)
    final: frozenset[int] = frozenset()
    colours: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if len({len(row) for row in self.text}) != 1 or not self.text[0]:
            raise InvalidArgumentError("the rows of a board have one length, and there is one cell at least")
        if not 0 <= self.start < len(self.cells):
            raise InvalidArgumentError(f"a board of {len(self.cells)} cells cannot begin in cell {self.start}")
        for action in self.actions:
            if action not in DIRECTIONS:
                raise InvalidArgumentError(f"an action of a board is {action!r}, not one of {', '.join(DIRECTIONS)}")

    @property
    def rows(self) -> int:
        """Height in cells."""
        return len(self.text)

    @property
    def columns(self) -> int:
        """Width in cells."""
        return len(self.text[0])

    @property
    def cells(self) -> str:
        """All characters, row by row."""
        return "".join(self.text)

    @property
    def tints(self) -> dict[str, str]:
        """A colour for each marked character, in order of the characters."""
        marked = sorted(set(self.cells) - {".", "#"})
        return {c: self.colours.get(c, TINTS[i % len(TINTS)]) for i, c in enumerate(marked)}
