"""`ltlc explain`: what a formula says, and what tells two formulas apart."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ltlc.budget import MAX_STATES
from ltlc.cli import flags
from ltlc.cli.inputs import formula_text
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.ltl import Formula


def explain(
    formula: Annotated[str, typer.Argument(metavar="FORMULA", help="A formula, or - to read it.")],
    other: Annotated[str | None, typer.Argument(metavar="[OTHER]", help="A formula to compare it with.")] = None,
    finite: flags.Finite = False,
    max_states: flags.MaxStates = MAX_STATES,
    timeout: flags.Timeout = None,
    json_: flags.Json = False,
) -> None:
    """Say a formula in plain English, and what of it is often meant otherwise.

    Brackets stand wherever one sentence stands inside another, so that there is
    one reading. With two formulas, words are shown that satisfy one and not the
    other, each way; the exit code is 1 if there are any.

    \b
    Examples:
      ltlc explain "G(request -> F grant)"
      ltlc explain "a U b" "a W b"
    """
    from ltlc.budget import time_limit
    from ltlc.ltl import parse

    if other is not None and finite:
        raise InvalidArgumentError("two formulas are compared on infinite words only: leave --finite out")
    text = formula_text(formula)
    with time_limit(text, timeout):
        parsed = [parse(each, finite=finite) for each in (text, other) if each is not None]
        answers = [_said(each) for each in parsed]
        apart = _apart(parsed[0], parsed[1], max_states) if len(parsed) > 1 else {}
    if json_:
        print(json.dumps({"formulas": answers, **({"apart": apart} if apart else {})}, ensure_ascii=False, indent=2))
    else:
        for answer in answers:
            print(f"{answer['formula']}\n  {answer['english']}")
            for warning in answer["misreadings"]:
                print(f"  mind: {warning}")
        for side, word in apart.items():
            print(f"{side}: {word or 'no word'}")
    if any(apart.values()):
        raise typer.Exit(1)


def _said(formula: Formula) -> dict[str, Any]:
    from ltlc.ltl import misreadings, to_english

    return {"formula": str(formula), "english": to_english(formula), "misreadings": misreadings(formula)}


def _apart(first: Formula, second: Formula, max_states: int) -> dict[str, str | None]:
    """A word for each way in which the formulas differ, or None where there is none."""
    from ltlc.automata import counterexample
    from ltlc.compiler import compile
    from ltlc.ltl import FALSE, And, Not

    def word(formula: Formula) -> str | None:
        automaton = compile(formula, effort="fast", max_states=max_states)
        found = counterexample(automaton, compile(And(formula, FALSE), effort="fast"))
        return None if found is None else str(found)

    return {
        "the first and not the second": word(And(first, Not(second))),
        "the second and not the first": word(And(second, Not(first))),
    }
