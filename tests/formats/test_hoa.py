"""HOA: round trips, ways to write the same, streams, every message, and Spot."""

from __future__ import annotations

import io
import re

import pytest
from hoa_texts import hoa
from random_automata import random_automata

from ltlc.automata import DRA
from ltlc.automata.compare import equivalent, is_empty
from ltlc.errors import FileFormatError
from ltlc.formats import from_hoa, read_hoa_stream, to_hoa


@pytest.mark.slow
def test_round_trip_is_stable_and_keeps_the_language() -> None:
    for automaton in random_automata(60, max_aps=3):
        text = to_hoa(automaton)
        again = from_hoa(text)
        assert to_hoa(again) == text
        assert again.acceptance == automaton.acceptance
        assert equivalent(again, automaton)


def test_text() -> None:
    automaton = DRA(("a", 'b "q"'), [[0, 1], [1, 1]], [0, 0, 0, 1], [[1, 0]], [[0, 1]], formula='F(a & "b \\"q\\"")')
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


def infinitely_often_a() -> DRA:
    return DRA(("a", "b"), [[0, 0]], [0, 1, 0, 1], [[[0, 0]]], [[[0, 1]]], acceptance="transition")


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


@pytest.mark.slow
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
