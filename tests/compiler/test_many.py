"""Many formulas at once: the same automata as one by one, each shape translated once."""

from __future__ import annotations

import random

import pytest

import ltlc
from ltlc.compiler import canonical_propositions
from ltlc.errors import InvalidArgumentError, LtlSyntaxError, StateLimitExceeded

FORMULAS = ["F goal & G !trap", "F(x & F y)", "F(b & F a)", "GF a & GF b", "F(x & F x)", "F exit & G !fire", "true"]


def reach_avoid(rng: random.Random, depth: int) -> str:
    """A sequence of places to reach, each while avoiding others, as in multi-task training."""
    names = [f"p{i}" for i in range(12)]
    task = ""
    for _ in range(depth):
        reach, *avoid = rng.sample(names, rng.randint(1, 3))
        goal = f"({reach} & {task})" if task else reach
        task = f"(!({' | '.join(avoid)}) U {goal})" if avoid else f"F {goal}"
    return task


def test_same_as_one_by_one() -> None:
    together = ltlc.compile_many(FORMULAS, acceptance="transition")
    assert [a.to_json() for a in together] == [ltlc.compile(f, acceptance="transition").to_json() for f in FORMULAS]


@pytest.mark.slow
def test_same_with_processes() -> None:
    rng = random.Random(5)
    formulas = [reach_avoid(rng, 3) for _ in range(80)]
    alone = ltlc.compile_many(formulas)
    assert [a.to_hoa() for a in ltlc.compile_many(formulas, workers=2)] == [a.to_hoa() for a in alone]


@pytest.mark.slow
def test_processes_report_progress_and_stop_at_the_first_error() -> None:
    rng = random.Random(6)
    formulas = [reach_avoid(rng, 3) for _ in range(90)]
    seen: list[tuple[int, int]] = []
    ltlc.compile_many(formulas, workers=2, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i + 1, len(seen)) for i in range(len(seen))]
    assert 64 <= len(seen) <= 90  # enough shapes for two processes
    with pytest.raises(LtlSyntaxError, match="has no right operand"):
        ltlc.compile_many([*formulas, "a &"], workers=2)
    with pytest.raises(StateLimitExceeded, match="needs more than 2 states"):
        ltlc.compile_many(formulas, workers=2, max_states=2)


def test_shapes_are_shared() -> None:
    assert canonical_propositions(ltlc.parse("F(x & F y)"))[0] is canonical_propositions(ltlc.parse("F(b & F a)"))[0]
    assert (
        canonical_propositions(ltlc.parse("F(x & F y)"))[0] is not canonical_propositions(ltlc.parse("F(x & F x)"))[0]
    )
    seen: list[tuple[int, int]] = []
    ltlc.compile_many(FORMULAS, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(i, 5) for i in range(1, 6)]


def test_cache_serves_both_doors() -> None:
    cache: ltlc.compiler.Cache = {}
    first = ltlc.compile("F(a & F b)", cache=cache)
    assert len(cache) == 1
    again = ltlc.compile("F(y & F x)", cache=cache)
    assert len(cache) == 1
    assert (again.aps, again.formula) == (("y", "x"), "F(y & F x)")
    assert again.to_json() == ltlc.compile("F(y & F x)").to_json()
    assert ltlc.compile_many(["F(a & F b)"], cache=cache)[0].to_json() == first.to_json()
    ltlc.compile("F(a & F b)", acceptance="transition", cache=cache)
    assert len(cache) == 2


def test_errors_name_the_formula() -> None:
    with pytest.raises(LtlSyntaxError):
        ltlc.compile_many(["a", "a &"])
    with pytest.raises(StateLimitExceeded, match="F a & F b & F c needs more than 3 states"):
        ltlc.compile_many(["a", "F a & F b & F c"], max_states=3)
    with pytest.raises(InvalidArgumentError, match="timeout is -1"):
        ltlc.compile_many(["a"], timeout=-1)


@pytest.mark.parametrize("formula", ["F(a & G b) | G c", "G(a -> F b)", "F(a & F b) & G !c & FG d"])
def test_effort(formula: str) -> None:
    fast, default = (ltlc.compile(formula, effort=e, acceptance="transition") for e in ("fast", "default"))
    assert default.n_states <= fast.n_states
    with pytest.raises(InvalidArgumentError, match="effort is 'most'"):
        ltlc.compile(formula, effort="most")  # type: ignore[arg-type]


def test_finite_traces() -> None:
    texts = ["F(a & last)", "F(b & last)", "G(a -> WX b)", "F a & X last"]
    many = ltlc.compile_many(texts, finite=True)
    single = [ltlc.compile(text, finite=True) for text in texts]
    for one, other in zip(many, single, strict=True):
        assert (one.to_json(), one.formula) == (other.to_json(), other.formula)
    assert [dfa.aps for dfa in many[:2]] == [("a",), ("b",)]
    with pytest.raises(LtlSyntaxError):
        ltlc.compile_many(["F(a & last"], finite=True)
