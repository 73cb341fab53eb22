"""A world in the plane at one moment: what environments hand out and pictures of trajectories read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_SAMPLES = 240
"""places in each direction that `Scene.labels` looks at."""


@dataclass(frozen=True)
class Region:
    """A part of the plane in which a proposition holds: a disc, or a square."""

    name: str
    x: float
    y: float
    radius: float
    """of a disc; half the width of a square."""
    square: bool = False


@dataclass(frozen=True)
class Scene:
    """What there is to draw of a world; x goes to the right, y up.

    Attributes:
        bounds: left, bottom, right and top of the world.
        regions: what lies in it.
        position: of who moves, (x, y).
        wraps: whether opposite sides are the same, so that a line between far positions goes round.
    """

    bounds: tuple[float, float, float, float]
    regions: tuple[Region, ...]
    position: tuple[float, float]
    wraps: bool = False

    @property
    def labels(self) -> set[frozenset[str]]:
        """The sets of names that hold together somewhere, found on a grid of places."""
        left, bottom, right, top = self.bounds
        x, y = np.meshgrid(np.linspace(left, right, _SAMPLES), np.linspace(bottom, top, _SAMPLES))
        names = sorted({region.name for region in self.regions})
        holds = np.zeros((len(names), x.size), dtype=np.bool_)
        for region in self.regions:
            dx, dy = np.abs(x - region.x).ravel(), np.abs(y - region.y).ravel()
            distance = np.maximum(dx, dy) if region.square else np.hypot(dx, dy)
            holds[names.index(region.name)] |= distance < region.radius
        return {
            frozenset(n for n, held in zip(names, column, strict=True) if held) for column in np.unique(holds.T, axis=0)
        }
