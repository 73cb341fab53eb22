"""What every reward scheme is: parameters, a citation, a guarantee, and a way to compile an automaton into tables."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from ltlc.automata import DRA, Refinement
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.rewards.closing import closed
from ltlc.rewards.tables import BoolArray, FloatArray, OnTermination, RewardTables

OnDeadlock = Literal["stay", "initial", "terminate"]

SMALLEST_DISTANCE = 1e-12
"""a discount nearer to 1 loses too many of its 16 digits in the products and sums that values are made of."""


@dataclass(frozen=True)
class StepRewards:
    """What a scheme says about each step (state, letter class), before deadlocks and accepting sinks are dealt with.

    Each entry is a number for all steps, or an array of shape (n_states, n_classes).

    Attributes:
        accepted: whether it carries an acceptance mark.
        reward, discount, stop, stop_reward: as in `RewardTables`.
        violation: reward of a step that enters a deadlock or breaks the promise to satisfy a pair, instead of `reward`.
        satisfaction: reward of the step into an accepting sink, where the episode ends: what accepting at every step
            for ever would be worth; None if that has no finite value, and then the episode goes on.
    """

    accepted: BoolArray
    reward: FloatArray | float = 0.0
    discount: FloatArray | float = 1.0
    stop: FloatArray | float = 0.0
    stop_reward: FloatArray | float = 0.0
    violation: float = 0.0
    satisfaction: float | None = None


@dataclass(frozen=True)
class RewardScheme(ABC):
    """A way to turn a deterministic Rabin automaton into rewards; the fields of a scheme are its parameters.

    Attributes:
        citation: authors, title, venue, year and DOI of the source.
        guarantee: one sentence: what a policy that is optimal for these rewards is known to satisfy.
        requires: the form of automaton that `steps` takes; `compile` brings any automaton into it.
        comparisons: the parameters, besides the defaults, with which `ltlc.faithful` compares it with other schemes.
        on_deadlock: what follows a violation unless `compile` is told otherwise.
    """

    name: ClassVar[str]
    citation: ClassVar[str]
    guarantee: ClassVar[str]
    requires: ClassVar[str]
    comparisons: ClassVar[tuple[Mapping[str, Any], ...]] = ({},)
    on_deadlock: ClassVar[OnDeadlock] = "terminate"

    @abstractmethod
    def steps(self, dra: DRA) -> StepRewards:
        """Rewards and discounts of every step of the automaton.

        Raises:
            InvalidArgumentError: the automaton lacks the form the scheme needs.
        """

    def refinement(self, dra: DRA) -> Refinement:
        """The automaton in the form that `steps` takes; here any will do."""
        return Refinement.trivial(dra)

    def towards_limit(self, k: int) -> RewardScheme | None:
        """The scheme with parameters k steps nearer to the limit in which its optimum maximises P(sat).

        With k = 0 it is the scheme itself; each step divides what is left by ten or more. Here there is no such limit,
        which is said by None.
        """
        return None

    def for_horizon(self, steps: int) -> RewardScheme:
        """The scheme for a learner that looks so many steps ahead, at least 2.

        Parameters that were set stay; here all do.
        """
        return self

    @property
    def has_guarantee(self) -> bool:
        """Whether optimal policies maximise the probability of satisfaction, near enough to a limit of parameters."""
        return self.towards_limit(0) is not None

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameter values by name."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    def compile(
        self,
        dra: DRA,
        on_deadlock: OnDeadlock | None = None,
        on_termination: OnTermination = "repeat",
    ) -> RewardTables:
        """The tables of this scheme for one automaton.

        An automaton without the form the scheme needs gets it: table states then refine its states, and where only a
        policy can know which pair it is going to satisfy, the tables have choices (`RewardTables.select_pair`).

        The reward is computed from the state entered, before any reset, so a violation is always paid for. The step
        into an accepting sink ends the episode wherever staying there has a finite value. So does a step that breaks
        the promise to satisfy a pair.

        Args:
            dra: the automaton.
            on_deadlock: after a violation go back to the state before it (`stay`), to the initial state (`initial`), or
                end the episode (`terminate`); by default what the source of the scheme does.
            on_termination: where the environment ends the episode, the word goes on with its last letter and so do the
                rewards (`repeat`), or nothing follows (`cut`). Rewards of which some letter, read for ever, would pay
                an infinite or undetermined sum are always cut; `RewardTables.on_termination` says what is done.

        Raises:
            InvalidArgumentError: a parameter does not fit the automaton.
            StateLimitExceeded: the form would need too many states.
            UnknownNameError: `on_deadlock` or `on_termination` does not exist.
        """
        mode = check_on_deadlock(self.on_deadlock if on_deadlock is None else on_deadlock)
        refinement = self.refinement(dra)
        return closed(tables_of(dra, refinement, self.steps(refinement.automaton), mode), on_termination)


def nearer_to_one(value: float, k: int) -> float:
    """The value with its distance to 1 divided by 10**k, as far as double precision has room for it."""
    nearer: float = round(1 - (1 - value) / 10**k, 15)
    return max(value, min(nearer, 1 - SMALLEST_DISTANCE))


def check_on_deadlock(mode: str) -> OnDeadlock:
    """The mode itself.

    Raises:
        UnknownNameError: it is none of the three.
    """
    if mode not in get_args(OnDeadlock):
        raise UnknownNameError("deadlock mode", mode, get_args(OnDeadlock))
    return mode  # type: ignore[return-value]


def check_probability(scheme: RewardScheme, field: str, *, one: bool = False) -> None:
    """Check that a parameter lies strictly between 0 and 1 (`one`: may also be 1).

    Raises:
        InvalidArgumentError: it does not.
    """
    value = getattr(scheme, field)
    if not (0 < value < 1 or (one and value == 1)):
        bounds = "in (0, 1]" if one else "strictly between 0 and 1"
        raise InvalidArgumentError(f"reward scheme {scheme.name}: {field} is {value!r}; it must lie {bounds}")


def tables_of(dra: DRA, refinement: Refinement, steps: StepRewards, on_deadlock: OnDeadlock) -> RewardTables:
    """Put what a scheme says about steps together with deadlocks, accepting sinks and progress of the automaton.

    Args:
        dra: the automaton of the task.
        refinement: of it, that `steps` is about.
        steps: what the scheme says.
        on_deadlock: see `RewardScheme.compile`.
    """
    delta, origin = refinement.automaton.delta, refinement.origin
    broken = (origin < 0)[delta]
    entered = np.where(broken, dra.delta[origin], origin[delta])
    violated = is_deadlock(dra)[entered]
    broken &= ~violated
    settled = is_accepting_sink(dra)[entered] & ~broken
    satisfied = settled & (steps.satisfaction is not None)
    reward, discount, stop, stop_reward = (
        np.broadcast_to(np.asarray(part, dtype=np.float64), delta.shape).copy()
        for part in (steps.reward, steps.discount, steps.stop, steps.stop_reward)
    )
    failed = violated | broken
    reward[failed], stop[failed], stop_reward[failed] = steps.violation, broken[failed], 0.0
    reward[satisfied], stop[satisfied], stop_reward[satisfied] = steps.satisfaction or 0.0, 1.0, 0.0
    # the states without a promise come first, numbered as those of the automaton
    next_state = np.where(origin[delta] < 0, entered, delta)
    if on_deadlock == "stay":
        next_state = np.where(violated, np.arange(len(delta))[:, None], next_state)
    elif on_deadlock == "initial":
        next_state[violated] = refinement.automaton.initial_state
    else:
        stop[violated] = 1.0
    kept = origin >= 0
    return RewardTables(
        aps=dra.aps,
        letter_class=refinement.automaton.letter_class,
        initial_state=refinement.automaton.initial_state,
        next_state=next_state[kept],
        reward=reward[kept],
        discount=discount[kept],
        stop=stop[kept],
        stop_reward=stop_reward[kept],
        violated=violated[kept],
        accepted=((steps.accepted | settled) & ~failed)[kept],
        automaton_state=origin[kept],
        progress=progress(dra)[origin[kept]],
        select_pair=refinement.select_pair[kept],
        possible=refinement.automaton.possible,
    )


def is_deadlock(dra: DRA) -> BoolArray:
    """Which states have an empty language, shape (n_states,)."""
    return _members(dra, dra.deadlocks)


def is_accepting_sink(dra: DRA) -> BoolArray:
    """Which states accept every word, shape (n_states,)."""
    return _members(dra, dra.accepting_sinks)


def progress(dra: DRA) -> FloatArray:
    """How near each state is to an accepting cycle: 1 on one, 0 in a deadlock, linear in the letters between."""
    distance = dra.annotations.distance
    return np.where(distance < 0, 0.0, 1.0 - distance / (distance.max(initial=0) + 1.0))


def _members(dra: DRA, states: tuple[int, ...]) -> BoolArray:
    mask = np.zeros(dra.n_states, dtype=np.bool_)
    mask[list(states)] = True
    return mask
