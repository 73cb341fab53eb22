"""One task file is learned in every library, unchanged; what is learned is judged.

`make test-hosts` runs these tests with all the libraries but RLlib, `make test-rllib` that one.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hosts import FILE, HOSTS, LABELS, MAP, missing

import ltlc
from ltlc.envs import GridWorld

pytestmark = [pytest.mark.peer, pytest.mark.slow, pytest.mark.filterwarnings("ignore")]
QUICK = {"gymnasium", "cleanrl-style", "dqn", "maskable-ppo-vector", "pettingzoo", "torchrl"}
"""what every run of the tests trains; the others take a minute together."""


@pytest.mark.parametrize("name", HOSTS)
def test_a_host_learns_the_task(name: str) -> None:
    if name not in QUICK and "LTLC_HOSTS" not in os.environ:
        pytest.skip("make test-hosts, or make test-rllib")
    absent = missing(HOSTS[name])
    if absent:
        pytest.skip(f"{absent} is not installed")
    learned = HOSTS[name].run()
    assert learned.value >= HOSTS[name].least
    assert learned.low <= learned.value <= learned.high


def test_the_file_is_that_of_its_formula() -> None:
    automaton = ltlc.load(FILE)
    assert automaton.formula == "!pit U (key & !pit U goal)"
    assert ltlc.compile(automaton.formula).to_json() == Path(FILE).read_text(encoding="utf-8")
    best = ltlc.Judge(GridWorld(MAP, labels=LABELS, slip=0.1, actions=4).labelled_mdp(), ltlc.Task(automaton)).maximum
    assert best.probability > 0.96
