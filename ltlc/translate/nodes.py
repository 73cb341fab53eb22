"""The subformulas of a formula as numbered nodes: building, negating, placing in the hierarchy, implying.

References:
    F. Somenzi, R. Bloem: Efficient Buchi Automata from LTL Formulae. CAV 2000, doi 10.1007/10722167_21 (syntactic
    implication).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import NamedTuple

from ltlc.budget import check_time
from ltlc.ltl import (
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    postorder,
)
from ltlc.translate.letters import Letters

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
_UNRELATED = frozenset((f, g) for f in ("letters", "F", "X") for g in ("letters", "G", "X") if f != g)
"""No rule below tells that a node of the first kind implies one of the second."""
_LEVELS = (("sigma1", 1), ("pi1", 2), ("sigma2", 4), ("pi2", 8))
_LOWEST = tuple(next((name for name, bit in _LEVELS if levels & bit), "") for levels in range(16))


class Node(NamedTuple):
    """A subformula: `kind` is "letters" or the operator's symbol, `args` are node numbers."""

    kind: str
    args: tuple[int, ...]
    letters: int


class Nodes:
    """The nodes of a formula in negation normal form, and those made from them.

    Args:
        formula: in negation normal form, over `&`, `|` and the temporal operators.
        letters: `letters_of` the formula.

    Attributes:
        nodes: by number; operands have smaller numbers.
        root: the number of the formula.
    """

    def __init__(self, formula: Formula, letters: Letters) -> None:
        self.letters = letters
        self.nodes: list[Node] = []
        self._number: dict[tuple[str, tuple[int, ...], int], int] = {}
        self._implies: dict[tuple[int, int], bool] = {}
        self._level: dict[int, int] = {}
        self._negation: dict[int, int] = {}
        self._finite_part: dict[int, int] = {}
        self.root = self._compile(formula)

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
        key = kind, args, letters
        known = self._number.get(key)
        if known is None:
            known = self._number[key] = len(self.nodes)
            self.nodes.append(Node(kind, args, letters))
        return known

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
                check_time()
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
        known = self._negation.get(node)
        if known is None:
            kind, args, letters = self.nodes[node]
            if kind == "letters":
                known = self.node(kind, letters=self.letters.all & ~letters)
            else:
                known = self.node(_DUAL[kind], *map(self.negation, args))
            self._negation[node] = known
        return known

    def finite_part(self, node: int) -> int:
        """The node with every greatest fixpoint (G, R, W) that is not co-safety taken as satisfied."""
        known = self._finite_part.get(node)
        if known is None:
            kind, args, _ = self.nodes[node]
            if self._levels(node) & 1:
                known = node
            elif kind in "GRW":
                known = self.constant(True)
            else:
                known = self.node(kind, *map(self.finite_part, args))
            self._finite_part[node] = known
        return known

    def level(self, node: int) -> str:
        """The lowest class of the syntactic hierarchy: "sigma1", "pi1", "sigma2", "pi2", or "" above these.

        References:
            I. Cerna, R. Pelanek: Relating Hierarchy of Temporal Properties to Model Checking. MFCS 2003,
            doi 10.1007/978-3-540-45138-9_26.
        """
        return _LOWEST[self._levels(node)]

    def is_obligation(self, node: int) -> bool:
        """Whether the node is a Boolean combination of safety and co-safety subformulas, in shape."""
        return self._is_combination(node, lambda part: self.level(part) in ("sigma1", "pi1"))

    def is_fair_obligation(self, node: int) -> bool:
        """Whether it is one of these and of G F a, F G a with a Boolean: fairness conditions."""
        return self._is_combination(node, lambda part: self.level(part) in ("sigma1", "pi1") or self._is_fairness(part))

    def is_limit(self, node: int) -> bool:
        """Whether it is G F f with a co-safety formula f, or F G f with a safety formula f, and f cannot be split."""
        kind, args, _ = self.nodes[node]
        if not self.level(node) or kind not in "FG":
            return False
        inner, parts, _ = self.nodes[args[0]]
        return inner == _DUAL[kind] and self.nodes[parts[0]].kind != ("|" if kind == "G" else "&")

    def is_low(self, node: int, side: str = "") -> bool:
        """Whether the node is a Boolean combination of sigma2 and pi2 subformulas, in shape; or of one side of them."""
        return self._is_combination(node, lambda part: self.level(part).startswith(side or ("sigma", "pi")))

    def _is_combination(self, node: int, holds: Callable[[int], bool]) -> bool:
        """Whether it is a Boolean combination of nodes for which that holds; each is asked once."""
        todo, seen = [node], {node}
        while todo:
            check_time()
            part = todo.pop()
            kind, args, _ = self.nodes[part]
            if not holds(part):
                if kind not in "&|":
                    return False
                todo += [arg for arg in args if arg not in seen]
                seen.update(args)
        return True

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

    # -- syntactic implication ----------------------------------------------------------------------------------------

    def implies(self, f: int, g: int) -> bool:
        """Whether node f implies node g by the shape of both alone: sound, not complete."""
        if f == g:
            return True
        key = (f, g)
        known = self._implies.get(key)
        if known is None:
            self._implies[key] = False  # no rule needs itself
            if not len(self._implies) & 63:
                check_time()
            known = self._implies[key] = self._implies_by_shape(f, g)
        return known

    def _implies_by_shape(self, f: int, g: int) -> bool:
        fk, fa, fl = self.nodes[f]
        gk, ga, gl = self.nodes[g]
        if fk == gk == "letters":
            return not fl & ~gl
        if (fk, gk) in _UNRELATED:
            return False
        imp = self.implies
        if fk == "|":
            return all(imp(a, g) for a in fa)
        if gk == "&":
            return all(imp(f, b) for b in ga)
        if fk == "&" and any(imp(a, g) for a in fa):
            return True
        if gk == "|" and any(imp(f, b) for b in ga):
            return True
        return self._weaken_left(f, g, fk, fa) or self._strengthen_right(f, g, gk, ga)

    def _weaken_left(self, f: int, g: int, kind: str, args: tuple[int, ...]) -> bool:
        """Replace f, which has this kind and these operands, by something it implies at once."""
        if kind not in "GUWRMFX":
            return False
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

    def _strengthen_right(self, f: int, g: int, kind: str, args: tuple[int, ...]) -> bool:
        """Replace g, which has this kind and these operands, by something that implies it."""
        imp = self.implies
        if kind == "F":
            return imp(f, args[0])
        if kind not in "UWRM":
            return False
        fk, fa, _ = self.nodes[f]
        if kind in "UW":
            if imp(f, args[1]):
                return True
            same = fk == "U" or (fk == kind == "W")
            return same and imp(fa[0], args[0]) and imp(fa[1], g)
        if imp(f, args[0]) and imp(f, args[1]):
            return True
        same = fk == "M" or (fk == kind == "R")
        return same and imp(fa[0], args[0]) and imp(fa[1], args[1])
