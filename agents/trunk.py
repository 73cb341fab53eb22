"""What comes before the layers of a network: images, grids of codes, and numbers without bounds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor, nn

from .encoder import Leaf, ObservationEncoder, bounds_of

SMALL = 32
"""cells of the longer side of a grid whose whole numbers are taken for codes, at most."""
CODES = 256
"""values that a code can have, at most."""
EMBEDDED = 8
"""numbers that stand for a code."""
_FEWEST = 5
"""cells of each side of what two dimensions make an image, at least."""
_SPREAD = 0.25
"""standard deviation of a bounded number below which it is magnified, of numbers scaled to [-1, 1]."""
_NORMAL = 0.5
"""standard deviation that others get, and so do bounded ones where there are many: of those, most say nothing at any
time, and what they are then would drown the rest."""
FEW = 32
"""numbers of an observation, at most, that are taken as they are."""
_MAGNIFIED = 25.0
_CLIP = 5.0
_LAYERS = {  # from this length of the longer side on: channels, kernel, stride
    36: ((16, 8, 4), (32, 4, 2)),
    12: ((16, 4, 2), (32, 3, 1)),
    0: ((16, 3, 1), (32, 3, 1)),
}


class Trunk(nn.Module):
    """Turns the features of an observation into the inputs of the first layer.

    By the declared space alone, not by what is seen:

    * A Box of three dimensions is an image, and so is one of whole numbers with two, from 5 x 5 on; a fourth dimension
      in front is a stack of images. Its channels are the dimension that the other two, being equal, leave over, or else
      the shorter of the first and the last. It passes two convolutions, and small ones, up to 32 x 32, are also seen as
      they are. Grids of whole numbers up to 11 x 11 are only seen as they are: what is where, and not what is beside
      what, says there where to go.
    * Whole numbers of 3 to 256 values in a small image are codes: each gets 8 learned numbers of its own in each
      channel, beside its value. Numbers of 2 values are indicators, and stay.
    * Other numbers are scaled by their bounds; those without are normalised by running statistics, and so are those
      whose statistics show that the bounds are far too wide, and all where there are more than 32.

    Args:
        encoder: of the observations.
        generator: source of the initial weights.

    Attributes:
        n_features: of the encoder.
        n_outputs: inputs of the first layer.

    References:
        V. Mnih et al., Playing Atari with deep reinforcement learning, 2013, https://arxiv.org/abs/1312.5602
        (convolutions).
    """

    def __init__(self, encoder: ObservationEncoder, generator: torch.Generator) -> None:
        super().__init__()
        self._slices = [leaf.features for leaf in encoder.leaves]
        self.n_features, raw = encoder.n_features, encoder.mode == "raw"
        self.parts = nn.ModuleList(nn.Identity() if raw else _part(leaf, generator) for leaf in encoder.leaves)
        self.n_outputs = sum(
            part.n_outputs if isinstance(part, Flat | Image) else leaf.features.stop - leaf.features.start
            for part, leaf in zip(self.parts, encoder.leaves, strict=True)
        )
        self.active = any(isinstance(part, Flat | Image) for part in self.parts)

    def forward(self, features: Tensor) -> Tensor:
        """Inputs of the first layer, shape (batch, n_outputs), of features, shape (batch, n_features)."""
        if not self.active:
            return features
        outputs = [part(features[:, columns]) for part, columns in zip(self.parts, self._slices, strict=True)]
        return outputs[0] if len(outputs) == 1 else torch.cat(outputs, dim=1)

    @torch.no_grad()
    def observe(self, encoder: ObservationEncoder, packed: npt.NDArray[Any]) -> None:
        """Take packed observations, shape (batch, width), into the running statistics."""
        if not any(isinstance(part, Flat | Image) and part.statistics is not None for part in self.parts):
            return
        features = encoder.features(torch.from_numpy(packed).to(self.device))
        for part, columns in zip(self.parts, self._slices, strict=True):
            if isinstance(part, Flat):
                part.statistics.add(features[:, columns])
            elif isinstance(part, Image) and part.statistics is not None:
                part.statistics.add(part.cells(features[:, columns]).movedim(1, -1).flatten(0, -2))

    @property
    def device(self) -> torch.device:
        """Where the running statistics are."""
        return next(iter(self.buffers())).device

    def share_statistics(self, other: Trunk) -> None:
        """Use the running statistics of another trunk of the same encoder from now on."""
        for part, theirs in zip(self.parts, other.parts, strict=True):
            if isinstance(part, Flat | Image):
                part.statistics = theirs.statistics  # type: ignore[assignment]


class RunningStatistics(nn.Module):
    """Mean and variance of all numbers so far, column by column.

    Args:
        bounded: shape (n_columns,), bool; the columns that are scaled by their bounds already.

    References:
        T. F. Chan, G. H. Golub, R. J. LeVeque, Algorithms for computing the sample variance, The American Statistician
        1983, https://doi.org/10.1080/00031305.1983.10483115.
    """

    count: Tensor
    mean: Tensor
    squares: Tensor
    bounded: Tensor

    def __init__(self, bounded: Any) -> None:
        super().__init__()
        self.register_buffer("bounded", torch.as_tensor(bounded), persistent=False)
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))
        for name in ("mean", "squares"):
            self.register_buffer(name, torch.zeros(len(bounded), dtype=torch.float64))

    def add(self, numbers: Tensor) -> None:
        """Take in rows, shape (n, n_columns)."""
        rows = numbers.to(torch.float64)
        total = self.count + len(rows)
        mean = rows.mean(dim=0)
        shift = mean - self.mean
        self.squares += (rows - mean).square().sum(dim=0) + shift.square() * self.count * len(rows) / total
        self.mean += shift * len(rows) / total
        self.count.copy_(total)

    def forward(self, numbers: Tensor) -> Tensor:
        """Normalise: deviation 1/2 where there are no bounds or many columns, at least about 1/4 elsewhere."""
        kept = self.bounded & (len(self.bounded) <= FEW)
        deviation = (self.squares / self.count.clamp(min=1)).sqrt()
        gain = torch.where(kept, _SPREAD, _NORMAL) / deviation.clamp(min=1e-8)
        gain = torch.where(self.bounded, gain.clamp(max=_MAGNIFIED), gain)
        gain = torch.where(kept, gain.clamp(min=1.0), gain)
        gain = torch.where((self.count > 0) & (deviation > 0), gain, torch.ones_like(gain))
        center = torch.where(kept, self.mean * (1 - 1 / gain), self.mean)
        return ((numbers - center.float()) * gain.float()).clamp(-_CLIP, _CLIP)


class Flat(nn.Module):
    """Numbers that are no image."""

    def __init__(self, leaf: Leaf) -> None:
        super().__init__()
        assert isinstance(leaf.space, spaces.Box)
        _, _, bounded = bounds_of(leaf.space)
        self.statistics = RunningStatistics(bounded)
        self.n_outputs = len(bounded)

    def forward(self, features: Tensor) -> Tensor:
        """Normalised numbers, of the same shape."""
        normalised: Tensor = self.statistics(features)
        return normalised


class Image(nn.Module):
    """An image or a grid: its codes embedded, convolutions, and where it is small also all of its cells."""

    def __init__(self, leaf: Leaf, shape: tuple[int, ...], generator: torch.Generator) -> None:
        super().__init__()
        assert isinstance(leaf.space, spaces.Box)
        self._shape = shape
        self._order = image_order(shape)
        height, width, channels = cell_shape(shape)
        self._small = max(height, width) <= SMALL
        low, high, bounded = bounds_of(leaf.space)
        self._radius = (float(high.max()) - float(low.min())) / 2
        whole = bool(leaf.sizes) and len({*leaf.sizes}) == 1 and len({*low.tolist()}) == 1
        self.embedding: nn.Parameter | None = None
        self.statistics: RunningStatistics | None = None
        if whole and self._small and 2 < leaf.sizes[0] <= CODES:
            table = torch.randn((channels, leaf.sizes[0], EMBEDDED), generator=generator) / 2
            self.embedding = nn.Parameter(table)
        if self.embedding is not None or not bounded.all():
            self.statistics = RunningStatistics(np.full(channels, bool(bounded.all())))
        depth = channels * (1 + (EMBEDDED if self.embedding is not None else 0))
        side = next(least for least in _LAYERS if max(height, width) >= least)
        layers: list[nn.Module] = []
        self.n_outputs = depth * height * width if self._small else 0
        for out, kernel, stride in () if leaf.sizes and not side else _LAYERS[side]:
            kernels = min(kernel, height), min(kernel, width)
            layers += [_convolution(depth, out, kernels, stride, generator), nn.ReLU()]
            height, width = ((size - k) // stride + 1 for size, k in zip((height, width), kernels, strict=True))
            depth = out
        self.layers = nn.Sequential(*layers)
        self.n_outputs += depth * height * width if layers else 0

    def cells(self, features: Tensor) -> Tensor:
        """The image, shape (batch, channels, height, width)."""
        image = features.view(-1, *self._shape).permute(0, *(axis + 1 for axis in self._order))
        return image.reshape(len(features), -1, *image.shape[-2:])

    def forward(self, features: Tensor) -> Tensor:
        """Outputs of the convolutions, and the cells of a small image, shape (batch, n_outputs)."""
        cells = self.cells(features)
        seen = (cells + 1) / 2  # from 0 to 1, so that what is absent is 0
        if self.statistics is not None:
            seen = self.statistics(cells.movedim(1, -1)).movedim(-1, 1)
        if self.embedding is not None:
            codes = ((cells + 1) * self._radius).round().long().clamp(0, self.embedding.shape[1] - 1)
            channel = torch.arange(codes.shape[1], device=codes.device)[:, None, None]
            embedded = self.embedding[channel, codes].movedim(-1, 2).flatten(1, 2)
            seen = torch.cat([seen, embedded], dim=1)
        if not len(self.layers):
            return seen.flatten(1)
        outputs: Tensor = self.layers(seen).flatten(1)
        return torch.cat([seen.flatten(1), outputs], dim=1) if self._small else outputs


def image_order(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The axes of an image in the order (stack,) channels, height, width; without channels for two dimensions."""
    if len(shape) == 2:
        return (0, 1)
    first, middle, last = shape[-3:]
    leads = middle == last if (first == middle) != (middle == last) else first < last
    axes = (0, 1, 2) if leads else (2, 0, 1)
    return axes if len(shape) == 3 else (0, *(axis + 1 for axis in axes))


def cell_shape(shape: tuple[int, ...]) -> tuple[int, int, int]:
    """Height, width and channels of an image, those of a stack multiplied."""
    *channels, height, width = (shape[axis] for axis in image_order(shape))
    return height, width, math.prod(channels)


def is_image(space: spaces.Space[Any]) -> bool:
    """Whether a space is taken for one of images."""
    if not isinstance(space, spaces.Box) or len(space.shape) not in (2, 3, 4):
        return False
    if len(space.shape) == 2:
        return space.dtype is not None and space.dtype.kind in "iub" and min(space.shape) >= _FEWEST
    height, width, _ = cell_shape(space.shape)
    return min(height, width) >= 3


def _part(leaf: Leaf, generator: torch.Generator) -> nn.Module:
    if not isinstance(leaf.space, spaces.Box):
        return nn.Identity()
    if is_image(leaf.space):
        return Image(leaf, leaf.space.shape, generator)
    return nn.Identity() if leaf.sizes and max(leaf.sizes) <= 2 else Flat(leaf)


def _convolution(n_in: int, n_out: int, kernel: tuple[int, int], stride: int, generator: torch.Generator) -> nn.Module:
    layer: nn.Conv2d = nn.utils.skip_init(nn.Conv2d, n_in, n_out, kernel, stride)  # type: ignore[no-untyped-call]
    nn.init.normal_(layer.weight, 0.0, math.sqrt(2 / (n_in * math.prod(kernel))), generator=generator)
    nn.init.zeros_(layer.bias)  # type: ignore[arg-type]
    return layer
