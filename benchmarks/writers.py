"""What writing an automaton costs beside compiling its formula.

    python benchmarks/writers.py                            # families with many letter classes or many edges
    python benchmarks/writers.py --sizes 12 16 --acceptance state
    python benchmarks/writers.py tests/formulas/*.ltl       # the formulas of files, one a line or in a column

Times are processor times in one warm process. A writer is measured on a fresh copy of the automaton, so that what it
asks for first (components, distances, guards) is counted as its own. Wanted is a tenth of the compilation.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import ltlc
from ltlc.automata import DRA
from ltlc.errors import LtlcError
from ltlc.formats import to_hoa, to_json
from ltlc.ltl import read_formulas

WRITERS: dict[str, Callable[[DRA], str]] = {"json": to_json, "hoa": to_hoa}


def families(n: int) -> dict[str, str]:
    """Formulas of n propositions, by name."""
    names = [f"a{i}" for i in range(1, n + 1)]
    recurring = " & ".join(f"G F {name}" for name in names)
    return {
        "recurrences": recurring,
        "patrol": " & ".join(f"G F {name}" for name in names[:-1]) + f" & G !{names[-1]}",
        "sequence": " & ".join(f"F({name}" for name in names[:-1]) + f" & F {names[-1]}" + ")" * (n - 1),
        "avoiding": " & ".join(f"F {name}" for name in names[: n // 2]) + f" & G !({' | '.join(names[n // 2 :])})",
        "until": " & ".join(f"(!{b} U {a})" for a, b in pairwise(names)),
        "one of": f"G F ({' | '.join(names)})",
        "even": f"G ({' xor '.join(names)})",
        "responses": " & ".join(f"G({a} -> F {b})" for a, b in zip(names[::2], names[1::2], strict=False)),
    }


def measured(formula: str, acceptance: str) -> tuple[DRA, float, dict[str, float], dict[str, int]]:
    """The automaton, the seconds of compiling, and for each writer its seconds and the length of its text."""
    start = time.process_time()
    automaton = ltlc.compile(formula, acceptance=acceptance, timeout=60)
    compiled = time.process_time() - start
    seconds, lengths = {}, {}
    for name, writer in WRITERS.items():
        fresh = automaton.named(automaton.formula or "")
        start = time.process_time()
        lengths[name] = len(writer(fresh))
        seconds[name] = time.process_time() - start
    return automaton, compiled, seconds, lengths


def of_families(sizes: Sequence[int], kinds: Sequence[str] | None, acceptance: str) -> None:
    """Print a line per family and size."""
    print(
        f"{'family':12}{'props':>6}{'states':>7}{'classes':>8}{'compile':>9}  ",
        "json      of it      kB  hoa       of it",
    )
    for n in sizes:
        for kind, formula in families(n).items():
            if kinds and kind not in kinds:
                continue
            try:
                automaton, compiled, seconds, lengths = measured(formula, acceptance)
            except LtlcError as error:
                print(f"{kind:12}{n:6}  {type(error).__name__}")
                continue
            size = f"{kind:12}{n:6}{automaton.n_states:7}{automaton.n_classes:8}{1000 * compiled:7.0f}ms  "
            json, hoa = (f"{1000 * s:7.1f}ms {100 * s / compiled:6.1f}%" for s in seconds.values())
            print(f"{size} {json} {lengths['json'] / 1000:7.0f} {hoa}", flush=True)


def of_files(files: Sequence[Path], acceptance: str) -> None:
    """Print the ratios over all formulas of the files."""
    texts = [
        line.split("\t")[0]
        for path in files
        for line in path.read_text(encoding="utf-8").splitlines()
        if line.strip() and not line.startswith(("#", "formula\t"))
    ]
    formulas = [formula for text in texts for _, formula in read_formulas(text)]
    ltlc.compile("G(a -> F b) & F G c", acceptance=acceptance)
    results = [measured(formula, acceptance)[1:3] for formula in formulas]
    for name in WRITERS:
        ratios = sorted(
            (seconds[name] / compiled, formula) for (compiled, seconds), formula in zip(results, formulas, strict=True)
        )
        total = sum(seconds[name] for _, seconds in results) / sum(compiled for compiled, _ in results)
        late = ratios[min(len(ratios) - 1, int(0.99 * len(ratios)))][0]
        median = statistics.median(ratio for ratio, _ in ratios)
        worst, formula = ratios[-1]
        print(
            f"{name}: {len(ratios)} formulas, median {100 * median:.1f} %, 99 % {100 * late:.1f} %, "
            f"worst {100 * worst:.1f} %, total {100 * total:.1f} %; worst: {str(formula)[:80]}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, help="formula files (default: the families)")
    parser.add_argument("--sizes", type=int, nargs="+", default=[12, 14, 16], help="numbers of propositions")
    parser.add_argument("--kind", action="append", help="only this family; may be repeated")
    parser.add_argument("--acceptance", default="transition", choices=["state", "transition"])
    options = parser.parse_args()
    for writer in WRITERS.values():
        writer(ltlc.compile("G(a -> F b) & F G c", acceptance=options.acceptance))  # imports what is needed, once
    if options.files:
        of_files(options.files, options.acceptance)
    else:
        of_families(options.sizes, options.kind, options.acceptance)


if __name__ == "__main__":
    main()
