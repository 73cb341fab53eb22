"""What Lark works out from the grammar `ltlc/grammars/ltl.lark`: its terminals and its LALR(1) table.

Both are kept in `ltlc/grammars/ltl.json`, as loading Lark and working them out takes longer than reading and
translating a formula. After a change of the grammar, Lark is asked again until
`python -c "from ltlc.ltl.tables import keep; keep('grammars')"` has made the file anew.

References:
    Frank DeRemer and Thomas Pennello, Efficient computation of LALR(1) look-ahead sets, ACM TOPLAS 4(4), 1982,
    doi:10.1145/69622.357187.
"""

from __future__ import annotations

import json
import os
import zlib
from importlib import import_module
from typing import Any, NamedTuple

UNKNOWN = "_UNKNOWN"
"""The kind of a character with which no token starts."""


class Rule(NamedTuple):
    """A rule of the grammar.

    Attributes:
        size: how many symbols it joins.
        kept: places of those that have a value.
        spliced: of these, the places of sequences whose members count instead.
        name: by which the function is known that makes its value; empty if the value is that of its one operand, or
            the sequence of its operands.
        result: the nonterminal that the value stands for.
        is_chain: whether it only renames the nonterminal of a single value.
    """

    size: int
    kept: tuple[int, ...]
    spliced: tuple[int, ...]
    name: str
    result: str
    is_chain: bool


class Tables(NamedTuple):
    """The terminals and the table; state 0 is the first.

    Attributes:
        pattern: matches a token, or a character that begins none; the name of the group is its kind.
        last_state: in which a text is read.
        rules: of the grammar.
        actions: per state, for the kind of the next token or the nonterminal just completed: the next state, or
            -1 - i for a reduction by rule i.
    """

    pattern: str
    last_state: int
    rules: list[Rule]
    actions: list[dict[str, int]]


def load() -> Tables:
    """The tables, from the file if it was made from the grammar as it is."""
    (folder,) = import_module("ltlc.grammars").__path__
    grammar = _text(os.path.join(folder, "ltl.lark"))
    ready = os.path.join(folder, "ltl.json")
    if os.path.isfile(ready):
        document = json.loads(_text(ready))
        if document["checksum"] == _checksum(grammar):
            rules = [Rule(size, tuple(kept), tuple(spliced), *rest) for size, kept, spliced, *rest in document["rules"]]
            return Tables(document["pattern"], document["last_state"], rules, document["actions"])
    return work_out(grammar)


def work_out(grammar: str) -> Tables:
    """The tables of a grammar, by Lark; states and rules are numbered as they are met."""
    from lark import Lark
    from lark.parsers.lalr_analysis import Shift

    lark = Lark(grammar, parser="lalr", lexer="basic", maybe_placeholders=False)
    # In the order in which Lark tries them.
    terminals = sorted(lark.terminals, key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name))
    ignored = "|".join(t.pattern.to_regexp() for t in terminals if t.name in lark.ignore_tokens)
    named = [f"(?P<{t.name}>{t.pattern.to_regexp()})" for t in terminals if t.name not in lark.ignore_tokens]
    table = lark.parse_interactive("").parser_state.parse_conf
    number = {table.start_state: 0}
    states = [table.start_state]
    rules: dict[Any, int] = {}
    actions: list[dict[str, int]] = []
    for state in states:  # grows while it is read
        row: dict[str, int] = {}
        for symbol, (action, target) in sorted(table.states[state].items(), key=lambda item: str(item[0])):
            if action is not Shift:
                row[str(symbol)] = -1 - rules.setdefault(target, len(rules))
                continue
            if target not in number:
                number[target] = len(states)
                states.append(target)
            row[str(symbol)] = number[target]
        actions.append(row)
    pattern = "|".join([ignored, *named, f"(?P<{UNKNOWN}>(?s:.))"])
    return Tables(pattern, number[table.end_state], [_rule(rule) for rule in rules], actions)


def _rule(rule: Any) -> Rule:
    symbols = list(enumerate(rule.expansion))
    kept = tuple(i for i, symbol in symbols if not (symbol.is_term and symbol.filter_out))
    spliced = tuple(i for i, symbol in symbols if not symbol.is_term and symbol.name.startswith("_"))
    is_chain = len(symbols) == 1 and rule.options.expand1 and rule.alias is None
    return Rule(len(symbols), kept, spliced, str(rule.alias or ""), str(rule.origin.name), is_chain)


def as_json(grammar: str) -> str:
    """The text of the file."""
    tables = work_out(grammar)
    document = {"checksum": _checksum(grammar), **tables._asdict()}
    return json.dumps(document, ensure_ascii=False, separators=(",", ":")) + "\n"


def _checksum(grammar: str) -> int:
    return zlib.crc32(grammar.encode())


def keep(folder: str) -> None:
    """Make the file anew.

    Args:
        folder: of the grammars.
    """
    made = as_json(_text(os.path.join(folder, "ltl.lark")))
    with open(os.path.join(folder, "ltl.json"), "w", encoding="utf-8") as file:
        file.write(made)


def _text(path: str) -> str:
    with open(path, encoding="utf-8") as file:
        return file.read()
