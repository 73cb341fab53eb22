"""`ltlc check`: is a word in the language?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from ltlc.cli import flags
from ltlc.cli.inputs import formula_text, given_automaton
from ltlc.cli.messages import complain

if TYPE_CHECKING:
    from ltlc.automata import DRA
    from ltlc.ltl import Formula, LassoWord


def check(
    source: Annotated[str, typer.Argument(metavar="SOURCE", help="A formula, a .json or .hoa file, or - to read one.")],
    word: Annotated[
        list[str],
        typer.Option(
            "--word", "-w", metavar="WORD", help="Letters and a cycle, as in 'a; b & c; cycle{!a}'. May be repeated."
        ),
    ],
    timeout: flags.Timeout = None,
    json_: flags.Json = False,
) -> None:
    """Decide whether infinite words satisfy a formula or are accepted by an automaton.

    A letter lists what holds, joined by &; what it leaves out does not hold.
    A formula is judged by its definition, an automaton by its run. The exit
    code is 0 if every word is accepted, and 1 if one is rejected.

    \b
    Examples:
      ltlc check "G(a -> F b)" --word "a; b; cycle{!a}"
      ltlc check dra.json -w "cycle{goal}" -w "trap; cycle{goal}"
    """
    from ltlc.budget import time_limit
    from ltlc.ltl import Formula, Proposition, parse, parse_word, propositions
    from ltlc.translate import Options

    Options(timeout=timeout).checked()
    with time_limit(source, timeout):
        given = given_automaton(source)
        subject = parse(given) if isinstance(given, str) else given
        known = propositions(subject) if isinstance(subject, Formula) else subject.aps
        verdicts = []
        for argument in word:
            text = formula_text(argument)
            lasso = parse_word(text)
            strange = {name for letter in lasso.letters for name in letter} - set(known)
            if strange:
                names = ", ".join(str(Proposition(name)) for name in sorted(strange))
                complain(f"warning: nothing in {source} depends on {names}")
            verdicts.append((" ".join(text.split()), *_judge(subject, lasso, known)))
    if json_:
        entries = [dict(zip(("word", "accepted", "violated"), verdict, strict=True)) for verdict in verdicts]
        print(json.dumps(entries, ensure_ascii=False, indent=2))
    else:
        for text, accepted, violated in verdicts:
            reason = f"  (does not satisfy {' and '.join(violated)})" if violated else ""
            print(f"{'accepted' if accepted else 'rejected'}: {text}{reason}")
    if not all(accepted for _, accepted, _ in verdicts):
        raise typer.Exit(1)


def _judge(subject: Formula | DRA, word: LassoWord, known: Sequence[str]) -> tuple[bool, list[str]]:
    """Whether the word is accepted; and if a conjunction is not satisfied, which of its parts are not."""
    from ltlc.ltl import And, Formula, satisfies

    if isinstance(subject, Formula):
        parts = subject.args if isinstance(subject, And) else (subject,)
        violated = [str(part) for part in parts if not satisfies(part, word)]
        return not violated, violated if len(parts) > 1 else []
    prefix, cycle = ([letter & set(known) for letter in letters] for letters in (word.prefix, word.cycle))
    return subject.accepts(prefix, cycle), []
