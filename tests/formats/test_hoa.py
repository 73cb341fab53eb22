"""HOA: round trips, all that the format allows, acceptance conditions against their meaning, and every message."""

from __future__ import annotations

import io
import random
import re
import time

import numpy as np
import pytest
from lark.exceptions import UnexpectedInput
from random_automata import random_automata, random_automaton, random_lassos

import ltlc
from ltlc.automata import RabinAutomaton
from ltlc.automata.compare import equivalent, is_empty
from ltlc.errors import AlphabetLimitExceeded, FileFormatError
from ltlc.formats import from_hoa, read_hoa_stream, to_hoa
from ltlc.formats.hoa_parser import HoaSyntaxError, _parser, parse_body, parse_label


def test_round_trip_is_stable_and_keeps_the_language() -> None:
    for automaton in random_automata(60, max_aps=3):
        text = to_hoa(automaton)
        again = from_hoa(text)
        assert to_hoa(again) == text
        assert again.acceptance == automaton.acceptance
        assert equivalent(again, automaton)


def test_text() -> None:
    automaton = RabinAutomaton(
        ("a", 'b "q"'), [[0, 1], [1, 1]], [0, 0, 0, 1], [[1, 0]], [[0, 1]], formula='F(a & "b \\"q\\"")'
    )
    assert re.sub(r"^tool: .*\n", "", to_hoa(automaton), flags=re.MULTILINE) == (
        "HOA: v1\n"
        'name: "F(a & \\"b \\\\\\"q\\\\\\"\\")"\n'
        "States: 2\n"
        "Start: 0\n"
        'AP: 2 "a" "b \\"q\\""\n'
        "acc-name: Rabin 1\n"
        "Acceptance: 2 Fin(0) & Inf(1)\n"
        "properties: trans-labels explicit-labels state-acc deterministic complete\n"
        "--BODY--\n"
        "State: 0 {0}\n"
        "[!0 | !1] 0\n"
        "[0 & 1] 1\n"
        "State: 1 {1}\n"
        "[t] 1\n"
        "--END--\n"
    )
    again = from_hoa(to_hoa(automaton))
    assert (again.aps, again.formula) == (automaton.aps, automaton.formula)


def hoa(
    body: str, *, header: str = "", ap: str = '2 "a" "b"', acceptance: str = "1 Inf(0)", start: str = "Start: 0"
) -> str:
    return f"HOA: v1\n{start}\nAP: {ap}\n{header}\nAcceptance: {acceptance}\n--BODY--\n{body}\n--END--\n"


def infinitely_often_a() -> RabinAutomaton:
    return RabinAutomaton(("a", "b"), [[0, 0]], [0, 1, 0, 1], [[[0, 0]]], [[[0, 1]]], acceptance="transition")


@pytest.mark.parametrize(
    "text",
    [
        hoa("State: 0 [0] 0 {0} [!0] 0"),
        hoa("State: 0 0 0 {0} 0 0 {0}"),
        hoa("State: 0 [@p] 0 {0} [!@p] 0", header="Alias: @q 0 Alias: @p (@q | @q&f)&t"),
        hoa("State: 0 [0&1] 0 {0} [0&!1] 0 {0} [!(0)|f] 0 /* twice */ [!0] 0"),
        hoa("State: 0 {0} [0] 0 [!0] 1 State: 1 [0] 0 [!0] 1"),
        hoa('State: 1 [0] 0 [!0] 1 /* /* nested */ " */ State: 0 "st\\"ate" {0} [0] 0 [!0] 1'),
        '/* first */ HOA: v1.1 tool: "x" extra: t 1 "s" name properties: !complete stutter-invariant States: 1'
        ' Acceptance: 3 Inf(1) AP: 2 "a" "b" Start: 0 --BODY-- State: 0 [0] 0 {1 2} [!0] 0 {2} --END--',
    ],
)
def test_ways_to_write_infinitely_often_a(text: str) -> None:
    assert equivalent(from_hoa(text), infinitely_often_a())


def test_label_on_states() -> None:
    """A label on a state is the label of all its edges; here a, then b, then anything."""
    automaton = from_hoa(hoa("State: [0] 0 1 State: [1] 1 2 State: [t] 2 {0} 2"))
    assert automaton.accepts([{"a"}, {"b"}], [set()])
    assert not automaton.accepts([{"a"}, {"a"}], [{"b"}])
    assert automaton.n_states == 4  # the deadlock was added


def test_state_and_transition_marks_mixed() -> None:
    automaton = from_hoa(
        hoa("State: 0 {0} [0] 0 {1} [!0] 1 State: 1 [0] 0 {1} [!0] 1 {0}", acceptance="2 Fin(0) & Inf(1)")
    )
    assert automaton.acceptance == "transition"
    assert automaton.accepts(cycle=[{"a"}]) is False
    assert automaton.pairs[0].fin == {(0, 0), (0, 1), (1, 0)}


def test_large_numbers_of_states_and_propositions() -> None:
    names = " ".join(f'"p{i}"' for i in range(12))
    body = "\n".join(f"State: {q} [{q}] {(q + 1) % 12} {{{q}}} [!{q}] {q}" for q in range(12))
    automaton = from_hoa(hoa(body, ap=f"12 {names}", acceptance="12 Inf(11)"))
    assert automaton.accepts(cycle=[{f"p{i}" for i in range(12)}])
    assert not automaton.accepts(cycle=[{f"p{i}" for i in range(11)}])
    assert to_hoa(from_hoa(to_hoa(automaton))) == to_hoa(automaton)


def test_incomplete_automaton_gets_a_deadlock() -> None:
    automaton = from_hoa(hoa('State: 0 "start" [0] 0', acceptance="0 t"))
    assert automaton.n_states == 2
    assert automaton.deadlocks == (1,)
    assert automaton.state_names == ("start", "1")
    assert automaton.accepts(cycle=[{"a"}])
    assert not automaton.accepts(prefix=[set()], cycle=[{"a"}])


def test_no_initial_state_accepts_nothing() -> None:
    assert is_empty(from_hoa(hoa("State: 0 [t] 0", start="States: 1", acceptance="0 t")))
    assert is_empty(from_hoa("HOA: v1 States: 0 Acceptance: 0 t --BODY-- --END--"))


# Acceptance conditions

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


def recurring(automaton: RabinAutomaton, prefix: tuple[int, ...], cycle: tuple[int, ...]) -> set[tuple[int, int]]:
    """The (state, letter) pairs that a run meets for ever: those after many rounds."""
    state, met = automaton.initial_state, set()
    rounds = automaton.n_states + 1
    for i, letter in enumerate((*prefix, *cycle * (2 * rounds))):
        if i >= len(prefix) + len(cycle) * rounds:
            met.add((state, letter))
        state = int(automaton.delta[state, automaton.letter_class[letter]])
    return met


# Streams


def test_stream_of_several_automata() -> None:
    one, two = (to_hoa(automaton) for automaton in random_automata(2))
    aborted = 'HOA: v1 States: 3 /* --END-- */ name: "--END--" --ABORT-- '
    text = f"{one}{aborted}{two}\nHOA: v1 --ABORT--\n"
    assert [to_hoa(a) for a in read_hoa_stream(text)] == [one, two]
    assert [to_hoa(a) for a in read_hoa_stream(io.StringIO(text))] == [one, two]
    assert [to_hoa(a) for a in read_hoa_stream(text.replace("\n", " "))] == [one, two]
    assert list(read_hoa_stream(" \n")) == []


def test_stream_is_read_as_it_comes() -> None:
    one = to_hoa(next(random_automata(1)))

    def lines() -> object:
        yield from one.splitlines(keepends=True)
        raise AssertionError("read on before it was asked to")

    assert to_hoa(next(read_hoa_stream(lines()))) == one  # type: ignore[arg-type]


def test_positions_count_in_the_whole_stream() -> None:
    good = to_hoa(next(random_automata(1)))
    stream = read_hoa_stream(good + hoa("State: 0 [0] 7"))
    next(stream)
    with pytest.raises(FileFormatError, match=rf"^line {good.count(chr(10)) + 7}, column 14: there is no state 7"):
        next(stream)
    line = "HOA: v1 --ABORT--HOA: v1 Start: 0 Acceptance: 0 t --BODY-- State: 0 [t]  7 --END--"
    with pytest.raises(FileFormatError, match=f"^line 1, column {line.index('7') + 1}: there is no state 7"):
        list(read_hoa_stream(line))


WRONG = [
    ("", "there is no automaton"),
    ("digraph {}", "ends before the --END--"),
    ("State: 0 --END--", "line 1, column 1: unexpected 'State:'; expected 'HOA:'"),
    ("HOA: v2 Acceptance: 0 t --BODY-- --END--", "line 1, column 6: this is HOA v2; only version v1 can be read"),
    ("HOA: v1 --BODY-- --END--", "the header Acceptance: is missing"),
    ("HOA: v1 Acceptance: 0 t States: 1 States: 1 --BODY-- --END--", "column 35: the header States: occurs twice"),
    ("HOA: v1 Acceptance: 0 t Colour: 3 --BODY-- --END--", "column 25: the header Colour: is not known"),
    ("HOA: v1 Acceptance: 0 t name: x --BODY-- --END--", "column 31: unexpected 'x'; expected a quoted string"),
    ("HOA: v1 Acceptance: 0 t /* open --END--", "line 1, column 25: this comment has no end"),
    ('HOA: v1 Acceptance: 0 t name: "open --END--', "line 1, column 31: this string has no end"),
    (
        hoa("State: 0 [0] 0 [0&1] 0 {0}"),
        "line 7, column 22: not deterministic: state 0 has a second edge for the letter a & b",
    ),
    (hoa("State: 0 [t] 0", start="Start: 0 Start: 0"), "line 2, column 10: a second initial state"),
    (hoa("State: 0 [t] 0", start="Start: 0 & 0"), "line 2, column 12: universal branching"),
    (hoa("State: 0 [t] 0 & 0"), "line 7, column 18: universal branching"),
    (hoa("State: 0 [t] 0", start="Start: 1"), "line 2, column 8: there is no state 1, 1 are listed"),
    (hoa("State: 0 [t] 0", start="States: 2 Start: 0"), "line 2, column 9: States: announces 2, and 1 are listed"),
    (hoa("State: 1 [t] 1"), "state 0 is not listed"),
    (hoa("State: 0 [t] 0 State: 0 [t] 0"), "line 7, column 23: state 0 is listed twice"),
    (hoa("State: 0 [t] 0 {1}"), "line 7, column 17: there is no acceptance set 1, Acceptance: announces 1"),
    (hoa("State: 0 {4} [t] 0"), "line 7, column 11: there is no acceptance set 4"),
    (hoa("State: 0 [2] 0"), "line 7, column 10: there is no proposition 2, AP: lists 2"),
    (hoa("State: 0 [@x] 0"), "line 7, column 10: the alias @x is not defined before it is used"),
    (hoa("State: 0 [t] 0", header="Alias: @x @x"), "line 4, column 8: the alias @x is not defined before it is used"),
    (hoa("State: 0 [t] 0", header="Alias: @x 0 Alias: @x 1"), "line 4, column 20: the alias @x is defined twice"),
    (hoa("State: 0 [0 1] 0"), "line 7, column 13: unexpected '1'"),
    (hoa("State: 0 [0 &] 0"), "line 7, column 14: unexpected ']'"),
    (hoa("State: 0 [t 0"), "line 7, column 10: unexpected '['"),
    (hoa("State: 0 0 0"), "line 7, column 1: state 0 has 2 edges without label; there are 4 letters"),
    (hoa("State: 0 [0] 0 0"), "line 7, column 16: this edge has no label"),
    (hoa("State: [0] 0 [0] 0"), "line 7, column 14: the state has a label already"),
    (hoa("State: 99999999999 [0] 0"), "line 7, column 8: numbers in HOA are below 2^31"),
    (hoa("State: 0 [t] 0", ap='3 "a" "b"'), "line 3, column 5: AP: announces 3 propositions, and 2 names follow"),
    (hoa("State: 0 [t] 0", ap='2 "a" ""'), "line 3, column 11: a proposition needs a name"),
    (hoa("State: 0 [t] 0", ap='2 "a" "a"'), 'line 3, column 11: the proposition "a" is listed twice'),
    (hoa("State: 0 [t] 0", acceptance="1 Inf(1)"), "line 5, column 13: the condition speaks of set 1"),
    (hoa("State: 0 [t] 0", acceptance="1 Sup(0)"), "line 5, column 15: unexpected 'Sup'"),
    (hoa("State: 0 [t] 0", acceptance="1 Inf(0) &"), "line 6, column 1: unexpected '--BODY--'; expected"),
    (
        hoa(
            f"State: 0 {{{' '.join(map(str, range(40)))}}} [t] 0",
            acceptance="40 " + "&".join(f"(Fin({2 * i})|Inf({2 * i + 1}))" for i in range(20)),
        ),
        "the acceptance condition has more than 1024 terms",
    ),
    (to_hoa(next(random_automata(1))) * 2, "there is more than one automaton"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_wrong_text(text: str, message: str) -> None:
    with pytest.raises(FileFormatError) as caught:
        from_hoa(text)
    assert message in str(caught.value)


# What a file claims


def claiming(claims: str, body: str = "State: 0 {0} [0] 0 [!0] 1 State: 1 [t] 1", **parts: str) -> str:
    return hoa(body, header=f"properties: {claims}", **parts)


HOLDS = [
    claiming("complete deterministic unambiguous state-acc explicit-labels trans-labels no-univ-branch !colored"),
    claiming("weak very-weak inherently-weak !terminal", "State: 0 [0] 0 {0} [!0] 1 State: 1 [t] 1"),
    claiming("!weak !very-weak inherently-weak", "State: 0 [0] 0 {0} [!0] 1 State: 1 [t] 0 {0} State: 2 [t] 2 {0}"),
    claiming("!inherently-weak colored", "State: 0 [0] 0 {0} [!0] 0 {1}", acceptance="2 Inf(0)"),
    claiming("terminal weak", "State: 0 [0] 0 [!0] 1 State: 1 [t] 1 {0}"),
    claiming("weak !very-weak !terminal", "State: 0 {0} [0] 1 State: 1 {0} [t] 0"),
    claiming("state-labels state-acc explicit-labels", "State: [0] 0 1 State: [1] 1 0"),
    claiming("implicit-labels trans-labels complete", "State: 0 0 0 {0} 0 0"),
    claiming("stutter-invariant tight !tight unknown !unknown"),
]
"""files that claim what is so"""

FAILS = [
    (claiming("complete", "State: 0 [0] 0"), "line 7, column 8: state 0 has no edge for the letter !a & !b"),
    (claiming("complete", "State: 0 [t] 0 State: 1"), "line 7, column 23: state 1 has no edge for the letter !a & !b"),
    (claiming("complete", start=""), "there is no initial state, though line 4 claims `complete`"),
    (claiming("!deterministic"), "line 4, column 14: `!deterministic` does not hold"),
    (claiming("exist-branch"), "`exist-branch` does not hold"),
    (claiming("univ-branch"), "`univ-branch` does not hold"),
    (claiming("!unambiguous"), "`!unambiguous` does not hold"),
    (claiming("state-acc", "State: 0 [t] 0 {0}"), "line 7, column 16: this edge has marks, though line 4 claims"),
    (claiming("trans-acc", "State: 0 {0} [t] 0"), "line 7, column 10: state 0 has marks, though line 4 claims"),
    (claiming("implicit-labels"), "line 7, column 14: this edge has a label, though"),
    (claiming("implicit-labels", "State: [0] 0 0"), "line 7, column 8: state 0 has a label, though"),
    (claiming("trans-labels", "State: [0] 0 0"), "state 0 has a label, though line 4 claims `trans-labels`"),
    (claiming("state-labels"), "this edge has a label, though line 4 claims `state-labels`"),
    (claiming("explicit-labels", "State: 0 0 0 0 0"), "state 0 has neither a label nor edges with labels"),
    (claiming("colored"), "`colored` does not hold"),
    (claiming("weak", "State: 0 [0] 0 {0} [!0] 1 State: 1 [t] 0"), "`weak` does not hold"),
    (claiming("very-weak", "State: 0 [0] 0 {0} [!0] 1 {0} State: 1 [t] 0 {0}"), "`very-weak` does not hold"),
    (claiming("inherently-weak", "State: 0 [0] 0 {0} [!0] 0"), "`inherently-weak` does not hold"),
    (claiming("terminal"), "`terminal` does not hold"),
    (claiming("terminal", "State: 0 {0} [0] 0"), "`terminal` does not hold"),
    (claiming("!weak"), "`!weak` does not hold"),
]


@pytest.mark.parametrize("text", HOLDS)
def test_claims_that_hold(text: str) -> None:
    from_hoa(text)


@pytest.mark.parametrize(("text", "message"), FAILS)
def test_claims_that_fail(text: str, message: str) -> None:
    with pytest.raises(FileFormatError) as caught:
        from_hoa(text)
    assert message in str(caught.value)


def test_a_lost_line_is_noticed_or_changes_nothing() -> None:
    for automaton in random_automata(30, max_states=4):
        lines = to_hoa(automaton).splitlines(keepends=True)
        for i in range(len(lines)):
            try:
                again = from_hoa("".join(lines[:i] + lines[i + 1 :]))
            except FileFormatError:
                continue
            assert i < lines.index("--BODY--\n")
            assert again.aps == () if lines[i].startswith("AP:") else equivalent(again, automaton)


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


def test_header_names_with_dots_and_denied_properties() -> None:
    text = hoa(
        "State: 0 [t] 0", header='spot.highlight.states: 0 3\nspot.x-y: t "s"\nproperties: deterministic !weak.x'
    )
    assert from_hoa(text.replace("v1", "v1.1")).n_states == 1


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
    names = " ".join(f'"p{i}"' for i in range(21))
    with pytest.raises(AlphabetLimitExceeded, match="21 propositions; at most 20"):
        from_hoa(hoa("State: 0 [t] 0", ap=f"21 {names}"))
    many = " ".join(f"State: {q} [{q % 20}] {q} [!{q % 20}] 0" for q in range(200))
    with pytest.raises(AlphabetLimitExceeded, match="200 states times 1048576 letter classes"):
        from_hoa(hoa(many, ap=f"20 {names.rsplit(' ', 1)[0]}", acceptance="0 t"))


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


# Spot, where it is installed

FORMULAS = [
    "F(A & F B) & G!C & FG T",
    "GFa & GFb",
    "(GFa -> GFb) & F(c & X d)",
    "FGa | (GFb & FGc) | GF(a & Xb)",
    "G(a -> Xb) | FG(b & Xc)",
    "(a U b) R (c | Xa)",
    "a xor GFb xor FGc",
]


@pytest.mark.parametrize(
    "options", ["det parity", "det parity sbacc", "det generic", "det generic complete", "det cobuchi"]
)
@pytest.mark.parametrize("formula", FORMULAS)
@pytest.mark.peer
def test_agrees_with_spot(formula: str, options: str) -> None:
    spot = pytest.importorskip("spot")
    theirs = spot.translate(formula, *options.split())
    if not spot.is_deterministic(theirs):
        pytest.skip("Spot gave a nondeterministic automaton")
    for style in ("", "i", "k", "t", "m"):
        if style == "i" and not spot.is_complete(theirs):
            continue
        ours = from_hoa(theirs.to_str("hoa", style))
        back = spot.automaton(to_hoa(ours))
        assert spot.is_deterministic(back)
        assert spot.is_complete(back)
        assert spot.are_equivalent(back, theirs)


@pytest.mark.peer
def test_spot_reads_what_we_write() -> None:
    spot = pytest.importorskip("spot")
    for automaton in random_automata(10):
        theirs = spot.automaton(to_hoa(automaton))
        assert theirs.num_states() == automaton.n_states
        assert equivalent(from_hoa(theirs.to_str("hoa")), automaton)
