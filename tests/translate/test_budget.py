"""The limits on states, time, propositions and depth: what they say, and what is kept when they are hit."""

from __future__ import annotations

from itertools import count

import pytest

from ltlc.automata import DRA, equivalent
from ltlc.automata.rabin import AcceptanceKind
from ltlc.errors import (
    AlphabetLimitExceeded,
    DepthLimitExceeded,
    LimitExceeded,
    StateLimitExceeded,
    TimeLimitExceeded,
)
from ltlc.ltl import parse
from ltlc.translate import TRANSLATORS, Options, translate

HARD = " & ".join(f"(G(a{i} | F b{i}) | F(c & X(b{i} U G a{i})))" for i in range(3))


def build(text: str, acceptance: AcceptanceKind = "transition", translator: str = "auto") -> DRA:
    return translate(parse(text), Options(acceptance=acceptance, translator=translator))


def test_the_normal_form_has_a_limit_of_its_own() -> None:
    text = "G(a | " + " & ".join(f"(b{i} | F(c{i} & G d{i}))" for i in range(5)) + ")"
    with pytest.raises(StateLimitExceeded, match=r"guess \d+ fixpoints, more than 8: use another translator"):
        build(text, translator="normal-form")


def test_too_many_propositions() -> None:
    with pytest.raises(AlphabetLimitExceeded, match=r"22 atomic propositions; .* at most 21"):
        build(" & ".join(f"F a{i}" for i in range(22)))


@pytest.mark.parametrize("translator", ["auto", *TRANSLATORS])
def test_the_limit_on_states(translator: str) -> None:
    text = " & ".join(f"F(a{i} & X F a{i + 1})" for i in range(6))
    with pytest.raises(StateLimitExceeded) as caught:
        translate(parse(text), Options(translator=translator, max_states=20))
    message = str(caught.value)
    assert message.startswith(str(parse(text))[:40])
    assert "more than 20 states" in message
    assert "raise the limit (max_states)" in message


@pytest.mark.parametrize("translator", ["auto", "product", "normal-form", "safra", "dual-safra"])
def test_the_limit_on_time(translator: str) -> None:
    with pytest.raises(TimeLimitExceeded) as caught:
        translate(parse(HARD), Options(translator=translator, timeout=0.02))
    message = str(caught.value)
    assert message.startswith(str(parse(HARD))[:40])
    assert "0.02 s" in message
    assert "raise the limit (timeout)" in message


@pytest.mark.parametrize("text", ["X " * 5000 + "a", "(a U (b U " * 2000 + "c" + "))" * 2000])
def test_formulas_that_are_nested_too_deeply_end_by_a_limit(text: str) -> None:
    with pytest.raises(DepthLimitExceeded, match="nested too deeply"):
        translate(parse(text))


def test_hard_formulas_end_by_a_limit() -> None:
    with pytest.raises(LimitExceeded):
        translate(parse(HARD), Options(max_states=300, timeout=0.02))


def test_a_limit_on_one_construction_does_not_stop_the_others() -> None:
    """Safra trees for these grow beyond the first rounds, the product does not."""
    text = "(GF a | FG b) & (GF c | FG d)"
    with pytest.raises(StateLimitExceeded):
        translate(parse(text), Options(translator="safra", max_states=10))
    assert translate(parse(text), Options(acceptance="transition", max_states=10)).n_states <= 10


@pytest.mark.slow
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_what_is_found_is_kept_when_the_time_is_over(
    monkeypatch: pytest.MonkeyPatch, acceptance: AcceptanceKind
) -> None:
    """On a clock that ticks whenever it is asked, so that the time is over at every place in turn."""
    tick = 0.01
    clock = count()
    monkeypatch.setattr("ltlc.budget.time.monotonic", lambda: tick * next(clock))
    formula = parse("G F(a & X X b) & F G(c | X d)")
    best = translate(formula, Options(acceptance=acceptance, timeout=1e6))
    ticks = next(clock)
    sizes = []
    for limit in range(10, ticks, ticks // 40):
        clock = count()
        try:
            automaton = translate(formula, Options(acceptance=acceptance, timeout=limit * tick))
        except TimeLimitExceeded:
            sizes.append(None)
            continue
        finally:
            # Nobody goes on for long without asking, or after the answer that the time is over.
            assert next(clock) * tick < 1.06 * limit * tick + 0.48 + 20 * tick
        assert equivalent(automaton, best)
        sizes.append(automaton.n_states)
    assert None in sizes
    assert best.n_states in sizes


def test_the_limit_on_states_holds_for_the_result() -> None:
    formula = parse("(G F p1 | F G p2) & (G F p2 | F G p3)")
    assert translate(formula, Options(acceptance="transition", max_states=2)).n_states == 2
    with pytest.raises(StateLimitExceeded, match="more than 2 states"):
        translate(formula, Options(max_states=2))
