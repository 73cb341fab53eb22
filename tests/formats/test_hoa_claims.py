"""What an HOA file claims about itself is checked."""

from __future__ import annotations

import pytest
from hoa_texts import hoa
from random_automata import random_automata

from ltlc.automata.compare import equivalent
from ltlc.errors import FileFormatError
from ltlc.formats import from_hoa, to_hoa


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


@pytest.mark.slow
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


def test_header_names_with_dots_and_denied_properties() -> None:
    text = hoa(
        "State: 0 [t] 0", header='spot.highlight.states: 0 3\nspot.x-y: t "s"\nproperties: deterministic !weak.x'
    )
    assert from_hoa(text.replace("v1", "v1.1")).n_states == 1
