"""The commands put together, and what becomes of errors."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence

from ltlc.cli.commands import COMMANDS, command_of
from ltlc.cli.messages import complain, complain_of_system, shown_once
from ltlc.cli.options import read
from ltlc.errors import LimitExceeded, LtlcError
from ltlc.registry import import_plugins

COMPLETION = "_LTLC_COMPLETE"
"""the variable of the environment by which a shell asks for completions."""


def run(arguments: Sequence[str]) -> int:
    """Run one command line.

    Returns:
        The exit code; every error on purpose has been printed to stderr as one paragraph.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = shown_once()
        try:
            import_plugins()
            code = _run(arguments)
            sys.stdout.flush()
        except LtlcError as error:
            return complain(error, code=3 if isinstance(error, LimitExceeded) else 2)
        except OSError as error:
            return complain_of_system(error)
        except UnicodeDecodeError as error:
            return complain(f"the input is not UTF-8 text: {error.reason} at byte {error.start}")
        except MemoryError:
            return complain("out of memory; --max-states with a smaller number stops earlier", code=3)
        except (EOFError, KeyboardInterrupt):
            return 130
        except SystemExit as done:
            import traceback

            *_, (frame, line) = traceback.walk_tb(done.__traceback__)
            if not frame.f_globals["__name__"].startswith("typer."):  # shell completion ends that way
                where = f"{frame.f_code.co_filename}:{line}"
                return complain(f"{where} calls sys.exit while the command runs; let it raise an exception")
            code = done.code
        except Exception:
            import traceback

            traceback.print_exc()
            return complain("this is a bug; please report it with the lines above", code=70)
    return code if isinstance(code, int) else 0


def _run(arguments: Sequence[str]) -> object:
    """Run a command line that is plain at once, and any other by typer."""
    if arguments and arguments[0] in COMMANDS and COMPLETION not in os.environ:
        command = command_of(arguments[0])
        values = read(command, arguments[1:])
        if values is not None:
            return command(**values)
    from ltlc.cli.typer_app import run_by_typer

    return run_by_typer(arguments)
