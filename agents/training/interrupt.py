"""Ctrl-C while an agent trains."""

from __future__ import annotations

import signal
import threading
from types import FrameType


class InterruptFlag:
    """While active, the first Ctrl-C only raises a flag; a second one is as usual."""

    def __init__(self) -> None:
        self.raised = False

    def __enter__(self) -> InterruptFlag:
        self._active = threading.current_thread() is threading.main_thread()
        if self._active:
            self._before = signal.signal(signal.SIGINT, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        if self._active:
            signal.signal(signal.SIGINT, self._before)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.raised:
            raise KeyboardInterrupt
        self.raised = True
