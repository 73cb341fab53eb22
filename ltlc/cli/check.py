"""`ltlc check`: is a word in the language?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from ltlc.cli import flags
from ltlc.cli.alphabet import check_possible, declared
from ltlc.cli.inputs import formula_text, given_automaton
from ltlc.cli.messages import complain
from ltlc.cli.options import Argument, Option
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.automata import DFA, DRA
    from ltlc.ltl import Formula, LassoWord, Letter


def check(
    source: Annotated[str, Argument(metavar="SOURCE", help="A formula, a .json or .hoa file, or - to read one.")],
    word: Annotated[
        list[str],
        Option(
            "--word", "-w", metavar="WORD", help="Letters and a cycle, as in 'a; b & c; cycle{!a}'. May be repeated."
        ),
    ],
    table: Annotated[bool, Option("--table", help="Show where on each word every part of the formula holds.")] = False,
    finite: flags.Finite = False,
    determinise: flags.Determinise = False,
    exclusive: flags.Exclusive = None,
    letters: flags.Letters = None,
    timeout: flags.Timeout = None,
    json_: flags.Json = False,
) -> int:
    """Decide whether words satisfy a formula or are accepted by an automaton.

    Words are infinite, and with --finite, or an automaton over finite traces,
    finite. A letter lists what holds, joined by &; what it leaves out does not hold.
    A formula is judged by its definition, an automaton by its run. The exit
    code is 0 if every word is accepted, and 1 if one is rejected.

    \b
    Examples:
      ltlc check "G(a -> F b)" --word "a; b; cycle{!a}"
      ltlc check dra.json -w "cycle{goal}" -w "trap; cycle{goal}"
      ltlc check --finite "F a" --word "b; a" --table
    """
    from ltlc.automata import DFA
    from ltlc.budget import time_limit
    from ltlc.ltl import Formula, LassoWord, Proposition, parse, parse_trace, parse_word, propositions
    from ltlc.translate import Options

    if json_ and table:
        raise InvalidArgumentError("--table is for people; leave --json out")
    Options(timeout=timeout).checked()
    possible = declared(exclusive, letters)
    with time_limit(source, timeout):
        given = given_automaton(source, determinise=determinise, timeout=timeout)
        subject = parse(given, finite=finite) if isinstance(given, str) else given
        finite = finite if isinstance(subject, Formula) else isinstance(subject, DFA)
        known = propositions(subject) if isinstance(subject, Formula) else subject.aps
        if table and not isinstance(subject, Formula):
            raise InvalidArgumentError("--table is about the parts of a formula, and an automaton has none")
        verdicts = []
        tables = []
        for argument in word:
            text = formula_text(argument)
            read = parse_trace(text) if finite else parse_word(text)
            seen = read.letters if isinstance(read, LassoWord) else read
            check_possible(known, possible, seen)
            strange = {name for letter in seen for name in letter} - set(known)
            if strange:
                names = ", ".join(str(Proposition(name)) for name in sorted(strange))
                complain(f"warning: nothing in {source} depends on {names}")
            if table and isinstance(subject, Formula):
                tables.append(_table(subject, read, seen))
            verdicts.append((" ".join(text.split()), *_judge(subject, read, known)))
    if json_:
        entries = [dict(zip(("word", "accepted", "violated"), verdict, strict=True)) for verdict in verdicts]
        print(json.dumps(entries, ensure_ascii=False, indent=2))
    else:
        for text, accepted, violated in verdicts:
            reason = f"  (does not satisfy {' and '.join(violated)})" if violated else ""
            print(f"{'accepted' if accepted else 'rejected'}: {text}{reason}")
            if table:
                print(tables.pop(0))
    return 0 if all(accepted for _, accepted, _ in verdicts) else 1


def _judge(
    subject: Formula | DRA | DFA, word: LassoWord | tuple[Letter, ...], known: Sequence[str]
) -> tuple[bool, list[str]]:
    """Whether the word is accepted; and if a conjunction is not satisfied, which of its parts are not."""
    from ltlc.automata import DFA
    from ltlc.ltl import And, Formula, LassoWord, satisfies, satisfies_trace

    if isinstance(subject, Formula):
        parts = subject.args if isinstance(subject, And) else (subject,)
        holds = [
            satisfies(part, word) if isinstance(word, LassoWord) else satisfies_trace(part, word) for part in parts
        ]
        violated = [str(part) for part, held in zip(parts, holds, strict=True) if not held]
        return not violated, violated if len(parts) > 1 else []
    if isinstance(subject, DFA):
        assert not isinstance(word, LassoWord)
        return subject.accepts([letter & set(known) for letter in word]), []
    assert isinstance(word, LassoWord)
    prefix, cycle = ([letter & set(known) for letter in letters] for letters in (word.prefix, word.cycle))
    return subject.accepts(prefix, cycle), []


def _table(formula: Formula, word: LassoWord | tuple[Letter, ...], letters: tuple[Letter, ...]) -> str:
    """A row for each part of the formula, a column for each letter; | stands before the cycle."""
    from ltlc.ltl import Proposition, truth_by_position

    truth, start = truth_by_position(formula, word)
    n = len(truth[formula])
    shown = [letters[i] if i < len(letters) else word.cycle[(i - n) % len(word.cycle)] for i in range(n)]  # type: ignore[union-attr]
    heads = [" ".join(str(Proposition(name)) for name in sorted(letter)) or "-" for letter in shown]
    rows = [("", heads), *((str(part), ["1" if holds else "." for holds in row]) for part, row in truth.items())]
    width = max(len(name) for name, _ in rows)
    widths = [max(len(cells[i]) for _, cells in rows) for i in range(n)]
    lines = []
    for name, cells in rows:
        columns = [("| " if i == start else "") + cell.center(widths[i]) for i, cell in enumerate(cells)]
        lines.append(f"  {name.ljust(width)}  {'  '.join(columns)}".rstrip())
    return "\n".join(lines)
