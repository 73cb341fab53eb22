"""What the tool is named for: a formula in, an annotated deterministic Rabin automaton out."""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from dataclasses import fields
from itertools import islice
from numbers import Integral, Real
from pathlib import Path
from typing import Any, NamedTuple, Self

from ltlc import formats
from ltlc.automata import RabinAutomaton
from ltlc.automata.rabin import Acceptance
from ltlc.budget import time_limit
from ltlc.errors import DepthLimitExceeded, InvalidArgumentError, MissingProgramError, check_type
from ltlc.formats.picture import draw
from ltlc.ltl import Formula, Proposition, fold, parse, postorder, propositions
from ltlc.translate import Effort, translate

NOTEBOOK_STATES = 200
"""A notebook shows larger automata as one line: Graphviz would take minutes, and nobody could read the result."""

MAX_SUBFORMULAS = 200_000
"""A formula with more of them takes seconds and hundreds of megabytes before a limit on states or time is asked."""


class Options(NamedTuple):
    """What a translation depends on besides the formula; see `compile`."""

    acceptance: Acceptance = "state"
    translator: str = "auto"
    effort: Effort = "default"
    max_states: int = 100_000
    timeout: float | None = None

    def check(self) -> None:
        """Raise InvalidArgumentError if a limit is none or out of range; names are checked where they are looked up."""
        check_type(self.translator, str, "translator", "a name")
        check_type(self.max_states, Integral, "max_states", "a whole number")
        if self.timeout is not None:
            check_type(self.timeout, Real, "timeout", "a positive number of seconds, or None")
        if self.max_states < 1:
            raise InvalidArgumentError(f"max_states is {self.max_states}; at least 1 state is needed")
        if self.timeout is not None and not self.timeout > 0:
            raise InvalidArgumentError(f"timeout is {self.timeout:g}; it must be a positive number of seconds, or None")


Cache = MutableMapping[tuple[Formula, Options], RabinAutomaton]


class DRA(RabinAutomaton):
    """A deterministic Rabin automaton that can write itself.

    Made by `compile` and `load`; everything about states, pairs and words is inherited.
    """

    @classmethod
    def of(cls, automaton: RabinAutomaton, **changes: Any) -> Self:
        """The same automaton, but for the fields in `changes`, with the methods of this class."""
        check_type(automaton, RabinAutomaton, "the automaton", "a RabinAutomaton")
        return cls(**{field.name: getattr(automaton, field.name) for field in fields(automaton)} | changes)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write to a file whose suffix says the format: .json .hoa .dot .mmd .md .svg .png .pdf.

        The file appears complete or not at all.

        Returns:
            Where it was written.

        Raises:
            InvalidArgumentError: the suffix is not one of those above.
            MissingProgramError: nothing that draws pictures is installed; the .dot file is written instead.
            OSError: the folder is missing, not writable or full.
        """
        return formats.write(self, path)

    def to_json(self) -> str:
        """The automaton with its annotations as the text of a .json file."""
        return formats.to_json(self)

    def to_hoa(self) -> str:
        """The automaton in the Hanoi Omega-Automata format, version 1."""
        return formats.to_hoa(self)

    def to_dot(self) -> str:
        """The picture as Graphviz source."""
        return formats.to_dot(self)

    def to_mermaid(self) -> str:
        """The picture as a Mermaid state diagram, for Markdown pages."""
        return formats.to_mermaid(self)

    def to_svg(self) -> str:
        """The picture.

        Raises:
            MissingProgramError: nothing that draws is installed.
        """
        return draw(self.to_dot(), "svg").decode("utf-8")

    def _repr_svg_(self) -> str | None:
        """The picture for a notebook, or None where nothing that draws is installed or there is too much to see."""
        try:
            return self.to_svg() if self.n_states <= NOTEBOOK_STATES else None
        except MissingProgramError:
            return None

    @property
    def size(self) -> str:
        """Size and kind for a reader, e.g. "5 states, 1 pair, state-based"."""
        states = "1 state" if self.n_states == 1 else f"{self.n_states} states"
        pairs = "1 pair" if self.n_pairs == 1 else f"{self.n_pairs} pairs"
        return f"{states}, {pairs}, {self.acceptance}-based"

    def __repr__(self) -> str:
        formula = self.formula or "an unnamed language"
        return f"<DRA of {formula if len(formula) <= 80 else formula[:77] + '...'}: {self.size}>"


def compile(
    formula_or_text: Formula | str,
    *,
    acceptance: Acceptance = "state",
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = 100_000,
    timeout: float | None = None,
    cache: Cache | None = None,
) -> DRA:
    """Translate an LTL formula into a small deterministic Rabin automaton for the same words.

    The result depends on the arguments alone: the same formula gives the same numbering on every run and system.

    Args:
        formula_or_text: a formula, or text for `ltlc.parse`.
        acceptance: whether marks sit on states or on transitions; the latter can need fewer states.
        translator: a name from `ltlc.translate.TRANSLATORS`, or "auto" for the smallest result of several.
        effort: "fast", "default" or "best"; the last searches by SAT for the smallest automaton there is, and needs
            the package python-sat.
        max_states: no construction may build more states than this.
        timeout: seconds from the call on, or None for no limit. When they are over, the smallest automaton found so far
            is the result; TimeLimitExceeded if there is none.
        cache: a dictionary in which results are looked up and kept; formulas that differ in the names of their
            propositions only share an entry.

    Raises:
        LtlSyntaxError: the text is not a formula.
        UnknownNameError: there is no such translator.
        InvalidArgumentError: another argument is out of range.
        LimitExceeded: `max_states`, `timeout` or the number of propositions does not suffice.

    Example:
        >>> dra = compile("F goal & G !trap")
        >>> dra.accepts(prefix=[[], ["goal"]], cycle=[[]])
        True
    """
    options = Options(acceptance, translator, effort, max_states, timeout)
    options.check()
    if cache is not None:
        check_type(cache, MutableMapping, "cache", "a dictionary, or None")
    with time_limit(formula_or_text if isinstance(formula_or_text, str) else "the formula", timeout):
        formula = as_formula(formula_or_text)
        shape, names = shape_of(formula)
        text = str(formula)
        known = None if cache is None else cache.get((shape, options))
        if known is None:
            known = translate(shape, **options._asdict(), text=text)
            if cache is not None:
                cache[shape, options] = known
        return DRA.of(known, aps=names, formula=text)


def as_formula(formula_or_text: Formula | str) -> Formula:
    """What an argument means: a formula, or text to parse."""
    check_type(formula_or_text, (Formula, str), "the formula", "a text, or what parse returns")
    return parse(formula_or_text) if isinstance(formula_or_text, str) else formula_or_text


def shape_of(formula: Formula) -> tuple[Formula, tuple[str, ...]]:
    """The formula with its propositions renamed p0, p1, ... in order of appearance, and their names.

    Raises:
        DepthLimitExceeded: the formula has more than `MAX_SUBFORMULAS` different subformulas.
    """
    if sum(1 for _ in islice(postorder(formula), MAX_SUBFORMULAS + 1)) > MAX_SUBFORMULAS:
        raise DepthLimitExceeded(
            f"the formula has more than {MAX_SUBFORMULAS} different subformulas: split it into several formulas"
        )
    names = propositions(formula)
    renamed = {name: Proposition(f"p{i}") for i, name in enumerate(names)}

    def rename(node: Formula, args: list[Formula]) -> Formula:
        return renamed[node.name] if isinstance(node, Proposition) else node.with_args(tuple(args))

    return fold(formula, {}, rename), names


def load(path: str | os.PathLike[str]) -> DRA:
    """Read an automaton from a .json or .hoa file; with another suffix the content decides.

    Raises:
        FileFormatError: the content is not what the suffix promises; says where.
        LimitExceeded: it has too many propositions, or needs too many states to get Rabin pairs.
        OSError: the file is missing or not readable.
    """
    return DRA.of(formats.read(path))
