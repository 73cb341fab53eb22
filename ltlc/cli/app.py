"""The commands put together, and what becomes of errors."""

from __future__ import annotations

import sys
import traceback
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated

import typer

from ltlc.cli import listing
from ltlc.cli.completion import words_of_bash
from ltlc.cli.messages import complain, complain_of_system, shown_once
from ltlc.errors import LimitExceeded, LtlcError
from ltlc.registry import import_plugins
from ltlc.version import __version__, is_compiled

_LISTS: Mapping[str, Callable[..., None]] = {
    "translators": listing.translators,
    "rewards": listing.rewards,
    "agents": listing.agents,
    "formats": listing.formats,
    "labellers": listing.labellers,
}
COMMANDS = (
    "compile",
    "show",
    "check",
    "monitor",
    "explain",
    "train",
    "sweep",
    "evaluate",
    "report",
    "solve",
    "faithful",
    "reproduce",
    "doctor",
    *_LISTS,
)
"""In the order of the help."""


def application(names: Sequence[str] = COMMANDS) -> typer.Typer:
    """The application with these of its commands: to make all takes longer than to compile a small formula."""
    app = typer.Typer(
        name="ltlc",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_ltlc)
    for name in names:
        app.command(name, cls=listing.Command)(_command(name))
    return app


def _command(name: str) -> Callable[..., None]:
    """The function of a command, whose file is only then imported."""
    match name:
        case "compile":
            from ltlc.cli.compile import compile_

            return compile_
        case "show":
            from ltlc.cli.show import show

            return show
        case "check":
            from ltlc.cli.check import check

            return check
        case "monitor":
            from ltlc.cli.monitor import monitor

            return monitor
        case "explain":
            from ltlc.cli.explain import explain

            return explain
        case "train":
            from ltlc.cli.train import train

            return train
        case "sweep":
            from ltlc.cli.sweep import sweep

            return sweep
        case "evaluate":
            from ltlc.cli.evaluate import evaluate

            return evaluate
        case "report":
            from ltlc.cli.report import report

            return report
        case "solve":
            from ltlc.cli.solve import solve

            return solve
        case "faithful":
            from ltlc.cli.faithful import faithful

            return faithful
        case "reproduce":
            from ltlc.cli.reproduce import reproduce

            return reproduce
        case "doctor":
            from ltlc.cli.doctor import doctor

            return doctor
    return _LISTS[name]


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


def run(arguments: Sequence[str]) -> int:
    """Run one command line.

    Returns:
        The exit code; every error on purpose has been printed to stderr as one paragraph.
    """
    command = typer.main.get_command(application(arguments[:1] if arguments and arguments[0] in COMMANDS else COMMANDS))
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = shown_once()
        try:
            import_plugins()
            with words_of_bash():
                code = command.main(list(arguments) or ["--help"], prog_name="ltlc", standalone_mode=False)
            sys.stdout.flush()
        except typer.TyperException as error:
            return _usage(error)
        except LtlcError as error:
            return complain(error, code=3 if isinstance(error, LimitExceeded) else 2)
        except OSError as error:
            return complain_of_system(error)
        except UnicodeDecodeError as error:
            return complain(f"the input is not UTF-8 text: {error.reason} at byte {error.start}")
        except MemoryError:
            return complain("out of memory; --max-states with a smaller number stops earlier", code=3)
        except typer.Abort:
            return 130
        except SystemExit as done:
            *_, (frame, line) = traceback.walk_tb(done.__traceback__)
            if not frame.f_globals["__name__"].startswith("typer."):  # shell completion ends that way
                where = f"{frame.f_code.co_filename}:{line}"
                return complain(f"{where} calls sys.exit while the command runs; let it raise an exception")
            code = done.code
        except Exception:
            traceback.print_exc()
            return complain("this is a bug; please report it with the lines above", code=70)
    return code if isinstance(code, int) else 0


def _usage(error: typer.TyperException) -> int:
    context = getattr(error, "ctx", None)
    message = error.format_message().replace("Value error, ", "")  # what typer 0.29 quotes from pydantic
    path = context.command_path if context else "ltlc"
    return complain(f"{message} (See: {path} --help)")
