"""Bodies and labels of HOA files, read by regular expressions, against the grammar; and large inputs."""

from __future__ import annotations

import random
import time

import numpy as np
import pytest
from hoa_texts import hoa
from lark.exceptions import UnexpectedInput
from random_automata import random_automaton

from ltlc.errors import AlphabetLimitExceeded
from ltlc.formats import from_hoa, to_hoa
from ltlc.formats.hoa_parser import HoaSyntaxError, _parser, parse_body, parse_label


@pytest.mark.slow
def test_bodies_are_read_as_the_grammar_says() -> None:
    rng = random.Random(7)
    words = [
        "State:",
        "0",
        "1",
        "17",
        "01",
        "[0]",
        "[ !0 ]",
        "[t",
        "{0}",
        "{ 0 0 }",
        "{",
        "&",
        '"s"',
        '"\\""',
        "x",
    ]
    for _ in range(3_000):
        body = "".join(rng.choice(words) + rng.choice(["", " ", "\n"]) for _ in range(rng.randint(1, 9)))
        if rng.random() < 0.7:
            body = f"State: 0 {body}"
        text = f"HOA: v1 Acceptance: 1 t --BODY-- {body} --END--"
        start = text.index("--BODY--") + 8
        try:
            list(parse_body(text, start))
            fits = True
        except HoaSyntaxError:
            fits = False
        try:
            _parser().parse(text[: text.index("--END--") + 7] if fits else text, start="automaton")
        except UnexpectedInput:
            assert not fits, text
        else:
            assert fits, text


@pytest.mark.slow
def test_labels_are_read_as_the_grammar_says() -> None:
    rng = random.Random(8)
    words = ["0", "1", "12", "@a", "t", "f", "!", "&", "|", "(", ")", "a", " "]
    for _ in range(3_000):
        text = "[" + "".join(rng.choice(words) for _ in range(rng.randint(1, 8))) + "]"
        try:
            expected = _parser().parse(text, start="label")
        except UnexpectedInput:
            expected = None
        try:
            assert parse_label(text) is expected
        except HoaSyntaxError:
            assert expected is None


def test_too_many_propositions() -> None:
    names = " ".join(f'"p{i}"' for i in range(22))
    with pytest.raises(AlphabetLimitExceeded, match=r"22 atomic propositions; .* at most 21"):
        from_hoa(hoa("State: 0 [t] 0", ap=f"22 {names}"))
    many = " ".join(f"State: {q} [{q % 20}] {q} [!{q % 20}] 0" for q in range(200))
    with pytest.raises(AlphabetLimitExceeded, match="200 states times 1048576 letter classes"):
        from_hoa(hoa(many, ap=f"20 {names.rsplit(' ', 2)[0]}", acceptance="0 t"))


def test_thousands_of_states_are_quick() -> None:
    automaton = random_automaton(np.random.default_rng(0), 2000, 2, 2, "transition")
    text = to_hoa(automaton)
    begin = time.perf_counter()
    again = from_hoa(text)
    assert time.perf_counter() - begin < 20
    assert to_hoa(again) == text


def test_deeply_nested_label() -> None:
    label = "!(" * 10_001 + "0" + ")" * 10_001
    automaton = from_hoa(hoa(f"State: 0 [{label}] 0 {{0}} [0] 0"))
    assert automaton.accepts(cycle=[set()])
    assert not automaton.accepts(cycle=[{"a"}])
