"""Arguments of a wrong type or out of range: each public function says so by an error on purpose."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ltlc
from ltlc.errors import InvalidAutomatonError
from ltlc.ltl import And, Eventually, Not, Proposition, Until

FORMULA = ltlc.parse("F a")
WORD = ltlc.parse_word("a; cycle{!a}")
DRA = ltlc.compile(FORMULA)

ODD: dict[str, Any] = {
    "nothing": None,
    "int": 3,
    "float": 2.5,
    "nan": math.nan,
    "bool": True,
    "bytes": b"F a",
    "list": ["F a"],
    "dict": {},
    "object": object(),
}
NUMBERS = ("int", "float", "nan", "bool")


def labels(observation: object) -> set[str]:
    return set()


# each takes an odd value; the kinds of value that are right for it
CALLS: dict[str, tuple[Callable[[Any], object], tuple[str, ...]]] = {
    "parse": (ltlc.parse, ()),
    "parse_word": (ltlc.parse_word, ()),
    "compile": (ltlc.compile, ()),
    "compile acceptance": (lambda x: ltlc.compile("F a", acceptance=x), ()),
    "compile translator": (lambda x: ltlc.compile("F a", translator=x), ()),
    "compile effort": (lambda x: ltlc.compile("F a", effort=x), ()),
    "compile max_states": (lambda x: ltlc.compile("F a", max_states=x), ("int",)),
    "compile timeout": (lambda x: ltlc.compile("F a", timeout=x), ("nothing", "int", "float")),
    "compile cache": (lambda x: ltlc.compile("F a", cache=x), ("nothing", "dict")),
    "compile_many": (ltlc.compile_many, ("list", "dict")),
    "compile_many formula": (lambda x: ltlc.compile_many(["F a", x]), ()),
    "compile_many max_states": (lambda x: ltlc.compile_many(["F a"], max_states=x), ("int",)),
    "compile_many timeout": (lambda x: ltlc.compile_many(["F a"], timeout=x), ("nothing", "int", "float")),
    "compile_many workers": (lambda x: ltlc.compile_many(["F a"], workers=x), ("nothing", "int")),
    "compile_many cache": (lambda x: ltlc.compile_many(["F a"], cache=x), ("nothing", "dict")),
    "compile_many progress": (lambda x: ltlc.compile_many(["F a"], progress=x), ("nothing",)),
    "load": (ltlc.load, ()),
    "satisfies formula": (lambda x: ltlc.satisfies(x, WORD), ()),
    "satisfies word": (lambda x: ltlc.satisfies(FORMULA, x), ()),
    "LassoWord prefix": (lambda x: ltlc.LassoWord(x, [{"a"}]), ("dict",)),
    "LassoWord cycle": (lambda x: ltlc.LassoWord([], x), ()),
    "LassoWord letter": (lambda x: ltlc.LassoWord([], [x]), ("list", "dict")),
    "LassoWord name": (lambda x: ltlc.LassoWord([], [(x,)]), ()),
    "DRA.save": (DRA.save, ()),
    "DRA.step state": (lambda x: DRA.step(x, {"a"}), ()),
    "DRA.step letter": (lambda x: DRA.step(0, x), ("dict",)),
    "DRA.step name": (lambda x: DRA.step(0, (x,)), ()),
    "DRA.accepts prefix": (lambda x: DRA.accepts(x, [{"a"}]), ("dict",)),
    "DRA.accepts cycle": (lambda x: DRA.accepts([], x), ()),
    "Proposition": (Proposition, ()),
    "Not": (Not, ()),
    "And": (lambda x: And(Proposition("a"), x), ()),
    "Until": (lambda x: Until(x, Proposition("a")), ()),
    "Task": (ltlc.Task, ()),
    "Task reward": (lambda x: ltlc.Task("F a", x), ()),
    "LTLWrapper env": (lambda x: ltlc.LTLWrapper(x, "F a", labels), ()),
    "LTLWrapper task": (lambda x: ltlc.LTLWrapper(gym.make("CartPole-v1"), x, labels), ()),
    "LTLVectorWrapper env": (lambda x: ltlc.LTLVectorWrapper(x, "F a", labels), ()),
    "LTLVectorWrapper task": (lambda x: ltlc.LTLVectorWrapper(gym.make_vec("CartPole-v1", 2), x, labels), ()),
}


@pytest.mark.parametrize("kind", ODD)
@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_type_is_an_error_on_purpose(call: str, kind: str) -> None:
    function, right = CALLS[call]
    if kind in right:
        function({} if kind == "dict" else ODD[kind])
        return
    with pytest.raises(ltlc.LtlcError) as caught:
        function(ODD[kind])
    message = str(caught.value)
    assert message
    assert "\n" not in message
    assert len(message) < 300


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ltlc.compile("F a", max_states="7"), "max_states is '7'; it must be a whole number"),
        (lambda: ltlc.compile("F a", max_states=math.nan), "max_states is nan; it must be a whole number"),
        (lambda: ltlc.compile("F a", max_states=math.inf), "max_states is inf; it must be a whole number"),
        (lambda: ltlc.compile("F a", max_states=True), "max_states is True; it must be a whole number"),
        (lambda: ltlc.compile("F a", max_states=0), "max_states is 0; at least 1 state is needed"),
        (lambda: ltlc.compile("F a", timeout="x"), "timeout is 'x'; it must be a positive number of seconds, or None"),
        (lambda: ltlc.compile("F a", timeout=math.nan), "timeout is nan; it must be a positive number of seconds"),
        (lambda: ltlc.compile("F a", timeout=-1), "timeout is -1; it must be a positive number of seconds"),
        (lambda: ltlc.compile(b"F a"), "the formula is b'F a'; it must be a text, or what parse returns"),
        (lambda: ltlc.compile_many("F a"), "formulas must be several: put a single one in a list"),
        (lambda: ltlc.compile_many(["F a"], workers=0), "workers is 0; at least 1 process is needed"),
        (lambda: ltlc.satisfies("F a", WORD), "formula is 'F a'; it must be what parse returns"),
        (lambda: DRA.step(0, "a"), "a letter is a set of propositions: write {'a'} instead of 'a'"),
        (lambda: DRA.step(-1, {"a"}), "state is -1; there are the states 0 to 1"),
        (lambda: DRA.step(2, {"a"}), "state is 2; there are the states 0 to 1"),
        (lambda: DRA.accepts(cycle=[]), "the cycle of a lasso word needs at least one letter"),
        (lambda: Proposition("caf\udce9"), r"the proposition 'caf\udce9' has half a character in its name"),
    ],
)
def test_the_message_says_what_is_wrong(call: Callable[[], object], message: str) -> None:
    with pytest.raises(ltlc.LtlcError) as caught:
        call()
    assert message in str(caught.value)


def test_numbers_of_numpy_are_numbers() -> None:
    dra = ltlc.compile("F a", max_states=np.int64(10), timeout=np.float32(10))
    assert dra.step(np.int32(0), {"a"}) == ltlc.compile("F a").step(0, {"a"})
    assert ltlc.compile("F a", timeout=math.inf).n_states == 2


def test_half_a_character_never_gets_into_an_automaton() -> None:
    with pytest.raises(InvalidAutomatonError, match="no text that a file could hold"):
        replace(DRA, aps=("caf\udce9",))
    assert replace(DRA, aps=("café",)).aps == ("café",)


@pytest.mark.slow
def test_formulas_that_are_too_large_end_by_a_limit_at_once() -> None:
    text = "X " * 250_000 + "a"
    with pytest.raises(ltlc.LimitExceeded, match="200000 different subformulas"):
        ltlc.compile(text)
    assert ltlc.compile(Eventually(ltlc.parse("F " * 250_000 + "a"))).n_states == 2
