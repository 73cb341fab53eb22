"""Whether `timeout` is kept: processor time and memory of formulas that are too large for it.

    python benchmarks/limits.py                                # what must hold: 1 and 3 seconds
    python benchmarks/limits.py --limits 2 --acceptance transition --effort best --random 50 --json result.json
    python benchmarks/limits.py --kind xor --translator safra

Each formula is compiled in a process of its own, which is forked, so that starting it costs nothing. Measured is the
processor time of that process from the text to the automaton and its HOA text, and its peak memory. The bound is
`1.1 * limit + 1` seconds; the exit code is 1 if a formula is above it.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import random
import resource
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import ltlc
from ltlc.budget import Overtime, overtime, time_limit
from ltlc.ltl import Always, And, Eventually, Formula, Iff, Next, Not, Or, Proposition, Release, Until, WeakUntil, Xor

UNARY = (Not, Next, Eventually, Always)
BINARY = (And, Or, Until, Release, WeakUntil, Iff, Xor)
HANG = 60.0
"""Seconds after the bound at which a process is killed."""


@dataclass(frozen=True)
class Measured:
    """One formula under one limit."""

    kind: str
    formula: str
    limit: float
    seconds: float
    """of processor time."""
    megabytes: float
    """peak memory."""
    outcome: str
    """number of states, or the name of the error."""

    @property
    def is_above(self) -> bool:
        """Whether the limit was not kept."""
        return self.seconds > bound(self.limit)


def bound(limit: float) -> float:
    """The processor time that a limit allows."""
    return 1.1 * limit + 1


def found_before() -> list[str]:
    """Formulas that once took many times their limit."""

    def windows(letter: str) -> str:
        return " & ".join(f"GF({letter}{i} & X {letter}{i})" for i in range(1, 4))

    return [
        " <-> ".join(f"F p{i}" for i in range(10)),
        " xor ".join(f"GF p{i}" for i in range(10)),
        "F" * 100_000 + "a",
        "!" * 1_000_000 + "a",
        "(" + " & ".join(f"(F a{i})" for i in range(1, 9)) + ") U G b | GF c",
        f"({windows('a')}) <-> ({windows('b')})",
        "GF((Ga & F(b R Xc)) | (F!a & G(!b U X!c)))",
    ]


def families() -> dict[str, list[str]]:
    """Formulas of some kinds, in growing sizes."""

    def chain(operator: str, parts: Sequence[str]) -> str:
        return f" {operator} ".join(f"({part})" for part in parts)

    def until(n: int, operator: str) -> str:
        return f" {operator} ".join(f"(p{i % 6} | X p{(i + 1) % 6})" for i in range(n))

    return {
        "conjunction": [chain("&", [f"G(p{i % 15} -> F p{(i * 7 + 3) % 15})" for i in range(n)]) for n in (8, 20, 60)]
        + [chain("&", [f"F(p{i % 18} & X F p{(i * 5 + 1) % 18})" for i in range(n)]) for n in (6, 18, 2000)]
        + [" & ".join(["G a"] * 50_000)],
        "xor": [chain("xor", [f"GF p{i}" for i in range(n)]) for n in (6, 14, 20)]
        + [chain("<->", [f"FG(p{i} | X p{(i + 1) % n})" for i in range(n)]) for n in (4, 12)]
        + [chain("xor", [f"F(p{i} & X p{i})" for i in range(n)]) for n in (8, 18)],
        "nesting": ["F(a & X" * n + "(b U c)" + ")" * n for n in (20, 400)]
        + ["GF(a U X(b R " * n + "c" + "))" * n for n in (3, 6, 200)]
        + ["X " * n + "a" for n in (900, 60_000)]
        + ["(" * 30_000 + "a U b" + ")" * 30_000],
        "until": [until(n, operator) for n in (6, 12, 40) for operator in ("U", "R", "W")],
        "many": [
            chain("&", [f"(GF p{i} -> GF p{i + 10})" for i in range(10)]),
            chain("|", [f"G(p{i} U X p{i + 10})" for i in range(10)]),
            "G(" + " | ".join(f"(p{i} & X F p{(i + 7) % 20})" for i in range(20)) + ")",
            " & ".join(f"GF p{i}" for i in range(20)),
            "GF(" + " xor ".join(f"p{i}" for i in range(20)) + ") xor " + " xor ".join(f"X p{i}" for i in range(20)),
            chain("&", [f"(p{i} | (p{(i * 3 + 1) % 20} & !p{(i * 7 + 2) % 20}))" for i in range(5000)]),
        ],
    }


def random_formulas(count: int, seed: int) -> list[str]:
    """Formulas of 40 to 80 nodes over 4 to 6 propositions."""
    rng = random.Random(seed)

    def grown(size: int, names: Sequence[str]) -> Formula:
        if size <= 1:
            return Proposition(rng.choice(names))
        if size == 2 or rng.random() < 0.35:
            return rng.choice(UNARY)(grown(size - 1, names))
        left = rng.randrange(1, size - 1)
        return rng.choice(BINARY)(grown(left, names), grown(size - 1 - left, names))

    return [str(grown(rng.randint(40, 80), "abcdef"[: rng.randint(4, 6)])) for _ in range(count)]


def measured(kind: str, formula: str, limit: float, options: dict[str, Any]) -> Measured:
    """Compile in a new process."""
    fork = multiprocessing.get_context("fork")
    ours, theirs = fork.Pipe(duplex=False)
    process = fork.Process(target=_compile, args=(theirs, formula, limit, options))
    process.start()
    theirs.close()
    if ours.poll(bound(limit) + HANG):
        try:
            seconds, megabytes, outcome = ours.recv()
        except EOFError:
            seconds, megabytes, outcome = float("inf"), float("nan"), "died"
    else:
        process.kill()
        seconds, megabytes, outcome = float("inf"), float("nan"), "killed"
    process.join()
    return Measured(kind, formula, limit, seconds, megabytes, outcome)


def _compile(pipe: Connection, formula: str, limit: float, options: dict[str, Any]) -> None:
    try:
        with time_limit(formula, limit):
            dra = ltlc.compile(formula, timeout=limit, **options)
            with overtime(Overtime.WRITE):
                dra.to_hoa()
        outcome = f"{dra.n_states} states"
    except Exception as error:
        outcome = type(error).__name__
    usage = resource.getrusage(resource.RUSAGE_SELF)
    pipe.send((time.process_time(), usage.ru_maxrss / 1024, outcome))


def report(results: Sequence[Measured]) -> None:
    """Print a line per kind and limit, then what is above the bound."""
    print(f"{'limit':>6} {'kind':12} {'n':>4} {'median':>7} {'99 %':>7} {'worst':>7} {'MB':>6}  above, errors")
    groups = {(r.limit, r.kind): None for r in results} | {(r.limit, "all"): None for r in results}
    for limit, kind in groups:
        chosen = [r for r in results if r.limit == limit and kind in (r.kind, "all")]
        times = sorted(r.seconds for r in chosen)
        percentile = times[min(len(times) - 1, int(0.99 * len(times)))]
        errors = sum(not r.outcome.endswith(" states") for r in chosen)
        print(
            f"{limit:6g} {kind:12} {len(chosen):4} {statistics.median(times):7.2f} {percentile:7.2f} {times[-1]:7.2f}"
            f" {max(r.megabytes for r in chosen):6.0f}  {sum(r.is_above for r in chosen)}, {errors}"
        )
    for r in results:
        if r.is_above:
            print(f"above: {r.seconds:.2f} s at {r.limit:g} s, {r.outcome}: {r.formula[:300]}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limits", type=float, nargs="+", default=[1.0, 3.0], help="seconds")
    parser.add_argument("--random", type=int, default=200, help="number of random formulas")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", help="only formulas of this kind; may be repeated")
    parser.add_argument("--acceptance", default="state", choices=["state", "transition"])
    parser.add_argument("--translator", default="auto")
    parser.add_argument("--effort", default="default", choices=["fast", "default", "best"])
    parser.add_argument("--json", type=Path, help="write the measurements to this file")
    arguments = parser.parse_args()
    kinds = {"found": found_before(), **families(), "random": random_formulas(arguments.random, arguments.seed)}
    options = {name: getattr(arguments, name) for name in ("acceptance", "translator", "effort")}
    results = []
    ltlc.compile("G(a -> F b)", **options).to_hoa()  # imports what is needed, once
    for limit in arguments.limits:
        for kind, formulas in kinds.items():
            if arguments.kind is None or kind in arguments.kind:
                results += [measured(kind, formula, limit, options) for formula in formulas]
    report(results)
    if arguments.json:
        arguments.json.write_text(json.dumps([asdict(r) for r in results], indent=1) + "\n", encoding="utf-8")
    return int(any(r.is_above for r in results))


if __name__ == "__main__":
    sys.exit(main())
