"""What a deterministic automaton has to remember for the operators of the past, and its product with the rest.

Whether a subformula of the past holds follows from the letter and one bit for each operator of the past: the value of
the operand (Y Z) or of the operator itself (O H S T) at the position before. The formula around it is translated with
a proposition for each such subformula, over an alphabet of its own: the letters together with what the past can say
then, and no others. The product of that automaton with the memory reads the letters of the formula.

References:
    K. Havelund, G. Rosu: Synthesizing Monitors for Safety Properties. TACAS 2002, doi 10.1007/3-540-46002-0_24.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, reduce
from typing import NamedTuple

from ltlc.arrays import np
from ltlc.automata.emerson_lei import EmersonLei, explore
from ltlc.budget import Budget, check_time
from ltlc.ltl import (
    And,
    Formula,
    Historically,
    Not,
    Once,
    Or,
    Since,
    Triggered,
    WeakYesterday,
    Yesterday,
    postorder,
)
from ltlc.ltl.past import PAST
from ltlc.ltl.recall import without_past
from ltlc.translate.letters import Letters

_HOLDS_AT_FIRST = (WeakYesterday, Historically, Triggered)
"""The operators whose bit is set before the first letter."""


class Move(NamedTuple):
    """What a set of letters does to a memory."""

    letters: int
    said: int
    """bit i: what proposition i stands for holds."""
    memory: int
    """the memory that follows."""


class Memory:
    """The past of a formula, as far as it matters.

    Args:
        formula: simplified, in negation normal form, with operators of the past.
        letters: `letters_of` the formula.
        budget: for the number of memories.

    Attributes:
        future: the formula with propositions for subformulas of the past.
        letters: the letters of `future` that can occur, in classes that it tells apart.

    Raises:
        StateLimitExceeded, TimeLimitExceeded: there are too many memories.
    """

    def __init__(self, formula: Formula, letters: Letters, budget: Budget) -> None:
        recalled = without_past(formula)
        self.future = recalled.future
        self._real = letters
        self._said = recalled.meaning
        parts = dict.fromkeys(part for meaning in recalled.meaning.values() for part in postorder(meaning))
        needed = set(recalled.meaning.values())
        for part in reversed(parts):
            if part in needed and part not in letters.sets:
                needed.update(part.args)
        self._parts = [part for part in parts if part in needed]
        self._operators = [part for part in self._parts if isinstance(part, PAST)]
        self._moves: list[list[Move]] = []
        self._explore(budget)
        self._extend()

    def _explore(self, budget: Budget) -> None:
        first = sum(1 << i for i, part in enumerate(self._operators) if isinstance(part, _HOLDS_AT_FIRST))
        moves: dict[int, list[Move]] = {}

        def successors(memory: int) -> Iterator[tuple[int, int, int]]:
            moves[memory] = self._moves_from(memory)
            for move in moves[memory]:
                yield move.letters, move.memory, 0

        memories, _ = explore(first, successors, budget)
        number = {memory: i for i, memory in enumerate(memories)}
        self._moves = [[m._replace(memory=number[m.memory]) for m in moves[memory]] for memory in memories]

    def _moves_from(self, memory: int) -> list[Move]:
        everything = self._real.all
        holds: dict[Formula, int] = {}
        for part in self._parts:
            if part in self._real.sets:
                holds[part] = self._real.sets[part]
            elif isinstance(part, PAST):
                recalled = everything if memory >> self._operators.index(part) & 1 else 0
                holds[part] = _value(part, [holds[arg] for arg in part.args], recalled)
            else:
                operation = int.__and__ if isinstance(part, And) else int.__or__
                holds[part] = reduce(operation, [holds[arg] for arg in part.args])
        following = [holds[p.args[0] if isinstance(p, Yesterday | WeakYesterday) else p] for p in self._operators]
        said = [holds[meaning] for meaning in self._said.values()]
        n = len(following)
        return [
            Move(letters, key >> n, key & (1 << n) - 1) for letters, key in _told_apart(everything, following + said)
        ]

    def _extend(self) -> None:
        """The letters of the future: what it tells apart among a real letter and what is said, as far as both occur."""
        signs = {sign: i for i, sign in enumerate(self._said)}
        parts = list(postorder(self.future))
        boolean: set[Formula] = set()
        maximal: dict[Formula, None] = {}
        for f in parts:
            if f in signs or f in self._real.sets or (isinstance(f, Not | And | Or) and boolean.issuperset(f.args)):
                boolean.add(f)
                maximal[f] = None
                for arg in f.args:
                    maximal.pop(arg, None)
        for f in parts:
            if f not in boolean:
                maximal.update((arg, None) for arg in f.args if arg in boolean)

        @cache
        def holding(said: int) -> list[int]:
            """The real letters with which each maximal Boolean part holds."""
            check_time()
            holds: dict[Formula, int] = {}
            for f in parts:
                if f in signs:
                    holds[f] = self._real.all if said >> signs[f] & 1 else 0
                elif f in self._real.sets:
                    holds[f] = self._real.sets[f]
                elif f in boolean:
                    values = [holds[arg] for arg in f.args]
                    operation = int.__and__ if isinstance(f, And) else int.__or__
                    holds[f] = self._real.all & ~values[0] if isinstance(f, Not) else reduce(operation, values)
            return [holds[f] for f in maximal]

        number: dict[int, int] = {}
        self._ways: list[dict[tuple[int, int], int]] = []
        for moves in self._moves:
            ways: dict[tuple[int, int], int] = {}
            for move in moves:
                for letters, key in _told_apart(move.letters, holding(move.said)):
                    way = (number.setdefault(key, len(number)), move.memory)
                    ways[way] = ways.get(way, 0) | letters
            self._ways.append(ways)
        sets = {f: sum(1 << k for key, k in number.items() if key >> i & 1) for i, f in enumerate(maximal)}
        self.letters = Letters(self._real.aps, np.arange(len(number), dtype=np.int32), len(number), sets)

    def product(self, automaton: EmersonLei, budget: Budget) -> EmersonLei:
        """The automaton of the whole formula, from one of `future` over `letters`."""

        def successors(state: tuple[int, int]) -> Iterator[tuple[int, tuple[int, int], int]]:
            place, memory = state
            for edge in automaton.edges[place]:
                following: dict[int, int] = {}
                for (extended, after), letter in self._ways[memory].items():
                    if edge.letters >> extended & 1:
                        following[after] = following.get(after, 0) | letter
                for after, letters in following.items():
                    yield letters, (edge.target, after), edge.marks

        states, edges = explore((0, 0), successors, budget)
        return EmersonLei(tuple(map(tuple, edges)), tuple(automaton.acceptance[place] for place, _ in states))


def _told_apart(letters: int, values: list[int]) -> list[tuple[int, int]]:
    """The letters in blocks on which each of the letter sets holds or does not; bit i of a key: the i-th holds."""
    blocks = [(letters, 0)]
    for i, value in enumerate(values):
        check_time()
        blocks = [
            (part, key | inside << i)
            for block, key in blocks
            for part, inside in ((block & value, 1), (block & ~value, 0))
            if part
        ]
    return blocks


def _value(operator: Formula, operands: list[int], recalled: int) -> int:
    """The letters with which an operator of the past holds, given those of its operands and what is recalled."""
    if isinstance(operator, Yesterday | WeakYesterday):
        return recalled
    if isinstance(operator, Once):
        return operands[0] | recalled
    if isinstance(operator, Historically):
        return operands[0] & recalled
    left, right = operands
    return right | (left & recalled) if isinstance(operator, Since) else right & (left | recalled)
