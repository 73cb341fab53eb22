"""Special forms of automata: what they look like, for which languages they are, and that the language stays."""

from __future__ import annotations

import random

import pytest
from random_ltl import random_formula, random_nesting, random_task

import ltlc
from ltlc.automata import counterexample, equivalent, parity_colours, with_form
from ltlc.automata.forms import Form
from ltlc.errors import InvalidArgumentError, StateLimitExceeded, UnknownNameError
from ltlc.formats import from_hoa, to_hoa
from ltlc.ltl import HierarchyClass, classify, parse

RECURRENCE = (HierarchyClass.SAFETY, HierarchyClass.CO_SAFETY, HierarchyClass.OBLIGATION, HierarchyClass.RECURRENCE)
PERSISTENCE = (*RECURRENCE[:3], HierarchyClass.PERSISTENCE)
NAMES = {"buchi": "Buchi", "co-buchi": "co-Buchi"}


def checked(text: str, form: Form) -> bool:
    """Whether the formula has the form; what was made is compared with what was asked for."""
    plain = ltlc.compile(text, acceptance="transition")
    try:
        automaton = ltlc.compile(text, form=form)
    except InvalidArgumentError as error:
        assert f"no deterministic {NAMES[form]} automaton accepts" in str(error)
        return False
    assert automaton.acceptance == "transition"
    assert equivalent(automaton, plain), f"{text} on {counterexample(automaton, plain)}"
    hoa = to_hoa(automaton)
    assert f"acc-name: {NAMES.get(form, 'parity max odd')}" in hoa
    assert equivalent(from_hoa(hoa), plain), text
    if form == "buchi":
        assert automaton.n_states == plain.n_states
        assert not automaton.fin.any()
    elif form == "co-buchi":
        assert automaton.n_pairs == 1
        assert automaton.inf.all()
    else:
        assert parity_colours(automaton) is not None
    return True


def random_text(rng: random.Random) -> str:
    names = "abc"[: rng.randint(1, 3)]
    kind = rng.randrange(3)
    if kind == 0:
        return str(random_formula(rng, rng.randint(2, 11), names))
    return str(random_nesting(rng, names) if kind == 1 else random_task(rng, names))


def compare(form: Form, n: int) -> None:
    rng = random.Random(form)
    has_it = 0
    for _ in range(n):
        text = random_text(rng)
        found = checked(text, form)
        known = classify(parse(text)) in (RECURRENCE if form == "buchi" else PERSISTENCE)
        assert found or (form != "parity" and not known), text
        has_it += found
    assert has_it > n // 3


@pytest.mark.parametrize("form", ["parity", "buchi", "co-buchi"])
def test_random_formulas(form: Form) -> None:
    compare(form, 40)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["parity", "buchi", "co-buchi"])
def test_many_random_formulas(form: Form) -> None:
    compare(form, 300)


@pytest.mark.parametrize(
    ("text", "parity", "buchi", "co_buchi"),
    [
        ("G F a", 2, True, False),
        ("F G a", 3, False, True),
        ("G F a & G F b", 2, True, False),
        ("G F a -> G F b", 4, False, False),
        ("F a & G b", 2, True, True),
        ("(G F a & F G b) | (G F c & F G d)", None, False, False),
        ("true", 2, True, True),
        ("false", 1, True, True),
    ],
)
def test_known_languages(text: str, parity: int | None, buchi: bool, co_buchi: bool) -> None:
    assert checked(text, "parity")
    assert checked(text, "buchi") == buchi
    assert checked(text, "co-buchi") == co_buchi
    hoa = ltlc.compile(text, form="parity").to_hoa()
    assert parity is None or f"acc-name: parity max odd {parity}\n" in hoa


def test_the_condition_is_written_as_hoa_writes_it() -> None:
    hoa = ltlc.compile("(G F a & F G b) | (G F c & F G d)", form="parity").to_hoa()
    assert "acc-name: parity max odd 5\nAcceptance: 5 Fin(4) & (Inf(3) | (Fin(2) & (Inf(1) | Fin(0))))\n" in hoa
    assert "colored" in hoa


def test_rabin_is_the_automaton_itself() -> None:
    automaton = ltlc.compile("G F a")
    assert with_form(automaton, "rabin") is automaton


def test_errors() -> None:
    with pytest.raises(UnknownNameError, match="unknown form 'büchi'"):
        ltlc.compile("a", form="büchi")  # type: ignore[call-overload]
    with pytest.raises(UnknownNameError, match="unknown form 'strett'"):
        with_form(ltlc.compile("a"), "strett")  # type: ignore[arg-type]
    with pytest.raises(InvalidArgumentError, match="of F G a: it is no recurrence property; take the form parity"):
        ltlc.compile("F G a", form="buchi")
    with pytest.raises(StateLimitExceeded):
        with_form(ltlc.compile("(G F a & F G b) | (G F c & F G d)"), "parity", max_states=1)
