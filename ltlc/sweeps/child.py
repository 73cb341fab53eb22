"""A command in a process of its own that ends with the process that has started it, however that one ends."""

from __future__ import annotations

import os
import runpy
import sys
import threading


def watch() -> None:
    """End this process at the end of its standard input, which the parent never writes to and holds open."""
    sys.stdin.buffer.read()
    os._exit(1)  # files are replaced whole, so there is nothing to tidy up


if __name__ == "__main__":
    threading.Thread(target=watch, daemon=True).start()
    runpy.run_module("ltlc", run_name="__main__", alter_sys=True)
