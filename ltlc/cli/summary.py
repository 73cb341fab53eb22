"""An automaton in a few lines, for a person and for a program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ltlc.cli.tables import Column, Row, Table, print_line, print_table

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA, OmegaAutomaton

ROWS = 60
"""States listed on a terminal; a longer list is better read by a program."""


def as_data(dra: DRA | DFA | OmegaAutomaton) -> dict[str, Any]:
    """The summary as JSON values; states by number, transitions as [state, letter class]."""
    from ltlc.automata import DFA, OmegaAutomaton
    from ltlc.formats.hoa_general import acceptance_text

    if isinstance(dra, OmegaAutomaton):
        return {
            "formula": dra.formula,
            "form": dra.form,
            "deterministic": dra.is_deterministic,
            "aps": list(dra.aps),
            "n_states": dra.n_states,
            "n_classes": dra.n_classes,
            "n_sets": dra.n_sets,
            "acceptance": acceptance_text(dra),
            "initial_states": list(dra.initial_states),
        }
    if isinstance(dra, DFA):
        return {
            "formula": dra.formula,
            "words": "finite",
            "aps": list(dra.aps),
            "n_states": dra.n_states,
            "n_classes": dra.n_classes,
            "initial_state": dra.initial_state,
            "accepting": [q for q, accepts in enumerate(dra.accepting.tolist()) if accepts],
            "deadlocks": list(dra.deadlocks),
            "accepting_sinks": list(dra.accepting_sinks),
            "distance": dra.annotations.distance.tolist(),
        }
    notes = dra.annotations
    return {
        "formula": dra.formula,
        "class": _hierarchy_class(dra),
        "translator": dra.translator,
        "acceptance": dra.acceptance,
        "aps": list(dra.aps),
        "n_states": dra.n_states,
        "n_classes": dra.n_classes,
        "n_pairs": dra.n_pairs,
        "initial_state": dra.initial_state,
        "pairs": [{"B": sorted(map(_plain, pair.fin)), "G": sorted(map(_plain, pair.inf))} for pair in dra.pairs],
        "deadlocks": list(dra.deadlocks),
        "accepting_sinks": list(dra.accepting_sinks),
        "scc": list(notes.components),
        "distance": list(notes.distances),
    }


def _plain(entry: int | tuple[int, int]) -> Any:
    return list(entry) if isinstance(entry, tuple) else entry


def _hierarchy_class(dra: DRA | DFA) -> str | None:
    from ltlc.errors import LtlcError
    from ltlc.ltl import classify, parse

    try:
        return classify(parse(dra.formula)).value if dra.formula else None
    except LtlcError:  # the name of an automaton from elsewhere need not be a formula
        return None


def print_summary(dra: DRA | DFA | OmegaAutomaton) -> None:
    """Print the summary to standard output: what it is, then a row per state."""
    from ltlc.automata import OmegaAutomaton

    if isinstance(dra, OmegaAutomaton):
        from ltlc.formats.hoa_general import acceptance_text

        print(f"{dra.formula or 'an automaton without a formula'}: {dra.size}")
        print(f"accepted runs: {acceptance_text(dra)}, of the sets that are taken infinitely often; -f hoa shows all")
        return
    print_line(dra.formula or "an automaton without a formula", style="bold")
    print_table(_facts(dra))
    print_table(_states(dra))
    if dra.n_states > ROWS:
        print_line(f"... and {dra.n_states - ROWS} more states; --json lists them all")


def _facts(dra: DRA | DFA) -> Table:
    from ltlc.automata import DFA
    from ltlc.ltl import Proposition

    def listed(states: tuple[int, ...], meaning: str) -> str:
        return f"{' '.join(map(str, states))}  ({meaning})" if states else "none"

    is_finite = isinstance(dra, DFA)
    kind = "deterministic" if is_finite else "deterministic Rabin"
    facts = {
        "automaton": f"{kind}, {dra.size}",
        "propositions": " ".join(str(Proposition(name)) for name in dra.aps) or "none",
        "letters": f"{dra.alphabet.numbers.size}, of which it tells {dra.n_classes} apart",
        "class": "formula about finite traces" if is_finite else _hierarchy_class(dra) or "unknown",
        "translator": dra.translator or "unknown",
        "accepted runs": "end in a state with +0" if is_finite else _condition(dra.n_pairs),
        "deadlocks": listed(dra.deadlocks, "nothing is accepted any more"),
        "accepting sinks": listed(dra.accepting_sinks, "everything is accepted"),
    }
    return Table((Column(style="dim"), Column()), [Row(fact) for fact in facts.items()], ruled=False)


def _condition(n_pairs: int) -> str:
    if n_pairs == 0:
        return "none"
    which = "0" if n_pairs == 1 else "i"
    some = "" if n_pairs == 1 else ", for some i"
    return f"see +{which} infinitely often and −{which} only finitely often{some}"


def _states(dra: DRA | DFA) -> Table:
    """A row per state: what it is, how far from acceptance, and where each guard leads."""
    from ltlc.automata import Annotations
    from ltlc.formats.edges import edges, state_marks

    notes = dra.annotations

    def component(state: int) -> str:
        if isinstance(notes, Annotations):
            return f"{notes.components[state]} {notes.scc_kinds[notes.components[state]]}"
        return ""

    rows: list[list[str]] = [[] for _ in range(dra.n_states)]
    for edge in edges(dra):
        rows[edge.source].append(f"{edge.guard} → {edge.target}{_marks(edge.fin, edge.inf)}")
    shown = [
        Row(
            (
                f"{'→ ' if state == dra.initial_state else ''}{state}",
                _marks(*state_marks(dra, state)).strip(),
                component(state),
                str(notes.distances[state]) if notes.distances[state] >= 0 else "∞",
                "\n".join(leads),
            ),
            style="red" if state in dra.deadlocks else "green" if state in dra.accepting_sinks else "",
        )
        for state, leads in enumerate(rows[:ROWS])
    ]
    headings = ("state", "marks", "component", "distance", "letters and next state")
    return Table([Column(heading, right=heading in ("state", "distance")) for heading in headings], shown)


def _marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
    """The marks of the pairs as in the picture: + for Inf, − for Fin."""
    return "".join(f" {sign}{pair}" for sign, pairs in (("+", inf), ("−", fin)) for pair in pairs)
