"""Syntax of other tools of the field: names that they reserve, words that are read, and what is not."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
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
PAST_PREFIX: Mapping[str, str] = MappingProxyType(
    {sign: name.replace(" ", "_") for sign, name in _PAST.items() if sign in "YZOH"}
    | {word: word for word in ("yesterday", "weak_yesterday", "once", "historically")}
    | {"previously": "yesterday"}
)
"""Words that are operators of the past where an operand is expected and another one follows, with the rule of each."""
PAST_INFIX: Mapping[str, str] = MappingProxyType(
    {"S": "since", "since": "since", "T": "triggered", "triggered": "triggered"}
)
"""Words that are operators of the past between two operands, with the rule of each."""
PAST_WORDS = frozenset((*PAST_PREFIX, *PAST_INFIX))
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

WEAK_NEXT = ("N", "WX", "wX", "weak_next", "weaknext")
"""Words for weak next."""
_PATH_QUANTIFIED = re.compile(r"[AE][XFGU]|A|E")
STARTS_OPERAND = frozenset(
    ("NAME", "QUOTED", "_TRUE", "_FALSE", "_OPEN", "_NOT", "_NEXT", "_EVENTUALLY", "_ALWAYS", "PREFIX"),
)
"""Kinds of tokens with which an operand starts."""


class Foreign(NamedTuple):
    """What a text is in the syntax of another tool."""

    message: str
    hint: str
    start: int
    """where it starts, in characters from 0."""


def foreign_operator(before: Token, here: Token) -> Foreign | None:
    """What the first of two operands side by side is for another tool.

    Args:
        before: ends an operand.
        here: starts the next one.
    """
    if before.kind != "NAME" or here.kind not in STARTS_OPERAND or not _PATH_QUANTIFIED.fullmatch(before.text):
        return None
    glued = len(before.text) > 1
    return _path_quantifier(before.text, before.start) if glued or here.kind in _OF_THE_FUTURE else None


_OF_THE_FUTURE = ("_NEXT", "_EVENTUALLY", "_ALWAYS")


def _path_quantifier(text: str, start: int) -> Foreign:
    message = f"'{text}' quantifies over paths, as in CTL; a formula here speaks about one path"
    if text[0] == "A":
        hint = f"write {text[1:] or 'F'} a, which a task asks of every path"
    else:
        hint = "EF a, for example, holds where not every path satisfies G !a"
    if len(text) == 1:
        hint += f"; if {text} is a name, put an operator such as & behind it"
    return Foreign(message, hint, start)


# --- patterns ---------------------------------------------------------------------------------------------------------

_AROUND = 200
"""a pattern is looked for in so many characters before and behind the place of an error."""


def foreign_syntax(text: str, position: int) -> Foreign | None:
    """What the place of an error belongs to in the syntax of another tool, if that is known."""
    start = max(0, position - _AROUND)
    window = text[start : position + _AROUND]
    for pattern, explain in _PATTERNS:
        for match in re.finditer(pattern, window):  # compiled where there is an error, not when this is imported
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
    operator = match["operator"]
    forms = f"{operator}[3]" if operator in "XYZ" else f"{operator}[2:5], {operator}[2:] or {operator}<=5"
    return Foreign(f"'{match[0]}' has a bound that is not read", f"write {forms}", match.start("operator"))


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
_PATTERNS: Sequence[tuple[str, Callable[[re.Match[str]], Foreign]]] = (
    (
        (
            r"(?s)(?<![\w.])(?P<ask>[PRS](?:\{[^{}]*\})?(?:max|min)?\s*(?:=\s*\?|[<>]=?\s*[\d.]+(?=\s*\[)))"
            r"(?:\s*\[(?P<inner>.*)\])?"
        ),
        _property,
    ),
    (
        r"(?<![\w.])[AE]\s*\[",
        lambda match: _path_quantifier(match[0][0], match.start()),
    ),
    (
        (
            r"(?:(?<![\w.])[XFG]*(?=[XFGURWMOHYZST])|(?=<>|\[\]))(?P<operator>[XFGURWMOHYZST]|<>|\[\])"
            rf"(?P<bound>{_BOUND}|\s*\^\s*\d+)"
        ),
        _bound,
    ),
    (
        r"(?<![\w.])cycle\s*\{",
        _explained("{} belongs to a word, and a formula is expected", "a formula says what holds for ever by G: G a"),
    ),
    (
        r"\{[^{}]*(?:[;:*]|\[[+*=-])[^{}]*\}?|\[(?:\*|\+|=|->)[^\]]*\]?|##\s*\d+",
        _explained(
            "{} is part of a regular expression, as in PSL and SVA", "write sequences with X: {a; b} is a & X b"
        ),
    ),
    (
        r"\|->|\|=>|\[\]->|<>->",
        _explained("{} is an operator of PSL and SVA", "a |-> b is a -> b, and a |=> b is a -> X b"),
    ),
    (r"~>", _explained("{} is 'leads to' of TLA+", "a ~> b is G(a -> F b)")),
    (r"(?<![\w.])[`‘‚](?P<name>[^`‘’]*)[`’‘]", _quoted),
    (r"[“„«](?P<name>[^“”„«»]*)[”“»]", _quoted),
)
