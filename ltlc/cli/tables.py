"""Tables and lines on standard output: plain text where nothing is styled and all fits, and rich does the rest.

To load rich takes longer than to compile a small formula, so what goes to a pipe or a file is written without it, in
the same bytes.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

_SIGNS = "→−∞─"
"""what our tables have beside ASCII; each takes one column."""
_DEFAULT_WIDTH = 80
"""columns where there is no terminal to ask: that of rich."""


class Column(NamedTuple):
    """How the cells below a heading are set."""

    heading: str = ""
    right: bool = False
    style: str = ""


class Row(NamedTuple):
    """Cells, of one line or several, and the style of them all."""

    cells: Sequence[str]
    style: str = ""


class Table(NamedTuple):
    """Columns and rows; `ruled` has headings and a rule below them, else the columns stand side by side."""

    columns: Sequence[Column]
    rows: Sequence[Row]
    ruled: bool = True


def print_line(text: str, style: str = "") -> None:
    """Print a text, broken into lines where the terminal is too narrow."""
    width = _plain_width()
    if width is not None and _is_plain(text) and "\n" not in text and len(text) < width:
        print(text)
        return
    from rich.console import Console
    from rich.text import Text

    Console(highlight=False).print(Text(text, style=style))


def print_table(table: Table) -> None:
    """Print a table, with cells broken into lines where the terminal is too narrow."""
    width = _plain_width()
    lines = [] if width is None else list(_plain_lines(table))
    if width is not None and lines and all(map(_is_plain, lines)) and len(lines[0]) < width:
        print("\n".join(lines))
        return
    from rich import box
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.text import Text

    shown = RichTable(box=box.SIMPLE_HEAD, pad_edge=False) if table.ruled else RichTable.grid(padding=(0, 2))
    for column in table.columns:
        shown.add_column(column.heading, justify="right" if column.right else "left", style=column.style)
    for row in table.rows:
        shown.add_row(*map(Text, row.cells), style=row.style)
    Console(highlight=False).print(shown)


def _plain_lines(table: Table) -> Iterator[str]:
    """The lines of a table, padded to one length; none if a column is empty, whose width only rich knows."""
    cells = [[cell.split("\n") for cell in row.cells] for row in table.rows]
    headings = [[column.heading if table.ruled else ""] for column in table.columns]
    widths = [max(len(line) for cell in column for line in cell) for column in zip(headings, *cells, strict=True)]
    if 0 in widths:
        return
    edge, gap = (" ", "   ") if table.ruled else ("", "  ")

    def set_in_columns(row: Sequence[Sequence[str]]) -> Iterator[str]:
        for line in range(max(map(len, row))):
            texts = [cell[line] if line < len(cell) else "" for cell in row]
            padded = (
                text.rjust(width) if column.right else text.ljust(width)
                for text, width, column in zip(texts, widths, table.columns, strict=True)
            )
            yield f"{edge}{gap.join(padded)}{edge}"

    if table.ruled:
        blank, rule = (edge + sign * (sum(widths) + len(gap) * (len(widths) - 1)) + edge for sign in " ─")
        yield blank
        yield from set_in_columns(headings)
        yield rule
    for row in cells:
        yield from set_in_columns(row)
    if table.ruled:
        yield blank


def _is_plain(text: str) -> bool:
    """Whether each character takes a column, here and for rich, which leaves out or replaces others."""
    return all((c.isascii() and c.isprintable()) or c in _SIGNS for c in text)


def _plain_width(environment: Mapping[str, str] = os.environ) -> int | None:
    """Columns of standard output, or None if what goes there may be styled or encoded in ways that rich knows."""
    if sys.stdout.isatty() or not (sys.stdout.encoding or "").lower().startswith("utf"):
        return None
    if environment.get("TTY_COMPATIBLE") == "1" or "FORCE_COLOR" in environment:
        return None
    columns = environment.get("COLUMNS", "")
    if columns.isdecimal():
        return int(columns) or None
    for stream in range(3):
        try:
            return os.get_terminal_size(stream).columns or _DEFAULT_WIDTH
        except OSError:  # it is no terminal
            continue
    return _DEFAULT_WIDTH
