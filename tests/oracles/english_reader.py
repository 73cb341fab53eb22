"""Reads the English of formulas back, from the inside out: brackets give way to numbered places."""

from __future__ import annotations

import re

from ltlc.ltl import FALSE, TRUE, Always, Eventually, Formula, Not, Proposition
from ltlc.ltl.english import FALSE_PHRASE, FINALLY, PHRASES, RECURRENTLY, SWAPPED, TRUE_PHRASE

_NAME = re.compile(r'("(?:[^"\\]|\\.)*"|[^\W\d][\w.]*) (holds|does not hold)')
_PLACE = r"<(\d+)>"


def read(text: str) -> Formula:
    """The formula of a sentence."""
    known: list[Formula] = []

    def place(formula: Formula) -> str:
        known.append(formula)
        return f"<{len(known) - 1}>"

    def literal(match: re.Match[str]) -> str:
        name = match[1]
        if name.startswith('"'):
            name = re.sub(r"\\(.)", r"\1", name[1:-1])
        formula: Formula = Proposition(name)
        return place(formula if match[2] == "holds" else Not(formula))

    text = _NAME.sub(literal, text)
    text = text.replace(TRUE_PHRASE, place(TRUE)).replace(FALSE_PHRASE, place(FALSE))
    while match := re.search(r"\(([^()]*)\)", text):
        text = text[: match.start()] + place(_flat(match[1], known)) + text[match.end() :]
    return _flat(text, known)


def _flat(text: str, known: list[Formula]) -> Formula:
    """A sentence without brackets, which exactly one of the patterns fits."""
    found: list[Formula] = []
    if match := re.fullmatch(_PLACE, text):
        return known[int(match[1])]
    if match := re.fullmatch(re.escape(RECURRENTLY) + _PLACE, text):
        found.append(Always(Eventually(known[int(match[1])])))
    if match := re.fullmatch(re.escape(FINALLY) + _PLACE, text):
        found.append(Eventually(Always(known[int(match[1])])))
    for phrases, step in ((PHRASES, 1), (SWAPPED, -1)):
        for operator, (before, *between, behind) in phrases.items():
            more = f"(?:{re.escape(between[0])}<\\d+>)+" if between else ""
            if re.fullmatch(f"{re.escape(before)}<\\d+>{more}{re.escape(behind)}", text):
                args = [known[int(number)] for number in re.findall(_PLACE, text)]
                found.append(operator(*args[::step]))
    (formula,) = found
    return formula
