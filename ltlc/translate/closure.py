"""One formula compiled to integers: its letters, its subformulas, and what each becomes after one letter.

Three representations carry every construction of this package:

* a **letter set** is a Python integer, bit c = letter class c. Intersection, union and complement are single
  operations, for four propositions as for twenty.
* an **obligation** is a positive Boolean combination of *atoms* (letter sets and temporal subformulas) in disjunctive
  normal form: a sorted tuple of clauses, each an integer with one bit per atom. Clauses are reduced by syntactic
  implication, so that equal tuples mean propositionally equivalent formulas, and many more are recognised as equal.
* a **derivative** is the deterministic successor relation: a dictionary obligation -> letter set that partitions the
  letters ("after" function, Brzozowski-style).

References:
    J. Esparza, J. Kretinsky, S. Sickert: One Theorem to Rule Them All: A Unified Translation of LTL into
    omega-Automata. LICS 2018, doi 10.1145/3209108.3209161 (the "after" function).
    F. Somenzi, R. Bloem: Efficient Buchi Automata from LTL Formulae. CAV 2000, doi 10.1007/10722167_21 (syntactic
    implication).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ltlc.automata.rabin import MAX_APS
from ltlc.errors import AlphabetLimitExceeded
from ltlc.ltl import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    postorder,
)
from ltlc.translate.bitset import bits
from ltlc.translate.budget import Budget

Obligation = tuple[int, ...]
Derivative = dict[Obligation, int]

TRUE: Obligation = (0,)
FALSE: Obligation = ()

_KIND: dict[type[Formula], str] = {
    And: "&",
    Or: "|",
    Next: "X",
    Eventually: "F",
    Always: "G",
    Until: "U",
    Release: "R",
    WeakUntil: "W",
    StrongRelease: "M",
}
_DUAL = {"&": "|", "|": "&", "X": "X", "F": "G", "G": "F", "U": "R", "R": "U", "W": "M", "M": "W"}
_LEVELS = (("sigma1", 1), ("pi1", 2), ("sigma2", 4), ("pi2", 8))
_COLUMNS_AT_ONCE = 40
"""truth values that fit, with the up to 2**20 classes before them, into 64 bits."""
_BOOLEAN = (Constant, Proposition, Not, And, Or)


class Node(NamedTuple):
    """A subformula: `kind` is "letters" or the operator's symbol, `args` are node numbers."""

    kind: str
    args: tuple[int, ...]
    letters: int


class Letters(NamedTuple):
    """The letters of 2^aps, grouped into the classes that a formula tells apart."""

    aps: tuple[str, ...]
    letter_class: npt.NDArray[np.int32]
    n_classes: int
    sets: Mapping[Formula, int]
    """the letter set of each Boolean subformula that no larger one contains."""

    @property
    def all(self) -> int:
        """The letter set of every letter."""
        return (1 << self.n_classes) - 1


class Closure:
    """The subformulas of a formula in negation normal form, and the derivative of each.

    Args:
        formula: in negation normal form, over `&`, `|` and the temporal operators.
        letters: `letters_of` the formula.
        budget: checked while obligations grow.
    """

    def __init__(self, formula: Formula, letters: Letters, budget: Budget) -> None:
        self.budget = budget
        self.letters = letters
        self.nodes: list[Node] = []
        self._number: dict[Node, int] = {}
        self._implies: dict[tuple[int, int], bool] = {}
        self._derivative: dict[int, Derivative] = {}
        self._after: dict[Obligation, Derivative] = {}
        self._combined: dict[tuple[bool, Obligation, Obligation], Obligation] = {}
        self._obligation: dict[int, Obligation] = {}
        self._level: dict[int, int] = {}
        self._up: list[int] = []
        self._against: list[int] = []
        self._atoms = 0
        self._registered: set[int] = set()
        self.root = self._compile(formula)

    # -- construction -------------------------------------------------------------------------------------------------

    def _compile(self, formula: Formula) -> int:
        boolean = self.letters.sets
        number: dict[Formula, int] = {}
        for f in postorder(formula):
            if f in boolean:
                number[f] = self.node("letters", letters=boolean[f])
            elif type(f) in _KIND and all(arg in number for arg in f.args):
                number[f] = self.node(_KIND[type(f)], *(number[arg] for arg in f.args))
        return number[formula]

    def node(self, kind: str, *args: int, letters: int = 0) -> int:
        """The number of a node, made on first use."""
        if kind in "&|":
            args = tuple(sorted(set(args)))
            if len(args) == 1:
                return args[0]
        node = Node(kind, args, letters)
        if node not in self._number:
            self._number[node] = len(self.nodes)
            self.nodes.append(node)
        return self._number[node]

    def constant(self, value: bool) -> int:
        """The node of true or false."""
        return self.node("letters", letters=self.letters.all if value else 0)

    def make(self, kind: str, *args: int) -> int:
        """Like `node`, with constants and repeated operators folded."""
        true, false = self.constant(True), self.constant(False)
        if kind in "&|":
            unit, zero = (true, false) if kind == "&" else (false, true)
            flat = [b for a in args for b in (self.nodes[a].args if self.nodes[a].kind == kind else (a,))]
            flat = [a for a in flat if a != unit]
            if zero in flat:
                return zero
            kept: list[int] = []
            for a in flat:
                if not any(self._absorbs(kind, b, a) for b in kept):
                    kept = [*(b for b in kept if not self._absorbs(kind, a, b)), a]
            return self.node(kind, *kept) if kept else unit
        last = args[-1]
        if kind in "XFG":
            idempotent = kind != "X" and self.nodes[last].kind == kind
            return last if idempotent or last in (true, false) else self.node(kind, last)
        left, right = args
        if {left, right} & {true, false}:
            return self._folded(kind, left, right, true, false)
        return self.node(kind, left, right)

    def _absorbs(self, kind: str, other: int, node: int) -> bool:
        """Whether `node` adds nothing beside `other` in a conjunction or disjunction."""
        return self.implies(other, node) if kind == "&" else self.implies(node, other)

    def _folded(self, kind: str, left: int, right: int, true: int, false: int) -> int:
        """A binary temporal operator with a constant operand."""
        if kind in "UW":
            if right == true or left == false:
                return right
            if right == false:
                return false if kind == "U" else self.make("G", left)
            return self.make("F", right) if kind == "U" else true  # left is true
        if right == false or left == true:
            return right
        if right == true:
            return self.make("F", left) if kind == "M" else true
        return self.make("G", right) if kind == "R" else false  # left is false

    def is_plain(self, node: int) -> bool:
        """Whether the node has no F, G, U, R, W or M."""
        return self._levels(node) == 15

    def negation(self, node: int) -> int:
        """The node of the negated subformula, again in negation normal form."""
        kind, args, letters = self.nodes[node]
        if kind == "letters":
            return self.node(kind, letters=self.letters.all & ~letters)
        return self.node(_DUAL[kind], *map(self.negation, args))

    def finite_part(self, node: int) -> int:
        """The node with every greatest fixpoint (G, R, W) that is not co-safety taken as satisfied."""
        kind, args, _ = self.nodes[node]
        if self._levels(node) & 1:
            return node
        if kind in "GRW":
            return self.node("letters", letters=self.letters.all)
        return self.node(kind, *map(self.finite_part, args))

    def level(self, node: int) -> str:
        """The lowest class of the syntactic hierarchy: "sigma1", "pi1", "sigma2", "pi2", or "" above these.

        References:
            I. Cerna, R. Pelanek: Relating Hierarchy of Temporal Properties to Model Checking. MFCS 2003,
            doi 10.1007/978-3-540-45138-9_26.
        """
        return next((name for name, bit in _LEVELS if self._levels(node) & bit), "")

    def is_obligation(self, node: int) -> bool:
        """Whether the node is a Boolean combination of safety and co-safety subformulas, in shape."""
        return self._is_combination(node, lambda part: self.level(part) in ("sigma1", "pi1"))

    def is_fair_obligation(self, node: int) -> bool:
        """Whether it is one of these and of G F a, F G a with a Boolean: fairness conditions."""
        return self._is_combination(node, lambda part: self.level(part) in ("sigma1", "pi1") or self._is_fairness(part))

    def is_low(self, node: int) -> bool:
        """Whether the node is a Boolean combination of sigma2 and pi2 subformulas, in shape."""
        return self._is_combination(node, lambda part: bool(self.level(part)))

    def _is_combination(self, node: int, holds: Callable[[int], bool]) -> bool:
        kind, args, _ = self.nodes[node]
        return holds(node) or (kind in "&|" and all(self._is_combination(arg, holds) for arg in args))

    def _is_fairness(self, node: int) -> bool:
        kind, args, _ = self.nodes[node]
        if kind not in "GF" or self.nodes[args[0]].kind != _DUAL[kind]:
            return False
        return self.nodes[self.nodes[args[0]].args[0]].kind == "letters"

    def _levels(self, node: int) -> int:
        known = self._level.get(node)
        if known is None:
            kind, args, _ = self.nodes[node]
            known = 15 if kind == "letters" else reduce(int.__and__, map(self._levels, args))
            if kind in "FUM":  # closed in sigma; a sigma1 formula is also in pi2
                known = 13 if known & 1 else known & 4
            elif kind in "GRW":
                known = 14 if known & 2 else known & 8
            self._level[node] = known
        return known

    def register(self, node: int) -> None:
        """Make known every atom that an obligation to satisfy the node can lead to.

        Clauses are reduced by what is implied among known atoms, so all of them have to be known before the first
        obligation is built: then equal obligations stay equal.
        """
        if node not in self._registered:
            self._registered.add(node)
            kind, args, _ = self.nodes[node]
            if kind not in "&|":
                self._register_atom(node)
            for arg in args:
                self.register(arg)

    def register_finite_parts(self, node: int) -> None:
        """`register` the finite part of every subformula."""
        self.register(self.finite_part(node))
        for arg in self.nodes[node].args:
            self.register_finite_parts(arg)

    def _register_atom(self, node: int) -> None:
        while len(self._up) < len(self.nodes):
            self._up.append(0)
            self._against.append(0)
        others = bits(self._atoms)
        self._atoms |= 1 << node
        up = above = 1 << node
        for other in others:
            if self.implies(node, other):
                up |= self._up[other]
            if self.implies(other, node):
                above |= 1 << other
            a, b = self.nodes[node], self.nodes[other]
            if a.kind == b.kind == "letters" and not a.letters & b.letters:
                self._against[node] |= 1 << other
                self._against[other] |= 1 << node
        self._up[node] = up
        for other in others:  # kept transitively closed
            if self._up[other] & above:
                self._up[other] |= up

    # -- obligations --------------------------------------------------------------------------------------------------

    def obligation(self, node: int) -> Obligation:
        """The obligation to satisfy a node."""
        known = self._obligation.get(node)
        if known is None:
            kind, args, letters = self.nodes[node]
            if kind == "letters" and letters in (0, self.letters.all):
                known = TRUE if letters else FALSE
            elif kind == "&":
                known = reduce(self.both, map(self.obligation, args))
            elif kind == "|":
                known = reduce(self.either, map(self.obligation, args))
            else:
                self.register(node)
                known = (1 << node,)
            self._obligation[node] = known
        return known

    def both(self, f: Obligation, g: Obligation) -> Obligation:
        """Conjunction."""
        if f in (g, FALSE) or g == TRUE:
            return f
        if f == TRUE or g == FALSE:
            return g
        key = (True, f, g) if f < g else (True, g, f)
        known = self._combined.get(key)
        if known is None:
            clauses = {c for a in f for b in g if (c := self._clause(a | b)) is not None}
            known = self._combined[key] = self._antichain(clauses)
        return known

    def either(self, f: Obligation, g: Obligation) -> Obligation:
        """Disjunction."""
        if f in (g, TRUE) or g == FALSE:
            return f
        if f == FALSE or g == TRUE:
            return g
        key = (False, f, g) if f < g else (False, g, f)
        known = self._combined.get(key)
        if known is None:
            known = self._combined[key] = self._antichain({*f, *g})
        return known

    def _clause(self, clause: int) -> int | None:
        """The clause without atoms that others of it imply, or None if it contradicts itself."""
        kept = clause
        for atom in bits(clause):
            if self._against[atom] & clause:
                return None
            if kept >> atom & 1:
                kept &= ~(self._up[atom] & ~(1 << atom))
        return kept

    def _antichain(self, clauses: set[int]) -> Obligation:
        self.budget.check_size(len(clauses))
        if len(clauses) == 1:
            return tuple(clauses)
        up = {c: self.closed(c) for c in clauses}
        kept: list[int] = []
        for c in sorted(clauses, key=lambda c: (c.bit_count(), c)):
            closed = up[c]
            if not any(d & ~closed == 0 for d in kept):
                kept = [d for d in kept if c & ~up[d]]
                kept.append(c)
        return tuple(sorted(kept))

    def closed(self, clause: int) -> int:
        """The clause with every atom that its atoms imply."""
        closed = 0
        for atom in bits(clause):
            closed |= self._up[atom]
        return closed

    # -- derivatives --------------------------------------------------------------------------------------------------

    def after(self, f: Obligation) -> Derivative:
        """What remains to be satisfied after one letter: a partition of the letters."""
        known = self._after.get(f)
        if known is None:
            self.budget.check_time()
            known = {FALSE: self.letters.all}
            for clause in f:
                both: Derivative = {TRUE: self.letters.all}
                for atom in bits(clause):
                    both = self._merge(True, both, self.derivative(atom))
                known = self._merge(False, known, both)
            self._after[f] = known
        return known

    def derivative(self, node: int) -> Derivative:
        """`after` for a node."""
        known = self._derivative.get(node)
        if known is None:
            known = self._derivative[node] = self._derive(node)
        return known

    def _derive(self, node: int) -> Derivative:
        kind, args, letters = self.nodes[node]
        everything = self.letters.all
        if kind == "letters":
            parts = {TRUE: letters, FALSE: everything & ~letters}
            return {f: part for f, part in parts.items() if part}
        if kind == "X":
            return {self.obligation(args[0]): everything}
        if kind in "&|":
            return reduce(lambda f, g: self._merge(kind == "&", f, g), map(self.derivative, args))
        again: Derivative = {self.obligation(node): everything}
        if kind == "F":
            return self._merge(False, self.derivative(args[0]), again)
        if kind == "G":
            return self._merge(True, self.derivative(args[0]), again)
        left, right = map(self.derivative, args)
        stays = kind in "UW"  # f U g = g | (f & X(f U g)); f R g = g & (f | X(f R g))
        return self._merge(not stays, right, self._merge(stays, left, again))

    def _merge(self, conjunction: bool, f: Derivative, g: Derivative) -> Derivative:
        combine = self.both if conjunction else self.either
        merged: Derivative = {}
        for a, letters_a in f.items():
            for b, letters_b in g.items():
                common = letters_a & letters_b
                if common:
                    c = combine(a, b)
                    merged[c] = merged.get(c, 0) | common
        self.budget.check_moves(len(merged))
        return merged

    # -- syntactic implication ----------------------------------------------------------------------------------------

    def implies(self, f: int, g: int) -> bool:
        """Whether node f implies node g by the shape of both alone: sound, not complete."""
        if f == g:
            return True
        key = (f, g)
        known = self._implies.get(key)
        if known is None:
            self._implies[key] = False  # no rule needs itself
            known = self._implies[key] = self._implies_by_shape(f, g)
        return known

    def _implies_by_shape(self, f: int, g: int) -> bool:
        fk, fa, fl = self.nodes[f]
        gk, ga, gl = self.nodes[g]
        imp = self.implies
        if fk == "letters" and gk == "letters":
            return fl & ~gl == 0
        if fk == "|":
            return all(imp(a, g) for a in fa)
        if gk == "&":
            return all(imp(f, b) for b in ga)
        if fk == "&" and any(imp(a, g) for a in fa):
            return True
        if gk == "|" and any(imp(f, b) for b in ga):
            return True
        return self._weaken_left(f, g) or self._strengthen_right(f, g)

    def _weaken_left(self, f: int, g: int) -> bool:
        """Replace f by something it implies at once."""
        kind, args, _ = self.nodes[f]
        imp = self.implies
        gk, ga, _ = self.nodes[g]
        if kind == "G":
            return imp(args[0], g) or (gk in "GX" and imp(f, ga[0])) or (gk in "RW" and imp(f, ga[gk == "R"]))
        if kind in "UW" and imp(args[0], g) and imp(args[1], g):
            return True
        if kind in "RM" and imp(args[1], g):
            return True
        if gk == "F":  # F is monotone and absorbs delays
            if kind in "FX":
                return imp(args[0], g)
            return (kind == "U" and imp(args[1], g)) or (kind == "M" and imp(args[0], g))
        return gk == kind == "X" and imp(args[0], ga[0])

    def _strengthen_right(self, f: int, g: int) -> bool:
        """Replace g by something that implies it."""
        kind, args, _ = self.nodes[f]
        gk, ga, _ = self.nodes[g]
        imp = self.implies
        if gk == "F":
            return imp(f, ga[0])
        if gk in "UW":
            if imp(f, ga[1]):
                return True
            same = kind == "U" or (kind == gk == "W")
            return same and imp(args[0], ga[0]) and imp(args[1], g)
        if gk in "RM":
            if imp(f, ga[0]) and imp(f, ga[1]):
                return True
            same = kind == "M" or (kind == gk == "R")
            return same and imp(args[0], ga[0]) and imp(args[1], ga[1])
        return False


def letters_of(formula: Formula, aps: tuple[str, ...]) -> Letters:
    """Group the letters by the maximal Boolean subformulas that hold on them; each becomes one letter set.

    Args:
        formula: in negation normal form.
        aps: the propositions of the alphabet, at least those of the formula.

    Raises:
        AlphabetLimitExceeded: there are more than `MAX_APS` propositions.
    """
    if len(aps) > MAX_APS:
        raise AlphabetLimitExceeded(
            f"the formula has {len(aps)} atomic propositions; tables over letters hold at most {MAX_APS}"
        )
    letter = np.arange(2 ** len(aps), dtype=np.int64)
    truth: dict[Formula, npt.NDArray[np.bool_]] = {}
    maximal: dict[Formula, None] = {}
    for f in postorder(formula):
        if isinstance(f, _BOOLEAN) and all(arg in truth for arg in f.args):
            truth[f] = _truth(f, truth, aps, letter)
            maximal[f] = None
        if isinstance(f, _BOOLEAN) and f in truth:
            for arg in f.args:
                maximal.pop(arg, None)
    for f in postorder(formula):
        if f not in truth:
            maximal.update((arg, None) for arg in f.args if arg in truth)
    columns = list(maximal)
    classes = np.zeros(len(letter), dtype=np.int64)
    for start in range(0, len(columns), _COLUMNS_AT_ONCE):
        for f in columns[start : start + _COLUMNS_AT_ONCE]:
            classes = classes << 1 | truth[f]
        _, first, classes = np.unique(classes, return_index=True, return_inverse=True)
    if columns:
        order = np.argsort(first)
        first, classes = first[order], np.argsort(order)[classes]
    else:
        first = np.zeros(1, dtype=np.int64)
    sets = {f: _as_letter_set(truth[f][first]) for f in columns}
    return Letters(aps, classes.astype(np.int32), len(first), sets)


def _truth(
    f: Formula,
    truth: dict[Formula, npt.NDArray[np.bool_]],
    aps: tuple[str, ...],
    letter: npt.NDArray[np.int64],
) -> npt.NDArray[np.bool_]:
    if isinstance(f, Proposition):
        return (letter >> aps.index(f.name) & 1).astype(np.bool_)
    if isinstance(f, Constant):
        return np.full(len(letter), f.value)
    columns = [truth[arg] for arg in f.args]
    if isinstance(f, Not):
        return ~columns[0]
    return reduce(np.logical_and if isinstance(f, And) else np.logical_or, columns)


def _as_letter_set(column: npt.NDArray[np.bool_]) -> int:
    return int.from_bytes(np.packbits(column, bitorder="little").tobytes(), "little")
