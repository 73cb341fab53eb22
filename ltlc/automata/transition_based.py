"""Acceptance on transitions for every automaton, so that what looks at cycles sees one kind of marks."""

from __future__ import annotations

from dataclasses import replace

from ltlc.automata.rabin import DRA


def to_transition_based(automaton: DRA) -> DRA:
    """The same automaton with the marks of each state on the transitions into it."""
    if automaton.acceptance == "transition":
        return automaton
    return replace(automaton, fin=automaton.edge_fin, inf=automaton.edge_inf, acceptance="transition")
