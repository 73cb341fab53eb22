"""Syntax of other tools of the field: names that they reserve, and what their operators and queries are."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from types import MappingProxyType
from typing import NamedTuple

from ltlc.ltl.grammar import Token, excerpt

# --- names ------------------------------------------------------------------------------------------------------------

_PAST = {
    "Y": "yesterday",
    "Z": "weak yesterday",
    "O": "once",
    "H": "historically",
    "S": "since",
    "T": "triggered",
}
_TRANSLATORS, _PAST_TOOLS, _SPIN = "Spot, SPIN and LTL2BA read", "nuXmv and BLACK read", "SPIN reads"
RESERVED: Mapping[str, str] = MappingProxyType(
    {
        "t": "ltl2dstar, LBT and guards in HOA files read true",
        "f": "ltl2dstar, LBT and guards in HOA files read false",
        "last": "tools for finite traces, such as LTLf2DFA, read the last position",
        "N": "tools for finite traces, such as Syft, read the operator weak next",
        "WX": "tools for finite traces, such as LTLf2DFA, read the operator weak next",
        "V": f"{_TRANSLATORS} the operator release, here R",
        **{sign: f"{_PAST_TOOLS} the past operator {name}" for sign, name in _PAST.items() if sign != "T"},
        "always": f"{_SPIN} the operator always, here G",
        "eventually": f"{_SPIN} the operator eventually, here F",
        "next": f"{_SPIN} the operator next, here X",
        "until": f"{_SPIN} the operator until, here U",
        "stronguntil": f"{_SPIN} the operator until, here U",
        "weakuntil": f"{_SPIN} the operator weak until, here W",
        "release": f"{_SPIN} the operator release, here R",
        "implies": f"{_SPIN} the operator implies, here ->",
        "equivalent": f"{_SPIN} the operator equivalent, here <->",
    }
)
"""Names of propositions that other tools for linear temporal logic cannot have, and what those read instead.

Not among them are the capital letters that only model checkers with languages of their own reserve (A C E I P of PRISM
and NuSMV), and T (triggered), because tasks name their regions A, B, C, T.
"""

_PAST_PREFIX = {sign: name for sign, name in _PAST.items() if sign in "YZOH"}
_PAST_PREFIX |= {word: word for word in ("once", "historically", "yesterday", "previously")}
_PAST_INFIX = {sign: name for sign, name in _PAST.items() if sign in "ST"}
_PAST_INFIX |= {word: word for word in ("since", "triggered")}
_WEAK_NEXT = ("N", "WX", "wX", "weak_next", "weaknext")
_PATH_QUANTIFIED = re.compile(r"[AE][XFGU]|A|E")
_STARTS_OPERAND = frozenset(
    ("NAME", "QUOTED", "_TRUE", "_FALSE", "_OPEN", "_NOT", "_NEXT", "_EVENTUALLY", "_ALWAYS"),
)
_NO_PAST = "formulas speak about the present and the future; "
_PAST_HINTS = {
    "yesterday": _NO_PAST + "G(b -> Y a), for example, says the same as !b & G(X b -> a)",
    "weak yesterday": _NO_PAST + "G(b -> Z a), for example, says the same as G(X b -> a)",
    "once": _NO_PAST + "G(b -> O a), for example, says the same as !b W a",
    "historically": _NO_PAST + "G(b -> H a), for example, says the same as G(!a -> G !b)",
    "since": _NO_PAST + "G(c -> (a S b)), for example, says the same as (!c W b) & G(!a & !b -> (!c W b))",
    "triggered": _NO_PAST + "G(c -> (a T b)), for example, says the same as G(!b -> (!c W (a & b)))",
}
_PAST_HINTS["previously"] = _PAST_HINTS["yesterday"]


class Foreign(NamedTuple):
    """What a text is in the syntax of another tool."""

    message: str
    hint: str
    start: int
    """where it starts, in characters from 0."""


def foreign_operator(before: Token, here: Token, after: Token | None) -> Foreign | None:
    """What the first of two operands side by side, or the one in the middle of three, is for another tool.

    Args:
        before: ends an operand.
        here: starts the next one.
        after: what follows `here`, or None for the end.
    """
    if before.kind == "NAME" and here.kind in _STARTS_OPERAND:
        if before.text in _PAST_PREFIX:
            return _past(before, _PAST_PREFIX[before.text])
        if before.text in _WEAK_NEXT:
            message = f"'{before}' is the weak next of finite traces"
            return Foreign(
                message, "words are infinite here, where every position has a next one: write X", before.start
            )
        if _PATH_QUANTIFIED.fullmatch(before.text) and (
            len(before.text) == 2 or here.kind in ("_NEXT", "_EVENTUALLY", "_ALWAYS")
        ):
            return _path_quantifier(before.text, before.start)
    if here.kind == "NAME" and here.text in _PAST_INFIX and after is not None and after.kind in _STARTS_OPERAND:
        return _past(here, _PAST_INFIX[here.text])
    return None


def _past(token: Token, name: str) -> Foreign:
    operator = f"'{token}'" if token.text == name else f"'{token}' ({name})"
    return Foreign(f"{operator} is an operator of the past, which is not read", _PAST_HINTS[name], token.start)


def _path_quantifier(text: str, start: int) -> Foreign:
    message = f"'{text}' quantifies over paths, as in CTL; a formula here speaks about one path"
    if text[0] == "A":
        hint = f"write {text[1:] or 'F'} a, which a task asks of every path"
    else:
        hint = "EF a, for example, holds where not every path satisfies G !a"
    if len(text) == 1:
        hint += f"; if {text} is a name, put an operator such as & behind it"
    return Foreign(message, hint, start)


# --- prefix notation --------------------------------------------------------------------------------------------------

_LBT_ARITY = {"_NOT": 1, "_NEXT": 1, "_EVENTUALLY": 1, "_ALWAYS": 1, "NAME": 0, "QUOTED": 0, "_TRUE": 0, "_FALSE": 0}
_LBT_ARITY |= dict.fromkeys(("_AND", "_OR", "_XOR", "_UNTIL", "_RELEASE", "_WEAK_UNTIL", "_STRONG_RELEASE"), 2)
_LBT_ARITY |= dict.fromkeys(("_IMPLIES", "_IFF"), 2)
_LBT_NAMES = {"i": "->", "e": "<->", "V": "R"}
_LBT_LONGEST = 200


def prefix_notation(scanned: Iterable[Token]) -> Foreign | None:
    """The formula in infix notation, if the tokens are one in the prefix notation of LBT and ltl2dstar."""
    tokens = list(islice(scanned, _LBT_LONGEST + 1))
    if not 2 < len(tokens) <= _LBT_LONGEST:
        return None
    operands: list[tuple[str, bool]] = []  # what was read from the right, and whether it needs no brackets
    first = len(tokens)
    for i in reversed(range(len(tokens))):
        kind, text = tokens[i].kind, tokens[i].text
        named = kind == "NAME" and text in _LBT_NAMES and len(operands) >= 2
        arity = 2 if named else _LBT_ARITY.get(kind)
        if arity is None or len(operands) < arity:
            return None
        if arity == 2:
            first = i
            (left, _), (right, _) = operands.pop(), operands.pop()
            operands.append((f"({left} {_LBT_NAMES[text] if named else text} {right})", False))
        elif arity == 1:
            operand, _ = operands.pop()
            operands.append((f"{text}{' ' if text.isalpha() else ''}{operand}", True))
        else:
            operands.append(({"t": "true", "f": "false"}.get(text, text), True))
    if len(operands) != 1 or first == len(tokens):
        return None
    infix, bare = operands[0]
    message = f"'{tokens[first]}' before its operands is prefix notation, as LBT and ltl2dstar read it"
    return Foreign(message, f"write operators between operands: {infix if bare else infix[1:-1]}", tokens[first].start)


# --- patterns ---------------------------------------------------------------------------------------------------------

_AROUND = 200
"""a pattern is looked for in so many characters before and behind the place of an error."""


def foreign_syntax(text: str, position: int) -> Foreign | None:
    """What the place of an error belongs to in the syntax of another tool, if that is known."""
    start = max(0, position - _AROUND)
    window = text[start : position + _AROUND]
    for pattern, explain in _PATTERNS:
        for match in pattern.finditer(window):
            if match.start() <= position - start < match.end():
                found = explain(match)
                return found._replace(start=found.start + start)
    return None


def _property(match: re.Match[str]) -> Foreign:
    what = {"R": "an expected reward", "S": "a long-run probability"}.get(match["ask"][0], "a probability")
    inner = " ".join((match["inner"] or "").split())
    hint = f"write {excerpt(inner)}" if inner else "write what stands between [ and ], such as F a"
    message = f"'{excerpt(match['ask'])}' asks for {what}, as properties of PRISM do; a formula is what it asks about"
    return Foreign(message, hint, match.start())


def _bound(match: re.Match[str]) -> Foreign:
    operator, bound = match["operator"], match["bound"]
    hint = _BOUND_HINTS.get(operator, "write the steps out with X")
    steps = _steps(bound, is_next=operator == "X")
    if steps and operator in _JOINED:
        hint = f"{operator}{bound} a is {_JOINED[operator].join('X ' * i + 'a' for i in steps)}"
    return Foreign(f"'{operator}{bound}' has a bound, which operators do not have here", hint, match.start("bound"))


def _steps(bound: str, is_next: bool) -> range:
    """The steps that a bound such as [0,3], <=3 or, of next, [3] speaks about; none if they are many, or not clear."""
    limit = re.fullmatch(r"[_{\[\s]*(<=|<|=|\^|)\s*(\d{1,3})[\s\]}]*", bound)
    interval = re.fullmatch(r"[_{\[\s]*(\d{1,3})\s*(?:,|:|\.\.)\s*(\d{1,3})[\s\]}]*", bound)
    if interval and not is_next:
        steps = range(int(interval[1]), int(interval[2]) + 1)
    elif limit and limit[1] in ("<", "<=") and not is_next:
        steps = range(int(limit[2]) + (limit[1] == "<="))
    elif limit and (limit[1] == "=" or (is_next and limit[1] in ("^", ""))):
        steps = range(int(limit[2]), int(limit[2]) + 1)
    else:
        steps = range(0)
    return steps if steps and steps[-1] <= _LONGEST_BOUND else range(0)


_LONGEST_BOUND = 5
_JOINED = {"X": "", "F": " | ", "<>": " | ", "G": " & ", "[]": " & "}
_BOUND_HINTS = {
    "X": "write an X for every step: X X a",
    **dict.fromkeys(("F", "<>"), "write the steps out: F a within two of them is a | X a | X X a"),
    **dict.fromkeys(("G", "[]"), "write the steps out: G a for two of them is a & X a & X X a"),
    "U": "write the steps out: a U b within two of them is b | a & X(b | a & X b)",
    "R": "write the steps out: a R b for two of them is b & (a | X(b & (a | X b)))",
}


def _quoted(match: re.Match[str]) -> Foreign:
    name = match["name"] or "name"
    return Foreign(
        f"{excerpt(match[0])} is no name: names are quoted with double quotes",
        f'write "{excerpt(name)}"',
        match.start(),
    )


def _explained(message: str, hint: str) -> Callable[[re.Match[str]], Foreign]:
    return lambda match: Foreign(message.format(f"'{excerpt(match[0])}'"), hint, match.start())


_BOUND = r"(?:_?\s*\[[\s\d,:.<>=$]*(?:inf|oo|∞)?[\s)]*\]|_?\{[\s\d,:.<>=\[\]]*\}|\s*(?:<=|<|>=|>|=)\s*\d+)"
_PATTERNS: Sequence[tuple[re.Pattern[str], Callable[[re.Match[str]], Foreign]]] = (
    (
        re.compile(
            r"(?<![\w.])(?P<ask>[PRS](?:\{[^{}]*\})?(?:max|min)?\s*(?:=\s*\?|[<>]=?\s*[\d.]+(?=\s*\[)))"
            r"(?:\s*\[(?P<inner>.*)\])?",
            re.DOTALL,
        ),
        _property,
    ),
    (
        re.compile(r"(?<![\w.])[AE]\s*\["),
        lambda match: _path_quantifier(match[0][0], match.start()),
    ),
    (
        re.compile(r"X\s*\[\s*!\s*\]"),
        _explained(
            "{} is the strong next of finite traces",
            "words are infinite here, where every position has a next one: write X",
        ),
    ),
    (
        re.compile(rf"(?<![\w.])[XFG]*[OHYZST]{_BOUND}"),
        _explained("{} is an operator of the past with a bound, which is not read", _NO_PAST.rstrip("; ")),
    ),
    (
        re.compile(
            r"(?:(?<![\w.])[XFG]*(?=[XFGURWM])|(?=<>|\[\]))(?P<operator>[XFGURWM]|<>|\[\])"
            rf"(?P<bound>{_BOUND}|\s*\^\s*\d+)"
        ),
        _bound,
    ),
    (
        re.compile(r"(?<![\w.])cycle\s*\{"),
        _explained("{} belongs to a word, and a formula is expected", "a formula says what holds for ever by G: G a"),
    ),
    (
        re.compile(r"\{[^{}]*(?:[;:*]|\[[+*=-])[^{}]*\}?|\[(?:\*|\+|=|->)[^\]]*\]?|##\s*\d+"),
        _explained(
            "{} is part of a regular expression, as in PSL and SVA", "write sequences with X: {a; b} is a & X b"
        ),
    ),
    (
        re.compile(r"\|->|\|=>|\[\]->|<>->"),
        _explained("{} is an operator of PSL and SVA", "a |-> b is a -> b, and a |=> b is a -> X b"),
    ),
    (re.compile(r"~>"), _explained("{} is 'leads to' of TLA+", "a ~> b is G(a -> F b)")),
    (re.compile(r"(?<![\w.])['`‘‚](?P<name>[^'`‘’]*)['`’‘]"), _quoted),
    (re.compile(r"[“„«](?P<name>[^“”„«»]*)[”“»]"), _quoted),
)
