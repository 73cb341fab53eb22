"""Acceptance on transitions for every automaton, so that what looks at cycles sees one kind of marks."""

from __future__ import annotations

from dataclasses import replace

from ltlc.automata.rabin import RabinAutomaton


def to_transition_based(automaton: RabinAutomaton) -> RabinAutomaton:
    """The same automaton with the marks of each state on the transitions into it."""
    if automaton.acceptance == "transition":
        return automaton
    return replace(automaton, fin=automaton.edge_fin, inf=automaton.edge_inf, acceptance="transition")
