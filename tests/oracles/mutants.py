"""Damaged and forged files of every kind that is read: texts with mutations, trees of values with other values."""

from __future__ import annotations

import copy
import io
import json
import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from random_automata import random_automata

from ltlc import LTLVectorWrapper, Task, compile
from ltlc.agents import DoubleDQN, DQNConfig, FittedQ, FittedQConfig, train
from ltlc.agents.tabular.policy import TablePolicy
from ltlc.agents.training.run_config import RunConfig
from ltlc.agents.training.run_folder import RunFolder
from ltlc.agents.training.storage import write_file
from ltlc.envs import VectorGridWorld
from ltlc.envs.spec import EnvSpec
from ltlc.errors import LtlcError
from ltlc.formats import from_hoa, from_json, to_hoa, to_json
from ltlc.mdp import LabelledMDP
from ltlc.prism import read_explicit, read_state_rewards, write_explicit


def one_observation(space: spaces.Space[Any]) -> Any:
    """A batch of one valid observation, made without drawing random numbers."""
    if isinstance(space, spaces.Dict):
        return {key: one_observation(part) for key, part in space.spaces.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(one_observation(part) for part in space.spaces)
    if isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        return np.asarray(space.start)[None]
    return np.zeros((1, *(space.shape or ())), dtype=space.dtype)


WORDS = re.findall(
    r"\S+",
    "HOA: v1 v1.1 States: Start: AP: Alias: Acceptance: acc-name: name: properties: --BODY-- State: --END-- --ABORT-- "
    '[ ] ( ) { } ! & | t f 0 1 2 17 99999999999 99999999999999999999 -1 0.5 1e999 nan 1/3 @a "a" "" '
    "Fin Inf Fin(0) Inf(!1) Rabin parity min odd weak complete colored mdp dtmc ctmc # #DECLARATION #END init "
    "² é 😀 : , null true",
)
"""of HOA, PRISM's files and JSON, and some that fit nowhere."""
VALUES: list[Any] = [
    None, True, False, 0, 1, -1, 2, 7, 10**6, 2**31, 2**62, 2**63, 10**30, 10**400, 0.5, -0.5, 1e-300, 1e308,
    float("nan"), float("inf"), "", "a", "cpu", "meta", "cuda:7", "Box", "Discrete", "repeat", "float64", "O", "\u00b2",
    [], [0], [1.5], [[0], [0, 1]], [100_000_000_000], ["a", "a"], {}, {"kind": "Discrete"}, {"a": 1}, {0: {}},
]  # fmt: skip
"""that are wrong in most places."""
TENSORS = [
    torch.zeros(0), torch.zeros(1), torch.zeros(()), torch.ones(3, 4), torch.full((2, 2), float("nan")),
    torch.zeros(2, 2, dtype=torch.int32), torch.full((3,), 2**31 - 1, dtype=torch.int32), torch.full((3,), -1),
    torch.zeros(1, dtype=torch.bool), torch.zeros(1, 1, dtype=torch.float64), torch.zeros(2, dtype=torch.complex64),
    torch.zeros(1).expand(10**6), torch.zeros(1).expand(10**5, 10**6), torch.zeros(2, 2).to_sparse(),
    torch.zeros(3, requires_grad=True), torch.zeros(2, dtype=torch.bfloat16), torch.zeros(5, device="meta"),
]  # fmt: skip
"""that are wrong in most places, among them some that are much larger than their numbers."""


def mutated_text(rng: random.Random, text: str) -> str:
    """The text with a few stretches deleted, doubled, moved or exchanged, or with lines lost or swapped."""
    for _ in range(rng.randint(1, 3)):
        if rng.random() < 0.3:
            lines = text.splitlines(keepends=True)
            i, j = rng.randrange(len(lines) + 1), rng.randrange(len(lines) + 1)
            text = "".join(rng.choice([lines[:i] + lines[i + 1 :], lines[:i] + lines[j : j + 1] + lines[i:]]))
            continue
        i = rng.randrange(len(text) + 1)
        j = min(len(text), i + rng.choice([0, 1, 1, 5, 60]))
        new = ["", text[i:j] * 2, rng.choice(WORDS), chr(rng.randrange(0x250)), str(rng.randrange(40)), "9" * 5_000]
        text = text[:i] + rng.choices(new, [4, 3, 6, 2, 4, 0.1])[0] + text[j:]
    return text


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths to all values inside a tree of dicts and lists."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inside:
        yield (*path, key)
        yield from places(part, (*path, key))


def forged(rng: random.Random, tree: Any, values: list[Any]) -> Any:
    """The tree with one or two of its values exchanged, lost, doubled, nested or shifted."""
    tree = copy.deepcopy(tree)
    for _ in range(rng.choice([1, 1, 1, 2])):
        every = list(places(tree))
        if not every:
            break
        *path, key = rng.choice(every)
        parent = tree
        for step in path:
            parent = parent[step]
        old = parent[key]
        match rng.randrange(8):
            case 0:
                del parent[key]
            case 1 if isinstance(parent, dict):
                parent[rng.choice(["x", 3, "kind", "weights"])] = old
            case 2:
                other = tree
                for step in rng.choice(every):
                    if not isinstance(other, dict | list) or (isinstance(other, dict) and step not in other):
                        break
                    if isinstance(other, list) and not (isinstance(step, int) and step < len(other)):
                        break
                    other = other[step]
                parent[key] = copy.deepcopy(other)
            case 3 if isinstance(old, torch.Tensor) and old.numel():
                parent[key] = _shifted(rng, old)
            case 4 if isinstance(old, list):
                parent[key] = old * rng.randint(2, 3)
            case 5 if isinstance(old, int | float) and not isinstance(old, bool) and abs(old) < 2**53:
                parent[key] = rng.choice([old + 1, old - 1, -old, old * 10**9, float(old), str(old)])
            case _:
                parent[key] = copy.deepcopy(rng.choice(values))
    return tree


def _shifted(rng: random.Random, tensor: torch.Tensor) -> torch.Tensor:
    """The tensor with other numbers, another shape or of another kind."""
    other = tensor.clone()
    match rng.randrange(5):
        case 0:
            place = rng.randrange(other.numel())
            other.view(-1)[place] = rng.choice([-1, 1, 127, 1e9, float("nan")]) if other.is_floating_point() else 119
            return other
        case 1:
            return other.flatten()[: rng.randrange(other.numel() + 1)]
        case 2:
            return torch.cat([other, other]) if other.dim() else other[None]
        case 3:
            return other.to(rng.choice([torch.float32, torch.float64, torch.int64, torch.bool, torch.uint8]))
    return other.flatten()[None]


Reader = Callable[[Any], object]
Maker = Callable[[random.Random], Any]


def kinds(folder: Path) -> dict[str, tuple[Maker, Reader]]:
    """For each kind of file a maker of mutants and the reader that is to survive them; `folder` is for their files."""
    automata = list(random_automata(30))
    hoas, jsons = [to_hoa(a) for a in automata], [to_json(a) for a in automata]
    trees = [json.loads(text) for text in jsons]
    return {
        "hoa": (lambda rng: mutated_text(rng, rng.choice(hoas)), from_hoa),
        "json": (lambda rng: _mutated_json(rng, rng.choice(jsons), rng.choice(trees)), from_json),
        "prism": _prism(folder / "prism"),
        "config": _config(folder / "config"),
        **_agents(folder / "agents"),
    }


def _mutated_json(rng: random.Random, text: str, tree: Any) -> str:
    return mutated_text(rng, text) if rng.random() < 0.5 else json.dumps(forged(rng, tree, VALUES))


def _config(folder: Path) -> tuple[Maker, Reader]:
    """The configuration of a run."""
    RunFolder.create(folder, RunConfig(env_spec=EnvSpec(env="FrozenLake-v1")), compile("F a")).close()
    path = folder / "config.json"
    text = path.read_text()

    def read(mutant: str) -> None:
        path.write_bytes(mutant.encode("utf-8", "surrogatepass"))
        RunFolder.open(folder)

    return lambda rng: _mutated_json(rng, text, json.loads(text)), read


def _prism(folder: Path) -> tuple[Maker, Reader]:
    folder.mkdir()
    rng = np.random.default_rng(0)
    files: list[list[str]] = []
    for i in range(8):
        n, n_actions = int(rng.integers(1, 6)), int(rng.integers(1, 4))
        p = rng.random((n_actions, n, n))
        mdp = LabelledMDP.from_arrays(
            p / p.sum(axis=2, keepdims=True), aps="ab", labels=[["a"] if q % 2 else ["a", "b"] for q in range(n)]
        )
        style: Any = ["prism", "storm"][i % 2]
        paths = write_explicit(mdp, folder / f"m{i}", style=style, state_reward=rng.random(n).round(2))
        heads = ["# Transitions (MDP)\n", "# Labels\n", "# States\n", "# State rewards\n"] if i % 4 < 2 else [""] * 4
        files.append([head + path.read_text() for head, path in zip(heads, paths, strict=True)])

    def make(rng: random.Random) -> list[str]:
        texts = list(rng.choice(files))
        i = rng.choice([0, 0, 0, 1, 2, 3])
        texts[i] = mutated_text(rng, texts[i])
        return texts

    def read(texts: list[str]) -> None:
        paths = [folder / f"x.{suffix}" for suffix in ("tra", "lab", "sta", "srew")]
        for path, text in zip(paths, texts, strict=True):
            path.write_bytes(text.encode("utf-8", "surrogatepass"))
        mdp = read_explicit(*paths[:3])
        read_state_rewards(paths[3], mdp.n_states)

    return make, read


def _agents(folder: Path) -> dict[str, tuple[Maker, Reader]]:
    """Policies of networks and of tables, tables of tabular learners, and checkpoints."""
    folder.mkdir()
    values = [*VALUES, *TENSORS]
    env = LTLVectorWrapper(VectorGridWorld("S..\n.C.\nA.B", 2), Task("F(A & F B) & G !C", on_deadlock="stay"))
    policies, checkpoints = _trained(env, folder)
    policies += _policies_of_other_spaces(folder)
    tables = _tables(folder)

    def load(kind: str, *agents: type[DoubleDQN] | type[FittedQ] | type[TablePolicy]) -> Reader:
        def read(content: Any) -> None:
            named = content.get("agent") if isinstance(content, dict) else None
            agent = next((agent for agent in agents if getattr(agent, "name", "") == named), agents[0])
            loaded = agent.load(write_file(folder / f"forged.{kind}", kind, content))
            packed = loaded.encoder.pack(one_observation(loaded.encoder.space))
            loaded.packed_policy(packed, np.array([loaded.tables.n_states - 1]))

        return read

    def resume(content: Any) -> None:
        write_file(folder / "resumed" / "checkpoint.ltlc", "checkpoint", content)
        train(env, folder=folder / "resumed", resume=True)

    (folder / "resumed").mkdir()
    return {
        "policy": (lambda rng: forged(rng, rng.choice(policies), values), load("policy", DoubleDQN, FittedQ)),
        "table": (lambda rng: forged(rng, rng.choice(tables), values), load("table", TablePolicy)),
        "checkpoint": (lambda rng: forged(rng, rng.choice(checkpoints), values), resume),
    }


_SMALL: dict[str, Any] = {"total_steps": 24, "learning_starts": 4, "batch_size": 4, "buffer_size": 40, "log_every": 12,
                          "checkpoint_every": 12}  # fmt: skip


_TABLE = {name: value for name, value in _SMALL.items() if name not in ("batch_size", "buffer_size")}


def _trained(env: LTLVectorWrapper, folder: Path) -> tuple[list[Any], list[Any]]:
    """Contents of policies, and of checkpoints half through."""
    policies, checkpoints = [], []
    for i, config in enumerate(
        (
            DQNConfig(hidden=(3,), **_SMALL),
            DQNConfig(hidden=(3,), optimizer="sgd", batch_norm=True, **_SMALL),
            FittedQConfig(**_TABLE),
        )
    ):
        train(env, config, folder=folder / f"run{i}", callback=lambda _: True)
        policies.append(_content(folder / f"run{i}" / "policy.ltlc"))
        checkpoints.append(_content(folder / f"run{i}" / "checkpoint.ltlc"))
    return policies, checkpoints


def _policies_of_other_spaces(folder: Path) -> list[Any]:
    box, bits, number = spaces.Box(0, 1, (2,)), spaces.MultiBinary(2), spaces.Discrete(2, start=1)
    agents = [
        DoubleDQN(space, 2, Task("F a").tables, DQNConfig(hidden=(2,)))
        for space in (spaces.Dict({"x": box, "y": bits}), spaces.Tuple([number, spaces.Box(0, 9, (1,), np.uint8)]))
    ]
    return [_content(agent.save(folder / "policy.ltlc")) for agent in agents]


def _tables(folder: Path) -> list[Any]:
    tables = Task("F a").tables
    contents = []
    for space, n in ((spaces.Discrete(3), 3), (spaces.MultiDiscrete([2, 2], start=[1, 0]), 4)):
        for table in (np.zeros((n, tables.n_states), dtype=np.int64), np.full((n, tables.n_states, 2), 0.5)):
            contents.append(_content(TablePolicy(space, 2, tables, table).save(folder / "table.ltlc")))
    return contents


def _content(path: Path) -> Any:
    """What a file of tensors holds."""
    return torch.load(io.BytesIO(path.read_bytes().partition(b"\n")[2]), weights_only=True)


def survives(read: Reader, mutant: Any) -> bool:
    """Whether a mutant is read; any error that is not ours goes on."""
    try:
        read(mutant)
    except LtlcError as error:
        assert str(error).isprintable() or "\n" in str(error)
        return False
    return True
