"""What is already known of a task before anything is learned, in plain words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ltlc.automata import DRA
from ltlc.mdp import LabelledMDP, MaxSatisfaction, Product, max_satisfaction_probability
from ltlc.mdp.product_exploration import InitialLabel
from ltlc.mdp.reachability import distance_to

Kind = Literal["unsatisfiable", "valid", "never", "always", "impossible", "improbable", "short-episodes"]


@dataclass(frozen=True)
class Diagnostic:
    """One thing that is known beforehand.

    Attributes:
        kind: what it is: the formula has no model or only models; a proposition never or always occurs; Pmax is 0 or
            small; episodes are cut too early.
        text: for a person: what is so, and what is optimised instead or what to do.
        proposition: of "never" and "always", the proposition.
    """

    kind: Kind
    text: str
    proposition: str | None = None


def diagnose(
    automaton: DRA,
    mdp: LabelledMDP | None = None,
    *,
    episode_steps: int | None = None,
    initial_label: InitialLabel = "read",
    maximum: MaxSatisfaction | None = None,
) -> tuple[Diagnostic, ...]:
    """What can be said of a task before training; empty where there is nothing to worry about.

    Args:
        automaton: of the formula.
        mdp: the environment, where its dynamics are known; otherwise only the formula is looked at.
        episode_steps: where episodes are cut off; None for never.
        initial_label: whether the label of the first state is read.
        maximum: the largest satisfaction probability, where it has been computed before (for this automaton).

    Raises:
        UnknownNameError: the automaton has a proposition that the environment does not label.
    """
    about_formula = _about_formula(automaton)
    if mdp is None:
        return about_formula
    diagnostics = [*about_formula, *_about_labels(automaton, mdp)]
    if about_formula:  # then the rest says the same once more
        return tuple(diagnostics)
    product = Product(mdp, automaton, initial_label=initial_label)
    if maximum is None or len(maximum.policy) != product.n_states:
        maximum = max_satisfaction_probability(product)
    diagnostics += _about_maximum(maximum)
    if maximum.probability > 0 and episode_steps is not None:
        diagnostics += _about_episodes(product, maximum, episode_steps)
    return tuple(diagnostics)


def _about_formula(automaton: DRA) -> tuple[Diagnostic, ...]:
    formula = automaton.formula or "the language of the automaton"
    if automaton.initial_state in automaton.deadlocks:
        text = (
            f"{formula} is unsatisfiable: no run can ever satisfy it. Every step counts as a violation, and rewards "
            "say nothing about it."
        )
        return (Diagnostic("unsatisfiable", text),)
    if automaton.initial_state in automaton.accepting_sinks:
        return (Diagnostic("valid", f"{formula} is valid: every run satisfies it, and there is nothing to learn."),)
    return ()


def _about_labels(automaton: DRA, mdp: LabelledMDP) -> list[Diagnostic]:
    """Propositions without a say, among the states that can be reached."""
    shown = np.asarray(mdp.label_probability[np.flatnonzero(mdp.explicit.reachable)].sum(axis=0)).ravel() > 0
    letters = mdp.letters[shown]
    diagnostics = []
    for name in automaton.aps:
        if name not in mdp.aps:
            continue
        holds = (letters >> mdp.aps.index(name)) & 1
        if not holds.any():
            text = f"{name!r} never holds in any state that can be reached: it is false for ever. Is the label right?"
            diagnostics.append(Diagnostic("never", text, name))
        elif holds.all():
            text = f"{name!r} holds in every state that can be reached: it is true for ever. Is the label right?"
            diagnostics.append(Diagnostic("always", text, name))
    return diagnostics


def _about_maximum(maximum: MaxSatisfaction) -> list[Diagnostic]:
    if maximum.probability > 0.01:
        return []
    if maximum.winning.any():
        text = (
            f"At best the formula is satisfied with probability {maximum.probability:.3g}. What an agent learns is "
            "decided almost only by runs that fail."
        )
        return [Diagnostic("improbable", text)]
    text = (
        "The probability of satisfying the formula is 0 under every policy: there is no accepting end component, that "
        "is, no set of states where a policy could stay for ever and keep the formula satisfied. What is optimised "
        "instead is the expected return of the reward scheme alone; look at violations per step and at the time to the "
        "first acceptance. Often noise ruins, sooner or later, a demand that must hold for ever: let the episode end "
        "at the goal, or demand it only until then (`!trap U goal` instead of `F goal & G !trap`)."
    )
    return [Diagnostic("impossible", text)]


def _about_episodes(product: Product, maximum: MaxSatisfaction, episode_steps: int) -> list[Diagnostic]:
    shortest = shortest_satisfaction(product, maximum)
    if shortest <= episode_steps:
        return []
    text = (
        f"Episodes are cut after {episode_steps} steps, but even the luckiest run needs {shortest} to accept where it "
        "can go on to satisfy the formula: no episode will ever see that. Allow more."
    )
    return [Diagnostic("short-episodes", text)]


def shortest_satisfaction(product: Product, maximum: MaxSatisfaction) -> int:
    """Fewest steps until a run has satisfied the formula for good, or accepts inside an accepting end component.

    The environment is taken to be as kind as possible. The maximum must be positive.
    """
    settled = maximum.winning & np.isin(product.automaton_state, product.automaton.accepting_sinks)
    accepts = np.zeros(product.n_states, dtype=np.bool_)
    for inf, component in zip(product.choice_inf, maximum.components, strict=True):
        accepts[product.choice_state[inf & component.choices]] = True
    start = np.flatnonzero(product.initial > 0)
    steps = [
        distance[start][distance[start] >= 0].min(initial=product.n_states) + further
        for distance, further in ((distance_to(product, settled), 0), (distance_to(product, accepts), 1))
    ]
    return int(min(steps))
