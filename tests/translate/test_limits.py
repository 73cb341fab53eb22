"""Limits on states and on time: they hold at every place, and end in the right error, compiled or not."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from itertools import count

import pytest

import ltlc
from ltlc.automata import DRA, equivalent, parity_colours, to_parity
from ltlc.automata.rabin import AcceptanceKind
from ltlc.budget import Overtime, check_time, has_time, overtime, time_left, time_limit
from ltlc.errors import InvalidArgumentError, LimitExceeded, StateLimitExceeded, TimeLimitExceeded
from ltlc.formats import from_hoa, from_json, to_dot, to_hoa, to_json, to_mermaid
from ltlc.ltl import Formula, Proposition, Xor, parse, parse_word, satisfies
from ltlc.minimize import to_state_based
from ltlc.translate import TRANSLATORS, Options, translate

TICK = 0.01
"""seconds from one question for the time to the next."""
HOA, JSON = (write(translate(parse("F(a & X F b) & GF c"))) for write in (to_hoa, to_json))
MIXED = (
    "G(c -> ((F a1 & F a2) U b))",
    "(a U X b) R (c | F(d & G a))",
    "GF(a & X b) <-> FG(c W a)",
    "(a M (b | X c)) & G(a -> F d)",
    "F p0 xor F p1 xor GF p2",
)


def build(text: str, translator: str, acceptance: AcceptanceKind, **limits: float | None) -> DRA | None:
    """The automaton, or None where the construction does not apply."""
    try:
        return translate(parse(text), Options(translator=translator, acceptance=acceptance, **limits))  # type: ignore[arg-type]
    except InvalidArgumentError:
        return None


@pytest.mark.slow
@pytest.mark.parametrize("translator", ["auto", *TRANSLATORS])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_the_limit_on_states_holds_at_every_place(translator: str, acceptance: AcceptanceKind) -> None:
    n_raised = n_built = 0
    for text in MIXED:
        for max_states in (1, 2, 3, 4, 6, 9, 14, 25, 60):
            try:
                automaton = build(text, translator, acceptance, max_states=max_states)
            except StateLimitExceeded as error:
                assert len(str(error)) < 200
                n_raised += 1
            else:
                assert automaton is None or automaton.n_states <= max_states
                n_built += automaton is not None
    assert translator == "obligation" or (n_raised and n_built)


@pytest.mark.slow
@pytest.mark.parametrize("translator", ["auto", *TRANSLATORS])
def test_the_limit_on_time_ends_the_same_way_at_every_place(monkeypatch: pytest.MonkeyPatch, translator: str) -> None:
    """On a clock that ticks whenever it is asked; an error that gets lost would be another one, or none."""
    clock = count()
    monkeypatch.setattr("ltlc.budget.time.monotonic", lambda: TICK * next(clock))
    for number, text in enumerate(MIXED):
        acceptance: AcceptanceKind = "state" if number % 2 else "transition"
        begin = next(clock)
        whole = build(text, translator, acceptance, timeout=1e6)
        if whole is None:
            continue
        ticks = next(clock) - begin
        for limit in range(1, ticks, max(1, ticks // 6)):
            clock = count()
            try:
                automaton = build(text, translator, acceptance, timeout=limit * TICK)
            except TimeLimitExceeded as error:
                assert f"after {limit * TICK:g} s: raise the limit" in str(error)
            else:
                assert automaton is not None
                assert equivalent(automaton, whole)
            # Nobody goes on for long without asking.
            assert next(clock) * TICK < 1.06 * limit * TICK + 0.5 + 20 * TICK


@pytest.mark.slow
def test_the_best_effort_keeps_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pysat")
    clock = count()
    monkeypatch.setattr("ltlc.budget.time.monotonic", lambda: TICK * next(clock))
    formula = parse("GF(a & X b) & GF(c & X d)")
    whole = translate(formula, Options(effort="best", acceptance="transition", timeout=1e6))
    ticks = next(clock)
    for limit in range(ticks // 20, ticks, ticks // 8):
        clock = count()
        try:
            automaton = translate(formula, Options(effort="best", acceptance="transition", timeout=limit * TICK))
        except TimeLimitExceeded:
            continue
        assert equivalent(automaton, whole)


@pytest.mark.parametrize(
    "text",
    [
        " <-> ".join(f"F p{i}" for i in range(10)),
        " xor ".join(f"GF p{i}" for i in range(10)),
        "F" * 3000 + "a",
        "((F a1) & (F a2) & (F a3) & (F a4) & (F a5) & (F a6) & (F a7) & (F a8)) U G b | GF c",
        "(GF(a1 & Xa1) & GF(a2 & Xa2) & GF(a3 & Xa3)) <-> (GF(b1 & Xb1) & GF(b2 & Xb2) & GF(b3 & Xb3))",
        "GF((Ga & F(b R Xc)) | (F!a & G(!b U X!c)))",
        " & ".join(f"(GF p{i} -> GF p{i + 10})" for i in range(10)),
        " & ".join(f"F(p{i % 18} & X F p{(i * 5 + 1) % 18})" for i in range(500)),
    ],
)
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_hard_formulas_end_in_time(text: str, acceptance: AcceptanceKind) -> None:
    started = time.process_time()
    with suppress(LimitExceeded):
        assert ltlc.compile(text, acceptance=acceptance, timeout=0.5).n_states > 0
    assert time.process_time() - started < 6  # 1.55 on a quiet machine; some of these took minutes


def exponential() -> Formula:
    """A formula whose text is exponentially long."""
    formula: Formula = Proposition("a")
    for i in range(40):
        formula = Xor(formula, Xor(Proposition(f"p{i % 5}"), formula))
    return formula


@pytest.fixture(scope="module")
def automaton() -> DRA:
    return translate(
        parse("(GF(a & X b) & GF c) | (FG d & G(a -> F c))"), Options(acceptance="transition", effort="fast")
    )


@pytest.mark.parametrize(
    "work",
    [
        lambda a: equivalent(a, a),
        to_parity,
        parity_colours,
        to_state_based,
        to_hoa,
        to_json,
        to_dot,
        to_mermaid,
        lambda _: from_hoa(HOA),
        lambda _: from_json(JSON),
        lambda a: a.annotations,
        lambda a: str(exponential()),
        lambda a: satisfies(parse("F a"), parse_word("cycle{a}")),
    ],
)
def test_everything_that_can_take_long_asks(
    monkeypatch: pytest.MonkeyPatch, automaton: DRA, work: Callable[[DRA], object]
) -> None:
    monkeypatch.setattr("ltlc.budget._OVERTIME", (0, 0))
    fresh = replace(automaton)  # nothing has been computed for it
    with time_limit("this", 1e-9), pytest.raises(TimeLimitExceeded, match=r"^this is not done after 1e-09 s"):
        work(fresh)


def test_many_formulas_have_their_time_each() -> None:
    easy = ["F a", "G b", "GF c"]
    hard = " xor ".join(f"GF p{i}" for i in range(10))
    with pytest.raises(TimeLimitExceeded, match=r"^G F p0 xor G F p1 .* is not done after 0.3 s"):
        ltlc.compile_many([*easy, hard], timeout=0.3)
    assert [dra.n_states for dra in ltlc.compile_many(easy, timeout=5)] == [2, 2, 2]
    with pytest.raises(TimeLimitExceeded, match="after 1e-09 s"):
        ltlc.compile_many([exponential()], timeout=1e-9)


# -- the limit itself -------------------------------------------------------------------------------------------------


def test_no_limit_is_in_force_by_default() -> None:
    assert time_left() is None
    with time_limit("nothing", None) as limit:
        assert limit.remaining is None
        assert time_left() is None
        check_time()


def test_a_limit_inside_another_does_not_extend_it() -> None:
    with time_limit("outer", 0):
        with time_limit("inner", 100) as limit:
            assert limit.name == "outer"
            with pytest.raises(TimeLimitExceeded, match=r"^outer is not done after 0 s"):
                check_time()
        with time_limit("inner", None), pytest.raises(TimeLimitExceeded, match=r"^outer"):
            check_time()
    with time_limit("outer", 100):
        with time_limit("inner", 0), pytest.raises(TimeLimitExceeded, match=r"^inner"):
            check_time()
        check_time()
    assert has_time()


def test_a_limit_ends_with_its_block_whatever_happens() -> None:
    with pytest.raises(TimeLimitExceeded), time_limit("block", 0):
        check_time()
    check_time()


def test_a_limit_is_not_seen_by_other_threads() -> None:
    left: list[float | None] = []
    with time_limit("here", 0):
        thread = threading.Thread(target=lambda: left.append(time_left()))
        thread.start()
        thread.join()
    assert left == [None]


def test_overtime_ends_too() -> None:
    with time_limit("this", 1e-9):
        assert not has_time()
        with overtime(Overtime.WRITE):
            check_time()
            with overtime(Overtime.REDUCE):
                assert time_left() < 0.13  # type: ignore[operator]
        assert not has_time()
        time.sleep(0.5)
        with overtime(Overtime.WRITE), pytest.raises(TimeLimitExceeded):
            check_time()
    with overtime(Overtime.WRITE):
        assert time_left() is None


def test_messages_name_the_formula_in_one_short_line() -> None:
    text = "G(a1\n & " + " & ".join(f"F b{i}" for i in range(15)) + ")"
    with pytest.raises(TimeLimitExceeded) as caught:
        ltlc.compile(text, timeout=1e-9)
    assert str(caught.value).startswith("G(a1 & F b0")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 160
