"""The Delta_2 normal form: every formula as a Boolean combination of sigma2 and pi2 formulas.

A word decides which least fixpoints (F, U, M) hold infinitely often, a set M, and which greatest fixpoints (G, R, W)
hold almost always, a set N. Under a guess (M, N) the formula becomes sigma2, and the guess itself is checked by G F and
F G formulas; the formula is the disjunction over all guesses. Only fixpoints whose answer the rewriting asks for are
guessed.

References:
    S. Sickert, J. Esparza: An Efficient Normalisation Procedure for Linear Temporal Logic and Very Weak Alternating
    Automata. LICS 2020, doi 10.1145/3373718.3394743, section 4.
"""

from __future__ import annotations

from collections.abc import Iterable

from ltlc.budget import check_time
from ltlc.errors import StateLimitExceeded
from ltlc.translate.closure import Closure

LEAST = "FUM"
GREATEST = "GRW"
_MAX_GUESSED = 8


def normal_form(closure: Closure, node: int) -> int:
    """The node of an equivalent formula whose outer Boolean combination is over sigma2 and pi2 subformulas.

    Raises:
        StateLimitExceeded: more than `_MAX_GUESSED` fixpoints would have to be guessed.
    """
    check_time()
    if closure.level(node):
        return node
    kind, args, _ = closure.nodes[node]
    if kind in "&|":
        return closure.make(kind, *(normal_form(closure, arg) for arg in args))
    return _guessed(closure, node)


def _guessed(closure: Closure, node: int) -> int:
    least, greatest = _asked(closure, node)
    if len(least) + len(greatest) > _MAX_GUESSED:
        raise StateLimitExceeded(
            f"the normal form would have to guess {len(least) + len(greatest)} fixpoints, more than {_MAX_GUESSED}: use"
            " another translator"
        )
    guesses = []
    for often in _subsets(least):
        for always in _subsets(greatest):
            check_time()
            guess = _Guess(closure, frozenset(often), frozenset(always))
            guesses.append(closure.make("&", guess.sigma2(node), guess.checked()))
    return closure.make("|", *guesses)


class _Guess:
    """The rewriting under one guess."""

    def __init__(self, closure: Closure, often: frozenset[int], always: frozenset[int]) -> None:
        self._closure = closure
        self._often = often
        self._always = always

    def checked(self) -> int:
        """What has to hold for the guess to be right."""
        make = self._closure.make
        often = [make("G", make("F", self.sigma1(node))) for node in sorted(self._often)]
        always = [make("F", make("G", self.pi1(node))) for node in sorted(self._always)]
        return make("&", *often, *always)

    def sigma2(self, node: int) -> int:
        """The formula, where what is asked of the far future is answered by the guess."""
        check_time()
        closure = self._closure
        if closure.level(node) in ("sigma1", "pi1", "sigma2"):
            return node
        kind, args, _ = closure.nodes[node]
        now = [self.sigma2(arg) for arg in args]
        if kind == "G":
            return closure.make("U", now[0], closure.make("G", self.pi1(args[0])))
        if kind == "W":
            return closure.make("U", now[0], closure.make("|", now[1], closure.make("G", self.pi1(args[0]))))
        if kind == "R":
            return closure.make("M", closure.make("|", now[0], closure.make("G", self.pi1(args[1]))), now[1])
        return closure.make(kind, *now)

    def pi1(self, node: int) -> int:
        """Least fixpoints are weakened if guessed to hold infinitely often, else false."""
        check_time()
        closure = self._closure
        if closure.level(node) == "pi1" or closure.is_plain(node):
            return node
        kind, args, _ = closure.nodes[node]
        if kind in LEAST and node not in self._often:
            return closure.constant(False)
        weak = [self.pi1(arg) for arg in args]
        if kind == "F":
            return closure.constant(True)
        return closure.make({"U": "W", "M": "R"}.get(kind, kind), *weak)

    def sigma1(self, node: int) -> int:
        """Greatest fixpoints are true if guessed to hold almost always, else strengthened."""
        check_time()
        closure = self._closure
        if closure.level(node) == "sigma1":
            return node
        kind, args, _ = closure.nodes[node]
        if kind in GREATEST and node in self._always:
            return closure.constant(True)
        if kind == "G":
            return closure.constant(False)
        strong = [self.sigma1(arg) for arg in args]
        return closure.make({"W": "U", "R": "M"}.get(kind, kind), *strong)


def _asked(closure: Closure, node: int) -> tuple[list[int], list[int]]:
    """The least and the greatest fixpoints whose answers `_Guess` looks up."""
    least: dict[int, None] = {}
    greatest: dict[int, None] = {}

    def in_sigma2(node: int) -> None:
        check_time()
        if closure.level(node) not in ("sigma1", "pi1", "sigma2"):
            kind, args, _ = closure.nodes[node]
            for arg in args:
                in_sigma2(arg)
            if kind in GREATEST:
                in_pi1(args[kind == "R"])

    def in_pi1(node: int) -> None:
        check_time()
        if closure.level(node) != "pi1" and not closure.is_plain(node):
            kind, args, _ = closure.nodes[node]
            if kind in LEAST and node not in least:
                least[node] = None
                in_sigma1(node)
            for arg in args:
                in_pi1(arg)

    def in_sigma1(node: int) -> None:
        check_time()
        if closure.level(node) != "sigma1":
            kind, args, _ = closure.nodes[node]
            if kind in GREATEST and node not in greatest:
                greatest[node] = None
                in_pi1(node)
            for arg in args:
                in_sigma1(arg)

    in_sigma2(node)
    return sorted(least), sorted(greatest)


def _subsets(nodes: list[int]) -> Iterable[list[int]]:
    return ([n for i, n in enumerate(nodes) if chosen >> i & 1] for chosen in range(1 << len(nodes)))
