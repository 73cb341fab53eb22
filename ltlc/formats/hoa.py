"""Writing the Hanoi Omega-Automata format, version 1.

References:
    T. Babiak, F. Blahoudek, A. Duret-Lutz, J. Klein, J. Kretinsky, D. Mueller, D. Parker, J. Strejcek, The Hanoi
    Omega-Automata Format, CAV 2015, doi 10.1007/978-3-319-21690-4_31.
"""

from __future__ import annotations

from ltlc.automata.finite import DFA
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time
from ltlc.formats.edges import edges, state_marks
from ltlc.version import __version__


def to_hoa(automaton: DRA | DFA) -> str:
    """The automaton in HOA: explicit labels, Fin(2i) & Inf(2i+1) for pair i, marks on states or on transitions.

    Every mark of a state is written at the state, every mark of a transition at the transition, so that reading gives
    the same tables back. The same automaton gives the same bytes. An automaton over finite traces has the header
    `Words: finite`, which other tools refuse, since its capital letter says that it changes what is accepted; a trace
    may then end in the states of Inf(1).
    """
    n_pairs = automaton.n_pairs
    pairs = [f"Fin({2 * i}) & Inf({2 * i + 1})" for i in range(n_pairs)]
    condition = pairs[0] if n_pairs == 1 else " | ".join(f"({pair})" for pair in pairs) or "f"
    where = "state-acc" if automaton.acceptance == "state" else "trans-acc"
    lines = ["HOA: v1", f'tool: "ltlc" {_string(__version__)}']
    if automaton.formula is not None:
        lines.append(f"name: {_string(automaton.formula)}")
    lines += [
        f"States: {automaton.n_states}",
        f"Start: {automaton.initial_state}",
        " ".join([f"AP: {len(automaton.aps)}", *map(_string, automaton.aps)]),
        f"acc-name: Rabin {n_pairs}",
        f"Acceptance: {2 * n_pairs} {condition}",
        *(["Words: finite"] if isinstance(automaton, DFA) else []),
        f"properties: trans-labels explicit-labels {where} deterministic complete",
        "--BODY--",
        *_body(automaton),
        "--END--",
    ]
    return "\n".join(lines) + "\n"


def _body(automaton: DRA | DFA) -> list[str]:
    numbers = [str(i) for i in range(len(automaton.aps))]
    labels: dict[tuple[int, ...], str] = {}
    lines: list[str] = []
    n_listed = 0
    for edge in edges(automaton):
        check_time()
        if edge.source == n_listed:
            name = "" if automaton.state_names is None else " " + _string(automaton.state_names[n_listed])
            lines.append(f"State: {n_listed}{name}{_marks(*state_marks(automaton, n_listed))}")
            n_listed += 1
        if edge.classes not in labels:
            labels[edge.classes] = automaton.alphabet.guard(edge.classes).text(numbers, "t", "f")
        lines.append(f"[{labels[edge.classes]}] {edge.target}{_marks(edge.fin, edge.inf)}")
    return lines


def _marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
    sets = sorted([2 * i for i in fin] + [2 * i + 1 for i in inf])
    return f" {{{' '.join(map(str, sets))}}}" if sets else ""


def _string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
