"""Random formulas and words on which everything is compared with the textbook's definition, which shares no code.

    python benchmarks/definitions.py                               # 200 000 comparisons, and 100 000 verdicts
    python benchmarks/definitions.py --kinds finite past bounded --count 1000000 --seed 7
    python benchmarks/definitions.py --kinds speed

The kinds: formulas on finite traces (a half of them with a past), with a past on infinite words, and with bounds on
both; automata, evaluation and normal forms say what the definition says. The verdicts of monitors are decided again by
emptiness. `speed` is the number of letters a second of a monitor that watches a thousand words. What is wrong is
printed, and the exit code is 1 then. The comparisons are those of `tests/oracles/by_definition.py`.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "oracles"))

from by_definition import Answers, bounded, finite, past, verdicts

from ltlc import Monitor

COMPARED: dict[str, Callable[[random.Random], Answers]] = {
    "finite": lambda rng: finite(rng, 1, 20),
    "past": lambda rng: past(rng, 1, 20, "fast"),
    "bounded": lambda rng: bounded(rng, 1, 10),
    "verdicts": lambda rng: verdicts(rng, 1),
}
LANGUAGES = ("finite", "past", "bounded")
KINDS = (*COMPARED, "speed")


def compared(kind: str, count: int, seed: int) -> int:
    """Make so many comparisons of a kind; the number of those that are wrong."""
    rng = random.Random(f"{kind} {seed}")
    begin, done, formulas, wrong = time.process_time(), 0, 0, 0
    while done < count:
        formulas += 1
        for answer in COMPARED[kind](rng):
            done += 1
            if answer is not None:
                wrong += 1
                print(f"{kind}, seed {seed}: {answer}", flush=True)
        if not formulas % 5000:
            print(f"  {done} so far", file=sys.stderr, flush=True)
    seconds = time.process_time() - begin
    print(f"{kind:9} {done:9} comparisons, {formulas} formulas, {wrong} wrong, {seconds:.0f} s", flush=True)
    return wrong


def speed() -> None:
    """Letters a second, all words at once."""
    monitor = Monitor("G(request -> F grant) & G !error & (start R !grant)")
    letters = np.random.default_rng(0).integers(1 << len(monitor.aps), size=(1000, 1000))
    begin = time.process_time()
    monitor.run(letters)
    print(f"speed     {letters.size / (time.process_time() - begin):.3g} letters a second, a thousand words at once")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--count", type=int, default=200_000, help="comparisons of languages; half as many of verdicts")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    wrong = 0
    for kind in arguments.kinds:
        if kind == "speed":
            speed()
            continue
        n_languages = sum(each in LANGUAGES for each in arguments.kinds)
        count = arguments.count // 2 if kind == "verdicts" else -(-arguments.count // n_languages)
        wrong += compared(kind, count, arguments.seed)
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
