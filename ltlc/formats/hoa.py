"""Writing the Hanoi Omega-Automata format, version 1.

References:
    T. Babiak, F. Blahoudek, A. Duret-Lutz, J. Klein, J. Kretinsky, D. Mueller, D. Parker, J. Strejcek, The Hanoi
    Omega-Automata Format, CAV 2015, doi 10.1007/978-3-319-21690-4_31.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ltlc.automata.finite import DFA
from ltlc.automata.omega import OmegaAutomaton
from ltlc.automata.rabin import DRA
from ltlc.formats.edges import edges, state_marks
from ltlc.formats.hoa_general import acceptance_of, body_of
from ltlc.formats.wide_edges import Names
from ltlc.graph import bits
from ltlc.version import __version__


def to_hoa(automaton: DRA | DFA | OmegaAutomaton) -> str:
    """The automaton in HOA: explicit labels, Fin(2i) & Inf(2i+1) for pair i, marks on states or on transitions.

    Every mark of a state is written at the state, every mark of a transition at the transition, so that reading gives
    the same tables back. The same automaton gives the same bytes. An automaton over finite traces has the header
    `Words: finite`, which other tools refuse, since its capital letter says that it changes what is accepted; a trace
    may then end in the states of Inf(1). One in a special form (`ltlc.automata.with_form`) has that form's name and
    condition. Where letters are impossible, labels say so, by the alias @possible, and the automaton has no edge for
    them; the headers `possible:` list the possible combinations, one part of the alphabet each, for reading it back.
    """
    if isinstance(automaton, OmegaAutomaton):
        return _general(automaton)
    if isinstance(automaton, DRA) and automaton.forms & set(_NAMED):
        return _named(automaton)
    n_pairs = automaton.n_pairs
    pairs = [f"Fin({2 * i}) & Inf({2 * i + 1})" for i in range(n_pairs)]
    condition = pairs[0] if n_pairs == 1 else " | ".join(f"({pair})" for pair in pairs) or "f"
    where = "state-acc" if automaton.acceptance == "state" else "trans-acc"
    lines = [
        *_head(automaton),
        f"acc-name: Rabin {n_pairs}",
        f"Acceptance: {2 * n_pairs} {condition}",
        *(["Words: finite"] if isinstance(automaton, DFA) else []),
        f"properties: trans-labels explicit-labels {where} deterministic{_complete(automaton)}",
        "--BODY--",
        *_body(automaton, _rabin_marks),
        "--END--",
    ]
    return "\n".join(lines) + "\n"


def _general(automaton: OmegaAutomaton) -> str:
    """An automaton with any condition, deterministic or not."""
    properties = " deterministic" if automaton.is_deterministic else ""
    if automaton.is_deterministic and automaton.is_complete:
        properties += _complete(automaton)
    lines = [
        *_head(automaton),
        *acceptance_of(automaton),
        f"properties: trans-labels explicit-labels trans-acc{properties}",
        "--BODY--",
        *body_of(automaton),
        "--END--",
    ]
    return "\n".join(lines) + "\n"


def _head(automaton: DRA | DFA | OmegaAutomaton) -> list[str]:
    lines = ["HOA: v1", f'tool: "ltlc" {_string(__version__)}']
    if automaton.formula is not None:
        lines.append(f"name: {_string(automaton.formula)}")
    return [
        *lines,
        f"States: {automaton.n_states}",
        *(f"Start: {state}" for state in _starts(automaton)),
        " ".join([f"AP: {len(automaton.aps)}", *map(_string, automaton.aps)]),
        *_possible(automaton),
    ]


def _starts(automaton: DRA | DFA | OmegaAutomaton) -> tuple[int, ...]:
    return automaton.initial_states if isinstance(automaton, OmegaAutomaton) else (automaton.initial_state,)


def _possible(automaton: DRA | DFA | OmegaAutomaton) -> list[str]:
    """The possible letters, part by part, and as an alias that labels use."""
    if automaton.possible is None:
        return []
    headers, condition = [], []
    for part in automaton.possible:
        places = sorted({i for mask in part for i in bits(mask)})
        headers.append(" ".join(["possible:", *(_string(" ".join(map(str, bits(mask)))) for mask in part)]))
        if part == (0, *(1 << i for i in places)):
            condition += [_at_most_one(places)] if len(places) > 1 else []
        elif len(part) < 1 << len(places):
            terms = (" & ".join(f"{'' if mask >> i & 1 else '!'}{i}" for i in places) for mask in part)
            condition.append(f"({' | '.join(terms)})")
    never = set(range(len(automaton.aps))) - {i for part in automaton.possible for mask in part for i in bits(mask)}
    condition += [f"!{i}" for i in sorted(never)]
    return [*headers, f"Alias: @possible {' & '.join(condition) or 't'}"]


def _at_most_one(places: Sequence[int]) -> str:
    """Of two propositions or more: n log n literals."""
    halves = places[: len(places) // 2], places[len(places) // 2 :]
    none = [" & ".join(f"!{i}" for i in half) for half in halves]
    if len(places) == 2:
        return f"({none[0]} | {none[1]})"
    some = [_at_most_one(half) if len(half) > 1 else "" for half in halves]
    sides = [" & ".join(filter(None, pair)) for pair in ((none[0], some[1]), (some[0], none[1]))]
    return f"({sides[0]} | {sides[1]})"


def _complete(automaton: DRA | DFA | OmegaAutomaton) -> str:
    return " complete" if automaton.possible is None else ""


_NAMED = ("parity", "buchi", "co-buchi")
_Marks = Callable[[tuple[int, ...], tuple[int, ...]], str]
"""The marks of an edge in HOA, given the pairs whose fin and inf contain it."""


def _named(automaton: DRA) -> str:
    """The automaton under the name of its form; see `ltlc.automata.forms`."""
    marks: _Marks
    if "parity" in automaton.forms:
        # An edge in fin of the first k pairs has colour 2 k, and 2 k + 1 if it is in inf of pair k.
        n = 2 * automaton.n_pairs + int(automaton.fin.all(axis=0).any())
        condition = "Fin(0)"
        for colour in range(1, n):
            inner = condition if colour == 1 else f"({condition})"
            condition = f"Inf({colour}) | {inner}" if colour % 2 else f"Fin({colour}) & {inner}"
        name = f"parity max odd {n}"
        properties = " colored"

        def marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
            return f" {{{2 * len(fin) + bool(inf)}}}"
    elif "buchi" in automaton.forms:
        n, name, condition, properties = 1, "Buchi", "Inf(0)", ""

        def marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
            return " {0}" if inf else ""
    else:
        n, name, condition, properties = 1, "co-Buchi", "Fin(0)", ""

        def marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
            return " {0}" if fin else ""

    lines = [
        *_head(automaton),
        f"acc-name: {name}",
        f"Acceptance: {n} {condition}",
        f"properties: trans-labels explicit-labels trans-acc{properties} deterministic{_complete(automaton)}",
        "--BODY--",
        *_body(automaton, marks),
        "--END--",
    ]
    return "\n".join(lines) + "\n"


def _body(automaton: DRA | DFA, marks: _Marks) -> list[str]:
    names = Names([str(i) for i in range(len(automaton.aps))], "t", "f")
    before, behind = ("[", "]") if automaton.possible is None else ("[@possible & (", ")]")
    written: dict[tuple[tuple[int, ...], tuple[int, ...]], str] = {}
    lines: list[str] = []
    n_listed = 0
    for source, target, guard, fin, inf in edges(automaton, names):
        if source == n_listed:
            name = "" if automaton.state_names is None else " " + _string(automaton.state_names[n_listed])
            lines.append(f"State: {n_listed}{name}{_rabin_marks(*state_marks(automaton, n_listed))}")
            n_listed += 1
        pairs = fin, inf
        if pairs not in written:
            written[pairs] = marks(fin, inf)
        lines.append(f"{before}{guard}{behind} {target}{written[pairs]}")
    return lines


def _rabin_marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
    sets = sorted([2 * i for i in fin] + [2 * i + 1 for i in inf])
    return f" {{{' '.join(map(str, sets))}}}" if sets else ""


def _string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
