"""The `ltlc` command: one file per command; each parses flags, calls the library and prints.

Exit codes: 0 done, 1 a negative answer, 2 bad usage or input, 3 a limit was hit, 70 a bug, 130 interrupted.
"""

import io
import signal
import sys
from typing import NoReturn


def main() -> NoReturn:
    """Run the command with the arguments of the process, and exit with its code."""
    if hasattr(signal, "SIGPIPE"):
        # A reader that goes away (`ltlc ... | head`) ends the process silently, as with other Unix tools.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # not every terminal has arrows and logical signs
    try:
        from ltlc.cli.app import run

        code = run(sys.argv[1:])
    except KeyboardInterrupt:
        code = 130
    sys.exit(code)
