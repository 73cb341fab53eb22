"""How small a deterministic Rabin automaton for a language can be at best."""

from __future__ import annotations

from ltlc.automata.languages import can_decide_languages
from ltlc.automata.rabin import DRA, AcceptanceKind
from ltlc.automata.rabin_type import Conflict, CycleGraph, rabin_condition
from ltlc.minimize.residuals import Part, residuals
from ltlc.minimize.safe_classes import least_by_safe_edges

_READABLE = 200_000
"""No bound is looked for where there are more edges than this."""
_MAX_NODES = 200
"""bound on the sets of labels looked at per part; beyond it the bound is weaker."""


def lower_bound(automaton: DRA, acceptance: AcceptanceKind | None = None) -> int:
    """A number of states that no equivalent automaton goes below.

    The sum over the strong components of the residual automaton of `part_lower_bound`, and 1 for each residual that is
    visited once at most. Any number of Rabin pairs is allowed to the others.

    Args:
        automaton: any Rabin automaton.
        acceptance: of the other automata; by default that of this one.
    """
    kind = acceptance or automaton.acceptance
    found = residuals(automaton)
    if found.n_residuals == found.automaton.n_states and kind == automaton.acceptance:
        return found.n_residuals
    return found.n_residuals + sum(part_lower_bound(p, kind) - len(p.residuals) for p in found.parts)


def proven_least(automaton: DRA, acceptance: AcceptanceKind | None = None) -> int:
    """`lower_bound`, or 1 for a large automaton, which is not looked into."""
    return lower_bound(automaton, acceptance) if automaton.n_states > 1 and is_readable(automaton) else 1


def is_readable(automaton: DRA) -> bool:
    """Whether a bound is worth looking for."""
    return automaton.n_states * automaton.n_classes <= _READABLE and can_decide_languages(automaton)


def part_lower_bound(part: Part, acceptance: AcceptanceKind) -> int:
    """The number of states that a component of any automaton needs to cover a component of the residual automaton.

    One for each residual; one more if the component of the residual automaton cannot carry a Rabin condition. More if
    some residual needs several copies: let there be a set of labels whose cycles are all accepted, and in it rejected
    cycles through one residual, no two of them in a larger rejected one. The states that the first takes for ever and
    those that the second takes have nothing in common, or both together would be rejected too. And what
    `least_by_safe_edges` says.

    References:
        A. Casares: On the Minimisation of Transition-Based Rabin Automata and the Chromatic Memory Requirements of
        Muller Conditions. CSL 2022, doi 10.4230/LIPIcs.CSL.2022.12 (for a single residual).
        S. Dziembowski, M. Jurdzinski, I. Walukiewicz: How much memory is needed to win infinite games? LICS 1997,
        doi 10.1109/LICS.1997.614939 (the recursion over the decomposition).
    """
    n_residuals = len(part.residuals)
    if len(part.states) == n_residuals and part.acceptance == acceptance:
        return n_residuals
    least = least_by_safe_edges(part)
    if (least == len(part.states) and part.acceptance == acceptance) or part.has_many_moves:
        return max(n_residuals, least)
    cycles = part.cycle_graph(part.step, range(n_residuals), acceptance == "state")
    if not isinstance(rabin_condition(cycles, max_nodes=cycles.affordable(_MAX_NODES)), Conflict):
        return max(n_residuals, least)
    copies = _Copies(cycles).needed(cycles.labels())
    return max(n_residuals + 1, sum(copies.values()), least)


class _Copies:
    """How many copies of each residual are needed."""

    def __init__(self, cycles: CycleGraph) -> None:
        self.cycles = cycles
        self._max_nodes = cycles.affordable(_MAX_NODES)
        self.known: dict[int, dict[int, int]] = {}

    def needed(self, labels: int) -> dict[int, int]:
        """Copies of each residual that lies on cycles with exactly these labels, on the runs with these labels."""
        if labels in self.known:
            return self.known[labels]
        copies = self.known[labels] = dict.fromkeys(self.cycles.places(labels), 1)
        if len(self.known) > self._max_nodes:
            return copies
        accepted, rejected = self.cycles.accepted_parts(labels), self.cycles.rejected_parts(labels)
        if labels not in rejected:
            apart = dict.fromkeys(copies, 0)
            for part in rejected:
                undecided = part in self.cycles.accepted_parts(part)
                for q, count in self.needed(part).items():
                    apart[q] += 1 if undecided else count
            _raise(copies, apart)
        for part in [*accepted, *rejected]:
            if part != labels:
                _raise(copies, self.needed(part))
        return copies


def _raise(copies: dict[int, int], bounds: dict[int, int]) -> None:
    for q, bound in bounds.items():
        copies[q] = max(copies[q], bound)
