"""Sizes and times of the constructions, beside Spot's in the same run if `spottl` is installed.

    python benchmarks/translation.py                             # the families in tests/formulas
    python benchmarks/translation.py sizes.tsv --translator auto # a table of known sizes
    python benchmarks/translation.py sizes.tsv --acceptance state --timeout 60 --json result.json

A formula file is either a table with tabs and a header row, whose first column is `formula` and whose others are known
sizes (`spot_transition`, `spot_state`, `owl_rabin`, `proven_rabin1`; empty: unknown), or a list of formulas, one a
line. Lines that start with # are comments. States are counted without the rejecting sink, as Spot and such tables do.

A formula is marked with * where the smallest automaton found here is larger than the smallest known one. Times are
processor times of one call in a warm process; ratios are formula by formula, over the formulas that both translate. A
construction is "alone smallest" where it gives fewer states than each other one.
"""

from __future__ import annotations

import argparse
import csv
import json
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar, get_args

from rich.console import Console
from rich.progress import track

from ltlc.automata import DRA
from ltlc.errors import InvalidArgumentError, LimitExceeded
from ltlc.ltl import Formula, parse, read_formulas, to_text
from ltlc.translate import TRANSLATORS, Effort, Options, translate

T = TypeVar("T")

FAMILIES = sorted((Path(__file__).parents[1] / "tests" / "formulas").glob("*.ltl"))
KNOWN = {"transition": ("spot_transition", "owl_rabin"), "state": ("spot_state",)}
"""columns with sizes of other tools for the kind of acceptance; the smaller one is the one to reach."""


RATIOS = ("median", "90 %", "99 %", "worst", "total")


@dataclass
class Measured:
    """The outcome of one construction for one formula."""

    seconds: float
    states: int | None = None
    note: str = ""
    """why there is no automaton."""


@dataclass
class Row:
    """A formula, its known sizes, and what was measured."""

    formula: str
    known: dict[str, int]
    measured: dict[str, Measured] = field(default_factory=dict)

    def is_above(self, columns: Sequence[str]) -> bool:
        """Whether no result here is as small as the smallest of these known sizes."""
        known = [self.known[column] for column in columns if column in self.known]
        found = [m.states for name, m in self.measured.items() if name != "spot" and m.states is not None]
        return bool(known) and min(found, default=max(known) + 1) > min(known)

    def alone_smallest(self) -> str | None:
        """The construction that gives fewer states than each other one, or None."""
        found = {n: m.states for n, m in self.measured.items() if n not in ("auto", "spot") and m.states is not None}
        best = [name for name, states in found.items() if states == min(found.values())]
        return best[0] if len(best) == 1 else None


def read_rows(path: Path) -> list[Row]:
    text = path.read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if not lines or lines[0].split("\t")[0] != "formula":
        return [Row(formula, {}) for _, formula in read_formulas(text)]
    rows = csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE)
    return [
        Row(row["formula"], {column: int(size) for column, size in row.items() if column != "formula" and size})
        for row in rows
    ]


def by_ltlc(formula: Formula, translator: str, options: argparse.Namespace) -> DRA:
    return translate(
        formula,
        Options(
            translator=translator,
            acceptance=options.acceptance,
            effort=options.effort,
            max_states=options.max_states,
            timeout=options.timeout,
        ),
    )


def by_spot(formula: Any, options: argparse.Namespace) -> Any:
    import spot

    return spot.translate(formula, "det", "parity", *(["sbacc"] if options.acceptance == "state" else []))


def timed(build: Callable[[], T], count_states: Callable[[T], int]) -> Measured:
    start = time.process_time()
    try:
        automaton = build()
    except (LimitExceeded, InvalidArgumentError) as error:
        note = "not applicable" if isinstance(error, InvalidArgumentError) else type(error).__name__
        return Measured(time.process_time() - start, note=note)
    return Measured(time.process_time() - start, count_states(automaton))


def measure(row: Row, translators: Iterable[str], options: argparse.Namespace) -> None:
    formula = parse(row.formula)
    for name in translators:
        build = partial(by_ltlc, formula, name, options)
        row.measured[name] = timed(build, lambda automaton: automaton.n_states - len(automaton.deadlocks))
    if options.spot:
        import spot

        other = spot.formula(to_text(formula, "spot"))
        row.measured["spot"] = timed(partial(by_spot, other, options), lambda automaton: int(automaton.num_states()))


def report(rows: Sequence[Row], options: argparse.Namespace) -> None:
    columns = KNOWN[options.acceptance]
    names = list(rows[0].measured)
    print(f"states / milliseconds, acceptance on {options.acceptance}s; known: {', '.join(columns)}\n")
    print("  ", " ".join(f"{name[:16]:>16}" for name in names), " known  formula")
    for row in rows:
        cells = [f"{'-' if m.states is None else m.states:>6} / {1000 * m.seconds:7.1f}" for m in row.measured.values()]
        known = ",".join(str(row.known.get(column, "")) for column in columns)
        print(" *" if row.is_above(columns) else "  ", " ".join(cells), f"{known:>6}  {row.formula}")

    heads = f"{'formulas':>9}{'states':>8}{'seconds':>9}{'alone smallest':>16}"
    print(f"\n{'':18}{heads}  of Spot's time: {', '.join(RATIOS)}")
    for name in names:
        done = [row for row in rows if row.measured[name].states is not None]
        states = sum(row.measured[name].states or 0 for row in done)
        seconds = sum(row.measured[name].seconds for row in rows)
        alone = sum(row.alone_smallest() == name for row in rows)
        print(f"{name:18}{len(done):9}{states:8}{seconds:9.2f}{alone:16}  {ratios(done, name)}")
    for column in dict.fromkeys(name for row in rows for name in row.known):
        sizes = [row.known[column] for row in rows if column in row.known]
        print(f"{column:18}{len(sizes):9}{sum(sizes):8}")
    best = [min(row.known[c] for c in columns if c in row.known) for row in rows if set(columns) & set(row.known)]
    if best:
        print(f"{'best known':18}{len(best):9}{sum(best):8}")
        print(f"\n{sum(row.is_above(columns) for row in rows)} formulas above the best known size (marked *)")


def ratios(rows: Sequence[Row], name: str) -> str:
    pairs = [(row.measured[name].seconds, row.measured["spot"].seconds) for row in rows if "spot" in row.measured]
    if not pairs or name == "spot":
        return ""
    ordered = sorted(mine / other for mine, other in pairs)
    quantiles = [ordered[min(len(ordered) - 1, int(share * len(ordered)))] for share in (0.5, 0.9, 0.99)]
    total = sum(mine for mine, _ in pairs) / sum(other for _, other in pairs)
    return ", ".join(f"{ratio:.2f}" for ratio in (*quantiles, ordered[-1], total))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, default=FAMILIES, help="formula files (default: tests/formulas)")
    parser.add_argument(
        "--translator", action="append", choices=("auto", *TRANSLATORS), help="repeatable; default: all"
    )
    parser.add_argument("--acceptance", choices=("transition", "state"), default="transition")
    parser.add_argument("--effort", choices=get_args(Effort), default="default")
    parser.add_argument("--timeout", type=float, default=10, help="seconds for each translation")
    parser.add_argument("--max-states", type=int, default=100_000)
    parser.add_argument("--no-spot", dest="spot", action="store_false", help="leave out Spot although it is installed")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the measurements too")
    options = parser.parse_args()
    options.spot = options.spot and find_spec("spot") is not None
    translators = options.translator or ["auto", *TRANSLATORS]

    rows = [row for path in options.files for row in read_rows(path)]
    if not rows:
        parser.error("no formulas")
    import_module("numpy")  # the first formula that needs arrays is not to pay for that
    warm_up = Row("G(a -> F b) & F G c | a U X b", {})
    measure(warm_up, translators, options)
    for row in track(rows, "translating", console=Console(stderr=True)):
        measure(row, translators, options)
    report(rows, options)
    if options.json:
        settings = {"acceptance": options.acceptance, "timeout": options.timeout, "max_states": options.max_states}
        document = {"settings": settings, "formulas": [asdict(row) for row in rows]}
        options.json.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
