"""Zone worlds: a point mass that is steered among coloured zones it sees by lidar.

The tasks and measures are those that agents are compared with on robots of a physics engine; the mechanics here are a
few lines, so that a world of 256 copies makes more than 100 000 steps a second.

References:
    P. Vaezipoor, A. Li, R. Toro Icarte, S. McIlraith, LTL2Action: generalizing LTL instructions for multi-task RL,
    ICML 2021, arXiv 2102.06858.
    A. Ray, J. Achiam, D. Amodei, Benchmarking safe exploration in deep reinforcement learning, 2019 (lidar).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from ltlc.envs.flat_world import OUTSIDE
from ltlc.envs.vector_world import BoolArray, FloatArray, IntArray, SingleWorld, StreamedWorld
from ltlc.errors import InvalidArgumentError
from ltlc.scene import Region, Scene

COLOURS = ("blue", "orange", "green", "red", "purple", "brown", "pink", "gray")
BINS = 32
"""directions that a lidar tells apart, counterclockwise from straight on."""
GAIN = 0.5
"""a lidar shows exp(-GAIN * distance)."""
TIME, DRAG, TOP_SPEED, FORCE, TURN = 0.05, 0.08, 3.0, 2.0, 3.0
"""time of a step; part of the speed lost in it; bound of the speed; acceleration and turning rate at full power."""
CONTROLS = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (0, 0)], dtype=np.float64)
"""force and turning of the discrete actions: forward, back, turn left, turn right, none."""
_BODY = 5
"""entries of an observation that show the body: acceleration, velocity (both ahead and to the left), turning rate."""


class VectorZoneWorld(StreamedWorld):
    """Many point masses, each among zones of its own.

    There is one zone of each colour, at random places drawn anew for each episode: centres are uniform in the middle
    of the world and a least distance apart, so that zones may overlap. The mass begins at rest, at a uniform place
    outside the zones, in a uniform direction. A step with force f along the heading is v = (v + f dt)(1 - drag), cut at
    the top speed, then x = x + v dt, then the heading turns.

    An observation, float32, is acceleration and velocity (each ahead, then to the left), turning rate, then for each
    colour 32 bins of lidar: exp(-distance / 2) of the zone's centre in the bin of its direction, and parts of it in the
    two bins beside, the nearer the more. What holds are the colours of the zones that the mass is strictly inside of;
    a mass that leaves the world ends its episode where only `outside` holds, which then holds for ever.

    Args:
        num_envs: number of copies.
        colours: names of the zones.
        radius: of zones.
        apart: least distance of centres.
        half_width: the world is [-half_width, half_width] in both directions.
        spawn: zones and mass begin in [-spawn, spawn] in both directions.
        continuous: whether an action is (force, turning) in [-1, 1]^2 in place of one of five.
        max_episode_steps: see `VectorWorld`, as the other arguments.
        autoreset_mode: when a finished copy starts again.
        render_mode: see `VectorWorld`.

    Raises:
        InvalidArgumentError: a length is not positive, or colours are missing, there twice, or called `outside`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        colours: Sequence[str] = COLOURS,
        radius: float = 0.4,
        apart: float = 0.55,
        half_width: float = 3.3,
        spawn: float = 2.5,
        continuous: bool = False,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        self.colours = tuple(colours)
        if not self.colours or len({*self.colours, OUTSIDE}) <= len(self.colours):
            raise InvalidArgumentError(f"colours are {self.colours!r}; each is there once, and none is {OUTSIDE!r}")
        if not (radius > 0 and apart >= 0 and half_width >= spawn > 0):
            raise InvalidArgumentError(
                f"radius is {radius}, apart {apart}, half_width {half_width}, spawn {spawn}; lengths are positive, and "
                "the spawn area lies in the world"
            )
        k = len(self.colours)
        body = np.array([*[FORCE + DRAG * TOP_SPEED / TIME] * 2, TOP_SPEED, TOP_SPEED, TURN]) * 1.01  # is rounded
        low, high = np.concatenate([-body, np.zeros(k * BINS)]), np.concatenate([body, np.ones(k * BINS)])
        super().__init__(
            num_envs,
            spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32),
            spaces.Box(-1.0, 1.0, (2,), np.float32) if continuous else spaces.Discrete(len(CONTROLS)),
            (*self.colours, OUTSIDE),
            max_episode_steps=max_episode_steps,
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
        )
        self.radius, self.apart, self.half_width, self.spawn = radius, apart, half_width, spawn
        self._continuous = continuous
        self._bits = 1 << np.arange(k, dtype=np.int64)[:, None]
        self._zones = np.zeros((2, k, num_envs))
        self._at = np.zeros((2, num_envs))
        self._velocity, self._acceleration = np.zeros((2, num_envs)), np.zeros((2, num_envs))
        self._heading, self._turning = np.zeros(num_envs), np.zeros(num_envs)
        self._letter = np.zeros(num_envs, dtype=np.int64)
        self._place = (np.arange(num_envs) * k + np.arange(k)[:, None]) * BINS

    def scene(self, copy: int = 0) -> Scene:
        """The zones and the mass of one copy."""
        places = self._zones[:, :, copy].T.tolist()
        regions = (Region(c, x, y, self.radius) for c, (x, y) in zip(self.colours, places, strict=True))
        w = self.half_width
        x, y = self._at[:, copy].tolist()
        return Scene((-w, -w, w, w), tuple(regions), (x, y))

    def _begin(self, mask: BoolArray) -> None:
        k = len(self.colours)
        first, second = np.triu_indices(k, 1)

        def apart(numbers: FloatArray, copies: IntArray) -> BoolArray:
            x, y = self._places(numbers)
            centres = _square(x[:k, None] - x[None, :k], y[:k, None] - y[None, :k])[first, second]
            start = _square(x[:k] - x[k], y[:k] - y[k])
            return np.asarray((centres >= self.apart**2).all(axis=0) & (start >= self.radius**2).all(axis=0))

        numbers = self._draw_until(mask, 2 * (k + 1) + 1, apart, "zones that far apart")
        places = self._places(numbers)
        self._zones[:, :, mask], self._at[:, mask] = places[:, :k], places[:, k]
        self._heading[mask] = 2 * np.pi * numbers[:, -1]
        for still in (self._velocity, self._acceleration, self._turning, self._letter):
            still[..., mask] = 0

    def _places(self, numbers: FloatArray) -> FloatArray:
        """The places of zones and mass, shape (2, zones + 1, m), of m rows of random numbers."""
        return self.spawn * (2 * numbers[:, :-1].T.reshape(2, -1, len(numbers)) - 1)

    def _move(self, actions: Any) -> BoolArray:
        force, turning = (actions if self._continuous else CONTROLS[actions]).T
        ahead = np.stack([np.cos(self._heading), np.sin(self._heading)])
        velocity = (self._velocity + FORCE * TIME * force * ahead) * (1 - DRAG)
        velocity *= TOP_SPEED / np.maximum(np.hypot(*velocity), TOP_SPEED)
        self._acceleration = (velocity - self._velocity) / TIME
        self._velocity = velocity
        self._at = self._at + velocity * TIME
        self._turning = TURN * turning
        self._heading = self._heading + self._turning * TIME
        outside = np.abs(self._at).max(axis=0) > self.half_width
        inside = _square(*(self._at[:, None] - self._zones)) < self.radius**2
        colours = (self._bits * inside).sum(axis=0)
        self._letter = np.where(outside, 1 << len(self.propositions) - 1, colours)
        return np.asarray(outside)

    def _observation(self) -> Any:
        shown = np.zeros((self.num_envs, _BODY + len(self.colours) * BINS), dtype=np.float32)
        cos, sin = np.cos(self._heading), np.sin(self._heading)
        for at, (x, y) in ((0, self._acceleration), (2, self._velocity)):
            shown[:, at], shown[:, at + 1] = x * cos + y * sin, y * cos - x * sin
        shown[:, 4] = self._turning
        shown[:, _BODY:] = self._lidar()
        return shown

    def _lidar(self) -> Any:
        x, y = self._zones - self._at[:, None]
        strength = np.exp(-GAIN * np.hypot(x, y))
        bins = (np.arctan2(y, x) - self._heading) * (BINS / (2 * np.pi)) % BINS
        whole = np.floor(bins)
        part = bins - whole
        whole = whole.astype(np.int64) % BINS
        seen = np.zeros(self._place.size * BINS, dtype=np.float32)
        seen[self._place + whole] = strength
        seen[self._place + (whole + 1) % BINS] = strength * part
        seen[self._place + (whole - 1) % BINS] = strength * (1 - part)
        return seen.reshape(self.num_envs, -1)

    def _letters(self) -> IntArray:
        return self._letter.copy()


class ZoneWorld(SingleWorld):
    """One point mass among coloured zones; see `VectorZoneWorld`.

    Args:
        colours: names of the zones.
        radius: of zones.
        apart: least distance of centres.
        half_width: the world is [-half_width, half_width] in both directions.
        spawn: zones and mass begin in [-spawn, spawn] in both directions.
        continuous: whether an action is (force, turning) in place of one of five.
        render_mode: see `SingleWorld`.
    """

    def __init__(
        self,
        *,
        colours: Sequence[str] = COLOURS,
        radius: float = 0.4,
        apart: float = 0.55,
        half_width: float = 3.3,
        spawn: float = 2.5,
        continuous: bool = False,
        render_mode: str | None = None,
    ) -> None:
        world = VectorZoneWorld(
            colours=colours, radius=radius, apart=apart, half_width=half_width, spawn=spawn, continuous=continuous
        )
        super().__init__(world, render_mode)


def _square(x: FloatArray, y: FloatArray) -> FloatArray:
    return x * x + y * y
