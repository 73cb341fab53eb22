"""Rabin automata in the special forms that other tools ask for: parity, Buchi and co-Buchi."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from ltlc.arrays import IntArray, np
from ltlc.automata.marks import buchi_edges
from ltlc.automata.parity import parity_colours, to_parity
from ltlc.automata.rabin import DRA, Form
from ltlc.automata.transition_based import to_transition_based
from ltlc.budget import MAX_STATES
from ltlc.errors import InvalidArgumentError, UnknownNameError


def with_form(automaton: DRA, form: Form, *, max_states: int = MAX_STATES) -> DRA:
    """An automaton for the same words whose pairs are of a special form, with acceptance on transitions.

    `parity` is a chain of pairs, see `to_parity`. `buchi` is one pair without Fin marks, `co-buchi` one pair whose Inf
    marks are everywhere; a Rabin automaton has the former on its own states if its language has it at all, and a parity
    automaton both. The result knows its form (`DRA.forms`), and HOA is written with the name and condition of it.

    Args:
        automaton: any Rabin automaton.
        form: "rabin" for the automaton itself.
        max_states: bound on the states of a parity automaton.

    Raises:
        UnknownNameError: there is no such form.
        InvalidArgumentError: no deterministic automaton of that form accepts the language.
        StateLimitExceeded: a parity automaton needs more states.

    Example:
        >>> import ltlc
        >>> with_form(ltlc.compile("G F a & G F b"), "buchi").to_hoa().splitlines()[6:8]
        ['acc-name: Buchi', 'Acceptance: 1 Inf(0)']

    References:
        S. C. Krishnan, A. Puri, R. K. Brayton, Deterministic omega-automata vis-a-vis deterministic Buchi automata,
        ISAAC 1994, doi 10.1007/3-540-58325-4_202.
    """
    if form not in get_args(Form):
        raise UnknownNameError("form", form, get_args(Form))
    if form == "rabin":
        return automaton
    if form == "buchi":
        accepting = buchi_edges(automaton)
        if accepting is None:
            raise _impossible(automaton, "Buchi", "is no recurrence property")
        inf = accepting[None]
        found = replace(to_transition_based(automaton), fin=np.zeros_like(inf), inf=inf)
        return found.annotated(form)
    parity = to_parity(automaton, max_states=max_states).automaton
    colours = parity_colours(parity)
    assert colours is not None
    if form == "parity":
        return coloured(parity, colours).annotated(form)
    rejecting = buchi_edges(coloured(parity, colours + 1))  # of the complement
    if rejecting is None:
        raise _impossible(automaton, "co-Buchi", "is no persistence property")
    fin = rejecting[None]
    return replace(to_transition_based(parity), fin=fin, inf=np.ones_like(fin)).annotated(form)


def coloured(automaton: DRA, colours: IntArray) -> DRA:
    """The graph of an automaton with a parity condition, as a chain of pairs, one for each odd colour.

    A run is accepted iff the largest colour that it sees infinitely often is odd.

    Args:
        automaton: the graph.
        colours: shape (n_states, n_classes), from 0 up.
    """
    odd = range(1, int(colours.max()) + 1, 2)
    shape = (0, *colours.shape)
    fin = np.array([colours > k for k in odd]).reshape(-1, *shape[1:]).astype(np.bool_)
    inf = np.array([colours == k for k in odd]).reshape(-1, *shape[1:]).astype(np.bool_)
    return replace(to_transition_based(automaton), fin=fin, inf=inf)


def _impossible(automaton: DRA, name: str, why: str) -> InvalidArgumentError:
    return InvalidArgumentError(
        f"no deterministic {name} automaton accepts the words of {automaton.formula or 'the automaton'}: it {why}; take"
        " the form parity, which every formula has"
    )
