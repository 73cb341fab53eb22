"""Tasks over finite traces: when they are satisfied, in episodes and exactly."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ltlc
from ltlc.automata import DFA, DRA
from ltlc.automata.finite import END, Goal, end_letter, spoken
from ltlc.errors import AlphabetLimitExceeded, InvalidArgumentError, InvalidAutomatonError
from ltlc.mdp import Judge, LabelledMDP

FORMULAS = ("F a & G !b", "a U last", "G(a -> WX b)", "F(b & Y a)", "true", "X X true", "F(last & O a)", "a <-> F b")


class Coins(gym.Env[Any, Any]):
    """Letters are tossed; every action has its own coins, and the episode ends by chance."""

    observation_space, action_space = gym.spaces.MultiBinary(2), gym.spaces.Discrete(2)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        return self.toss(0), {}

    def toss(self, action: int) -> Any:
        return (self.np_random.random(2) < (0.7 if action else 0.3)).astype(np.int8)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        return self.toss(action), 0.0, bool(self.np_random.random() < 0.2), bool(self.np_random.random() < 0.05), {}


LABELS = {"a": lambda coins: bool(coins[0]), "b": lambda coins: bool(coins[1])}


def letter(coins: Any) -> set[str]:
    return {name for name, coin in zip("ab", coins, strict=True) if coin}


def dfa_of(text: str) -> DFA:
    return ltlc.compile(f"({text}) & (a | !a) & (b | !b)", finite=True)


@pytest.mark.parametrize("goal", ["reach", "end"])
@pytest.mark.parametrize("text", FORMULAS)
def test_episodes_are_satisfied_as_the_goal_says(text: str, goal: Goal) -> None:
    dfa = dfa_of(text)
    env = ltlc.LTLWrapper(Coins(), ltlc.Task(dfa, goal=goal), LABELS, success_key=True)
    rng = np.random.default_rng(1)
    for episode in range(40):
        observation, info = env.reset(seed=episode)
        trace, over = [letter(observation["observation"])], False
        while not over:
            observation, _, ended, truncated, info = env.step(int(rng.integers(2)))
            trace.append(letter(observation["observation"]))
            over = ended or truncated
            assert info["ltl"]["label_names"] - {END} == trace[-1]
        automaton = env.task.automaton
        won = env.automaton_state in automaton.accepting_sinks
        if goal == "reach":
            # Where every way to go on leads there, it counts as reached.
            assert won >= any(dfa.accepts(trace[:i]) for i in range(1, len(trace) + 1))
        elif END in info["ltl"]["label_names"]:
            assert won == dfa.accepts(trace)
            assert won or env.automaton_state in automaton.deadlocks
        else:
            assert not won


@pytest.mark.parametrize("mode", list(gym.vector.AutoresetMode)[:2])
@pytest.mark.parametrize("text", ["F a & G !b", "G(a -> WX b)"])
def test_many_environments_at_once(text: str, mode: gym.vector.AutoresetMode) -> None:
    dfa = dfa_of(text)
    base = gym.vector.SyncVectorEnv([Coins] * 5, autoreset_mode=mode)
    task = ltlc.Task(dfa, goal="end", reward="two-discount", on_deadlock="stay")
    envs = ltlc.LTLVectorWrapper(base, task, LABELS, success_key=True)
    rng = np.random.default_rng(2)
    observations, _ = envs.reset(seed=3)
    traces = [[letter(coins)] for coins in observations["observation"]]
    checked = 0
    begun = np.zeros(5, dtype=bool)
    for _ in range(120):
        observations, _, ended, truncated, infos = envs.step(rng.integers(2, size=5))
        same_step = mode == gym.vector.AutoresetMode.SAME_STEP
        for i in range(5):
            if begun[i]:
                traces[i] = [letter(observations["observation"][i])]
                continue
            over = bool(ended[i] or truncated[i])
            final = infos["final_obs"][i] if same_step and over else None
            coins = observations["observation"][i] if final is None else final["observation"]
            traces[i].append(letter(coins))
            ltl = infos["final_info"]["ltl"] if final is not None else infos["ltl"]
            if ltl["base_terminated"][i]:
                won = dfa.accepts(traces[i])
                assert bool(ltl["success"][i]) == won
                checked += 1
            if final is not None:
                traces[i] = [letter(observations["observation"][i])]
        begun = (ended | truncated) & (not same_step)
    assert checked > 20


def random_model(rng: np.random.Generator) -> LabelledMDP:
    """Six states with random letters, of which the last two end the episode."""
    matrices = rng.dirichlet(np.full(6, 0.4), size=(2, 6))
    matrices[:, 4:] = np.eye(6)[4:]
    labels = {q: [name for name in "ab" if rng.random() < 0.5] for q in range(6)}
    return LabelledMDP.from_arrays(matrices, aps=["a", "b"], labels=labels, terminal=np.arange(6) >= 4)


def most_probable_end(model: LabelledMDP, dfa: DFA) -> float:
    """By value iteration on pairs of a state and an automaton state, from the definition."""
    matrices = [np.asarray(matrix.todense()) for matrix in model.transitions]
    letters = [
        {name for i, name in enumerate(model.aps) if model.letters[int(row.argmax())] >> i & 1}
        for row in np.asarray(model.label_probability.todense())
    ]
    after = [[dfa.step(q, letters[s]) for s in range(6)] for q in range(dfa.n_states)]
    value = np.zeros((6, dfa.n_states))
    value[4:] = dfa.accepting
    for _ in range(3000):
        for s in range(4):
            for q in range(dfa.n_states):
                value[s, q] = max(sum(m[s, t] * value[t, after[q][t]] for t in range(6)) for m in matrices)
    start = int(np.flatnonzero(model.start)[0])
    return float(value[start, after[dfa.initial_state][start]])


@pytest.mark.slow
@pytest.mark.parametrize("text", FORMULAS)
def test_exact_probability_of_ending_well(text: str) -> None:
    rng = np.random.default_rng(4)
    dfa = dfa_of(text)
    for _ in range(3):
        model = random_model(rng)
        judge = Judge(model, ltlc.Task(dfa, goal="end"))
        assert judge.maximum.probability == pytest.approx(most_probable_end(model, dfa), abs=1e-6)


def test_the_automaton_of_an_end() -> None:
    automaton = ltlc.Task("F a & last", finite=True, goal="end").automaton
    assert isinstance(automaton, DRA)
    assert automaton.aps == ("a", END)
    assert automaton.formula == "end(F a & WX false)"
    assert spoken(automaton.aps) == ("a",)
    four = automaton.letter_class
    assert [end_letter(aps, four) for aps in (automaton.aps, ("a", "b"), (END, "a"))] == [2, 0, 0]
    assert not automaton.accepts(cycle=[{"a"}])
    assert automaton.accepts([{"a", END}], [set()])
    assert not automaton.accepts([set(), {"a", END}], [set()])


def test_errors() -> None:
    dfa = ltlc.compile("F a", finite=True)
    with pytest.raises(InvalidArgumentError, match="goal is 'start'; it can be 'reach' or 'end'"):
        dfa.with_goal("start")  # type: ignore[arg-type]
    with pytest.raises(InvalidAutomatonError, match="listed twice"):
        ltlc.compile(f'F "{END}"', finite=True).ended()
    with pytest.raises(AlphabetLimitExceeded):
        DFA(tuple(f"p{i}" for i in range(21)), np.zeros((1, 1)), np.zeros(2**21), np.ones(1)).ended()
