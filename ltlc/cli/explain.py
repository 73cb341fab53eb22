"""`ltlc explain`: what a formula says, and what tells two formulas apart."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Annotated, Any

from ltlc.budget import MAX_STATES
from ltlc.cli import flags
from ltlc.cli.explain_run import print_reasons
from ltlc.cli.inputs import formula_text
from ltlc.cli.options import Argument, Option
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.ltl import Formula


def explain(
    formula: Annotated[
        str, Argument(metavar="FORMULA", help="A formula, or - to read it; or the folder of a training run.")
    ],
    other: Annotated[str | None, Argument(metavar="[OTHER]", help="A formula to compare it with.")] = None,
    finite: flags.Finite = False,
    max_states: flags.MaxStates = MAX_STATES,
    timeout: flags.Timeout = None,
    output: Annotated[
        str | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            is_path=True,
            help="Of a run: draw the ways to fail on the map.",
        ),
    ] = None,
    episodes: Annotated[
        int, Option("--episodes", "-n", least=1, metavar="N", help="Of a run that is sampled: how many.")
    ] = 200,
    seed: Annotated[int, Option("--seed", least=0, metavar="N", help="Of the sampling.")] = 0,
    json_: flags.Json = False,
) -> int:
    """Say a formula in plain English, and what of it is often meant otherwise.

    Brackets stand wherever one sentence stands inside another, so that there is
    one reading. With two formulas, words are shown that satisfy one and not the
    other, each way; the exit code is 1 if there are any.

    With the folder of a run, it says why what was learned satisfies its formula
    with a probability below 1: the most probable ways to fail, which carry 90 %
    of what is lost, and where lost runs stay; exactly where the environment is
    known, else by the words of sampled episodes.

    \b
    Examples:
      ltlc explain "G(request -> F grant)"
      ltlc explain "a U b" "a W b"
      ltlc explain runs/f-goal-g-hole-frozenlake-v1-0 -o lost.png
    """
    from ltlc.budget import time_limit
    from ltlc.ltl import parse

    if os.path.isdir(formula):
        if other is not None or finite:
            raise InvalidArgumentError(f"{formula} is a folder: explain it alone")
        print_reasons(formula, output, episodes, seed, json_)
        return 0
    if output is not None:
        raise InvalidArgumentError(f"-o draws what a run loses, and {formula!r} is no folder of a run")
    if other is not None and finite:
        raise InvalidArgumentError("two formulas are compared on infinite words only: leave --finite out")
    text = formula_text(formula)
    with time_limit(text, timeout):
        parsed = [parse(each, finite=finite) for each in (text, other) if each is not None]
        answers = [_said(each, finite) for each in parsed]
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
    return 1 if any(apart.values()) else 0


def _said(formula: Formula, finite: bool) -> dict[str, Any]:
    from ltlc.ltl import misreadings, to_english, to_text

    text = str(formula) if finite else to_text(formula, "bounded")
    return {"formula": text, "english": to_english(formula), "misreadings": misreadings(formula)}


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
