"""Automaton forms that schemes ask for, and the error where one is missing."""

from __future__ import annotations

import numpy as np

from ltlc.automata import RabinAutomaton
from ltlc.errors import InvalidArgumentError
from ltlc.rewards import forms
from ltlc.rewards.scheme import RewardScheme
from ltlc.rewards.tables import BoolArray, IntArray


def buchi(scheme: RewardScheme, dra: RabinAutomaton) -> BoolArray:
    """Accepting edges of the automaton as a Büchi automaton.

    Raises:
        InvalidArgumentError: it is none.
    """
    marks = forms.buchi_marks(dra)
    if marks is None:
        raise lacks_form(scheme, dra)
    return marks


def buchi_or_one_pair(scheme: RewardScheme, dra: RabinAutomaton) -> BoolArray:
    """Accepting edges as a Büchi automaton, or else the Inf edges (without Fin) of the only pair.

    Raises:
        InvalidArgumentError: there are several pairs, and no Büchi form.
    """
    marks = forms.buchi_marks(dra)
    if marks is not None:
        return marks
    if dra.n_pairs == 1:
        return np.asarray(dra.edge_inf[0] & ~dra.edge_fin[0])
    raise lacks_form(scheme, dra)


def parity(scheme: RewardScheme, dra: RabinAutomaton) -> IntArray:
    """Colours of the automaton as a parity automaton (max odd).

    Raises:
        InvalidArgumentError: it is none.
    """
    colours = forms.parity_colours(dra)
    if colours is None:
        raise lacks_form(scheme, dra)
    return colours


def lacks_form(scheme: RewardScheme, dra: RabinAutomaton) -> InvalidArgumentError:
    """The error for an automaton without the form that the steps of a scheme are about."""
    pairs = "1 Rabin pair" if dra.n_pairs == 1 else f"{dra.n_pairs} Rabin pairs"
    return InvalidArgumentError(
        f"reward scheme {scheme.name!r} needs {scheme.needs}, and the automaton of {dra.formula or 'this language'} "
        f"({dra.n_states} states, {pairs}) has not; `compile` brings it into that form, `steps` does not"
    )
