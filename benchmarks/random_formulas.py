"""Random formulas beside Spot: where either fails, whose automata are smaller in sum, and in what time.

    python benchmarks/random_formulas.py                          # 200 formulas each of size 20, 40 and 80
    python benchmarks/random_formulas.py --sizes 40 --count 50 --acceptance state --json result.json

Formulas are drawn by Spot's `randltl` over four and five propositions in turn, those that mention none left out. Each
translation runs in a process of its own, forked from a warm one, in which a timer counts its processor time: Spot gets
`--spot-seconds`, then its process ends; ltlc gets `--timeout`, which it keeps by itself, on the same clock. States are
counted without the rejecting sink. Sums are over the formulas that both translate. A formula is listed if ltlc has no
answer where Spot has one, if its automaton is larger, or if it took more than `--slow` times as long and more than half
a second.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import signal
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

import spot
from rich.console import Console
from rich.progress import track

from ltlc.errors import LimitExceeded
from ltlc.ltl import parse, to_text
from ltlc.translate import Options, translate

PROPOSITIONS = ("abcde", "abcd")
FORK = multiprocessing.get_context("fork")


class Answer(NamedTuple):
    """What a translation gave: the number of states, or None where it was ended; and its processor time."""

    states: int | None
    seconds: float


def drawn(size: int, count: int, seed: int) -> list[str]:
    """Different formulas of a size, in the syntax of ltlc."""

    def formulas() -> Iterator[str]:
        streams = [iter(spot.randltl(list(names), -1, tree_size=size, seed=seed)) for names in PROPOSITIONS]
        while True:
            for stream in streams:
                formula = next(stream)
                if spot.atomic_prop_collect(formula):
                    yield to_text(parse(str(formula)))

    found: dict[str, None] = {}
    for text in formulas():
        found.setdefault(text)
        if len(found) == count:
            break
    return list(found)


def measured(work: Callable[[], int | None], seconds: float) -> Answer:
    """Do something in a process that ends after so many seconds of processor time."""
    here, there = FORK.Pipe(duplex=False)
    process = FORK.Process(target=_worker, args=(work, seconds, there))
    process.start()
    there.close()
    try:
        answer = Answer(*here.recv())
    except EOFError:
        answer = Answer(None, seconds)
    process.join()
    return answer


def _worker(work: Callable[[], int | None], seconds: float, answers: Connection) -> None:
    signal.signal(signal.SIGVTALRM, signal.SIG_DFL)  # which ends the process, whatever it does
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    time.monotonic = time.process_time  # the clock of ltlc's limit, so that other programs do not count
    begin = time.process_time()
    states = work()
    answers.send((states, time.process_time() - begin))


def compared(text: str, options: argparse.Namespace) -> dict[str, Any]:
    """Both answers for a formula."""
    formula = parse(text)
    other = spot.formula(to_text(formula, "spot"))

    def by_ltlc() -> int | None:
        wanted = Options(acceptance=options.acceptance, effort=options.effort, timeout=options.timeout)
        try:
            automaton = translate(formula, wanted)
        except LimitExceeded:
            return None
        return automaton.n_states - len(automaton.deadlocks)

    def by_spot() -> int | None:
        kind = ["sbacc"] if options.acceptance == "state" else []
        return int(spot.translate(other, "det", "parity", *kind).num_states())

    mine = measured(by_ltlc, 2 * options.timeout)
    theirs = measured(by_spot, options.spot_seconds)
    return {"formula": text, "ltlc": mine._asdict(), "spot": theirs._asdict()}


def report(size: int, rows: list[dict[str, Any]], slow: float) -> None:
    """Print the sums and what is worth looking at."""
    both = [row for row in rows if row["ltlc"]["states"] is not None and row["spot"]["states"] is not None]
    failed = [row for row in rows if row["ltlc"]["states"] is None]
    sums = {name: sum(row[name]["states"] for row in both) for name in ("ltlc", "spot")}
    seconds = {name: sum(row[name]["seconds"] for row in both) for name in ("ltlc", "spot")}
    print(f"\nsize {size}: {len(rows)} formulas, {len(both)} translated by both")
    print(f"  no answer: ltlc {len(failed)}, Spot {sum(row['spot']['states'] is None for row in rows)}")
    print(f"  states: ltlc {sums['ltlc']}, Spot {sums['spot']}")
    print(f"  seconds: ltlc {seconds['ltlc']:.1f}, Spot {seconds['spot']:.1f}")
    for row in rows:
        mine, theirs = row["ltlc"], row["spot"]
        if theirs["states"] is None:
            continue
        what = []
        if mine["states"] is None:
            what.append("no answer")
        elif mine["states"] > theirs["states"]:
            what.append("larger")
        if mine["seconds"] > max(0.5, slow * theirs["seconds"]):
            what.append("slow")
        if what:
            sizes = f"{mine['states']} / {theirs['states']} states, {mine['seconds']:.2f} / {theirs['seconds']:.2f} s"
            print(f"  {', '.join(what)}: {sizes}: {row['formula']}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[20, 40, 80], help="nodes of the syntax tree")
    parser.add_argument("--count", type=int, default=200, help="formulas of each size")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--acceptance", choices=("transition", "state"), default="transition")
    parser.add_argument("--effort", choices=("fast", "default"), default="default")
    parser.add_argument("--timeout", type=float, default=20.0, help="seconds that ltlc may take")
    parser.add_argument("--spot-seconds", type=float, default=1.0, help="seconds that Spot may take")
    parser.add_argument("--slow", type=float, default=20.0, help="times Spot's time from which on a formula is listed")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the measurements too")
    options = parser.parse_args()
    compared("G(a -> F b) & F G c | a U X b", options)
    document = {}
    for size in options.sizes:
        texts = drawn(size, options.count, options.seed)
        rows = [compared(text, options) for text in track(texts, f"size {size}", console=Console(stderr=True))]
        report(size, rows, options.slow)
        document[size] = rows
    if options.json:
        options.json.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
