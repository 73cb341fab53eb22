"""The `ltlc` command: one file per command; each parses flags, calls the library and prints.

Exit codes: 0 done, 1 a negative answer, 2 bad usage or input, 3 a limit was hit, 70 a bug, 130 interrupted.
"""

import gc
import io
import os
import signal
import sys
from typing import NoReturn

_NARROWEST, _DIGITS = 20, 6
"""columns in which a table can still be read, and digits that a number of columns can have."""
_COLLECT_AFTER = 50_000
"""objects; what a command imports is that many, and no garbage."""
_MAY_BE_OTHERS = {"gymnasium", "importlib.metadata"}
"""modules that are loaded before the code of an environment, of labels or of a plug-in is."""


def main() -> NoReturn:
    """Run the command with the arguments of the process, and exit with its code."""
    if hasattr(signal, "SIGPIPE"):
        # A reader that goes away (`ltlc ... | head`) ends the process silently, as with other Unix tools.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    _open_standard_streams()
    columns = os.environ.get("COLUMNS")
    if columns and not (len(columns) <= _DIGITS and columns.isdecimal() and int(columns) >= _NARROWEST):
        del os.environ["COLUMNS"]  # tables in no columns are empty; without it the terminal is asked
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # not every terminal has arrows and logical signs
    gc.set_threshold(_COLLECT_AFTER)
    try:
        from ltlc.cli.app import run

        code = run(sys.argv[1:])
    except KeyboardInterrupt:
        code = 130
    if not _MAY_BE_OTHERS & sys.modules.keys():
        # Else the interpreter looks through all that is left, more than once, before it ends. Where there may be
        # objects of others it is to: a file in a cycle of references is written to the end by that.
        gc.freeze()
    sys.exit(code)


def _open_standard_streams() -> None:
    """Open the standard streams that the caller has closed, in a way that reading and writing them fails.

    Else files opened later would take their numbers, and what libraries print would end up in those. What goes to
    standard error vanishes then: there is nobody to tell.
    """
    streams = (("stdin", "r", os.O_WRONLY), ("stdout", "w", os.O_RDONLY), ("stderr", "w", os.O_WRONLY))
    for number, (name, mode, flags) in enumerate(streams):
        if getattr(sys, name) is None:
            handle = os.open(os.devnull, flags)
            if handle != number:
                os.dup2(handle, number)
                os.close(handle)
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8", closefd=False))
