"""`ltlc compile -F`: a file of formulas becomes a stream of automata."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ltlc.cli.inputs import standard_input
from ltlc.cli.messages import complain
from ltlc.cli.outputs import write_bytes
from ltlc.cli.summary import as_data

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA, OmegaAutomaton


def compile_file(
    source: str,
    translate: Callable[[str], DRA | DFA | OmegaAutomaton],
    targets: Sequence[str],
    as_json: bool,
    timeout: float | None,
) -> int:
    """Compile the formulas of a file one after the other.

    Each result is on standard output before the next formula is read. Files are written at the end, complete: an
    interrupted batch leaves them as they were.

    Args:
        source: a path, or `-` for standard input.
        translate: from the text of one formula to its automaton.
        targets: .hoa files, and `-` for standard output, which is also meant when there are none.
        as_json: print a summary per line instead of HOA.
        timeout: seconds that one formula may take, from its text to that of its automaton; None for no limit.

    Returns:
        The exit code: 2 if a line failed, else 0.
    """
    from pathlib import Path

    from ltlc.atomic import atomic_write_all
    from ltlc.budget import Overtime, overtime, time_limit
    from ltlc.errors import LtlcError
    from ltlc.ltl import read_formulas

    files = [target for target in targets if target != "-"]
    collected: list[str] = []
    code = 0
    with _opened(source) as lines:
        for number, text in read_formulas(lines):
            try:
                with time_limit(text, timeout):
                    dra = translate(text)
                    with overtime(Overtime.WRITE):
                        hoa = dra.to_hoa() if files or not as_json else ""
                        summary = json.dumps(as_data(dra), ensure_ascii=False) if as_json else ""
            except LtlcError as error:
                code = complain(f"{_named(source)}: {_on_line(error, number)}")
                continue
            if files:
                collected.append(hoa)
            if as_json:
                print(summary, flush=True)
            elif not files or "-" in targets:
                write_bytes(hoa.encode("utf-8"))
    stream = "".join(collected)
    atomic_write_all(dict.fromkeys(map(Path, files), stream))
    return code


@contextmanager
def _opened(source: str) -> Iterator[Iterable[str]]:
    if source == "-":
        yield standard_input()
    else:
        from pathlib import Path

        with Path(source).open(encoding="utf-8") as stream:
            yield stream


def _named(source: str) -> str:
    return "standard input" if source == "-" else source


def _on_line(error: Exception, number: int) -> str:
    from ltlc.errors import LtlSyntaxError

    if isinstance(error, LtlSyntaxError):  # its own position, but in the file
        text = "\n" * (number - 1) + error.text
        return str(LtlSyntaxError(error.message, text, number, error.column, error.hint))
    return f"line {number}: {error}"
