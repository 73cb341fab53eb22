"""What each reward scheme really optimises: the exact satisfaction probability of its optimal policy."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ltlc.automata import DRA
from ltlc.compiler import compile
from ltlc.errors import InvalidArgumentError, RewardWarning, StateLimitExceeded
from ltlc.ltl import Formula
from ltlc.mdp import LabelledMDP, Product, max_satisfaction_probability
from ltlc.mdp.figures import figure_text
from ltlc.mdp.product_exploration import InitialLabel
from ltlc.mdp.verdict import TOLERANCE, Judge
from ltlc.notebook import fragment
from ltlc.rewards import RECOMMENDED, SCHEMES, OnDeadlock, OnTermination, RewardScheme, arguments_of, get_scheme
from ltlc.task import Task

FAITHFUL_GAP = 1e-5
"""a policy that misses Pmax by no more counts as one that attains it: solvers and limits leave that much open."""


SEARCHED_UP_TO = 10_000
"""product states; in larger ones, no other rewards are tried for a task whose rewards fall short."""
STEPS_TO_LIMIT = 3
"""towards the limit of a scheme; further on, values are too near to each other to learn by."""


@dataclass(frozen=True)
class Candidate:
    """A reward scheme with its parameters, under a name for the table.

    Attributes:
        on_deadlock: None: what the scheme says.
    """

    name: str
    scheme: RewardScheme
    on_deadlock: OnDeadlock | None = None
    on_termination: OnTermination = "repeat"

    @classmethod
    def from_name(
        cls,
        scheme: str,
        on_deadlock: OnDeadlock | None = None,
        on_termination: OnTermination = "repeat",
        **parameters: Any,
    ) -> Candidate:
        """A scheme by name; the candidate is called after what differs from its defaults.

        Raises:
            UnknownNameError: there is no such scheme.
            InvalidArgumentError: it has no such parameter, or the value is out of range.
        """
        found = get_scheme(scheme, **parameters)
        return cls(_title(scheme, parameters, on_deadlock, on_termination), found, on_deadlock, on_termination)

    def task(self, automaton: DRA) -> Task:
        """The task of an automaton with these rewards; a missing guarantee is no reason to warn here.

        Raises:
            InvalidArgumentError: the scheme does not apply to the automaton.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RewardWarning)
            return Task(automaton, self.scheme, on_deadlock=self.on_deadlock, on_termination=self.on_termination)


def _title(
    scheme: str, parameters: Mapping[str, Any], on_deadlock: OnDeadlock | None, on_termination: OnTermination
) -> str:
    shown = [f"{key}={value}" for key, value in parameters.items()]
    shown += [] if on_deadlock is None else [f"deadlock={on_deadlock}"]
    shown += [] if on_termination == "repeat" else [f"termination={on_termination}"]
    return " ".join([scheme, *shown])


@dataclass(frozen=True)
class Faithfulness:
    """What one reward scheme optimises in one task.

    Attributes:
        objective: largest expected return of the scheme; None where it has none, or where the scheme does not apply.
        satisfaction: probability that a policy with that return satisfies the formula.
        gap: what it misses the maximum by.
        problem: why there is no answer.
    """

    name: str
    scheme: str
    parameters: Mapping[str, Any]
    guarantee: str
    objective: float | None
    satisfaction: float | None
    gap: float | None
    problem: str | None = None

    @property
    def faithful(self) -> bool | None:
        """Whether the optimal policy attains the maximum; None where there is no answer."""
        return None if self.gap is None else self.gap <= FAITHFUL_GAP


@dataclass(frozen=True)
class FaithfulnessReport:
    """The faithfulness of several schemes in one task.

    Attributes:
        maximum: the maximum satisfaction probability, Pmax.
    """

    formula: str | None
    maximum: float
    lower: float
    upper: float
    rows: tuple[Faithfulness, ...]

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        rows = [
            (
                row.name,
                "" if row.objective is None else figure_text(row.objective),
                row.problem or ("" if row.satisfaction is None else figure_text(row.satisfaction)),
                "" if row.faithful is None or row.gap is None else "none" if row.faithful else figure_text(row.gap),
            )
            for row in self.rows
        ]
        heading = f"{self.formula or 'the task'}: at most {figure_text(self.maximum)} is possible"
        return fragment(heading, rows, titles=("optimal for", "best return", "P(satisfied)", "loses"))

    def to_dict(self) -> dict[str, Any]:
        """The report as JSON values."""
        rows = [asdict(row) | {"parameters": dict(row.parameters), "faithful": row.faithful} for row in self.rows]
        return {"formula": self.formula, "maximum_satisfaction": [self.lower, self.maximum, self.upper], "rows": rows}


def default_candidates(
    on_deadlock: OnDeadlock | None = None, on_termination: OnTermination = "repeat"
) -> tuple[Candidate, ...]:
    """Every scheme there is, with the parameters of its paper and others that it wants compared."""
    return tuple(
        Candidate.from_name(name, on_deadlock, on_termination, **parameters)
        for name, scheme in SCHEMES.items()
        for parameters in scheme.comparisons
    )


def faithfulness(
    mdp: LabelledMDP,
    formula: Formula | str | DRA,
    candidates: Sequence[Candidate] | None = None,
    *,
    initial_label: InitialLabel = "read",
) -> FaithfulnessReport:
    """What each scheme really optimises in a known environment.

    For each candidate the product of environment and reward tables is solved exactly for the scheme's own objective,
    and the policy found is judged by the formula alone: as an endless run, in which a violation is final. Where several
    policies are optimal for a scheme, one is judged; the others may do better or worse, which is itself a reason not to
    trust the scheme.

    Args:
        mdp: the environment.
        formula: the task.
        candidates: None for `default_candidates`.
        initial_label: whether the label of the first state is read.

    Raises:
        LtlSyntaxError: the text is not a formula.
        UnknownNameError: the formula has a proposition that the environment does not label.
    """
    automaton = formula if isinstance(formula, DRA) else compile(formula)
    maximum = max_satisfaction_probability(Product(mdp, automaton, initial_label=initial_label))
    rows = [
        _row(mdp, automaton, candidate, maximum.probability, initial_label)
        for candidate in (default_candidates() if candidates is None else candidates)
    ]
    return FaithfulnessReport(automaton.formula, maximum.probability, maximum.lower, maximum.upper, tuple(rows))


def _row(
    mdp: LabelledMDP, automaton: DRA, candidate: Candidate, maximum: float, initial_label: InitialLabel
) -> Faithfulness:
    scheme = candidate.scheme
    objective = satisfaction = gap = None
    problem = None
    try:
        task = candidate.task(automaton)
    except InvalidArgumentError as error:
        problem = str(error)
    else:
        judge = Judge(mdp, task, initial_label=initial_label)
        objective = judge.value
        if objective is None or judge.optimal_policy is None:
            problem = "its return has no finite maximum"
        else:
            satisfaction = judge.satisfaction(judge.optimal_policy)
            gap = max(0.0, maximum - satisfaction)
    return Faithfulness(
        candidate.name, scheme.name, scheme.parameters, scheme.guarantee, objective, satisfaction, gap, problem
    )


@dataclass(frozen=True)
class Shortfall:
    """What a policy that is optimal for the rewards of a task misses, and rewards whose optimum does not.

    Attributes:
        maximum: the maximum satisfaction probability, Pmax.
        satisfaction: probability that the policy that is optimal for the rewards satisfies the formula; None: there is
            no such policy, since the rewards can be collected for ever without a discount.
        better: rewards whose optimum comes within `TOLERANCE` of the maximum; None: none were found.
        better_satisfaction: probability that a policy that is optimal for these satisfies the formula.
        searched: whether other rewards were tried; they are not where the product has more than `SEARCHED_UP_TO`
            states.
    """

    maximum: float
    satisfaction: float | None
    better: Candidate | None
    better_satisfaction: float | None
    searched: bool

    @property
    def text(self) -> str:
        """What falls short and what does not, for a person."""
        best = figure_text(self.maximum, digits=6)
        if self.satisfaction is None:
            missed = f"the rewards have no optimal policy, and the formula can be satisfied with probability {best}"
        else:
            missed = (
                "a policy that is optimal for the rewards satisfies the formula with probability "
                f"{figure_text(self.satisfaction, digits=6)} where {best} is possible"
            )
        if self.better is None:
            tried = "no rewards that were tried reach it" if self.searched else "the model is too large to try others"
            return f"{missed}; {tried}"
        reached = "" if self.better_satisfaction is None else figure_text(self.better_satisfaction, digits=6)
        return f"{missed}; the optimum of the rewards {self.better.name} satisfies it with probability {reached}"

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        reached = None
        if self.better is not None:
            name, parameters = arguments_of(self.better.scheme)
            reached = {
                "reward": name,
                "parameters": parameters,
                "on_deadlock": self.better.on_deadlock,
                "on_termination": self.better.on_termination,
                "satisfaction": self.better_satisfaction,
            }
        return {
            "maximum_satisfaction": self.maximum,
            "satisfaction": self.satisfaction,
            "reached_by": reached,
            "searched": self.searched,
        }


def shortfall(judge: Judge, task: Task) -> Shortfall | None:
    """What the optimum of the rewards of a task misses of the maximum satisfaction probability; None: nothing much.

    Where it falls short, other rewards are tried in turn, and the optimum of each is judged exactly: the same scheme
    nearer to its limit, then the recommended one at its defaults and nearer to its limit, then all others with a limit.

    Args:
        judge: of the task.
        task: the task.
    """
    if not judge.falls_short:
        return None
    maximum = judge.maximum
    satisfaction = None if judge.optimum is None else judge.optimum.satisfaction
    if judge.rewards.n_states > SEARCHED_UP_TO:
        return Shortfall(maximum.probability, satisfaction, None, None, searched=False)
    for candidate in _nearer(task):
        try:
            other = candidate.task(task.automaton)
        except (InvalidArgumentError, StateLimitExceeded):  # the scheme does not apply, or only to a huge automaton
            continue
        tried = Judge(judge.rewards.mdp, other, initial_label=judge.initial_label)
        if tried.optimal_policy is not None:
            reached = tried.policy_satisfaction(tried.optimal_policy)
            if reached.lower >= maximum.probability - min(TOLERANCE, maximum.lower / 2):
                return Shortfall(maximum.probability, satisfaction, candidate, reached.probability, searched=True)
    return Shortfall(maximum.probability, satisfaction, None, None, searched=True)


def _nearer(task: Task) -> Iterator[Candidate]:
    """Rewards to try instead of those of a task, each once."""
    steps = range(STEPS_TO_LIMIT + 1)
    named = [get_scheme(RECOMMENDED), *(SCHEMES[name]() for name in SCHEMES)]
    schemes = [scheme.towards_limit(k) for scheme in (task.scheme, *named) for k in steps]
    given = (task.on_deadlock, task.on_termination)
    for modes in dict.fromkeys((given, _DEFAULT_MODES)):
        for scheme in dict.fromkeys(schemes):
            if scheme is not None and (scheme, modes) != (task.scheme, given):
                yield Candidate(_title(*arguments_of(scheme), *modes), scheme, *modes)


_DEFAULT_MODES: tuple[OnDeadlock | None, OnTermination] = (None, "repeat")
