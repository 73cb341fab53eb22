"""Mutants of every kind of file that is read: how many are read, how many refused, and whether any does harm.

    python benchmarks/fuzz.py [--kinds hoa json prism config policy table checkpoint] [--count 20000] [--seed 0]
                              [--json FILE]

Mutants are made in `tests/oracles/mutants.py`. Harm is an exception that is none of ours (it is shown, with the seed
that makes the mutant again), code that runs, or more than 1 GB of memory.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "oracles"))

from mutants import Maker, Reader, kinds

from ltlc.errors import LtlcError

KINDS = ("hoa", "json", "prism", "config", "policy", "table", "checkpoint")


def run(name: str, make: Maker, read: Reader, count: int, seed: int) -> dict[str, Any]:
    """Read so many mutants."""
    ends: Counter[str] = Counter()
    slowest, slow_seed = 0.0, 0
    for number in range(seed, seed + count):
        mutant = make(random.Random(number))
        begin = time.perf_counter()
        try:
            read(mutant)
            ends["read"] += 1
        except LtlcError as error:
            ends[type(error).__name__] += 1
        except Exception as error:
            ends[f"HARM {type(error).__name__}"] += 1
            print(f"{name}, seed {number}:", traceback.format_exc(limit=-4), file=sys.stderr)
        seconds = time.perf_counter() - begin
        if seconds > slowest:
            slowest, slow_seed = seconds, number
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return {
        "kind": name,
        "count": count,
        **ends,
        "slowest_s": round(slowest, 3),
        "slow_seed": slow_seed,
        "peak_mb": peak,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    forbidden: Counter[str] = Counter()

    def audit(event: str, _: tuple[object, ...]) -> None:
        if event in ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork"):
            forbidden[event] += 1

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        made = kinds(Path(folder))
        sys.addaudithook(audit)
        for name in arguments.kinds:
            row = run(name, *made[name], arguments.count, arguments.seed)
            row["executed"] = sum(forbidden.values())
            rows.append(row)
            print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
