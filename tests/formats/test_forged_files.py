"""Damaged and forged files of every kind end in what they say or in an `LtlcError`, and nothing in them is executed."""

from __future__ import annotations

import hashlib
import io
import random
import zipfile
from pathlib import Path
from typing import Any

import pytest
import torch
from gymnasium import spaces
from mutants import Maker, Reader, forged, kinds, survives

from ltlc import LTLVectorWrapper, Task, compile
from ltlc.agents import DoubleDQN, DQNConfig, FittedQ, FittedQConfig, train
from ltlc.agents.training.run_config import RunConfig
from ltlc.agents.training.run_folder import RunFolder
from ltlc.agents.training.storage import read_file, write_file
from ltlc.envs import VectorGridWorld
from ltlc.envs.spec import EnvSpec
from ltlc.errors import FileFormatError

pytestmark = [
    pytest.mark.filterwarnings("ignore::ltlc.ltl.LtlSyntaxWarning"),
    pytest.mark.filterwarnings("ignore::UserWarning:gymnasium"),
]
COUNTS = {"hoa": 600, "json": 600, "prism": 500, "config": 300, "policy": 200, "table": 200, "checkpoint": 80}


@pytest.fixture(scope="module")
def makers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Maker, Reader]]:
    return kinds(tmp_path_factory.mktemp("forged"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_mutants(makers: dict[str, tuple[Maker, Reader]], kind: str) -> None:
    make, read = makers[kind]
    n_read = sum(survives(read, make(random.Random(seed))) for seed in range(COUNTS[kind]))
    assert 0 < n_read < COUNTS[kind]


def policy(folder: Path) -> Path:
    """A policy with two inputs, three hidden units and two actions."""
    agent = DoubleDQN(spaces.Box(-1, 1, (2,)), 2, Task("F a").tables, DQNConfig(hidden=(3,), layer_norm=False, waves=0))
    return agent.save(folder / "policy.ltlc")


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("config.hidden", [100_000_000_000], r"policy_network has \d+ weights; the hyperparameters .* ask for"),
        ("config.hidden", [3.5], "config is wrong: each entry of hidden is 3.5"),
        ("config.gamma", "high", "config is wrong: gamma is 'high'"),
        ("config.device", 5, "config.device is 5, not a text"),
        ("config.layers", 3, "config is wrong: unknown hyperparameter 'layers'"),
        ("n_actions", 10**15, "policy_network has"),
        ("n_actions", True, "n_actions is True, not a whole number"),
        ("n_actions", 3, r"policy_network.* has"),
        ("tables.reward", None, "tables.reward is None, not a tensor"),
        ("tables.reward", torch.zeros(2).double(), "tables is wrong: reward tables: reward has shape"),
        ("tables.next_state", torch.zeros(2, 2), "tables.next_state has numbers of the kind torch.float32"),
        ("tables.aps", [str(i) for i in range(40)], "tables.aps has 40 entries; at most 21"),
        ("observation_space.kind", "Cube", "observation_space.kind is 'Cube', which is no kind of space"),
        ("observation_space.low", torch.ones(2) * 5, "observation_space has a lower bound above the upper one"),
        ("observation_space.dtype", "O", "observation_space.dtype is 'O', not one of"),
        ("observation_space", {"kind": "Discrete", "n": 10**12, "start": 0}, "policy_network has 30 weights; the"),
        ("policy_network.layers.0.weight", torch.zeros(3, 2).fill_(float("nan")), "has a number that is not finite"),
        ("policy_network.layers.0.weight", torch.zeros(2, 3), r"layers.0.weight has the shape \(2, 3\), not \(3, 2\)"),
        ("policy_network.layers.0.weight", torch.zeros(1).expand(10**9, 4), "is much larger than the file"),
        ("x", "\ud800", "x has half of a surrogate pair"),
        ("x", 2j, "x is complex, which does not belong in this file"),
    ],
)
def test_what_is_wrong_with_a_policy(tmp_path: Path, field: str, value: Any, message: str) -> None:
    path = policy(tmp_path)
    content = read_file(path, "policy").value
    place, (*steps, last) = content, field.split(".", 2 if field.startswith("policy_network") else 9)
    if field.startswith("policy_network"):
        steps, last = ["policy_network"], field.removeprefix("policy_network.")
    for step in steps:
        place = place[step]
    place[last] = value
    write_file(path, "policy", content)
    with pytest.raises(FileFormatError, match=message) as caught:
        DoubleDQN.load(path)
    assert str(caught.value).startswith(f"{path}: ")


def written(path: Path, payload: bytes) -> Path:
    """A policy file with this payload and the right checksum."""
    path.write_bytes(f"ltlc policy 1 {hashlib.sha256(payload).hexdigest()}\n".encode() + payload)
    return path


def repacked(payload: bytes, compression: int, pickled: bytes | None = None) -> bytes:
    """The archive of tensors, compressed, or with another pickle inside."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(payload)) as old, zipfile.ZipFile(stream, "w", compression) as new:
        for name in old.namelist():
            new.writestr(name, pickled if pickled is not None and name.endswith("data.pkl") else old.read(name))
    return stream.getvalue()


def test_nothing_is_executed_or_unpacked(tmp_path: Path) -> None:
    payload = policy(tmp_path).read_bytes().partition(b"\n")[2]
    trap = tmp_path / "executed"
    call = b"cposix\nsystem\n(V" + f"touch {trap}".encode() + b"\ntR."
    reduce = b"cbuiltins\nexec\n(Vopen('" + str(trap).encode() + b"', 'w')\ntR."
    shared = b"]" + b"".join(b"q%c(h%ch%ct" % (i, i, i) for i in range(40)) + b"."  # a tree of 2^40 values
    bomb = io.BytesIO()
    torch.save({"config": torch.zeros(2_000_000)}, bomb)
    for content, message in (
        (call, "was not written by ltlc"),
        (reduce, "was not written by ltlc"),
        (b"not an archive", "was not written by ltlc"),
        (repacked(payload, zipfile.ZIP_STORED, call), "was not written by ltlc"),
        (repacked(payload, zipfile.ZIP_STORED, reduce), "was not written by ltlc"),
        (repacked(payload, zipfile.ZIP_STORED, shared), "larger than the file|was not written"),
        (repacked(bomb.getvalue(), zipfile.ZIP_DEFLATED), "unpacks to more than it is"),
    ):
        with pytest.raises(FileFormatError, match=message):
            DoubleDQN.load(written(tmp_path / "forged.ltlc", content))
    assert not trap.exists()


@pytest.mark.slow
def test_a_forged_checkpoint_leaves_the_run_as_it_was(tmp_path: Path) -> None:
    env = LTLVectorWrapper(VectorGridWorld("S..\nA.B", 2), "F(A & F B)")
    config = DQNConfig(hidden=(3,), total_steps=24, batch_size=4, learning_starts=4, log_every=8, checkpoint_every=8)
    train(env, config, folder=tmp_path, callback=lambda progress: progress.row.steps >= 16)
    content = read_file(tmp_path / "checkpoint.ltlc", "checkpoint").value
    metrics = (tmp_path / "metrics.csv").read_bytes()
    content["memory"]["action"][0] = 99
    write_file(tmp_path / "checkpoint.ltlc", "checkpoint", content)
    with pytest.raises(FileFormatError, match=r"memory.action has a number that is not in 0 \.\. "):
        train(env, folder=tmp_path, resume=True)
    assert (tmp_path / "metrics.csv").read_bytes() == metrics


@pytest.mark.parametrize(("n_cells", "n_actions", "formula", "message"), [
    (25, 5, "F(A & F B)", ""),
    (25, 7, "F(A & F B)", r"is for Discrete\(25\) and 7 actions; the environment of the run has .* and 5"),
    (30, 5, "F(A & F B)", r"is for Discrete\(30\) and 5 actions"),
    (25, 5, "F(B & F A)", "is of another task"),
])  # fmt: skip
def test_a_policy_that_does_not_fit_its_run(
    tmp_path: Path, n_cells: int, n_actions: int, formula: str, message: str
) -> None:
    config = RunConfig(env_spec=EnvSpec(env="ltlc/Thesis5x5-v0"))
    with RunFolder.create(tmp_path / "run", config, compile("F(A & F B)")) as run:
        agent = FittedQ(spaces.Discrete(n_cells), n_actions, Task(formula).tables, FittedQConfig())
        agent.save(run.path / "policy.ltlc", run=run.id)
        if message:
            with pytest.raises(FileFormatError, match=message):
                run.load()
        else:
            assert run.load().n_actions == n_actions


def test_forging_changes_something() -> None:
    tree = {"a": [1, {"b": 2.5}], "c": torch.zeros(2)}
    assert sum(repr(forged(random.Random(seed), tree, [None])) != repr(tree) for seed in range(100)) > 80
    assert repr(tree) == repr({"a": [1, {"b": 2.5}], "c": torch.zeros(2)})
