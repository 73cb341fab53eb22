"""Options that several commands share; a command lists those it wants among its parameters."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from ltlc.errors import InvalidArgumentError


def _translator_names(incomplete: str) -> list[str]:
    from ltlc.translate import TRANSLATORS

    return [name for name in ("auto", *TRANSLATORS) if name.startswith(incomplete)]


def path_given(parameter: typer.CallbackParam, value: str | list[str] | None) -> str | list[str] | None:
    """Callback of options that name a path: an empty one, as of a variable that is not set, is no default.

    Raises:
        InvalidArgumentError: the path is empty or blank.
    """
    for path in [value] if isinstance(value, str) else value or []:
        if not path.strip():
            raise InvalidArgumentError(f"{parameter.opts[0]} is empty; give a path")
    return value


Translator = Annotated[
    str,
    typer.Option(
        "--translator",
        "-t",
        metavar="NAME",
        help="Construction to use, a name from 'ltlc translators'; auto keeps the smallest result of several.",
        autocompletion=_translator_names,
    ),
]
Effort = Annotated[
    Literal["fast", "default", "best"],
    typer.Option("--effort", "-e", help="Stop at the first good automaton, compare several, or find the smallest."),
]
Acceptance = Annotated[
    Literal["state", "transition"],
    typer.Option("--acceptance", "-a", help="Put the marks of the pairs on states or on transitions."),
]
MaxStates = Annotated[
    int,
    typer.Option("--max-states", metavar="N", help="Give up, with exit code 3, before building more states."),
]
Timeout = Annotated[
    float | None,
    typer.Option("--timeout", metavar="SECONDS", help="Give up, with exit code 3, after this time."),
]
Prism = Annotated[
    str | None,
    typer.Option(
        "--prism",
        metavar="DIR",
        callback=path_given,
        help="Write files with which PRISM or Storm can check the probability.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
