"""`ltlc compile`: formulas to automata."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any, cast, get_args

from ltlc.budget import MAX_STATES
from ltlc.cli import flags
from ltlc.cli.alphabet import declared
from ltlc.cli.batch import compile_file
from ltlc.cli.inputs import formula_text
from ltlc.cli.options import Argument, Option
from ltlc.cli.outputs import Output, check_targets, write_targets
from ltlc.cli.summary import as_data, print_summary
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA, OmegaAutomaton
    from ltlc.automata.rabin import Form

Formula = Annotated[str | None, Argument(metavar="FORMULA", help="An LTL formula, or - to read it.")]
Formulas = Annotated[
    str | None,
    Option(
        "--formulas",
        "-F",
        metavar="FILE",
        is_path=True,
        help="A file of formulas, one a line, or - to read them.",
    ),
]
Format = Annotated[
    str | None,
    Option(
        "--format",
        "-f",
        metavar="NAME",
        help="Write the automaton to standard output in this format: {formats}.",
        completion=flags.names_of("formats"),
    ),
]


def compile_(
    formula: Formula = None,
    formulas: Formulas = None,
    output: Output = None,
    form: Format = None,
    finite: flags.Finite = False,
    exclusive: flags.Exclusive = None,
    letters: flags.Letters = None,
    form_: flags.Form = "rabin",
    acceptance: flags.Acceptance = "state",
    translator: flags.Translator = "auto",
    effort: flags.Effort = "default",
    max_states: flags.MaxStates = MAX_STATES,
    timeout: flags.Timeout = None,
    json_: flags.Json = False,
) -> int:
    """Compile an LTL formula into a deterministic Rabin automaton.

    With --finite the formula is about finite traces, and the result is the
    smallest deterministic automaton for them. Without -o and --format a summary is printed.

    With -F the automata are written as a stream of HOA, in the order of the
    formulas; a line that fails is reported with its number, the rest goes on,
    and the exit code is 2. The limits hold for each line. Interrupted, standard
    output has the automata so far; files of -o are as they were, since they
    appear at the end.

    \b
    Examples:
      ltlc compile "F(A & F B) & G!C & FG T" -o dra.json -o dra.svg
      ltlc compile "G(request -> F grant)" --format hoa
      ltlc compile -F formulas.txt --acceptance transition > automata.hoa
      echo "GF a -> GF b" | ltlc compile - --json
      ltlc compile --finite "G(a -> WX b) & F last" -o dfa.svg
      ltlc compile "F(hall & F kitchen)" --exclusive hall,kitchen,office
    """
    # First, since numpy comes with it: deep below other imports CPython maps memory for single calls, again and again.
    from ltlc.automata.formats import FORMATS
    from ltlc.budget import Overtime, overtime, time_limit
    from ltlc.compiler import compile
    from ltlc.translate import GeneralForm

    limits: dict[str, Any] = {"max_states": max_states, "timeout": timeout, **declared(exclusive, letters)._asdict()}
    search: dict[str, Any] = {"translator": translator, "effort": effort, **limits}

    def translated(text: str) -> DRA | DFA | OmegaAutomaton:
        if finite:
            return compile(text, finite=True, **limits)
        if form_ in get_args(GeneralForm):
            return compile(text, form=cast("GeneralForm", form_), **search)
        return compile(text, form=cast("Form", form_), acceptance=acceptance, **search)

    targets = output or (["-"] if form else [])
    if (formula is None) == (formulas is None):
        raise InvalidArgumentError("give either a FORMULA or, with -F, a file of formulas")
    if form and "-" not in targets:
        raise InvalidArgumentError("--format is for standard output; the suffix of -o says the format of a file")
    if finite and form_ != "rabin":
        raise InvalidArgumentError("--form is about infinite words; an automaton over finite traces has one form")
    if json_ and "-" in targets:
        raise InvalidArgumentError("--json and the automaton cannot both go to standard output")
    check_targets(targets)
    if form:
        FORMATS[form]  # a wrong name is told before the work
    if formula is not None:
        text = formula_text(formula)
        with time_limit(text, timeout):
            dra = translated(text)
            with overtime(Overtime.WRITE):
                _one(dra, targets, form or "hoa", json_)
        return 0
    if form not in (None, "hoa") or any(target != "-" and not target.endswith(".hoa") for target in targets):
        raise InvalidArgumentError("-F writes a stream of automata, which only HOA can hold")
    assert formulas is not None
    return compile_file(formulas, translated, targets, json_, timeout)


def _one(dra: DRA | DFA | OmegaAutomaton, targets: list[str], form: str, json_: bool) -> None:
    write_targets(dra, targets, form)
    if json_:
        print(json.dumps(as_data(dra), ensure_ascii=False, indent=2))
    elif not targets:
        print_summary(dra)
    elif "-" not in targets:
        print(f"{', '.join(targets)}: {dra.size}")
