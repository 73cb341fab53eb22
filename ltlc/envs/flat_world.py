"""FlatWorld: a point that walks among coloured circles, where multi-task agents are compared.

References:
    M. Jackermeier, A. Abate, DeepLTL: learning to efficiently satisfy complex LTL specifications for multi-task RL,
    ICLR 2025, arXiv 2410.04631.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from ltlc.envs.vector_world import BoolArray, FloatArray, IntArray, SingleWorld, StreamedWorld
from ltlc.errors import InvalidArgumentError
from ltlc.scene import Region, Scene

OUTSIDE = "outside"
"""what holds where the world has been left."""


class Circle(NamedTuple):
    """A coloured disc; its rim does not belong to it."""

    colour: str
    x: float
    y: float
    radius: float


CIRCLES = (
    Circle("red", -1.4, 0.55, 0.4),
    Circle("red", 0.5, -1.3, 0.35),
    Circle("magenta", -1.1, 1.1, 0.5),
    Circle("yellow", -1.0, -1.2, 0.3),
    Circle("orange", -1.53, -0.5, 0.32),
    Circle("blue", 0.1, 0.0, 0.8),
    Circle("green", 0.7, 0.7, 0.5),
    Circle("green", 1.5, -0.75, 0.4),
    Circle("aqua", 0.8, 0.2, 0.3),
)
_DIAGONAL = 0.5**0.5
DIRECTIONS = np.array(
    [(1, 0), (_DIAGONAL, _DIAGONAL), (0, 1), (-_DIAGONAL, _DIAGONAL),
     (-1, 0), (-_DIAGONAL, -_DIAGONAL), (0, -1), (_DIAGONAL, -_DIAGONAL), (0, 0)]
)  # fmt: skip
"""what the discrete actions add, in steps: eight directions counterclockwise from the right, and staying."""


class VectorFlatWorld(StreamedWorld):
    """Many points in a square, each in an episode of its own.

    Observations are positions (x, y), float32. Episodes begin at a place that is uniform outside the circles. What
    holds are the colours of the circles that a point is strictly inside of; circles overlap. A point that leaves the
    square ends its episode where only `outside` holds, which then holds for ever: a task that this would satisfy, such
    as `G !blue`, needs `& G !outside`.

    Args:
        num_envs: number of copies.
        circles: (colour, x, y, radius) each.
        half_width: the square is [-half_width, half_width] in both directions.
        stride: length of a step.
        continuous: whether an action is a vector in [-1, 1]^2, cut to length 1, in place of one of nine.
        max_episode_steps: see `VectorWorld`, as the other arguments.
        autoreset_mode: when a finished copy starts again.
        render_mode: see `VectorWorld`.

    Raises:
        InvalidArgumentError: a length is not positive, or a circle is called `outside`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        circles: Sequence[Sequence[Any]] = CIRCLES,
        half_width: float = 2.0,
        stride: float = 0.08,
        continuous: bool = False,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        self.circles = tuple(Circle(*circle) for circle in circles)
        colours = tuple(dict.fromkeys(circle.colour for circle in self.circles))
        if not (half_width > 0 and stride > 0 and all(circle.radius > 0 for circle in self.circles)):
            raise InvalidArgumentError(f"half_width is {half_width}, stride {stride}; lengths and radii are positive")
        if OUTSIDE in colours:
            raise InvalidArgumentError(f"no circle is called {OUTSIDE!r}, which is what holds beyond the square")
        bound = half_width + stride * 1.01  # the last step may lead out, and is rounded
        super().__init__(
            num_envs,
            spaces.Box(-bound, bound, (2,), np.float32),
            spaces.Box(-1.0, 1.0, (2,), np.float32) if continuous else spaces.Discrete(len(DIRECTIONS)),
            (*colours, OUTSIDE),
            max_episode_steps=max_episode_steps,
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
        )
        self.half_width, self.stride, self._continuous = half_width, stride, continuous
        self._centre = np.array([[c.x, c.y] for c in self.circles]).reshape(-1, 2).T[:, :, None]
        self._square = np.array([c.radius**2 for c in self.circles])[:, None]
        self._bits = np.array([1 << colours.index(c.colour) for c in self.circles], dtype=np.int64)[:, None]
        self._at = np.zeros((2, num_envs))
        self._letter = np.zeros(num_envs, dtype=np.int64)
        self._strides = stride * DIRECTIONS.T

    def scene(self, copy: int = 0) -> Scene:
        """The circles and the point of one copy."""
        w = self.half_width
        x, y = self._at[:, copy].tolist()
        return Scene((-w, -w, w, w), tuple(Region(*circle) for circle in self.circles), (x, y))

    def _begin(self, mask: BoolArray) -> None:
        def free(numbers: FloatArray, copies: IntArray) -> BoolArray:
            return np.equal(self._colours(self._place(numbers)), 0)

        self._at[:, mask] = self._place(self._draw_until(mask, 2, free, "a start outside the circles"))
        self._letter[mask] = 0

    def _place(self, numbers: FloatArray) -> FloatArray:
        return self.half_width * (2 * numbers.T - 1)

    def _move(self, actions: Any) -> BoolArray:
        if self._continuous:
            vectors = np.asarray(actions).T
            self._at += self.stride * vectors / np.maximum(np.hypot(*vectors), 1.0)
        else:
            self._at += self._strides.take(actions, axis=1)
        outside = np.abs(self._at).max(axis=0) > self.half_width
        self._letter = np.where(outside, 1 << len(self.propositions) - 1, self._colours(self._at))
        return np.asarray(outside)

    def _observation(self) -> Any:
        return self._at.T.astype(np.float32)

    def _letters(self) -> IntArray:
        return self._letter.copy()

    def _colours(self, at: FloatArray) -> IntArray:
        """The colours at some places, shape (2, m), as bits, shape (m,)."""
        x, y = at[:, None] - self._centre
        inside = x * x + y * y < self._square
        return np.asarray(np.bitwise_or.reduce(self._bits * inside, axis=0))


class FlatWorld(SingleWorld):
    """One point in a square; see `VectorFlatWorld`.

    Args:
        circles: (colour, x, y, radius) each.
        half_width: the square is [-half_width, half_width] in both directions.
        stride: length of a step.
        continuous: whether an action is a vector in place of one of nine.
        render_mode: see `SingleWorld`.
    """

    def __init__(
        self,
        *,
        circles: Sequence[Sequence[Any]] = CIRCLES,
        half_width: float = 2.0,
        stride: float = 0.08,
        continuous: bool = False,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(
            VectorFlatWorld(circles=circles, half_width=half_width, stride=stride, continuous=continuous), render_mode
        )
