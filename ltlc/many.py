"""Thousands of formulas at once, as multi-task training needs them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import starmap
from multiprocessing import get_context

from ltlc.automata import RabinAutomaton
from ltlc.automata.rabin import Acceptance
from ltlc.compiler import DRA, Cache, Options, shape_of
from ltlc.ltl import Formula, parse
from ltlc.translate import Effort, translate

_CHUNK = 32
"""formulas handed to a process at a time; fewer are not worth starting one."""


def compile_many(
    formulas: Iterable[Formula | str],
    *,
    acceptance: Acceptance = "state",
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = 100_000,
    timeout: float | None = None,
    workers: int | None = 1,
    cache: Cache | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[DRA]:
    """`ltlc.compile` for many formulas.

    Formulas that differ in the names of their propositions only have the same automaton but for these names; each such
    shape is translated once, and the shapes are shared among processes.

    Args:
        formulas: formulas or their texts.
        acceptance: see `ltlc.compile`.
        translator: see `ltlc.compile`.
        effort: see `ltlc.compile`.
        max_states: see `ltlc.compile`; for each formula.
        timeout: see `ltlc.compile`; for each formula.
        workers: number of processes, 1 for none besides this one, None for one per processor. With more than one, a
            script has to keep its own work under `if __name__ == "__main__":`.
        cache: see `ltlc.compile`.
        progress: called with the number of shapes translated so far and of those to translate.

    Returns:
        The automata in the order of the formulas; the same as one call of `ltlc.compile` for each.

    Raises:
        LtlSyntaxError, LimitExceeded, UnknownNameError, InvalidArgumentError: as `ltlc.compile`, for the first formula
            that fails.

    Example:
        >>> [dra.n_states for dra in compile_many(["F goal", "F exit", "GF a & GF b"])]
        [2, 2, 3]
    """
    options = Options(acceptance, translator, effort, max_states, timeout)
    options.check()
    parsed = [parse(f) if isinstance(f, str) else f for f in formulas]
    shaped = [shape_of(formula) for formula in parsed]
    known: Cache = {} if cache is None else cache
    texts: dict[Formula, str] = {}
    for formula, (shape, _) in zip(parsed, shaped, strict=True):
        if (shape, options) not in known:
            texts.setdefault(shape, str(formula))
    jobs = [(shape, options, text) for shape, text in texts.items()]
    for done, (job, automaton) in enumerate(zip(jobs, _translated(jobs, workers), strict=True), 1):
        known[job[:2]] = automaton
        if progress is not None:
            progress(done, len(jobs))
    return [
        DRA.of(known[shape, options], aps=names, formula=str(formula))
        for formula, (shape, names) in zip(parsed, shaped, strict=True)
    ]


def _translated(jobs: list[tuple[Formula, Options, str]], workers: int | None) -> Iterator[RabinAutomaton]:
    n_workers = min(os.cpu_count() or 1 if workers is None else workers, len(jobs) // _CHUNK)
    if n_workers <= 1:
        yield from starmap(_translate, jobs)
        return
    with ProcessPoolExecutor(n_workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(_translate, *zip(*jobs, strict=True), chunksize=_CHUNK)


def _translate(formula: Formula, options: Options, text: str) -> RabinAutomaton:
    return translate(formula, **options._asdict(), text=text)
