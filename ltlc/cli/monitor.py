"""`ltlc monitor`: verdicts on a word while its letters arrive."""

from __future__ import annotations

import json
from typing import Annotated

from ltlc.budget import MAX_STATES
from ltlc.cli import flags
from ltlc.cli.alphabet import declared
from ltlc.cli.inputs import standard_input
from ltlc.cli.letter_lines import LetterLines
from ltlc.cli.messages import complain
from ltlc.cli.options import Argument, Option
from ltlc.errors import FileFormatError


def monitor(
    formula: Annotated[str, Argument(metavar="FORMULA", help="A formula.")],
    finite: flags.Finite = False,
    exclusive: flags.Exclusive = None,
    letters: flags.Letters = None,
    max_states: flags.MaxStates = MAX_STATES,
    timeout: flags.Timeout = None,
    csv_: Annotated[
        bool, Option("--csv", help="Read a table: names of columns in the first line, then a letter a row.")
    ] = False,
    json_: flags.Json = False,
) -> int:
    """Read letters from standard input, one a line, and print what they say of a formula.

    A letter is the names of what holds, with blanks, commas or & between them
    (1 for none), a JSON list of such names, or a JSON object of names with true
    and false. A comparison in the formula is about numbers in such an object, or,
    with --csv, in columns. Blank lines are passed over. After each letter a verdict is
    printed: satisfied or violated, which is final and ends the command, or
    presumably so, which is what it would be if the word ended there.

    The exit code is 1 if the formula is violated; with --finite the end of the
    input ends the trace, and the exit code is 1 if the formula does not hold.

    \b
    Examples:
      printf "a\\nb\\n" | ltlc monitor "G(a -> X b)"
      tail -f log.jsonl | ltlc monitor "G !error" --json
      ltlc monitor 'G("speed > 5" -> F "speed < 1")' --csv < log.csv
    """
    from ltlc.ltl import Proposition
    from ltlc.monitor import Monitor, Verdict

    possible = declared(exclusive, letters)._asdict()
    watching = Monitor(formula, finite=finite, max_states=max_states, timeout=timeout, **possible)
    strange: set[str] = set()
    n_letters = 0
    reader = LetterLines(watching.aps)
    for letter in reader.of_table(standard_input()) if csv_ else reader.of_lines(standard_input()):
        for name in () if csv_ else sorted(letter - set(watching.aps) - strange):
            strange.add(name)
            complain(f"warning: nothing in {formula} depends on {Proposition(name)}")
        verdict = watching.step(letter & set(watching.aps))
        n_letters += 1
        said = {"letter": n_letters, "verdict": verdict.value}
        print(json.dumps(said) if json_ else verdict.value, flush=True)
        if verdict.is_final:
            break
    if n_letters == 0 and finite:
        raise FileFormatError("there is no letter on standard input, and a trace has one at least")
    unfulfilled = watching.verdict is Verdict.PRESUMABLY_VIOLATED and finite
    return 1 if watching.verdict is Verdict.VIOLATED or unfulfilled else 0
