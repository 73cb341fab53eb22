"""Huge formulas: seconds, little memory, no recursion."""

from __future__ import annotations

import copy
import os
import pickle
import random
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from random_ltl import random_formula

from ltlc.ltl import (
    Formula,
    Proposition,
    nnf,
    parse,
    simplify,
)

a, b, c, d = map(Proposition, "abcd")


N = 10_000
HUGE = {
    "brackets": "(" * N + "a" + ")" * N,
    "negations": "!" * N + "a",
    "next": "X" * N + "a",
    "mixed unary": "!X" * (N // 2) + "a",
    "conjunction": " & ".join(f"a{i}" for i in range(N)),
    "disjunction of F": " | ".join(f"F a{i}" for i in range(N)),
    "implications": " -> ".join(["a"] * N),
    "left implications": "(" * N + "a" + " -> b)" * N,
    "right U": "a U " * N + "b",
    "left U": "(" * N + "a" + " U b)" * N,
    "and or": "".join(f"a{i} & (b{i} | " for i in range(N // 2)) + "c" + ")" * (N // 2),
}


@pytest.mark.parametrize("name", HUGE)
def test_huge_formulas_take_seconds_not_recursion(name: str) -> None:
    start = time.process_time()
    formula = parse(HUGE[name])
    assert parse(str(formula)) is formula
    assert isinstance(nnf(formula), Formula)
    simple = simplify(formula)
    assert isinstance(simple, Formula)
    assert pickle.loads(pickle.dumps(formula)) is formula
    assert copy.deepcopy(formula) is copy.copy(formula) is formula
    del formula, simple
    assert time.process_time() - start < 20


@pytest.mark.parametrize("transfer", [copy.copy, copy.deepcopy, lambda f: pickle.loads(pickle.dumps(f))])
def test_copies_are_the_same_object(transfer: Callable[[Formula], Formula]) -> None:
    rng = random.Random(3)
    for _ in range(50):
        formula = random_formula(rng, 12)
        assert transfer(formula) is formula


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
@pytest.mark.parametrize(
    "text", ["'F' * 10**6 + 'a'", "'!' * 10**6 + 'a'", "'\"' + 'a' * 10**6 + '\"'", "'(' * 10**6 + 'a' + ')' * 10**6"]
)
def test_a_million_characters_take_seconds_and_little_memory(text: str) -> None:
    code = f"""
import pathlib, re, time, ltlc
dra = ltlc.compile({text})
peak = re.search(r"VmHWM:\\s*(\\d+)", pathlib.Path("/proc/self/status").read_text())[1]
print(dra.n_states, time.process_time(), peak)
"""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    n_states, seconds, memory = map(float, done.stdout.split())
    assert n_states <= 3
    assert seconds < 20  # a guard against quadratic time, which would take an hour
    assert memory < 500 * 2**10
