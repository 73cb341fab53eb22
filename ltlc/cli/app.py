"""The commands put together, and what becomes of errors."""

from __future__ import annotations

import sys
import traceback
import warnings
from collections.abc import Sequence
from typing import Annotated

import typer

from ltlc.cli import (
    check,
    compile,
    doctor,
    evaluate,
    explain,
    faithful,
    listing,
    monitor,
    report,
    reproduce,
    show,
    solve,
    sweep,
    train,
)
from ltlc.cli.completion import words_of_bash
from ltlc.cli.messages import complain, complain_of_system, shown_once
from ltlc.errors import LimitExceeded, LtlcError
from ltlc.registry import import_plugins
from ltlc.version import __version__, is_compiled


def application() -> typer.Typer:
    """The application with all its commands."""
    app = typer.Typer(
        name="ltlc",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_ltlc)
    for command in (
        compile.compile_,
        show.show,
        check.check,
        monitor.monitor,
        explain.explain,
        train.train,
        sweep.sweep,
        evaluate.evaluate,
        report.report,
        solve.solve,
        faithful.faithful,
        reproduce.reproduce,
        doctor.doctor,
        listing.translators,
        listing.rewards,
        listing.agents,
        listing.formats,
        listing.labellers,
    ):
        app.command(command.__name__.rstrip("_"), cls=listing.Command)(command)
    return app


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
    command = typer.main.get_command(application())
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
