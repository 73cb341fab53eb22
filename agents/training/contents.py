"""What may stand in a policy or a checkpoint: everything is checked before anything is made of it.

The checksum of a file tells damage, not where it comes from. So a file is taken for any tree of plain values and
tensors (`check_plain`), and whoever takes a value out of it says what it must be; the error names the file and the
value. What is made of the values is never much larger than the file.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, NoReturn, TypeVar

import numpy as np
import numpy.typing as npt
import torch
from gymnasium import spaces
from torch import Tensor, nn

from ltlc.automata.possible import MAX_APS, Possible
from ltlc.errors import FileFormatError, LtlcError
from ltlc.rewards import RewardTables

from ..config import AgentConfig

Config = TypeVar("Config", bound=AgentConfig)

_DEPTH = 60
"""values are nested no deeper."""
_SHARED = 16
"""bytes of all tensors for each byte of the file, at most; tensors may share their numbers."""
_MOST_NAMES = 1 << 16
_DTYPES = {"IntArray": torch.int32, "FloatArray": torch.float64, "BoolArray": torch.bool}
"""of the arrays of reward tables, by their annotation."""
_PLAIN = (torch.float64, torch.float32, torch.float16, torch.int64, torch.int32, torch.int16, torch.int8, torch.uint8,
          torch.bool)  # fmt: skip
_BOX_DTYPES = ("float16", "float32", "float64", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32",
               "uint64", "bool")  # fmt: skip


class Content:
    """A value in a file, with where it stands.

    Args:
        value: of any kind.
        path: of the file.
        field: its name in the file, such as `config.hidden`; empty for the whole.
    """

    def __init__(self, value: Any, path: str, field: str = "") -> None:
        self.value, self.path, self.field = value, path, field

    def fail(self, what: str) -> NoReturn:
        """Raise the error that the value is wrong."""
        raise FileFormatError(f"{self.path}: {self.field or 'its content'} {what}")

    def check(self, condition: bool, what: str) -> None:
        """Check something of the value."""
        if not condition:
            self.fail(what)

    def __getitem__(self, key: str | int) -> Content:
        """A member of a dict or an entry of a list."""
        if isinstance(key, str):
            self.check(key in self.members(), f"has no {key!r}")
            return Content(self.value[key], self.path, f"{self.field}.{key}" if self.field else key)
        return Content(self.value[key], self.path, f"{self.field}[{key}]")

    def members(self) -> Mapping[str, Any]:
        """The value as a dict with texts as keys."""
        proper = isinstance(self.value, dict) and all(isinstance(key, str) for key in self.value)
        self.check(proper, f"is {_shown(self.value)}, not a table of named values")
        members: Mapping[str, Any] = self.value
        return members

    def entries(self, length: int | None = None) -> list[Content]:
        """The entries of a list."""
        self.check(isinstance(self.value, list | tuple), f"is {_shown(self.value)}, not a list")
        self.check(length in (None, len(self.value)), f"has {len(self.value)} entries, not {length}")
        return [self[i] for i in range(len(self.value))]

    def count(self, least: int = 0, most: int = 2**62) -> int:
        """The value as a whole number."""
        proper = isinstance(self.value, int) and not isinstance(self.value, bool)
        self.check(proper, f"is {_shown(self.value)}, not a whole number")
        self.check(least <= self.value <= most, f"is {self.value}, not in {least} .. {most}")
        return int(self.value)

    def number(self, least: float = -math.inf) -> float:
        """The value as a finite number."""
        proper = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        self.check(proper and math.isfinite(self.value), f"is {_shown(self.value)}, not a finite number")
        self.check(self.value >= least, f"is {self.value}, less than {least}")
        return float(self.value)

    def text(self) -> str:
        """The value as a text."""
        self.check(isinstance(self.value, str), f"is {_shown(self.value)}, not a text")
        return str(self.value)

    def tensor(self, dtype: torch.dtype, shape: tuple[int, ...] | None = None) -> Tensor:
        """The value as a tensor, whose floating numbers must be finite."""
        self.check(isinstance(self.value, Tensor), f"is {_shown(self.value)}, not a tensor")
        tensor: Tensor = self.value
        self.check(tensor.dtype == dtype, f"has numbers of the kind {tensor.dtype}, not {dtype}")
        self.check(shape in (None, tuple(tensor.shape)), f"has the shape {tuple(tensor.shape)}, not {shape}")
        self.check(not dtype.is_floating_point or bool(tensor.isfinite().all()), "has a number that is not finite")
        return tensor.contiguous()

    def indices(self, dtype: torch.dtype, shape: tuple[int, ...] | None, below: int) -> Tensor:
        """The value as a tensor of numbers from 0 to below a bound."""
        tensor = self.tensor(dtype, shape)
        self.check(bool(((tensor >= 0) & (tensor < below)).all()), f"has a number that is not in 0 .. {below - 1}")
        return tensor

    def state_of(self, module: nn.Module) -> dict[str, Tensor]:
        """The value as the state of a module."""
        expected = module.state_dict()
        self.check(self.members().keys() == expected.keys(), f"does not have the parts {', '.join(expected)}")
        return {name: self[name].tensor(part.dtype, tuple(part.shape)) for name, part in expected.items()}


def check_plain(content: Any, path: str, size: int) -> Content:
    """Check that the content of a file is a tree of plain values and tensors, not much larger than the file.

    Args:
        content: what was read.
        path: of the file.
        size: of the file, in bytes.

    Raises:
        FileFormatError: it is something else.
    """
    whole = Content(content, path)
    n_values = n_bytes = 0

    def walk(value: Any, field: str, depth: int) -> None:
        nonlocal n_values, n_bytes
        n_values += 1
        n_bytes += _check_value(Content(value, path, field))
        whole.check(n_values <= size and n_bytes <= _SHARED * size, "is much larger than the file")
        whole.check(depth <= _DEPTH, "is nested too deeply")
        parts = (
            value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list | tuple) else ()
        )
        for key, part in parts:
            walk(part, f"{field}.{key}" if field else str(key), depth + 1)

    walk(content, "", 0)
    return whole


def _check_value(node: Content) -> int:
    """Check a value without what is in it; returns how many bytes of tensors it is."""
    match node.value:
        case None | bool() | float() | list() | tuple():
            pass
        case dict():
            proper = all(isinstance(key, str | int) for key in node.value)
            node.check(proper, "has a key that is neither a text nor a number")
        case str():
            node.check(not any("\ud800" <= letter <= "\udfff" for letter in node.value), "has half of a surrogate pair")
        case int():
            node.check(-(2**63) <= node.value < 2**63, "is a number beyond 64 bits")
        case Tensor():
            tensor = node.value
            plain = tensor.dtype in _PLAIN and tensor.layout is torch.strided and tensor.device.type == "cpu"
            node.check(plain and not tensor.requires_grad, "is no plain tensor")
            return tensor.numel() * tensor.element_size()
        case _:
            node.fail(f"is {type(node.value).__name__}, which does not belong in this file")
    return 0


def config_of(content: Content, kind: type[Config]) -> Config:
    """Hyperparameters of an agent.

    Raises:
        FileFormatError: a name or a value is wrong.
    """
    if "device" in content.members():
        content["device"].text()
    try:
        return kind.from_dict(content.value)
    except LtlcError as error:
        content.fail(f"is wrong: {error}")


def tables_of(content: Content) -> RewardTables:
    """Reward tables, as `tables_to_tensors` of the storage made them.

    Raises:
        FileFormatError: they are of another kind, or do not fit together.
    """
    fields = {field.name: field for field in dataclasses.fields(RewardTables)}
    needed = {name for name, field in fields.items() if field.default_factory is field.default is dataclasses.MISSING}
    # Files of earlier versions say commit.
    keys = {"select_pair" if key == "commit" else key: key for key in content.members()}
    content.check(needed <= keys.keys() <= fields.keys(), f"does not have the parts {', '.join(fields)}")
    values: dict[str, Any] = {}
    for name, key in keys.items():
        part, kind = content[key], str(fields[name].type)
        if kind in _DTYPES:
            values[name] = part.tensor(_DTYPES[kind]).numpy()
        elif kind == "int":
            values[name] = part.count()
        elif kind == "tuple[str, ...]":
            values[name] = tuple(entry.text() for entry in part.entries())
            free = "possible" not in keys or content["possible"].value is None
            part.check(len(values[name]) <= MAX_APS or not free, f"has {len(values[name])} entries; at most {MAX_APS}")
        elif name == "possible":
            values[name] = None if part.value is None else _possible(part)
        else:
            values[name] = part.text()
    try:
        return RewardTables(**values)
    except LtlcError as error:
        content.fail(f"is wrong: {error}")


def _possible(content: Content) -> Possible:
    """The parts of an alphabet, of which each combination is a list of numbers of propositions."""
    return tuple(
        tuple(sum(1 << place.count(0, _MOST_NAMES) for place in mask.entries()) for mask in part.entries())
        for part in content.entries()
    )


def space_of(content: Content) -> spaces.Space[Any]:
    """A space of observations, as `plain_space` of the storage made it.

    Raises:
        FileFormatError: there is no such space.
    """
    kind = content["kind"].text()
    try:
        match kind:
            case "Discrete":
                n, first = content["n"].count(1, 2**53), content["start"].count(-(2**53), 2**53)
                return spaces.Discrete(n, start=first)
            case "MultiDiscrete":
                nvec, start = _integers(content["nvec"], 1), _integers(content["start"], -(2**53))
                content.check(nvec.shape == start.shape, "has not one start for each number")
                return spaces.MultiDiscrete(nvec, start=start)
            case "MultiBinary":
                size = content["n"]
                return spaces.MultiBinary(
                    _integers(size, 1).tolist() if isinstance(size.value, list) else size.count(1, 2**31)
                )
            case "Box":
                dtype = content["dtype"]
                dtype.check(
                    dtype.value in _BOX_DTYPES, f"is {_shown(dtype.value)}, not one of {', '.join(_BOX_DTYPES)}"
                )
                low, high = (_bound(content[name]) for name in ("low", "high"))
                content.check(low.shape == high.shape, "has bounds of different shapes")
                content.check(bool((low <= high).all()), "has a lower bound above the upper one")
                return spaces.Box(low, high, dtype=np.dtype(dtype.value).type)
            case "Text":
                return spaces.Text(1)
            case "Dict":
                parts = content["parts"]
                parts.check(bool(parts.members()), "is empty")
                return spaces.Dict({key: space_of(parts[key]) for key in parts.members()})
            case "Tuple":
                entries = content["parts"].entries()
                content.check(bool(entries), "is empty")
                return spaces.Tuple([space_of(part) for part in entries])
    except (AssertionError, ValueError, TypeError, OverflowError) as error:
        if isinstance(error, LtlcError):
            raise
        content.fail(f"is no space: {error}")
    content["kind"].fail(f"is {kind!r}, which is no kind of space")


def _integers(content: Content, least: int) -> npt.NDArray[np.int64]:
    """A list of whole numbers, or lists of such lists of one length."""
    entries = content.entries()
    content.check(bool(entries), "is empty")
    if not any(isinstance(entry.value, list | tuple) for entry in entries):
        return np.array([entry.count(least, 2**53) for entry in entries], dtype=np.int64)
    rows = [_integers(entry, least) for entry in entries]
    content.check(len({row.shape for row in rows}) == 1, "has rows of different lengths")
    return np.stack(rows)


def _bound(content: Content) -> npt.NDArray[Any]:
    tensor = content.value
    content.check(isinstance(tensor, Tensor), f"is {_shown(tensor)}, not a tensor of bounds")
    content.check(tensor.numel() > 0 and not bool(tensor.isnan().any()), "is empty, or has a bound that is no number")
    bound: npt.NDArray[Any] = tensor.numpy()
    return bound


def _shown(value: object) -> str:
    text = f"a tensor of shape {tuple(value.shape)}" if isinstance(value, Tensor) else repr(value)[:60]
    return text if len(text) < 60 else f"{text[:40]}..."


def numbers_in(content: Content) -> int:
    """How many numbers there are in the tensors of a table of tensors."""
    parts = [content[name] for name in content.members()]
    for part in parts:
        part.check(isinstance(part.value, Tensor), f"is {_shown(part.value)}, not a tensor")
    return sum(part.value.numel() for part in parts)


def check_optimizer(content: Content, optimizer: torch.optim.Optimizer) -> None:
    """Check the state of an optimizer before it is loaded into one that is made alike.

    Raises:
        FileFormatError: it is of another optimizer, or of other parameters.
    """
    (own,) = optimizer.state_dict()["param_groups"]
    (group,) = content["param_groups"].entries(1)
    for name in own:
        found = group[name].value
        group[name].check(name == "lr" or repr(found) == repr(own[name]), f"is {_shown(found)}, not {own[name]}")
    group["lr"].number(0.0)
    names = {"step", "exp_avg", "exp_avg_sq"} if isinstance(optimizer, torch.optim.Adam) else {"momentum_buffer"}
    state = content["state"]
    state.check(isinstance(state.value, dict), f"is {_shown(state.value)}, not a table")
    for number in state.value:
        state.check(number in own["params"], f"has a parameter {number!r}")
        part = Content(state.value[number], state.path, f"{state.field}.{number}")
        part.check(part.members().keys() == names, "is of another optimizer")
        weights = optimizer.param_groups[0]["params"][number]
        for name in names:
            if part.value[name] is not None or name != "momentum_buffer":
                part[name].tensor(torch.float32, () if name == "step" else tuple(weights.shape))
