"""`ltlc show`: look at an automaton."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

from ltlc.budget import MAX_STATES
from ltlc.cli import flags
from ltlc.cli.alphabet import declared
from ltlc.cli.inputs import given_automaton
from ltlc.cli.options import Argument
from ltlc.cli.outputs import Output, check_targets, write_targets
from ltlc.cli.summary import as_data, print_summary
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA
    from ltlc.automata.possible import DeclaredLetters
    from ltlc.translate import Options


def show(
    source: Annotated[str, Argument(metavar="SOURCE", help="A .json or .hoa file, a formula, or - to read one.")],
    output: Output = None,
    finite: flags.Finite = False,
    determinise: flags.Determinise = False,
    exclusive: flags.Exclusive = None,
    letters: flags.Letters = None,
    acceptance: flags.Acceptance = "state",
    translator: flags.Translator = "auto",
    max_states: flags.MaxStates = MAX_STATES,
    timeout: flags.Timeout = None,
    json_: flags.Json = False,
) -> None:
    """Summarise an automaton on the terminal, and draw it with -o.

    Acceptance, translator and the limit on states matter only where SOURCE is a
    formula.

    \b
    Examples:
      ltlc show dra.json
      ltlc show dra.hoa -o dra.svg
      ltlc show "GF a -> GF b" --acceptance transition
      ltl2tgba "FG a | GF b" | ltlc show - --determinise -o dra.svg
    """
    from ltlc.budget import Overtime, overtime, time_limit
    from ltlc.translate import Options

    targets = output or []
    if json_ and "-" in targets:
        raise InvalidArgumentError("--json and the automaton cannot both go to standard output")
    check_targets(targets)
    options = Options(acceptance, translator, max_states=max_states, timeout=timeout).checked()
    with time_limit(source, timeout):
        dra = given_automaton(source, determinise=determinise, max_states=max_states, timeout=timeout)
        if isinstance(dra, str):
            dra = _compiled(dra, options, finite, declared(exclusive, letters))
        with overtime(Overtime.WRITE):
            write_targets(dra, targets)
            if json_:
                print(json.dumps(as_data(dra), ensure_ascii=False, indent=2))
            elif "-" not in targets:
                print_summary(dra)


def _compiled(text: str, options: Options, finite: bool, possible: DeclaredLetters) -> DRA | DFA:
    from ltlc.compiler import compile

    common = {"max_states": options.max_states, "timeout": options.timeout, **possible._asdict()}
    if finite:
        return compile(text, finite=True, **common)
    return compile(text, acceptance=options.acceptance, translator=options.translator, **common)
