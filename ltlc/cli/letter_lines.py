"""Letters as `ltlc monitor` reads them: a line each, as names, JSON or columns of numbers and truth values."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ltlc.errors import FileFormatError, InvalidArgumentError, LtlSyntaxError

if TYPE_CHECKING:
    from ltlc.envs.comparisons import Comparison

_TRUTH = {"1": True, "true": True, "0": False, "false": False, "": False}
_NAME = re.compile(r"[^\W\d][\w.]*")


class LetterLines:
    """Reads letters, and says of comparisons in the formula whether they hold of the numbers in a line.

    Args:
        aps: the propositions of the formula.

    Raises:
        LtlSyntaxError: a proposition with a relation in its name is no comparison; says where.
    """

    def __init__(self, aps: Sequence[str]) -> None:
        self.aps = aps
        self._comparisons: dict[str, Comparison] = {}
        if any(re.search("[<>]|[=!]=", name) for name in aps):
            from ltlc.envs.comparisons import Comparison, is_comparison

            for name in filter(is_comparison, aps):
                variables = {word: tuple(word.split(".")) for word in _NAME.findall(name) if word != "abs"}
                self._comparisons[name] = Comparison(name, variables)

    def of_lines(self, lines: Iterable[str]) -> Iterator[frozenset[str]]:
        """The letters of lines of names or JSON; blank lines are passed over.

        Raises:
            FileFormatError: a line is no letter; names it.
        """
        for number, line in enumerate(lines, start=1):
            if line.strip():
                yield self._of_line(line.strip(), f"letter on line {number}")

    def of_table(self, lines: Iterable[str]) -> Iterator[frozenset[str]]:
        """The letters of the rows of a table, whose first line names the columns.

        Commas stand between columns, or tabs or semicolons if the first line has these. Columns that the formula does
        not speak of may hold anything.

        Raises:
            FileFormatError: a column is missing, or a row has a wrong value; names line and column.
        """
        rest = iter(lines)
        first = next(rest, "")
        between = "\t" if "\t" in first else ";" if ";" in first and "," not in first else ","
        columns = [name.strip() for name in next(csv.reader([first], delimiter=between), [])]
        if not any(columns):
            raise FileFormatError("there is no line with the names of the columns on standard input")
        twice = next((name for name in columns if columns.count(name) > 1), None)
        if twice is not None:
            raise FileFormatError(f"line 1: the column {twice!r} is there twice")

        plain = [name for name in self.aps if name not in self._comparisons]
        numbers = {".".join(map(str, each.variables[n])) for each in self._comparisons.values() for n in each.names}
        for name in [*plain, *sorted(map(str, numbers))]:
            if name not in columns:
                raise FileFormatError(f"line 1: there is no column {name!r}; there are: {', '.join(columns)}")
        reader = csv.reader(rest, delimiter=between)
        for row in reader:
            if not row:
                continue
            where = f"line {reader.line_num + 1}"
            if len(row) != len(columns):
                raise FileFormatError(f"{where}: {len(row)} values, and there are {len(columns)} columns")
            cells = {name: cell.strip() for name, cell in zip(columns, row, strict=True)}
            holds: dict[str, Any] = {name: _truth(cells[name], f"{where}, column {name!r}") for name in plain}
            for name in numbers:
                _put(holds, name.split("."), _number(cells[name], f"{where}, column {name!r}"))
            yield self._named(holds, where)

    def _of_line(self, text: str, where: str) -> frozenset[str]:
        from ltlc.ltl import parse_letter

        if text[0] not in "[{":
            try:
                return parse_letter(text)
            except LtlSyntaxError as error:
                raise FileFormatError(f"{where}: {error.message} (column {error.column}); {error.hint}") from None
        try:
            value = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise FileFormatError(f"{where}: not JSON: {error}") from None
        if isinstance(value, list) and all(isinstance(name, str) and name for name in value):
            return frozenset(value)
        if isinstance(value, dict):
            return self._named(value, where)
        raise FileFormatError(
            f'{where}: expected a list of names, ["a"], or an object of true and false, {{"a": true}}'
        )

    def _named(self, values: Mapping[str, Any], where: str) -> frozenset[str]:
        """The names that hold: those that are true, and the comparisons that hold of the numbers."""
        for name in self.aps:
            if name in values and name not in self._comparisons and not isinstance(values[name], bool):
                raise FileFormatError(
                    f'{where}: expected a list of names, ["a"], or an object of true and false, {{"a": true}}; '
                    f"{name!r} is {json.dumps(values[name])[:40]}"
                )
        names = {name for name, holds in values.items() if holds is True and name}
        for name, comparison in self._comparisons.items():
            try:
                if comparison(values):
                    names.add(name)
            except InvalidArgumentError as error:
                raise FileFormatError(f"{where}: {error}") from None
        return frozenset(names)


def _truth(cell: str, where: str) -> bool:
    known = _TRUTH.get(cell.lower())
    if known is None:
        raise FileFormatError(f"{where}: {cell[:40]!r} is no truth value; expected true, false, 1, 0 or nothing")
    return known


def _number(cell: str, where: str) -> float:
    try:
        return float(cell)
    except ValueError:
        raise FileFormatError(f"{where}: {cell[:40]!r} is no number") from None


def _put(values: dict[str, Any], path: Sequence[str], number: float) -> None:
    for key in path[:-1]:
        values = values.setdefault(key, {})
    values[path[-1]] = number
