"""The commands as an application of typer: for help, completion, and what `ltlc.cli.options.read` does not read."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from ltlc.cli import flags
from ltlc.cli.commands import COMMANDS, command_of
from ltlc.cli.completion import words_of_bash
from ltlc.cli.messages import complain
from ltlc.cli.options import Argument, Option, parameters_of
from ltlc.errors import InvalidArgumentError
from ltlc.version import __version__, is_compiled


class Command(TyperCommand):
    """A command in whose help `{suffixes}`, `{formats}`, `{rewards}` and so on become the names that there are.

    They are looked up when the help is asked for, so that starting a command imports nothing.
    """

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        for parameter in self.params:
            text = getattr(parameter, "help", None)
            for kind in flags.NAMES:
                if text and f"{{{kind}}}" in text:
                    text = text.replace(f"{{{kind}}}", ", ".join(flags.NAMES[kind]()) or "none yet")
                    parameter.help = text  # type: ignore[attr-defined]
        super().format_help(ctx, formatter)


def application(names: Sequence[str] = COMMANDS) -> typer.Typer:
    """The application with these of its commands: to make all takes longer than to compile a small formula."""
    app = typer.Typer(
        name="ltlc",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_ltlc)
    for name in names:
        app.command(name, cls=Command)(_for_typer(command_of(name)))
    return app


def run_by_typer(arguments: Sequence[str]) -> object:
    """Run one command line.

    Returns:
        What the command returns, or the exit code if it did not run.
    """
    command = typer.main.get_command(application(arguments[:1] if arguments and arguments[0] in COMMANDS else COMMANDS))
    try:
        with words_of_bash():
            return command.main(list(arguments) or ["--help"], prog_name="ltlc", standalone_mode=False)
    except typer.TyperException as error:
        return _usage(error)
    except typer.Abort:
        return 130


def _for_typer(command: Callable[..., object]) -> Callable[..., object]:
    """A command whose parameters are described in the words of typer."""

    @wraps(command)
    def called(**values: Any) -> object:
        return command(**values)

    described = [
        parameter.replace(annotation=Annotated[kind, _described(description)])
        for parameter, kind, description in parameters_of(command)
    ]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in described}
    called.__signature__ = inspect.Signature(described)  # type: ignore[attr-defined]
    return called


def _described(description: Option | Argument) -> Any:
    """An option or argument in the words of typer."""
    callback = _path_given if description.is_path else None
    if isinstance(description, Argument):
        return typer.Argument(metavar=description.metavar, help=description.help, callback=callback)
    return typer.Option(
        *description.names,
        metavar=description.metavar,
        help=description.help,
        callback=callback,
        min=description.least,
        show_default=True if description.shown_default is None else description.shown_default,
        autocompletion=description.completion,
    )


def _path_given(parameter: typer.CallbackParam, value: str | list[str] | None) -> str | list[str] | None:
    """Callback of options that name a path: an empty one, as of a variable that is not set, is no default.

    Raises:
        InvalidArgumentError: the path is empty or blank.
    """
    for path in [value] if isinstance(value, str) else value or []:
        if not path.strip():
            raise InvalidArgumentError(f"{parameter.opts[0]} is empty; give a path")
    return value


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"ltlc {__version__} (compiled)" if is_compiled() else f"ltlc {__version__}")
        raise typer.Exit


def _ltlc(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", is_eager=True, callback=_print_version)
    ] = False,
) -> None:
    """Compile linear temporal logic into automata and rewards, train agents on them, and judge what they learn."""


def _usage(error: typer.TyperException) -> int:
    context = getattr(error, "ctx", None)
    message = error.format_message().replace("Value error, ", "")  # what typer 0.29 quotes from pydantic
    path = context.command_path if context else "ltlc"
    return complain(f"{message} (See: {path} --help)")
