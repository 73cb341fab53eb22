"""Reward schemes against the rules they come from, and the automaton forms they ask for."""

from __future__ import annotations

import itertools
import pickle
import random
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from random_ltl import random_formula
from rewards_reference import buchi_automaton, random_automaton, thesis_step

import ltlc
from ltlc.automata import DRA
from ltlc.automata.compare import equivalent
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.rewards import SCHEMES, RewardTables, Shaped, get_scheme, shape
from ltlc.rewards.forms import buchi_marks, parity_colours, relevant_marks
from ltlc.rewards.frontier import Frontier
from ltlc.rewards.thesis import Thesis

MODES = ("stay", "initial", "terminate")
BUCHI_SCHEMES = ("accept", "zeta-reach", "zeta-discount", "two-discount", "eventual", "frontier", "parity")


def gf_a(n_pairs: int = 1) -> DRA:
    """One state, G F a, with Inf on the letter that has a."""
    marks = np.array([[[False, True]]] * n_pairs)
    return DRA(("a",), [[0, 0]], [0, 1], np.zeros_like(marks), marks, acceptance="transition", formula="GF a")


def two_pairs() -> DRA:
    """FG a | FG b: needs both pairs, and is of no parity form on its structure."""
    fin = np.array([[[True, False, True, False]], [[True, True, False, False]]])
    inf = np.ones_like(fin)
    return DRA(("a", "b"), [[0, 0, 0, 0]], [0, 1, 2, 3], fin, inf, acceptance="transition", formula="FG a | FG b")


def until() -> DRA:
    """!b U a: waiting 0, accepting sink 1, deadlock 2."""
    delta = [[0, 1, 2, 1], [1, 1, 1, 1], [2, 2, 2, 2]]
    return DRA(("a", "b"), delta, [0, 1, 2, 3], [[False] * 3], [[False, True, False]], formula="!b U a")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("terminate_on_accept", [True, False])
def test_thesis_rewards_follow_the_rules_step_by_step(mode: str, terminate_on_accept: bool) -> None:
    scheme = Thesis(accepting=5.0, terminal=50.0, terminate_on_accept=terminate_on_accept)
    for seed in range(40):
        dra = random_automaton(seed, acceptance=("state", "transition")[seed % 2], n_pairs=1 + seed % 3)
        tables = scheme.compile(dra, on_deadlock=mode)
        for q, letter in itertools.product(range(dra.n_states), range(4)):
            at = q, dra.letter_class[letter]
            reward, after, ends = thesis_step(dra, q, letter, mode, scheme.parameters)
            assert (tables.reward[at], tables.next_state[at], tables.stop[at]) == (reward, after, float(ends))
            assert tables.violated[at] == (dra.delta[at] in dra.deadlocks)


def test_a_violation_is_paid_for_though_the_state_is_reset() -> None:
    tables = get_scheme("thesis").compile(until())
    assert (tables.reward[0, 2], tables.next_state[0, 2], tables.stop[0, 2]) == (-100, 0, 0)


def test_thesis_code_pays_for_the_goal_and_starts_over_after_a_deadlock() -> None:
    scheme = get_scheme("thesis-code")
    assert (scheme.terminal, scheme.accepting, scheme.on_deadlock) == (100, 10, "initial")
    assert scheme.compile(until()).next_state[0, 2] == 0


@pytest.mark.parametrize("name", sorted(SCHEMES))
def test_rewards_do_not_ask_where_an_automaton_came_from(name: str, tmp_path: Path) -> None:
    """The same automaton translated, read from JSON, read from HOA and written down by hand (W4)."""
    for formula in ("F(a & F b) & G !c & FG d", "FG a | GF b & X X c", "a U (b & FG c)"):
        dra = ltlc.compile(formula)
        tables = get_scheme(name).compile(dra)
        others = [replace(dra, translator=None, formula=None), replace(dra, translator="another tool")]
        for suffix in ("json", "hoa"):
            dra.save(tmp_path / f"dra.{suffix}")
            others.append(ltlc.load(tmp_path / f"dra.{suffix}"))
        for other in others:
            again = get_scheme(name).compile(other)
            for field in fields(tables):
                assert np.array_equal(getattr(tables, field.name), getattr(again, field.name)), (formula, field.name)


@pytest.mark.slow
def test_translated_automata_have_no_fin_marks_where_their_pair_cannot_accept() -> None:
    """So the thesis' rewards do not depend on how a construction marks transient states."""
    rng = random.Random(2)
    for _ in range(150):
        dra = ltlc.compile(random_formula(rng, rng.randint(3, 12)))
        component = np.array(dra.annotations.scc)
        relevant = relevant_marks(dra)[0]
        inside = component[:, None] == component[dra.delta]
        assert not (dra.edge_fin & ~relevant & inside).any(), dra.formula


def test_thesis_pays_for_the_marks_there_are() -> None:
    """A Fin mark where the pair cannot accept is paid like any other, as ltl2dstar's are in the thesis."""
    transient = DRA(("a",), [[0, 1], [1, 1]], [0, 1], [[True, False]], [[False, True]])
    assert get_scheme("thesis").compile(transient).reward[0, 0] == -10


@pytest.mark.parametrize("name", BUCHI_SCHEMES)
def test_an_accepting_sink_is_worth_what_staying_there_would_be(name: str) -> None:
    """Entering the sink ends the episode and pays the value of the same scheme on GF true, computed by iteration."""
    scheme = get_scheme(name)
    paid = scheme.compile(until())
    assert paid.stop[0, 1] == 1
    forever = scheme.steps(gf_a())
    acc = (0, 1)
    reward, discount, stop, bonus = (
        np.broadcast_to(part, (1, 2))[acc]
        for part in (forever.reward, forever.discount, forever.stop, forever.stop_reward)
    )
    value = (reward + stop * bonus) / (1 - discount * (1 - stop))
    assert paid.reward[0, 1] == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(("name", "reward", "discount"), [
    ("accept", (0, 1), (0.99, 0.99)),
    ("sadigh", (0, 1), (0.99, 0.99)),
    ("zeta-discount", (0, 1), (1, 0.99)),
    ("eventual", (0, 1), (1, 0.99)),
    ("frontier", (0, 1), (1, 0.99)),
    ("two-discount", (0, 0.01), (0.99999, 0.99)),
    ("parity", (-0.0001, 0.01), (0.9999, 0.99)),
])  # fmt: skip
def test_rewards_of_gf_a(name: str, reward: tuple[float, float], discount: tuple[float, float]) -> None:
    tables = get_scheme(name).compile(gf_a())
    assert tables.reward[0] == pytest.approx(reward)
    assert tables.discount[0] == pytest.approx(discount)
    assert not tables.stop.any()
    assert tables.accepted.tolist() == [[False, True]]


def test_zeta_reach_ends_by_chance_and_pays_only_then() -> None:
    tables = get_scheme("zeta-reach", zeta=0.9).compile(gf_a())
    assert tables.stop[0] == pytest.approx((0, 0.1))
    assert (tables.reward == 0).all()
    assert (tables.stop_reward == 1).all()
    assert tables.expected_reward[0] == pytest.approx((0, 0.1))
    assert tables.expected_discount[0] == pytest.approx((1, 0.9))
    assert not tables.terminal.any()


def test_parity_by_termination() -> None:
    tables = get_scheme("parity", mode="terminate", epsilon=0.1).compile(gf_a())
    assert tables.stop[0] == pytest.approx((0.01, 0.1))
    assert tables.stop_reward[0].tolist() == [0, 1]


def test_sadigh_weighs_one_pair() -> None:
    assert get_scheme("sadigh").compile(two_pairs()).n_choices == 2
    tables = get_scheme("sadigh", pair=1, weight_fin=7.0).compile(two_pairs())
    assert tables.reward[0].tolist() == [-7, -7, 1, 1]
    with pytest.raises(InvalidArgumentError, match="pair 5 of an automaton with 2"):
        get_scheme("sadigh", pair=5).compile(two_pairs())


@pytest.mark.parametrize("name", [name for name in BUCHI_SCHEMES if name != "frontier"])
def test_steps_take_only_the_form_the_scheme_needs(name: str) -> None:
    with pytest.raises(InvalidArgumentError, match=r"FG a \| FG b .* has not; `compile` brings it into that form"):
        get_scheme(name).steps(two_pairs())
    assert get_scheme(name).compile(two_pairs()).n_choices == (0 if name == "parity" else 2)


def test_one_pair_of_no_buchi_form_can_use_parity_rewards() -> None:
    fg = DRA(("a",), [[0, 0]], [0, 1], [[[1, 0]]], [[[0, 1]]], acceptance="transition", formula="FG a")
    assert get_scheme("parity").compile(fg).reward[0] == pytest.approx((-0.01, 0.0001))


@pytest.mark.slow
def test_buchi_and_parity_forms_keep_the_language() -> None:
    found = {"büchi": 0, "parity": 0, "neither": 0}
    for seed in range(250):
        dra = random_automaton(
            seed, n_states=2 + seed % 3, n_pairs=1 + seed % 3, density=0.4, acceptance=("state", "transition")[seed % 2]
        )
        fin, inf = relevant_marks(dra)
        relevant = DRA(dra.aps, dra.delta, dra.letter_class, fin, inf, acceptance="transition")
        assert equivalent(dra, relevant)
        marks, colours = buchi_marks(dra), parity_colours(dra)
        if marks is not None:
            found["büchi"] += 1
            assert equivalent(dra, buchi_automaton(dra, marks))
        if colours is not None:
            found["parity"] += 1
            odd = range(1, int(colours.max()) + 2, 2)
            chain = DRA(
                dra.aps, dra.delta, dra.letter_class,
                [colours > c for c in odd], [colours >= c for c in odd], acceptance="transition",
            )  # fmt: skip
            assert equivalent(dra, chain)
        else:
            found["neither"] += 1
    assert min(found.values()) > 10, found


def test_a_buchi_type_automaton_is_recognised_however_its_pairs_are_written() -> None:
    """GF a & GF !a as two pairs on a structure where each pair alone is too much."""
    delta = [[0, 1], [0, 1]]
    dra = DRA(("a",), delta, [0, 1], [[True, False]], [[False, True]], formula="FG a")
    assert buchi_marks(dra) is None
    twice = DRA(("a",), delta, [0, 1], [[0, 0], [1, 0]], [[1, 0], [0, 1]], formula="GF !a | FG a")
    marks = buchi_marks(twice)
    assert marks is not None
    assert marks.all()  # the language is everything


def test_frontier_pays_each_set_once_per_round() -> None:
    dra = DRA(("a",), [[0, 1], [0, 1]], [0, 1], [[False, False]], [[True, True]])
    tables = Frontier(sets=(frozenset({0}), frozenset({1}))).compile(dra)
    state, paid = tables.initial_state, []
    for letter in (0, 0, 1, 1, 0, 1, 0, 0):
        paid.append(tables.accepted[state, letter])
        state = tables.next_state[state, letter]
        assert tables.automaton_state[state] == letter
    assert paid == [1, 0, 1, 1, 1, 1, 1, 1]
    with pytest.raises(InvalidArgumentError, match=r"outside 0..1"):
        Frontier(sets=(frozenset({2}),)).compile(dra)
    with pytest.raises(InvalidArgumentError, match="0 sets"):
        Frontier(sets=())


@pytest.mark.parametrize("name", list(SCHEMES))
def test_shaping_keeps_every_policy_value_up_to_the_potential_of_the_start(name: str) -> None:
    rng = np.random.default_rng(5)
    for dra in (until(), gf_a()):
        tables = get_scheme(name).compile(dra)
        plain = replace(tables, discount=np.minimum(tables.discount, 0.999))  # so that all values are finite
        potential = 3.0 * plain.progress
        letters = rng.dirichlet(np.ones(dra.n_classes), size=dra.n_states)  # a policy, as letters it makes likely

        def value(tables: RewardTables, letters: np.ndarray = letters) -> np.ndarray:
            step = np.zeros((tables.n_states, tables.n_states))
            for q, c in itertools.product(range(tables.n_states), range(tables.n_classes)):
                step[q, tables.next_state[q, c]] += letters[q, c] * tables.expected_discount[q, c]
            return np.linalg.solve(np.eye(len(step)) - step, (letters * tables.expected_reward).sum(axis=1))

        assert value(plain) - value(shape(plain, potential)) == pytest.approx(potential, abs=1e-9)


def test_shaping_telescopes_along_any_run() -> None:
    """The discounted sum of shaping terms is -Phi(start), plus what is left where the run is cut off."""
    rng = np.random.default_rng(2)
    for seed in range(30):
        dra = random_automaton(seed)
        tables = Thesis().compile(dra, on_deadlock=MODES[seed % 3])
        potential = rng.normal(size=dra.n_states)
        shaped = shape(tables, potential)
        state = start = tables.initial_state
        weight, total = 1.0, 0.0
        for c in rng.integers(0, 4, 50):
            total += weight * (shaped.reward[state, c] - tables.reward[state, c])
            weight *= tables.discount[state, c]
            stopped = tables.stop[state, c] == 1
            state = tables.next_state[state, c]
            if stopped:
                assert total == pytest.approx(-potential[start])
                break
        else:
            assert total == pytest.approx(weight * potential[state] - potential[start])


def test_shaping_of_a_step_that_ends_by_chance_is_right_in_both_outcomes() -> None:
    potential = np.array([2.0])
    shaped = shape(get_scheme("zeta-reach", zeta=0.9).compile(gf_a()), potential)
    assert shaped.reward[0] == pytest.approx((0, 0))  # going on: 0 + 2 - 2
    assert shaped.reward[0, 1] + shaped.stop_reward[0, 1] == pytest.approx(1 - 2)  # ending: 1 + 0 - 2


def test_progress_falls_with_the_letters_to_an_accepting_cycle() -> None:
    tables = get_scheme("thesis").compile(until())
    assert tables.progress.tolist() == [0.5, 1, 0]


def test_every_scheme_introduces_itself() -> None:
    for name, scheme in SCHEMES.items():
        assert scheme.name == name
        assert "doi" in scheme.citation or "https" in scheme.citation
        assert scheme.guarantee.endswith(".")
        assert scheme.requires
        made = get_scheme(name)
        assert set(made.parameters) >= set()
        assert pickle.loads(pickle.dumps(made)) == made
    assert get_scheme("thesis", shaping=2.0) == Shaped(Thesis(), 2.0)


@pytest.mark.parametrize(("call", "message"), [
    (lambda: get_scheme("zeta-reech"), "unknown reward scheme 'zeta-reech'. Did you mean zeta-reach"),
    (lambda: get_scheme("zeta-reach", zetta=0.9), "scheme 'zeta-reach': 'zetta'. Did you mean zeta"),
    (lambda: get_scheme("zeta-reach", zeta=1.0), "zeta is 1.0; it must lie strictly between 0 and 1"),
    (lambda: get_scheme("thesis", gamma=1.5), r"gamma is 1.5; it must lie in \(0, 1\]"),
    (lambda: get_scheme("thesis", gamma=float("nan")), "gamma is nan"),
    (lambda: get_scheme("parity", mode="adaptve"), "mode of the parity scheme 'adaptve'. Did you mean adaptive"),
    (lambda: get_scheme("thesis", shaping=float("inf")), "shaping weight is inf"),
    (lambda: get_scheme("thesis").compile(gf_a(), on_deadlock="stop"), "unknown deadlock mode 'stop'"),
])  # fmt: skip
def test_wrong_arguments_are_named(call: object, message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        call()


@pytest.mark.parametrize(("field", "value", "message"), [
    ("reward", np.full((1, 2), np.nan), "reward has an entry that is not finite"),
    ("discount", [[0.5, 1.5]], r"discount has an entry outside \[0, 1\]"),
    ("stop", [[0.5, np.nan]], r"stop has an entry outside \[0, 1\]"),
    ("next_state", [[0, 1]], "next_state leads outside the states"),
    ("letter_class", [0, 2], "letter_class names a class that has no column"),
    ("letter_class", [0, 1, 1], r"letter_class has shape \(3,\), expected \(2,\)"),
    ("reward", [0.0, 1.0], r"reward has shape \(2,\), expected \(1, 2\)"),
    ("initial_state", 3, "initial state 3 of 1 states"),
    ("progress", [2.0], "progress has an entry outside"),
])  # fmt: skip
def test_tables_are_validated(field: str, value: object, message: str) -> None:
    tables = get_scheme("thesis").compile(gf_a())
    fields = {name: getattr(tables, name) for name in tables.__dataclass_fields__}
    with pytest.raises(InvalidArgumentError, match=message):
        RewardTables(**{**fields, field: value})


def test_tables_are_frozen() -> None:
    tables = get_scheme("thesis").compile(gf_a())
    with pytest.raises(ValueError, match="read-only"):
        tables.reward[0, 0] = 1


def test_unknown_scheme_is_an_unknown_name() -> None:
    with pytest.raises(UnknownNameError):
        get_scheme("none")
