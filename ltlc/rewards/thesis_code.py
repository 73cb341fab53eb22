"""The rewards the thesis code pays, where they differ from the thesis text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ltlc.rewards.scheme import OnDeadlock
from ltlc.rewards.thesis import Thesis


@dataclass(frozen=True)
class ThesisCode(Thesis):
    """+100 for the step that ends the episode, +10 for G; a deadlock sends the automaton back to its initial state.

    References:
        Q. Gao, code of 2018 beside the thesis, https://github.com/gaoqitong/LTL_RL. The code also asks for a goal cell
        before it ends the episode; here, as in its successor of 2019, entering G is enough.
    """

    name: ClassVar[str] = "thesis-code"
    citation: ClassVar[str] = "Q. Gao, code beside the thesis, 2018, https://github.com/gaoqitong/LTL_RL"
    on_deadlock: ClassVar[OnDeadlock] = "initial"

    accepting: float = 10.0
    terminal: float = 100.0
