"""Options of the commands that bring a task and an environment together, and what they mean."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

from ltlc.cli import completion, flags
from ltlc.cli.alphabet import declared
from ltlc.cli.inputs import given_automaton
from ltlc.cli.options import Option
from ltlc.cli.values import assignments, kinds_of
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.automata import DRA
    from ltlc.automata.finite import Goal
    from ltlc.automata.possible import DeclaredLetters
    from ltlc.envs.spec import EnvSpec


Labels = Annotated[
    str | None,
    Option(
        "--labels",
        "-l",
        metavar="MODULE:NAME",
        help="A function of the observation that returns the names that hold, or a dict of predicates; or the name of "
        "registered ones: {labellers}.",
        completion=completion.labels,
    ),
]
_ENV = Option(
    "--env",
    "-e",
    metavar="ID",
    help="An environment of Gymnasium's registry, or MODULE:ID.",
    completion=completion.environments,
)
Env = Annotated[str | None, _ENV]
GivenEnv = Annotated[str, _ENV]
Variables = Annotated[
    list[str] | None,
    Option(
        "--variables",
        metavar="NAME=PLACE",
        help="Where in an observation a number of that name stands, as in x=0 or speed=car.1; propositions are then "
        "comparisons in quotes. May be repeated.",
    ),
]
Robustness = Annotated[
    float | None,
    Option(
        "--robustness",
        least=0.0,
        metavar="WEIGHT",
        help="Let values begin with this weight times how near the numbers of --variables are to what is waited for. "
        "It changes no optimal policy.",
        shown_default="0",
    ),
]
EnvArguments = Annotated[
    list[str] | None,
    Option("--env-set", metavar="KEY=VALUE", help="An argument of the environment. May be repeated."),
]
EpisodeSteps = Annotated[
    int | None,
    Option("--episode-steps", least=1, metavar="N", help="Cut episodes after N steps.", shown_default="the env's"),
]
Discretise = Annotated[
    int | None,
    Option(
        "--discretise",
        least=2,
        metavar="N",
        help="Of continuous actions: take N values of each coordinate.",
        shown_default="no",
    ),
]
InitialLabel = Annotated[
    Literal["read", "skip"],
    Option("--initial-label", help="Whether the automaton reads the label of the first observation."),
]
Reward = Annotated[
    str | None,
    Option(
        "--reward",
        "-r",
        metavar="NAME",
        help="A scheme: {rewards}, or MODULE:CLASS. See 'ltlc rewards'.",
        shown_default="the recommended one",
        completion=flags.names_of("rewards"),
    ),
]
Parameters = Annotated[
    list[str] | None,
    Option("--set", "-s", metavar="KEY=VALUE", help="A parameter of the reward scheme. May be repeated."),
]
OnDeadlock = Annotated[
    Literal["stay", "initial", "terminate"] | None,
    Option("--on-deadlock", help="What follows a violation.", shown_default="what the scheme says"),
]
OnTermination = Annotated[
    Literal["repeat", "cut"],
    Option("--on-termination", help="Where the environment ends: its last letter for ever, or nothing."),
]


def parameters_of(texts: Sequence[str] | None, reward: str, option: str = "--set") -> dict[str, Any]:
    """The parameters of a reward scheme."""
    from ltlc.rewards import SCHEMES

    return assignments(texts, option, {"shaping": float} | kinds_of(SCHEMES[reward]))


def with_robustness(
    hyper: list[str] | None, robustness: float | None, variables: Sequence[str] | None, agent: str
) -> list[str] | None:
    """Hyperparameters as typed, with those that --robustness stands for.

    Raises:
        InvalidArgumentError: it is given without variables, or for an agent whose values begin with nothing.
    """
    if not robustness:
        return hyper
    if not variables:
        raise InvalidArgumentError("--robustness is about comparisons of numbers; say where they are: --variables x=0")
    from ltlc.agents.registry import AGENTS, AUTO, DOUBLE_DQN

    if agent != AUTO and not hasattr(AGENTS[agent].defaults, "robustness"):
        raise InvalidArgumentError(
            f"the agent {agent!r} plans with all that it has seen, whatever values begin with; --robustness is for "
            f"--agent {DOUBLE_DQN}"
        )
    return [*(hyper or ()), f"robustness={robustness}", f"variables={', '.join(variables)}"]


def _labels_of(labels: str | None, variables: Sequence[str] | None) -> str | None:
    """The labels that the options describe.

    Raises:
        InvalidArgumentError: there are two kinds, or a variable has no place.
    """
    from ltlc.envs.comparisons import VARIABLES, Variables

    if not variables:
        return labels
    if labels is not None:
        raise InvalidArgumentError("--labels and --variables are both given; labels can compare numbers themselves")
    return VARIABLES + Variables(", ".join(variables)).text


def automaton_of(
    source: str,
    env_spec: EnvSpec,
    acceptance: Literal["state", "transition"] = "state",
    translator: str = "auto",
    finite: bool = False,
    goal: Goal = "reach",
    exclusive: Sequence[str] | None = None,
) -> DRA:
    """The automaton in a file, or compiled from a formula; one over finite traces as that of their goal.

    A formula is compiled over the letters that --exclusive leaves, or those that the environment declares.
    """
    from ltlc.automata import DFA
    from ltlc.compiler import compile

    given = given_automaton(source)
    if isinstance(given, str):
        possible = (declared(exclusive) if exclusive else _letters_in(env_spec, given, finite))._asdict()
        if not finite:
            return compile(given, acceptance=acceptance, translator=translator, **possible)
        given = compile(given, finite=True, **possible)
    return given.with_goal(goal) if isinstance(given, DFA) else given


def _letters_in(env_spec: EnvSpec, formula: str, finite: bool) -> DeclaredLetters:
    """What the environment declares; or the letters of its exact model, where a formula has too many propositions."""
    from ltlc.automata.possible import MAX_APS
    from ltlc.compiler import as_formula
    from ltlc.envs.declared import letters_in
    from ltlc.ltl import propositions

    declared = env_spec.declared_letters
    if declared.exclusive or declared.letters is not None:
        return declared
    if len(propositions(as_formula(formula, finite=finite))) <= MAX_APS or env_spec.model is None:
        return declared
    return letters_in(env_spec.model)


def env_spec_of(
    env: str,
    labels: str | None,
    arguments: Sequence[str] | None,
    episode_steps: int | None = None,
    initial_label: Literal["read", "skip"] = "read",
    discretise: int | None = None,
    variables: Sequence[str] | None = None,
) -> EnvSpec:
    """The environment that the options describe."""
    from ltlc.envs.spec import EnvSpec

    kinds: dict[str, Any] = {}
    if arguments:
        for name, default in EnvSpec(env=env).default_arguments.items():
            # A number may be given where the default is one of another kind; a word or a switch may not.
            kinds |= {name: type(default)} if isinstance(default, bool) else {}
            kinds |= {name: str | None} if isinstance(default, str) else {}
    return EnvSpec(
        env=env,
        arguments=assignments(arguments, "--env-set", kinds),
        labels=_labels_of(labels, variables),
        max_episode_steps=episode_steps,
        initial_label=initial_label,
        discretise=discretise,
    )


def command_line(*words: str) -> str:
    """Words as a shell takes them."""
    return shlex.join(words)
