"""Words on the command line become what their key asks for, or are refused."""

from __future__ import annotations

from typing import Any

import pytest

from ltlc.agents import AGENTS, DQNConfig
from ltlc.cli.values import assignments, kinds_of
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.rewards import SCHEMES

KINDS = kinds_of(DQNConfig)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *[(f"batch_norm={word}", True) for word in ("on", "yes", "true", "True", "YES")],
        *[(f"double={word}", False) for word in ("off", "no", "false", "False", "Off")],
        ("batch-size=64", 64),
        ("batch_size=1_000", 1_000),
        ("learning_rate=1e-4", 1e-4),
        ("tau=1", 1),
        ("hidden=64,64", (64, 64)),
        ("hidden=[64, 64]", (64, 64)),
        ("hidden=128", (128,)),
        ("hidden=none", None),
        ("reward_scale=null", None),
        ("threads=2", 2),
        ("optimizer=sgd", "sgd"),
        ('state_input="one-hot"', "one-hot"),
        ("device=cuda:1", "cuda:1"),
    ],
)
def test_a_value_is_of_the_kind_of_its_key(text: str, value: object) -> None:
    found = assignments([text], "--hyper", KINDS)
    key = text.partition("=")[0].replace("-", "_")
    assert found == {key: value} and type(found[key]) is type(value)
    DQNConfig.from_dict(found)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("batch_norm=maybe", "batch_norm is 'maybe'; it must be on or off"),
        ("double=0", "double is '0'; it must be on or off"),
        ("double=", "double is ''; it must be on or off"),
        ("batch_size=many", "batch_size is 'many'; it must be a whole number"),
        ("batch_size=2.5", "must be a whole number"),
        ("batch_size=true", "must be a whole number"),
        ("learning_rate=fast", "learning_rate is 'fast'; it must be a number"),
        ("reward_scale=big", "it must be a number or none"),
        ("threads=no", "it must be a whole number or none"),
        ("hidden=wide", "it must be a list, such as 64,64 or none"),
        ("seed", "expected KEY=VALUE"),
        ("=3", "expected KEY=VALUE"),
        ("batch_size=" + "9" * 5_000, "batch_size is '9999"),
    ],
)
def test_other_values_are_refused(text: str, words: str) -> None:
    with pytest.raises(InvalidArgumentError, match=words) as caught:
        assignments([text], "--hyper", KINDS)
    assert len(str(caught.value)) < 200


def test_choices_get_a_suggestion_and_a_key_comes_once() -> None:
    with pytest.raises(UnknownNameError, match=r"value of state_input 'heds'\. Did you mean heads"):
        assignments(["state_input=heds"], "--hyper", KINDS)
    with pytest.raises(InvalidArgumentError, match="--hyper gives tau twice"):
        assignments(["tau=.1", "tau=.2"], "--hyper", KINDS)


@pytest.mark.parametrize(
    ("text", "value"), [("3", 3), ("[1, 2]", [1, 2]), ("True", True), ("None", None), ("4x4", "4x4"), ("off", "off")]
)
def test_without_a_kind_it_is_what_it_looks_like(text: str, value: Any) -> None:
    assert assignments([f"x={text}"], "--env-set") == {"x": value}


@pytest.mark.parametrize("fields", [*SCHEMES.values(), *dict.fromkeys(type(AGENTS[name].defaults) for name in AGENTS)])
def test_the_default_of_every_key_can_be_typed(fields: type[Any]) -> None:
    kinds, made = kinds_of(fields), fields()
    for key in kinds:
        value = getattr(made, key)
        assert assignments([f"{key}={value}"], "--set", kinds) == {key: value}
