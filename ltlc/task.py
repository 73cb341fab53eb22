"""A task: a formula, its automaton, and the rewards that teach it."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterable

import numpy as np

from ltlc.automata import DFA, DRA
from ltlc.automata.finite import Goal
from ltlc.automata.rabin import AcceptanceKind
from ltlc.compiler import compile
from ltlc.errors import InvalidArgumentError, RewardWarning, check_type
from ltlc.ltl import Formula
from ltlc.notebook import fragment
from ltlc.rewards import RECOMMENDED, OnDeadlock, OnTermination, RewardScheme, RewardTables, get_scheme


class Task:
    """What an agent is to learn: a formula as an automaton with reward tables.

    Attributes:
        automaton: the deterministic Rabin automaton; of a formula about finite traces, that of its goal.
        scheme: the reward scheme.
        on_deadlock: see below; None: what the scheme says.
        on_termination: see below.
        tables: the scheme compiled for the automaton; all that stepping needs. Their states may refine those of the
            automaton, and they may leave the choice of a Rabin pair to the policy; see `RewardTables`.
        formula: text of the formula, or None for an automaton of unknown origin.

    Args:
        formula: a formula, its text, or an automaton.
        finite: whether the formula is about finite traces; an automaton says itself what it is about.
        goal: when a formula about finite traces is satisfied: "reach", as soon as the trace so far satisfies it; "end",
            if the trace satisfies it when the environment terminates, and not at all if it never does.
        reward: a scheme, or its name in `ltlc.rewards.SCHEMES`; by default `ltlc.rewards.RECOMMENDED`.
        shaping: potential of an accepting cycle for shaping by distance to acceptance, if `reward` is a name; 0: none.
        on_deadlock: what follows a violation: "stay", "initial" or "terminate"; by default what the scheme says.
        on_termination: what follows where the environment ends the episode: "repeat" (the last letter for ever, and the
            last step is paid what that is worth) or "cut" (nothing); see `RewardScheme.compile`.
        hold: a proposition on which the automaton stands still, for environments whose sensors sometimes say nothing
            (the thesis code; such a letter repeats the state instead of being read); None for none.
        acceptance: see `ltlc.compile`; without effect for an automaton.
        translator: see `ltlc.compile`; without effect for an automaton.
        exclusive: see `ltlc.compile`; without effect for an automaton.
        letters: see `ltlc.compile`; without effect for an automaton.

    Warns:
        RewardWarning: the scheme has no guarantee.

    Raises:
        LtlSyntaxError: the text is not a formula.
        UnknownNameError: there is no such scheme, mode or translator.
        InvalidArgumentError: a parameter does not fit the automaton.
        LimitExceeded: the formula is too large.

    Example:
        >>> task = Task("F goal & G !hole", reward="zeta-discount")
        >>> task.automaton.aps
        ('goal', 'hole')
        >>> Task("G !hole & F(goal & last)", finite=True).automaton.n_states
        3
    """

    def __init__(
        self,
        formula: Formula | str | DRA | DFA,
        reward: str | RewardScheme = RECOMMENDED,
        *,
        finite: bool = False,
        goal: Goal = "reach",
        shaping: float = 0.0,
        on_deadlock: OnDeadlock | None = None,
        on_termination: OnTermination = "repeat",
        hold: str | None = None,
        acceptance: AcceptanceKind = "state",
        translator: str = "auto",
        exclusive: Iterable[Iterable[str]] = (),
        letters: Iterable[Iterable[str]] | None = None,
    ) -> None:
        if isinstance(formula, DRA):
            automaton = formula
        elif isinstance(formula, DFA):
            automaton = formula.with_goal(goal)
        elif finite:
            automaton = compile(formula, finite=True, exclusive=exclusive, letters=letters).with_goal(goal)
        else:
            automaton = compile(
                formula, acceptance=acceptance, translator=translator, exclusive=exclusive, letters=letters
            )
        if not isinstance(reward, str) and shaping:
            raise InvalidArgumentError("shaping goes with the name of a scheme; wrap a scheme object in Shaped instead")
        check_type(reward, (str, RewardScheme), "reward", "the name of a scheme, or a scheme")
        self.automaton = automaton if hold is None else with_hold(automaton, hold)
        self.on_deadlock, self.on_termination = on_deadlock, on_termination
        self.scheme = get_scheme(reward, shaping=shaping) if isinstance(reward, str) else reward
        if not self.scheme.has_guarantee:
            warnings.warn(RewardWarning(_no_guarantee(self.scheme)), stacklevel=2)
        self.tables: RewardTables = self.scheme.compile(self.automaton, on_deadlock, on_termination)

    @property
    def formula(self) -> str | None:
        """Text of the formula, or None."""
        return self.automaton.formula

    @property
    def aps(self) -> tuple[str, ...]:
        """The atomic propositions that labels are about."""
        return self.automaton.aps

    @property
    def discount(self) -> float | None:
        """The discount of all steps that an episode goes on after, or None where it differs.

        An agent that knows one discount only can learn nothing but a task that has one; the others tell it the
        discount of each step in `info["ltl"]["discount"]`.
        """
        used = np.unique(self.tables.discount[self.tables.stop < 1])
        return float(used[0]) if len(used) == 1 else None

    def for_horizon(self, steps: int) -> Task:
        """The task with the discounts of a learner that looks so many steps ahead, at least 2; 0: as it is.

        Parameters of the rewards that somebody has set stay; see `RewardScheme.for_horizon`.
        """
        scheme = self.scheme.for_horizon(steps) if steps else self.scheme
        if scheme == self.scheme:
            return self
        return Task(self.automaton, scheme, on_deadlock=self.on_deadlock, on_termination=self.on_termination)

    def _repr_html_(self) -> str:
        """The automaton and what is paid, for a notebook."""
        automaton, tables = self.automaton, self.tables
        discount = "one for each step" if self.discount is None else f"{self.discount:g}"
        rows = [
            ("automaton", automaton.size),
            ("rewards", str(self.scheme)),
            ("guarantee", self.scheme.guarantee),
            ("discount", discount),
            ("table states", str(tables.n_states)),
        ]
        return fragment(self.formula or "a task", rows, picture=automaton._repr_svg_() or "")

    def __repr__(self) -> str:
        return f"<Task {self.formula or 'of an unnamed language'}: {self.automaton.n_states} states, {self.scheme}>"


def _no_guarantee(scheme: RewardScheme) -> str:
    known = scheme.guarantee.removeprefix("None: ")
    return (
        f"the rewards {scheme.name!r} do not guarantee that an optimal policy satisfies the formula as probably as "
        f"possible. {known[0].upper()}{known[1:]} The default, {RECOMMENDED!r}, guarantees it in a limit."
    )


def with_hold(automaton: DRA, proposition: str) -> DRA:
    """The automaton with one more proposition; on letters that have it, the state stays what it is.

    Standing still counts as entering the state again; with acceptance on transitions it carries no mark.

    Raises:
        InvalidArgumentError: the automaton has that proposition already.
    """
    if proposition in automaton.aps:
        raise InvalidArgumentError(f"the hold proposition {proposition!r} occurs in the formula; choose another name")
    n, k = automaton.delta.shape
    fin, inf = automaton.fin, automaton.inf
    if automaton.acceptance == "transition":
        still = np.zeros((automaton.n_pairs, n, 1), dtype=np.bool_)
        fin, inf = np.concatenate([fin, still], axis=2), np.concatenate([inf, still], axis=2)
    return dataclasses.replace(
        automaton,
        aps=(*automaton.aps, proposition),
        delta=np.column_stack([automaton.delta, np.arange(n, dtype=np.int32)]),
        letter_class=np.concatenate([automaton.letter_class, np.full_like(automaton.letter_class, k)]),
        possible=None if automaton.possible is None else (*automaton.possible, (0, 1 << len(automaton.aps))),
        fin=fin,
        inf=inf,
    )
