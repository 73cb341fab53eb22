"""Thousands of formulas at once, as multi-task training needs them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, MutableMapping
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import replace
from itertools import chain, islice
from multiprocessing import get_context
from numbers import Integral
from typing import Any, Literal, overload

from ltlc.automata import DFA, DRA
from ltlc.automata.possible import possible_letters
from ltlc.automata.rabin import AcceptanceKind
from ltlc.budget import MAX_STATES, time_limit
from ltlc.compiler import Cache, as_formula, canonical_propositions
from ltlc.errors import InvalidArgumentError, check_type
from ltlc.ltl import Formula
from ltlc.translate import Effort, Options, translate, translate_finite

_CHUNK = 32
"""formulas handed to a process at a time; fewer are not worth starting one."""

_Job = tuple[Formula, Options, str, float, bool]
"""a shape to translate, how, the text of a formula of that shape, how many seconds it took to read it, and whether it
is about finite traces."""


@overload
def compile_many(
    formulas: Iterable[Formula | str],
    *,
    finite: Literal[False] = False,
    acceptance: AcceptanceKind = "state",
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    workers: int | None = 1,
    cache: Cache | None = None,
    progress: Callable[[int, int], None] | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> list[DRA]: ...


@overload
def compile_many(
    formulas: Iterable[Formula | str],
    *,
    finite: Literal[True],
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    workers: int | None = 1,
    progress: Callable[[int, int], None] | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> list[DFA]: ...


def compile_many(
    formulas: Iterable[Formula | str],
    *,
    finite: bool = False,
    acceptance: AcceptanceKind = "state",
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    workers: int | None = 1,
    cache: Cache | None = None,
    progress: Callable[[int, int], None] | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> list[DRA] | list[DFA]:
    """`ltlc.compile` for many formulas.

    Formulas that differ in the names of their propositions only have the same automaton but for these names; each such
    shape is translated once, and the shapes are shared among processes.

    Args:
        formulas: formulas or their texts.
        finite: whether they are about finite traces; then the results are `ltlc.DFA`, and `acceptance`, `translator`,
            `effort` and `cache` have no effect.
        acceptance: see `ltlc.compile`.
        translator: see `ltlc.compile`.
        effort: see `ltlc.compile`.
        max_states: see `ltlc.compile`; for each formula.
        timeout: see `ltlc.compile`; for each formula.
        workers: number of processes, 1 for none besides this one, None for one per processor. With more than one, a
            script has to keep its own work under `if __name__ == "__main__":`.
        cache: see `ltlc.compile`.
        progress: called with the number of shapes translated so far and of those to translate.
        exclusive: see `ltlc.compile`; for all formulas.
        letters: see `ltlc.compile`; for all formulas.

    Returns:
        The automata in the order of the formulas; the same as one call of `ltlc.compile` for each.

    Raises:
        LtlSyntaxError, LimitExceeded, UnknownNameError, InvalidArgumentError: as `ltlc.compile`, for the first formula
            that fails.

    Example:
        >>> [dra.n_states for dra in compile_many(["F goal", "F exit", "GF a & GF b"])]
        [2, 2, 3]
        >>> [dfa.n_states for dfa in compile_many(["F goal", "F(a & last)"], finite=True)]
        [2, 2]
    """
    options = Options(acceptance, translator, effort, max_states, timeout).checked()
    if isinstance(formulas, str) or not isinstance(formulas, Iterable):
        raise InvalidArgumentError("formulas must be several: put a single one in a list")
    if workers is not None:
        check_type(workers, Integral, "workers", "a number of processes, or None")
        if workers < 1:
            raise InvalidArgumentError(
                f"workers is {workers}; at least 1 process is needed, or None for all processors"
            )
    if progress is not None and not callable(progress):
        raise InvalidArgumentError(f"progress is of type {type(progress).__name__}; it must be a function, or None")
    if cache is not None:
        check_type(cache, MutableMapping, "cache", "a dictionary, or None")
    known: dict[Any, Any] | Cache = {} if cache is None or finite else cache
    read: list[tuple[Formula, Options, tuple[str, ...], str]] = []
    missing: dict[tuple[Formula, Options], None] = {}
    groups, possible = [frozenset(group) for group in exclusive], None if letters is None else list(letters)

    def jobs() -> Iterator[_Job]:
        for formula in formulas:
            started = time.monotonic()
            with time_limit(formula if isinstance(formula, str) else "the formula", timeout):
                parsed = as_formula(formula, finite=finite)
                shape, names = canonical_propositions(parsed)
                text = str(parsed)
                own = options._replace(possible=possible_letters(names, groups, possible))
            read.append((shape, own, names, text))
            if (shape, own) not in missing and (shape, own) not in known:
                missing[shape, own] = None
                yield shape, own, text, time.monotonic() - started, finite

    for done, ((shape, own, *_), automaton) in enumerate(_translated(jobs(), workers), 1):
        known[shape, own] = automaton
        if progress is not None:
            progress(done, len(missing))
    return [replace(known[shape, own], aps=names, formula=text) for shape, own, names, text in read]


def _translated(jobs: Iterator[_Job], workers: int | None) -> Iterator[tuple[_Job, Any]]:
    """The jobs with their automata, in order; the first one comes when there are no more jobs to come."""
    n_workers = os.cpu_count() or 1 if workers is None else workers
    first = list(islice(jobs, 2 * _CHUNK if n_workers > 1 else None))
    if n_workers <= 1 or len(first) < 2 * _CHUNK:
        for job in first:
            yield job, _translate(job)
        return
    ahead = chain(first, jobs)
    under_way: list[tuple[list[_Job], Future[list[DRA | DFA]]]] = []
    with ProcessPoolExecutor(n_workers, mp_context=get_context("spawn")) as pool:
        try:
            # Others translate while this process still reads formulas.
            while chunk := list(islice(ahead, _CHUNK)):
                under_way.append((chunk, pool.submit(_translate_all, chunk)))
            for chunk, automata in under_way:
                yield from zip(chunk, automata.result(), strict=True)
        finally:
            for _, automata in under_way:
                automata.cancel()


def _translate_all(jobs: list[_Job]) -> list[DRA | DFA]:
    return [_translate(job) for job in jobs]


def _translate(job: _Job) -> DRA | DFA:
    shape, options, text, spent, finite = job
    with time_limit(text, options.timeout, spent):
        if finite:
            return translate_finite(shape, max_states=options.max_states, text=text, possible=options.possible)
        return translate(shape, options, text=text)
