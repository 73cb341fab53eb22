"""The transform for TorchRL says what the reward tables say, for one environment and for many, across resets."""

from __future__ import annotations

import importlib
import sys
import warnings
from typing import Any

import numpy as np
import pytest
import torch

import ltlc
from ltlc.errors import InvalidArgumentError, MissingProgramError, RewardWarning

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    torchrl = pytest.importorskip("torchrl", reason="torchrl is not installed", exc_type=ImportError)
    envs = importlib.import_module("torchrl.envs")
    bridge = importlib.import_module("ltlc.bridges.torchrl")

pytestmark = [pytest.mark.peer, pytest.mark.filterwarnings("ignore")]
LABELS = {"right": lambda seen: seen[0] > 0.02, "left": lambda seen: seen[0] < -0.02}
FORMULA = "G F right & G F left"


def pole(task: Any, n: int = 0, **more: Any) -> Any:
    base = envs.SerialEnv(n, lambda: envs.GymEnv("CartPole-v1")) if n else envs.GymEnv("CartPole-v1")
    return envs.TransformedEnv(base, bridge.LTLTransform(task, LABELS, **more))


def check(rows: Any, task: ltlc.Task, skip: bool = False) -> int:
    """Follow the tables along one row of steps; how many episodes there were."""
    tables, episodes, state = task.tables, 0, -1
    aps = {name: 1 << i for i, name in enumerate(tables.aps)}

    def column(seen: Any) -> int:
        return int(tables.letter_class[sum(bit for name, bit in aps.items() if LABELS[name](seen.numpy()))])

    for step in rows:
        after, begins = step["next"], state < 0
        if begins:
            episodes += 1
            state = (
                tables.initial_state
                if skip
                else int(tables.next_state[tables.initial_state, column(step["observation"])])
            )
        assert step["automaton_state"].item() == state
        assert step["automaton"].argmax().item() == state
        at = state, column(after["observation"])
        base_ended = bool(abs(after["observation"][0]) > 2.4 or abs(after["observation"][2]) > 0.2095)
        stop = tables.stop[at] == 1
        paid = tables.reward[at] + stop * tables.stop_reward[at]
        paid += (base_ended and not stop) * tables.discount[at] * tables.final_value[at]
        assert after["reward"].item() == pytest.approx(paid, rel=1e-6)
        assert after["discount"].item() == pytest.approx(tables.discount[at], rel=1e-6)
        assert after["ltl_violated"].item() == tables.violated[at]
        assert after["ltl_accepting"].item() == tables.accepted[at]
        assert after["terminated"].item() == (base_ended or stop)
        state = int(tables.next_state[at])
        assert after["automaton_state"].item() == state
        if after["done"].item():
            state = -1
    return episodes


@pytest.mark.parametrize("initial_label", ["read", "skip"])
@pytest.mark.parametrize("formula", [FORMULA, "F right", "G !left"])
def test_one_environment(formula: str, initial_label: str) -> None:
    task = ltlc.Task(formula, "two-discount")
    env = pole(task, initial_label=initial_label) if formula == FORMULA else None
    if env is None:
        labels = {name: LABELS[name] for name in task.aps}
        env = envs.TransformedEnv(
            envs.GymEnv("CartPole-v1"), bridge.LTLTransform(task, labels, initial_label=initial_label)
        )
    env.set_seed(0)
    torch.manual_seed(0)
    rows = env.rollout(80, break_when_any_done=False)
    assert check(rows, task, initial_label == "skip") > 1


def test_many_environments_some_of_which_are_reset() -> None:
    task = ltlc.Task(FORMULA, "two-discount")
    env = pole(task, 3)
    env.set_seed(0)
    torch.manual_seed(0)
    rows = env.rollout(80, break_when_any_done=False)
    assert [check(rows[i], task) > 1 for i in range(3)] == [True] * 3


@pytest.mark.parametrize("n", [0, 2])
def test_specs_are_right(n: int) -> None:
    envs.check_env_specs(pole(FORMULA, n))


def test_the_primer_holds_the_first_state() -> None:
    transform = bridge.LTLTransform(FORMULA, LABELS)
    env = envs.TransformedEnv(envs.GymEnv("CartPole-v1"), transform.make_tensordict_primer())
    assert env.reset()["automaton_state"].tolist() == [transform.task.tables.initial_state]


def test_losses_weigh_by_the_discount_of_each_step() -> None:
    values = importlib.import_module("torchrl.objectives.value")
    nn = importlib.import_module("tensordict.nn")
    task = ltlc.Task("G F right | G F left", "parity")
    torch.manual_seed(0)
    rows = pole(task).rollout(60, break_when_any_done=False)
    value = nn.TensorDictModule(torch.nn.Linear(task.tables.n_states, 1), ["automaton"], ["state_value"])
    estimator = values.TD0Estimator(gamma=0.9, value_network=value)
    found = estimator.value_estimate(bridge.with_discounts(rows, 0.9))
    after = rows["next"]
    with torch.no_grad():
        follows = after["discount"] * ~after["terminated"] * value.module(after["automaton"])
    assert len(after["discount"].unique()) > 1
    assert torch.allclose(found, after["reward"] + follows, atol=1e-5)


def test_wrong_input_is_told() -> None:
    with pytest.raises(InvalidArgumentError, match="choice between Rabin pairs"):
        bridge.LTLTransform(ltlc.Task("F G left | F G right", "eventual"), LABELS)
    with pytest.raises(InvalidArgumentError, match="gamma is 1"):
        bridge.with_discounts({}, 1)


def test_a_missing_library_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torchrl.data", None)
    monkeypatch.delitem(sys.modules, "ltlc.bridges.torchrl")
    with pytest.raises(MissingProgramError, match="pip install torchrl"):
        import ltlc.bridges.torchrl  # noqa: F401


def test_numpy_arrays_are_what_labels_see() -> None:
    seen: list[Any] = []
    transform = bridge.LTLTransform("F right", lambda x: seen.append(x) or set())
    envs.TransformedEnv(envs.GymEnv("CartPole-v1"), transform).reset()
    assert isinstance(seen[0], np.ndarray) and seen[0].shape == (4,)


def test_discounts_of_steps_are_warned_of() -> None:
    with pytest.warns(RewardWarning, match="say warn_discount=False, or take"):
        bridge.LTLTransform(ltlc.Task(FORMULA, "two-discount"), LABELS)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bridge.LTLTransform(ltlc.Task(FORMULA, "two-discount"), LABELS, warn_discount=False)
        bridge.LTLTransform(ltlc.Task(FORMULA, "zeta-reach"), LABELS)
