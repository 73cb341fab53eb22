"""Acceptance conditions of HOA files against their meaning, under their names, and as few pairs as needed."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hoa_texts import hoa
from random_automata import random_automaton, random_lassos

import ltlc
from ltlc.automata import DRA
from ltlc.automata.compare import equivalent
from ltlc.errors import FileFormatError
from ltlc.formats import from_hoa

NAMED = {
    "Buchi": "1 Inf(0)",
    "co-Buchi": "1 Fin(0)",
    "generalized-Buchi 3": "3 Inf(0)&Inf(1)&Inf(2)",
    "generalized-co-Buchi 3": "3 Fin(0)|Fin(1)|Fin(2)",
    "promises": "3 Inf(!0) & Inf(!1) & Inf(!2)",
    "Streett 1": "2 Fin(0)|Inf(1)",
    "Streett 2": "4 (Fin(0)|Inf(1))&(Fin(2)|Inf(3))",
    "Rabin 2": "4 (Fin(0)&Inf(1))|(Fin(2)&Inf(3))",
    "Krishnan": "4 (Inf(0)&Fin(!1))|(Inf(2)&Fin(!3))",
    "generalized-Rabin 2 2 1": "5 (Fin(0)&Inf(1)&Inf(2))|(Fin(3)&Inf(4))",
    "parity min even 4": "4 Inf(0) | (Fin(1) & (Inf(2) | Fin(3)))",
    "parity min odd 4": "4 Fin(0) & (Inf(1) | (Fin(2) & Inf(3)))",
    "parity max even 4": "4 Fin(3) & (Inf(2) | (Fin(1) & Inf(0)))",
    "parity max odd 5": "5 Fin(4) & (Inf(3) | (Fin(2) & (Inf(1) | Fin(0))))",
    "all": "0 t",
    "none": "0 f",
    "contradiction": "1 Fin(0) & Inf(0)",
    "mixture": "3 (Fin(!0) | Inf(1) & t) & (Inf(2) | Inf(0) & Fin(2) | f)",
}


def holds(condition: str, seen: set[int], n_sets: int, others_seen: set[int]) -> bool:
    """Truth of a condition: `seen` are the sets met infinitely often, `others_seen` those whose complement is."""

    def atom(match: re.Match[str]) -> str:
        met = int(match[3]) in (others_seen if match[2] else seen)
        return str(met if match[1] == "Inf" else not met)

    words = re.sub(r"(Fin|Inf)\((!?)(\d+)\)", atom, condition.split(" ", 1)[1])
    words = re.sub(r"\bt\b", "True", re.sub(r"\bf\b", "False", words))
    return evaluate(words)


def evaluate(text: str) -> bool:
    """Value of an expression of True, False, &, | and brackets."""
    text = text.replace(" ", "")
    while text not in ("True", "False"):
        shorter = re.sub(r"\((True|False)\)", r"\1", text)
        shorter = re.sub(r"(True|False)&(True|False)", lambda m: str(m[1] == m[2] == "True"), shorter, count=1)
        if shorter == text:
            shorter = re.sub(
                r"(?<!&)(True|False)\|(True|False)(?!&)", lambda m: str("True" in (m[1], m[2])), text, count=1
            )
        assert shorter != text, text
        text = shorter
    return text == "True"


def test_pairs_are_those_of_a_translation() -> None:
    """Streett conditions, read and translated: one way to Rabin pairs, hence the same sizes."""
    for n in (1, 2, 3):
        condition = "&".join(f"(Fin({2 * i})|Inf({2 * i + 1}))" for i in range(n))
        names = " ".join(f'"p{i}"' for i in range(2 * n))
        letters = (
            f"[{'&'.join(f'{i}' if letter >> i & 1 else f'!{i}' for i in range(2 * n))}] 0 "
            f"{{{' '.join(str(i) for i in range(2 * n) if letter >> i & 1)}}}"
            for letter in range(4**n)
        )
        text = hoa("State: 0 " + " ".join(letters), ap=f"{2 * n} {names}", acceptance=f"{2 * n} {condition}")
        formula = " & ".join(f"(GF p{2 * i} -> GF p{2 * i + 1})" for i in range(n))
        read, translated = from_hoa(text), ltlc.compile(formula, acceptance="transition")
        assert equivalent(read, translated)
        assert (read.n_states, read.n_pairs) == (translated.n_states, translated.n_pairs)


@pytest.mark.parametrize("on_states", [False, True])
@pytest.mark.parametrize("name", NAMED)
def test_acceptance_condition_means_what_it_says(name: str, on_states: bool) -> None:
    condition = NAMED[name]
    n_sets = int(condition.split()[0])
    rng = np.random.default_rng(sum(name.encode()) + on_states)
    for _ in range(6):
        skeleton = random_automaton(rng, 4, 2, 0, "state")
        marks = rng.random((n_sets, 4, 4)) < 0.35
        if on_states:
            marks[:] = marks[:, :, :1]
        body = []
        for q in range(4):
            own = " ".join(str(i) for i in range(n_sets) if marks[i, q, 0])
            body.append(f"State: {q} {{{own}}}" if on_states else f"State: {q}")
            for letter in range(4):
                sets = " ".join(str(i) for i in range(n_sets) if marks[i, q, letter])
                target = skeleton.delta[q, skeleton.letter_class[letter]]
                body.append(f"{target}" if on_states else f"{target} {{{sets}}}")
        text = hoa("\n".join(body), acceptance=condition, start=f"Start: {skeleton.initial_state}")
        automaton = from_hoa(text)
        assert automaton.acceptance == ("state" if on_states or not marks.any() else "transition")
        for prefix, cycle in random_lassos(rng, 4, 40):
            met = recurring(skeleton, prefix, cycle)
            seen = {i for i in range(n_sets) if any(marks[i, q, letter] for q, letter in met)}
            others = {i for i in range(n_sets) if any(not marks[i, q, letter] for q, letter in met)}
            assert automaton.accepts_letters(prefix, cycle) == holds(condition, seen, n_sets, others)


def recurring(automaton: DRA, prefix: tuple[int, ...], cycle: tuple[int, ...]) -> set[tuple[int, int]]:
    """The (state, letter) pairs that a run meets for ever: those after many rounds."""
    state, met = automaton.initial_state, set()
    rounds = automaton.n_states + 1
    for i, letter in enumerate((*prefix, *cycle * (2 * rounds))):
        if i >= len(prefix) + len(cycle) * rounds:
            met.add((state, letter))
        state = int(automaton.delta[state, automaton.letter_class[letter]])
    return met


NAMES = ["Buchi", "co-Buchi", "all", "none", "Rabin 1", "Rabin 2", "Streett 1", "Streett 2", "generalized-Buchi 3"]
NAMES += ["generalized-co-Buchi 3", "generalized-Rabin 2 2 1", "parity min even 4", "parity max odd 5"]


def test_names_of_conditions() -> None:
    for name in NAMES:
        for other, condition in NAMED.items():
            text = hoa("State: 0 [t] 0", header=f"acc-name: {name}", acceptance=condition)
            if name == other:
                from_hoa(text)
            elif other in NAMES:
                with pytest.raises(
                    FileFormatError, match=f"line 4, column 1: the condition .* is not what is called {name}"
                ):
                    from_hoa(text)
    for name in ("Rabin", "Rabin 1 2", "parity up odd 3", "very-strange 3", "generalized-Rabin 2 1"):  # not defined
        from_hoa(hoa("State: 0 [t] 0", header=f"acc-name: {name}"))
    with pytest.raises(FileFormatError, match="is not what is called Rabin 999999999"):
        from_hoa(hoa("State: 0 [t] 0", header="acc-name: Rabin 999999999"))
    old = "5 Inf(0) | (Fin(0)&Fin(1)&Inf(2)) | (Fin(0)&Fin(1)&Fin(2)&Fin(3)&Inf(4))"  # as in the first text of v1
    from_hoa(hoa("State: 0 [t] 0", header="acc-name: parity min even 5", acceptance=old))


def test_sets_that_nothing_carries_make_no_pairs() -> None:
    condition = "Fin(0)"
    for i in range(1, 411):
        condition = f"{'Inf' if i % 2 else 'Fin'}({i}) {'|' if i % 2 else '&'} ({condition})"
    edges = " ".join(f"State: {q} [0] {(q + 1) % 34} {{{200 + q % 3}}} [!0] {q // 2} {{7}}" for q in range(34))
    text = hoa(edges, ap='1 "a"', acceptance=f"411 {condition}", header="acc-name: parity max odd 411")
    automaton = from_hoa(text)
    assert (automaton.n_states, automaton.n_pairs) == (34, 2)
    few = "5 Fin(4) & (Inf(3) | (Fin(2) & (Inf(1) | Fin(0))))"
    for old, new in ((7, 1), (200, 2), (201, 3), (202, 4)):
        edges = edges.replace(f"{{{old}}}", f"{{{new}}}")
    assert equivalent(automaton, from_hoa(hoa(edges, ap='1 "a"', acceptance=few)))
