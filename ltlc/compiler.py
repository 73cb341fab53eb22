"""What the tool is named for: a formula in, an annotated deterministic Rabin automaton out."""

from __future__ import annotations

import os
from collections.abc import Iterable, MutableMapping
from dataclasses import replace
from itertools import islice
from typing import Literal, cast, get_args, overload

from ltlc import formats
from ltlc.automata.finite import DFA
from ltlc.automata.omega import OmegaAutomaton
from ltlc.automata.possible import possible_letters
from ltlc.automata.rabin import DRA, AcceptanceKind, Form
from ltlc.budget import MAX_STATES, time_limit
from ltlc.errors import DepthLimitExceeded, UnknownNameError, check_type
from ltlc.ltl import Formula, Proposition, fold, parse, postorder, propositions
from ltlc.translate import Effort, GeneralForm, Options, translate

MAX_SUBFORMULAS = 200_000
"""A formula with more of them takes seconds and hundreds of megabytes before a limit on states or time is asked."""


FORMS: tuple[str, ...] = (*get_args(Form), *get_args(GeneralForm))
"""The forms of automata over infinite words."""
Cache = MutableMapping[tuple[Formula, Options], DRA]


@overload
def compile(
    formula_or_text: Formula | str,
    *,
    finite: Literal[False] = False,
    form: Form = "rabin",
    acceptance: AcceptanceKind = "state",
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    cache: Cache | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> DRA: ...


@overload
def compile(
    formula_or_text: Formula | str,
    *,
    form: GeneralForm,
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> OmegaAutomaton: ...


@overload
def compile(
    formula_or_text: Formula | str,
    *,
    finite: Literal[True],
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> DFA: ...


def compile(
    formula_or_text: Formula | str,
    *,
    finite: bool = False,
    form: Form | GeneralForm = "rabin",
    acceptance: AcceptanceKind = "state",
    translator: str = "auto",
    effort: Effort = "default",
    max_states: int = MAX_STATES,
    timeout: float | None = None,
    cache: Cache | None = None,
    exclusive: Iterable[Iterable[str]] = (),
    letters: Iterable[Iterable[str]] | None = None,
) -> DRA | DFA | OmegaAutomaton:
    """Translate an LTL formula into a small deterministic Rabin automaton for the same words.

    The result depends on the arguments alone: the same formula gives the same numbering on every run and system.

    Args:
        formula_or_text: a formula, or text for `ltlc.parse`.
        finite: whether the formula is about finite traces. Then the result is the smallest deterministic automaton for
            them, an `ltlc.DFA`, and `form`, `acceptance`, `translator`, `effort` and `cache` have no effect.
        form: "rabin", or another form, with acceptance on transitions: "parity", "buchi" or "co-buchi", see
            `ltlc.automata.with_form`; or "emerson-lei", "generalized-rabin", "streett" or "limit-deterministic", for
            which the result is an `ltlc.automata.OmegaAutomaton`; see `ltlc.translate.translate_to_form`.
        acceptance: whether marks sit on states or on transitions; the latter can need fewer states.
        translator: a name from `ltlc.translate.TRANSLATORS`, or "auto" for the smallest result of several.
        effort: "fast", "default" or "best"; the last searches by SAT for the smallest automaton there is, and needs
            the package python-sat.
        max_states: no construction may build more states than this.
        timeout: seconds from the call on, or None for no limit. When they are over, the smallest automaton found so far
            is the result; TimeLimitExceeded if there is none.
        cache: a dictionary in which results are looked up and kept; formulas that differ in the names of their
            propositions only share an entry.
        exclusive: groups of propositions of which at most one holds at a time, as `[{"room1", "room2"}]`; they may
            overlap, and name propositions that the formula does not mention. The automaton reads only letters that
            are possible then, and raises `ImpossibleLetterError` on another one.
        letters: instead of that, all letters that are possible, each a set of names; what the formula does not mention
            is left out of them.

    Raises:
        LtlSyntaxError: the text is not a formula.
        UnknownNameError: there is no such translator or form.
        InvalidArgumentError: another argument is out of range, or no automaton of the form accepts the language.
        LimitExceeded: `max_states`, `timeout` or the number of propositions does not suffice.

    Example:
        >>> dra = compile("F goal & G !trap")
        >>> dra.accepts(prefix=[[], ["goal"]], cycle=[[]])
        True
        >>> compile("F goal & last", finite=True).accepts([["goal"]])
        True
        >>> compile("F(a & F b)").n_classes, compile("F(a & F b)", exclusive=[{"a", "b"}]).n_classes
        (4, 3)
    """
    options = Options(acceptance, translator, effort, max_states, timeout).checked()
    if form not in FORMS:
        raise UnknownNameError("form", form, FORMS)
    if form != "rabin":
        options = options._replace(acceptance="transition")
    if cache is not None:
        check_type(cache, MutableMapping, "cache", "a dictionary, or None")
    with time_limit(formula_or_text if isinstance(formula_or_text, str) else "the formula", timeout):
        formula = as_formula(formula_or_text, finite=finite)
        shape, names = canonical_propositions(formula)
        possible = possible_letters(names, exclusive, letters)
        if finite:
            from ltlc.translate import translate_finite

            return translate_finite(formula, max_states=options.max_states, possible=possible)
        options = options._replace(possible=possible)
        text = str(formula)
        if form in get_args(GeneralForm):
            from ltlc.translate import translate_to_form

            general = translate_to_form(shape, cast(GeneralForm, form), options, text=text)
            return replace(general, aps=names, formula=text)
        known = None if cache is None else cache.get((shape, options))
        if known is None:
            known = translate(shape, options, text=text)
            if cache is not None:
                cache[shape, options] = known
        named = known.named(text, aps=names)
        if form == "rabin":
            return named
        from ltlc.automata import with_form

        return with_form(named, cast(Form, form), max_states=options.max_states)


def as_formula(formula_or_text: Formula | str, *, finite: bool = False) -> Formula:
    """What an argument means: a formula, or text to parse."""
    check_type(formula_or_text, (Formula, str), "the formula", "a text, or what parse returns")
    return parse(formula_or_text, finite=finite) if isinstance(formula_or_text, str) else formula_or_text


def check_size(formula: Formula) -> None:
    """Raise DepthLimitExceeded if the formula has more than `MAX_SUBFORMULAS` different subformulas."""
    if sum(1 for _ in islice(postorder(formula), MAX_SUBFORMULAS + 1)) > MAX_SUBFORMULAS:
        raise DepthLimitExceeded(
            f"the formula has more than {MAX_SUBFORMULAS} different subformulas: split it into several formulas"
        )


def canonical_propositions(formula: Formula) -> tuple[Formula, tuple[str, ...]]:
    """The formula with its propositions renamed p0, p1, ... in order of appearance, and their names.

    Raises:
        DepthLimitExceeded: the formula has more than `MAX_SUBFORMULAS` different subformulas.
    """
    check_size(formula)
    names = propositions(formula)
    renamed = {name: Proposition(f"p{i}") for i, name in enumerate(names)}

    def rename(node: Formula, args: list[Formula]) -> Formula:
        return renamed[node.name] if isinstance(node, Proposition) else node.with_args(tuple(args))

    return fold(formula, {}, rename), names


def load(
    path: str | os.PathLike[str],
    *,
    determinise: bool = False,
    max_states: int = MAX_STATES,
    timeout: float | None = None,
) -> DRA | DFA:
    """Read an automaton from a .json or .hoa file; with another suffix the content decides.

    A file of an automaton over finite traces gives an `ltlc.DFA`.

    Args:
        path: of the file.
        determinise: make a nondeterministic Buchi or generalized Buchi automaton in HOA deterministic, instead of an
            error; see `ltlc.translate.determinise`.
        max_states: limit for that.
        timeout: seconds for that, or None.

    Raises:
        FileFormatError: the content is not what the suffix promises; says where.
        LimitExceeded: it has too many propositions, or needs too many states to get Rabin pairs.
        OSError: the file is missing or not readable.
    """
    if not determinise:
        return formats.read(path)
    return _determinised(formats.read_any(path), max_states, timeout)


def deterministic(hoa: str, *, max_states: int = MAX_STATES, timeout: float | None = None) -> DRA | DFA:
    """The automaton of an HOA text as `load` with `determinise` gives it."""
    return _determinised(formats.from_hoa(hoa, nondeterministic=True), max_states, timeout)


def _determinised(automaton: DRA | DFA | OmegaAutomaton, max_states: int, timeout: float | None) -> DRA | DFA:
    from ltlc.automata import OmegaAutomaton
    from ltlc.translate import determinise

    if isinstance(automaton, OmegaAutomaton):
        return determinise(automaton, max_states=max_states, timeout=timeout)
    return automaton
