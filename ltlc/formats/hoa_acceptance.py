"""From any acceptance condition over Fin and Inf to Rabin pairs, for deterministic automata.

The condition goes into disjunctive normal form. A term is one pair: its Fin sets are joined into one; several Inf sets
are visited in turn, which a counter in the state remembers (the degeneralisation of generalized Buchi automata).
Buchi, co-Buchi, parity, Streett, generalized Rabin and their Boolean combinations are all instances of this. Before,
sets that nothing carries are replaced by what is true of them, since the form grows with the number of sets.

References:
    E. A. Emerson, C.-L. Lei, Modalities for model checking: branching time logic strikes back, Science of Computer
    Programming 1987, doi 10.1016/0167-6423(87)90036-0 (conditions in this form).
    Y. Choueka, Theories of automata on omega-tapes: a simplified approach, JCSS 1974, doi
    10.1016/S0022-0000(74)80051-6 (the counter).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ltlc.automata.rabin import BoolArray, RabinAutomaton
from ltlc.budget import check_time
from ltlc.errors import StateLimitExceeded
from ltlc.ltl.formula import TRUE, And, Formula, Or, Proposition
from ltlc.ltl.traversal import postorder

_MANY = 64
"""A comparison with more than so many terms asks for the time."""

MAX_TERMS = 1024
"""Terms of the largest disjunctive normal form that is built."""

MAX_STATES = 100_000
"""States of the largest automaton with counters that is built."""

_MAX_MARKS = 1 << 24
"""Entries of its largest table, one for each state, letter class and pair."""


class Atom(NamedTuple):
    """Fin or Inf of an acceptance set or of its complement."""

    is_inf: bool
    complement: bool
    number: int

    @classmethod
    def of(cls, name: str) -> Atom:
        """The atom that a condition names like `Fin(!3)`."""
        # a number with more digits than any set can have is refused later, as out of range
        return cls(name.startswith("Inf"), name[4] == "!", int(name[4:-1].lstrip("!")[:12]))


Term = frozenset[Atom]
Terms = tuple[Term, ...]
"""A disjunction of conjunctions of atoms, in the order of the text; () is false."""

ALWAYS: Terms = (Term(),)
NEVER: Terms = ()


class TooManyTermsError(Exception):
    """The disjunctive normal form is too large."""


def atoms_of(condition: Formula) -> list[Atom]:
    """The atoms of a condition, without repetition."""
    return [Atom.of(node.name) for node in postorder(condition) if isinstance(node, Proposition)]


def terms_of(condition: Formula, used: Collection[int]) -> Terms:
    """The disjunctive normal form of a condition in an automaton where only these sets have members.

    Raises:
        TooManyTermsError: it has more than `MAX_TERMS` terms.
    """
    value: dict[Formula, Terms] = {}
    for node in postorder(condition):
        parts = [value[arg] for arg in node.args]
        if isinstance(node, Proposition):
            atom = Atom.of(node.name)
            if atom.number in used:
                value[node] = (Term((atom,)),)
            else:
                value[node] = NEVER if atom.is_inf != atom.complement else ALWAYS
        elif isinstance(node, And):
            value[node] = _all_of(parts)
        else:
            value[node] = _any_of(parts) if isinstance(node, Or) else ALWAYS if node is TRUE else NEVER
    return value[condition]


def _any_of(parts: Iterable[Terms]) -> Terms:
    """The disjunction, without terms that another one makes superfluous."""
    kept: list[Term] = []
    for term in (term for part in parts for term in part):
        if len(kept) > _MANY:
            check_time()
        if not any(other <= term for other in kept):
            kept = [other for other in kept if not term <= other]
            kept.append(term)
            if len(kept) > MAX_TERMS:
                raise TooManyTermsError
    return tuple(kept)


def _all_of(parts: Iterable[Terms]) -> Terms:
    """The conjunction, distributed over the disjunctions."""
    result = ALWAYS
    for part in parts:
        joined = (first | second for first in result for second in part)
        result = _any_of([tuple(term for term in joined if not _contradictory(term))])
    return result


def _contradictory(term: Term) -> bool:
    return any(atom.is_inf and atom._replace(is_inf=False) in term for atom in term)


def with_rabin_pairs(
    skeleton: RabinAutomaton, terms: Terms, members: Callable[[Atom], BoolArray], everything: BoolArray
) -> RabinAutomaton:
    """The automaton with Rabin pairs for a condition, and with counters in its states where a term needs one.

    Args:
        skeleton: the automaton without pairs.
        terms: the condition in disjunctive normal form.
        members: the marks of an atom's set, in the shape of one pair's marks.
        everything: the marks of a term without Inf; false only where no accepted run passes for ever.

    Raises:
        StateLimitExceeded: the counters need more than `MAX_STATES` states, or tables too large for memory.
    """
    fin = np.zeros((len(terms), *everything.shape), dtype=np.bool_)
    rounds: list[list[BoolArray]] = []
    for i, term in enumerate(terms):
        check_time()
        for atom in term:
            if not atom.is_inf:
                fin[i] |= members(atom)
        rounds.append(_strongest([members(atom) for atom in sorted(term) if atom.is_inf]) or [everything])
    if all(len(sets) == 1 for sets in rounds):
        inf = np.array([sets[0] for sets in rounds], dtype=np.bool_).reshape(fin.shape)
        return replace(skeleton, fin=fin, inf=inf)
    return _with_counters(skeleton, fin, rounds)


def _strongest(sets: Sequence[BoolArray]) -> list[BoolArray]:
    """The sets without those that contain another one: seeing the smaller again and again is enough."""
    kept: list[BoolArray] = []
    for marks in sets:
        if not any((other <= marks).all() for other in kept):
            kept = [other for other in kept if not (marks <= other).all()]
            kept.append(marks)
    return kept


def _with_counters(skeleton: RabinAutomaton, fin: BoolArray, rounds: Sequence[Sequence[BoolArray]]) -> RabinAutomaton:
    """The reachable product with one counter per pair: which of its Inf sets it waits for.

    A counter moves on while the marks at hand are those it waits for; the pair's inf is where it completes a round.
    Where marks are on states, completing a round depends on the state and the counter alone, and stays on states.
    """
    n_classes, on_states = skeleton.n_classes, skeleton.acceptance == "state"
    most = min(MAX_STATES, _MAX_MARKS // (n_classes * len(rounds)))
    start = (skeleton.initial_state, (0,) * len(rounds))
    index = {start: 0}
    queue = [start]
    delta: list[list[int]] = []
    completed: list[list[tuple[bool, ...]]] = []
    for q, counters in queue:
        check_time()
        row: list[int] = []
        done_row: list[tuple[bool, ...]] = []
        for c in range(n_classes):
            place = (q,) if on_states else (q, c)
            moved = [_advance(sets, k, place) for sets, k in zip(rounds, counters, strict=True)]
            successor = (int(skeleton.delta[q, c]), tuple(k for k, _ in moved))
            if successor not in index:
                if len(index) >= most:
                    raise StateLimitExceeded(
                        f"turning the acceptance condition into Rabin pairs needs more than {most} states"
                    )
                index[successor] = len(queue)
                queue.append(successor)
            row.append(index[successor])
            done_row.append(tuple(done for _, done in moved))
        delta.append(row)
        completed.append(done_row)
    inf = np.moveaxis(np.array(completed, dtype=np.bool_), 2, 0)
    origin = [q for q, _ in queue]
    return replace(
        skeleton,
        delta=np.array(delta, dtype=np.int32),
        fin=fin[:, origin],
        inf=inf[:, :, 0] if on_states else inf,
        initial_state=0,
        state_names=None,
    )


def _advance(sets: Sequence[BoolArray], counter: int, place: tuple[int, ...]) -> tuple[int, bool]:
    while counter < len(sets) and sets[counter][place]:
        counter += 1
    return (0, True) if counter == len(sets) else (counter, False)
