"""Writing automata with any acceptance condition in the Hanoi Omega-Automata format, version 1."""

from __future__ import annotations

from ltlc.automata.acceptance import Acceptance, Clause, negation
from ltlc.automata.omega import OmegaAutomaton
from ltlc.budget import check_time
from ltlc.graph import bits

_LIMIT = 1000
"""A condition of more clauses than this is not turned round to see which way is shorter."""


def body_of(automaton: OmegaAutomaton) -> list[str]:
    """The lines between --BODY-- and --END--."""
    numbers = [str(i) for i in range(len(automaton.aps))]
    labels: dict[int, str] = {}
    lines = []
    for state, row in enumerate(automaton.edges):
        lines.append(f"State: {state}")
        for edge in row:
            check_time()
            if edge.letters not in labels:
                label = automaton.alphabet.guard(bits(edge.letters)).text(numbers, "t", "f")
                labels[edge.letters] = label if automaton.possible is None else f"@possible & ({label})"
            sets = f" {{{' '.join(map(str, bits(edge.marks)))}}}" if edge.marks else ""
            lines.append(f"[{labels[edge.letters]}] {edge.target}{sets}")
    return lines


def acceptance_of(automaton: OmegaAutomaton) -> list[str]:
    """The header Acceptance:, and acc-name: where the condition has one."""
    name = _name(automaton.condition, automaton.n_sets)
    return [*([f"acc-name: {name}"] if name else []), f"Acceptance: {automaton.n_sets} {acceptance_text(automaton)}"]


def acceptance_text(automaton: OmegaAutomaton) -> str:
    """The acceptance condition as HOA writes it."""
    condition = automaton.condition
    name = _name(condition, automaton.n_sets)
    return _streett(condition[0]) if name and name.startswith("Streett") else _shorter(condition)


def _name(condition: Acceptance, n: int) -> str | None:
    if len(condition) == 1 and not condition[0].promises and condition[0] == Clause(0, (1 << n) - 1):
        return {0: "all", 1: "Buchi"}.get(n, f"generalized-Buchi {n}")
    if not condition:
        return "none" if n == 0 else None
    if condition[0].promises and condition[0].promises == tuple((1 << 2 * i, 2 << 2 * i) for i in range(n // 2)):
        return f"Streett {n // 2}" if condition[0][:2] == (0, 0) else None
    place, widths = 0, []
    for clause in condition:
        width = clause.inf.bit_count()
        if clause.promises or clause != Clause(1 << place, ((1 << width) - 1) << place + 1):
            return None
        widths.append(width)
        place += width + 1
    return f"generalized-Rabin {len(widths)} {' '.join(map(str, widths))}" if place == n else None


def _streett(clause: Clause) -> str:
    parts = [f"(Fin({2 * i}) | Inf({2 * i + 1}))" for i in range(len(clause.promises))]
    return " & ".join(parts) or "t"


def _shorter(condition: Acceptance) -> str:
    """As a disjunction of conjunctions, or the other way round."""
    direct = _text(condition, "Fin", "Inf", " & ", " | ", "f", "t")
    if len(condition) < 2 or len(condition) > _LIMIT:
        return direct
    turned = negation(condition)
    if len(turned) > _LIMIT:
        return direct
    other = _text(turned, "Inf", "Fin", " | ", " & ", "t", "f")
    return other if len(other) < len(direct) else direct


def _text(condition: Acceptance, fin: str, inf: str, inner: str, outer: str, none: str, every: str) -> str:
    terms = []
    for clause in condition:
        atoms = [f"{fin}({i})" for i in bits(clause.fin)] + [f"{inf}({i})" for i in bits(clause.inf)]
        for mark, partners in clause.promises:  # in conditions of one clause only
            atoms.append(f"(Fin({bits(mark)[0]}) | {' | '.join(f'Inf({i})' for i in bits(partners))})")
        terms.append(inner.join(atoms) or every)
    if len(terms) == 1:
        return terms[0]
    return outer.join(f"({term})" for term in terms) or none
