"""Options that several commands share; a command lists those it wants among its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Annotated, Literal

from ltlc.cli.options import Option


def _translators() -> Iterable[str]:
    from ltlc.translate import TRANSLATORS

    return ("auto", *TRANSLATORS)


def _rewards() -> Iterable[str]:
    from ltlc.rewards import SCHEMES

    return SCHEMES


def _agents() -> Iterable[str]:
    from ltlc.agents.registry import AGENTS, AUTO

    return (AUTO, *AGENTS)


def _formats() -> Iterable[str]:
    from ltlc.formats import FORMATS

    return FORMATS


def _suffixes() -> Iterable[str]:
    from ltlc.automata.formats import suffixes

    return suffixes()


def _labellers() -> Iterable[str]:
    from ltlc.envs.labels import LABELLERS

    return LABELLERS


NAMES: Mapping[str, Callable[[], Iterable[str]]] = MappingProxyType(
    {
        "translators": _translators,
        "rewards": _rewards,
        "agents": _agents,
        "formats": _formats,
        "suffixes": _suffixes,
        "labellers": _labellers,
    }
)
"""the names of every kind of part, for help and completion."""


def names_of(kind: str) -> Callable[[str], list[str]]:
    """Make the completion of an option that takes the name of a part of a kind."""
    return lambda incomplete: [name for name in NAMES[kind]() if name.startswith(incomplete)]


Translator = Annotated[
    str,
    Option(
        "--translator",
        "-t",
        metavar="NAME",
        help="Construction to use: {translators}; auto keeps the smallest result of several. See 'ltlc translators'.",
        completion=names_of("translators"),
    ),
]
Effort = Annotated[
    Literal["fast", "default", "best"],
    Option("--effort", "-e", help="Stop at the first good automaton, compare several, or find the smallest."),
]
Acceptance = Annotated[
    Literal["state", "transition"],
    Option("--acceptance", "-a", help="Put the marks of the pairs on states or on transitions."),
]
Finite = Annotated[bool, Option("--finite", help="Read the formula as one about finite traces (LTLf).")]
Goal = Annotated[
    Literal["reach", "end"],
    Option("--goal", help="Satisfy a formula about finite traces at some time, or where the episode ends."),
]
Form = Annotated[
    Literal[
        "rabin",
        "parity",
        "buchi",
        "co-buchi",
        "emerson-lei",
        "generalized-rabin",
        "streett",
        "limit-deterministic",
    ],
    Option("--form", help="Another acceptance condition, on transitions; the last four are written as HOA only."),
]
Exclusive = Annotated[
    list[str] | None,
    Option(
        "--exclusive",
        metavar="A,B,...",
        help="Propositions of which at most one holds at a time: other letters are left out. May be repeated.",
    ),
]
Letters = Annotated[
    str | None,
    Option("--letters", metavar="'A; B & C; 1'", help="All letters that are possible (1: nothing holds)."),
]
Determinise = Annotated[
    bool, Option("--determinise", help="Make a nondeterministic Buchi automaton in HOA deterministic.")
]
MaxStates = Annotated[
    int,
    Option("--max-states", metavar="N", help="Give up, with exit code 3, before building more states."),
]
Timeout = Annotated[
    float | None,
    Option("--timeout", metavar="SECONDS", help="Give up, with exit code 3, after this time."),
]
Prism = Annotated[
    str | None,
    Option(
        "--prism",
        metavar="DIR",
        is_path=True,
        help="Write files with which PRISM or Storm can check the probability.",
    ),
]
Device = Annotated[
    str | None,
    Option("--device", metavar="NAME", help="cpu, cuda, cuda:1, ...; of double-dqn.", shown_default="cpu"),
]
Json = Annotated[bool, Option("--json", help="Print the result as JSON.")]
