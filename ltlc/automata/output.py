"""How an automaton shows and saves itself, in the formats that are registered."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Literal

from ltlc.automata.formats import FORMATS
from ltlc.errors import MissingProgramError, TimeLimitExceeded
from ltlc.registry import import_object

if TYPE_CHECKING:
    from pathlib import Path

NOTEBOOK_STATES = 200
"""A notebook shows larger automata as one line: Graphviz would take minutes, and nobody could read the result."""


class Output(ABC):
    """The methods by which an automaton leaves the program."""

    acceptance: Literal["state", "transition"]
    formula: str | None

    @property
    @abstractmethod
    def n_states(self) -> int:
        """Number of states."""

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write to a file whose suffix says the format: .json .hoa .dot .mmd .md .svg .png .pdf or any in `FORMATS`.

        The file appears complete or not at all.

        Returns:
            Where it was written.

        Raises:
            InvalidArgumentError: no format has the suffix.
            MissingProgramError: nothing that draws pictures is installed; the .dot file is written instead.
            OSError: the folder is missing, not writable or full.
        """
        written: Path = import_object("ltlc.formats:write", "the writer of files")(self, path)
        return written

    def _text(self, name: str) -> str:
        automaton: Any = self
        return FORMATS[name].write(automaton).decode("utf-8")

    def to_json(self) -> str:
        """Write the automaton with its annotations as the text of a .json file."""
        return self._text("json")

    def to_hoa(self) -> str:
        """Write the automaton in the Hanoi Omega-Automata format, version 1."""
        return self._text("hoa")

    def to_dot(self) -> str:
        """Draw the picture as Graphviz source."""
        return self._text("dot")

    def to_mermaid(self) -> str:
        """Draw the picture as a Mermaid state diagram, for Markdown pages."""
        return self._text("mermaid")

    def to_svg(self) -> str:
        """Draw the picture.

        Raises:
            MissingProgramError: nothing that draws is installed.
        """
        return self._text("svg")

    def _repr_svg_(self) -> str | None:
        """The picture for a notebook, which shows the text of `repr` where there is None.

        That is where nothing that draws is installed, there is too much to see, or the automaton has a form without
        pictures.
        """
        if self.n_states > NOTEBOOK_STATES or "svg" not in getattr(self, "formats", ("svg",)):
            return None
        try:
            return self.to_svg()
        except (MissingProgramError, TimeLimitExceeded):
            return None

    @property
    def size(self) -> str:
        """Size for a reader, e.g. "5 states"; automata add what else there is to count."""
        states = "1 state" if self.n_states == 1 else f"{self.n_states} states"
        return states

    def __repr__(self) -> str:
        formula = self.formula or "an unnamed language"
        kind = type(self).__name__
        return f"<{kind} of {formula if len(formula) <= 80 else formula[:77] + '...'}: {self.size}>"
