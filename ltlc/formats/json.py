"""The automaton as JSON: the format of record. `dra.schema.json` beside this module is its JSON Schema.

Major versions change the meaning of what was there before and are refused by older readers; minor versions only add
keys, which older readers pass over. What a reader can compute itself (`tool`, `deadlocks`, `accepting_sinks`,
`distance`) is there for people and other programs; it is not trusted on reading, so a file edited by hand stays right.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ltlc.automata.alphabet import guard_text
from ltlc.automata.finite import DFA, from_table
from ltlc.automata.rabin import DRA, MAX_APS, AcceptanceKind, BoolArray, IntArray
from ltlc.budget import check_time
from ltlc.errors import FileFormatError, LtlSyntaxError
from ltlc.formats.edges import MAX_TABLE, a_letter_of, all_letters, edges, letters_of, letters_with, tabulate
from ltlc.version import __version__

FORMAT, FORMAT_OF_TRACES = "ltlc-dra", "ltlc-dfa"
MAJOR, MINOR = 1, 0


def to_json(automaton: DRA | DFA) -> str:
    """The automaton as JSON text, one line per state, transition and pair; the same automaton gives the same bytes."""
    names = automaton.state_names
    deadlocks, sinks = automaton.deadlocks, automaton.accepting_sinks
    states: list[dict[str, Any]] = []
    for q, distance in enumerate(automaton.annotations.distance.tolist()):
        state: dict[str, Any] = {"id": q}
        if names is not None:
            state["name"] = names[q]
        state["distance"] = distance if distance >= 0 else None
        if q in deadlocks:
            state["deadlock"] = True
        if q in sinks:
            state["accepting_sink"] = True
        states.append(state)
    is_finite = isinstance(automaton, DFA)
    head = {
        "format": FORMAT_OF_TRACES if is_finite else FORMAT,
        "version": f"{MAJOR}.{MINOR}",
        "tool": f"ltlc {__version__}",
        "formula": automaton.formula,
        "translator": automaton.translator,
        "acceptance": automaton.acceptance,
        "aps": list(automaton.aps),
        "initial_state": int(automaton.initial_state),
        "n_states": automaton.n_states,
        "n_pairs": automaton.n_pairs,
    }
    if is_finite:
        del head["translator"], head["acceptance"], head["n_pairs"]
    lines = [f"  {_compact(key)}: {_compact(value)}" for key, value in head.items()]
    lines.append(_block("states", list(map(_compact, states))))
    lines.append(_block("transitions", _transitions(automaton)))
    if is_finite:
        lines.append(f'  "accepting": {_compact(np.flatnonzero(automaton.inf[0]).tolist())}')
    elif not isinstance(automaton, DFA) and automaton.acceptance == "state":
        lines.append(_block("pairs", [_compact({"B": sorted(p.fin), "G": sorted(p.inf)}) for p in automaton.pairs]))
    lines.append(f'  "deadlocks": {_compact(list(deadlocks))}')
    lines.append(f'  "accepting_sinks": {_compact(list(sinks))}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _transitions(automaton: DRA | DFA) -> list[str]:
    """Each transition as JSON; written by hand, since there may be very many."""
    known: dict[tuple[int, ...], str] = {}
    result = []
    on_edges = automaton.acceptance == "transition"
    for source, target, classes, fin, inf in edges(automaton):
        check_time()
        guard = known.get(classes)
        if guard is None:
            guard = known[classes] = _compact(guard_text(automaton, classes))
        marks = f', "B": {list(fin)}, "G": {list(inf)}' if on_edges else ""
        result.append(f'{{"source": {source}, "target": {target}, "guard": {guard}{marks}}}')
    return result


def _compact(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _block(key: str, entries: Sequence[str]) -> str:
    body = ",\n".join(f"    {entry}" for entry in entries)
    return f'  "{key}": [\n{body}\n  ]' if entries else f'  "{key}": []'


def from_json(text: str) -> DRA | DFA:
    """The automaton a JSON text describes.

    Raises:
        FileFormatError: it is not JSON, not this format, of a newer major version, or not a complete deterministic
            automaton; the message names the line or the key.
        AlphabetLimitExceeded: it has too many propositions.
    """
    document = _Node(_load(text), "")
    is_finite = _check_version(document)
    aps = tuple(item.name() for item in document["aps"].items())
    document["aps"].check(len(set(aps)) == len(aps), "a proposition is listed twice")
    document["aps"].check(len(aps) <= MAX_APS, f"{len(aps)} propositions; at most {MAX_APS} are supported")
    acceptance: AcceptanceKind = "state"
    if not is_finite:
        acceptance = document["acceptance"].one_of("state", "transition")  # type: ignore[assignment]
    states = document["states"].items()
    n_states = len(states)
    document["states"].check(n_states > 0, "there is no state")
    document["n_states"].check(document["n_states"].index() == n_states, f"there are {n_states} states")
    for q, state in enumerate(states):
        state["id"].check(state["id"].index() == q, f"states are listed in order, so this one is {q}")
    named = [state.has("name") for state in states]
    document["states"].check(all(named) or not any(named), "either all states have a name or none")

    transitions = document["transitions"].items()
    sources = [item["source"].index(n_states, "states") for item in transitions]
    targets = [item["target"].index(n_states, "states") for item in transitions]
    guards = _guards(transitions, sources, aps)
    _check_complete(document["transitions"], sources, guards, n_states, aps)
    letter_class, edge = tabulate(len(aps), n_states, sources, guards)
    if is_finite:
        inf = np.zeros((1, n_states), dtype=np.bool_)
        inf[0, [item.index(n_states, "states") for item in document["accepting"].items()]] = True
        fin = np.zeros_like(inf)
    else:
        fin, inf = _read_marks(document, acceptance, transitions, edge)
    automaton = DRA(
        aps=aps,
        delta=np.array(targets, dtype=np.int32)[edge],
        letter_class=letter_class,
        fin=fin,
        inf=inf,
        initial_state=document["initial_state"].index(n_states, "states"),
        acceptance=acceptance,
        formula=document["formula"].text_or_none() if document.has("formula") else None,
        state_names=tuple(state["name"].text() for state in states) if all(named) else None,
        translator=document["translator"].text_or_none() if document.has("translator") else None,
    )
    return from_table(automaton) if is_finite else automaton


def _read_marks(
    document: _Node, acceptance: AcceptanceKind, transitions: list[_Node], edge: IntArray
) -> tuple[BoolArray, BoolArray]:
    """Fin and inf; `edge` is the transition taken from each state on each letter class."""
    on_states = acceptance == "state"
    n_states = len(edge)
    owners = document["pairs"].items() if on_states else transitions
    n_pairs = document["n_pairs"].index()
    if on_states:
        document["n_pairs"].check(n_pairs == len(owners), f"there are {len(owners)} pairs")
    n_marked = n_states if on_states else len(transitions)
    document["n_pairs"].check(n_pairs * max(n_marked, edge.size) <= MAX_TABLE, "too many pairs for tables in memory")
    fin = np.zeros((n_pairs, n_marked), dtype=np.bool_)
    inf = np.zeros((n_pairs, n_marked), dtype=np.bool_)
    for i, owner in enumerate(owners):
        for marks, key in ((fin, "B"), (inf, "G")):
            for item in owner[key].items():
                if on_states:
                    marks[i, item.index(n_states, "states")] = True
                else:
                    marks[item.index(n_pairs, "pairs"), i] = True
    return (fin, inf) if on_states else (fin[:, edge], inf[:, edge])


def _load(text: str) -> object:
    try:
        return json.loads(text, object_pairs_hook=_object, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise FileFormatError(f"line {error.lineno}, column {error.colno}: not JSON: {error.msg}") from None
    except RecursionError:
        raise FileFormatError("not an automaton: brackets are nested too deeply") from None
    except ValueError as error:  # an integer with thousands of digits, or one of the two hooks below
        raise FileFormatError(f"not JSON that can be read: {error}") from None


def _object(members: list[tuple[str, object]]) -> dict[str, object]:
    result = dict(members)
    if len(result) < len(members):
        twice = Counter(key for key, _ in members).most_common(1)[0][0]
        raise ValueError(f"the key {twice!r} occurs twice in one object")
    return result


def _no_constant(name: str) -> object:
    raise ValueError(f"{name} is not a JSON number")


class _Node:
    """A value of the document together with its key path, which every message names."""

    def __init__(self, value: object, path: str) -> None:
        self.value = value
        self.path = path

    def fail(self, message: str) -> FileFormatError:
        return FileFormatError(f"{self.path}: {message}" if self.path else message)

    def check(self, condition: bool, message: str) -> None:
        if not condition:
            raise self.fail(message)

    def _expect(self, kind: type, wanted: str) -> Any:
        # JSON's true is an int for Python, but not for a reader.
        if not isinstance(self.value, kind) or isinstance(self.value, bool):
            raise self.fail(f"expected {wanted}, found {_describe(self.value)}")
        return self.value

    def _members(self) -> Mapping[str, object]:
        members: Mapping[str, object] = self._expect(dict, "an object")
        return members

    def has(self, key: str) -> bool:
        return key in self._members()

    def __getitem__(self, key: str) -> _Node:
        members = self._members()
        if key not in members:
            raise self.fail(f"the key {key!r} is missing")
        return _Node(members[key], f"{self.path}.{key}" if self.path else key)

    def items(self) -> list[_Node]:
        return [_Node(item, f"{self.path}[{i}]") for i, item in enumerate(self._expect(list, "a list"))]

    def text(self) -> str:
        value: str = self._expect(str, "a string")
        # Half of a surrogate pair cannot be written to any file again.
        self.check(not any("\ud800" <= letter <= "\udfff" for letter in value), "half of a surrogate pair")
        return value

    def name(self) -> str:
        value = self.text()
        self.check(bool(value), "a proposition needs a name")
        return value

    def text_or_none(self) -> str | None:
        return None if self.value is None else self.text()

    def one_of(self, *known: str) -> str:
        value = self.text()
        self.check(value in known, f"expected {' or '.join(map(repr, known))}, found {_describe(value)}")
        return value

    def index(self, count: int | None = None, what: str = "") -> int:
        value: int = self._expect(int, "a number")
        self.check(value >= 0, f"{_describe(value)} is negative")
        self.check(count is None or value < count, f"{_describe(value)} is out of range, there are {count} {what}")
        return value


def _describe(value: object) -> str:
    if isinstance(value, (dict, list)):
        return "an object" if isinstance(value, dict) else "a list"
    if isinstance(value, int) and value.bit_length() > 100:
        return "a huge number"
    shown = json.dumps(value)
    return shown if len(shown) <= 40 else shown[:37] + "..."


def _check_version(document: _Node) -> bool:
    """Whether the automaton reads finite traces, if the version can be read."""
    document.check(isinstance(document.value, dict), "expected an object with the key 'format'")
    document.check(document.has("format"), f"not an automaton: the key 'format' is missing, it should be {FORMAT!r}")
    found = document["format"]
    known = found.value in (FORMAT, FORMAT_OF_TRACES)
    found.check(known, f"expected {FORMAT!r}, found {_describe(found.value)}")
    version = document["version"]
    major, dot, minor = version.text().partition(".")
    numbers = [part.isascii() and part.isdigit() and len(part) <= 6 for part in (major, minor)]
    version.check(all(numbers) and bool(dot), f"expected a version like '1.0', found {_describe(version.value)}")
    version.check(
        int(major) <= MAJOR,
        f"the file has version {version.value}, this is ltlc {__version__}, which reads up to {MAJOR}.x. "
        "Update ltlc, or write the file with an older one.",
    )
    version.check(int(major) == MAJOR, f"there is no version {version.value}; the first one is 1.0")
    return bool(found.value == FORMAT_OF_TRACES)


def _guards(transitions: list[_Node], sources: list[int], aps: tuple[str, ...]) -> list[int]:
    """The letters of each guard, checked to be disjoint for each source."""
    known: dict[str, int] = {}
    seen: dict[int, int] = {}
    result: list[int] = []
    for transition, source in zip(transitions, sources, strict=True):
        node = transition["guard"]
        text = node.text()
        if text not in known:
            known[text] = _parse_guard(node, text, aps)
        letters = known[text]
        overlap = letters & seen.get(source, 0)
        if overlap:
            other = next(j for j, q in enumerate(sources) if q == source and result[j] & overlap)
            raise node.fail(
                f"not deterministic: state {source} has this transition and transitions[{other}] for the letter "
                + a_letter_of(overlap & result[other], aps)
            )
        seen[source] = seen.get(source, 0) | letters
        result.append(letters)
    return result


def _parse_guard(node: _Node, text: str, aps: tuple[str, ...]) -> int:
    from ltlc.ltl.parser import parse_silently

    def atom(name: str) -> int:
        if name not in aps:
            raise node.fail(f"{name!r} is not one of aps")
        return letters_with(aps.index(name), len(aps))

    try:
        return letters_of(parse_silently(text), atom, len(aps))
    except LtlSyntaxError as error:
        raise node.fail(f"column {error.column}: {error.message}") from None
    except FileFormatError:
        raise
    except ValueError as error:
        raise node.fail(f"a guard is about one letter, it cannot hold the temporal operator {error}") from None


def _check_complete(node: _Node, sources: list[int], guards: list[int], n_states: int, aps: tuple[str, ...]) -> None:
    covered = [0] * n_states
    for source, letters in zip(sources, guards, strict=True):
        covered[source] |= letters
    universe = all_letters(len(aps))
    for q, letters in enumerate(covered):
        if letters != universe:
            missing = a_letter_of(universe ^ letters, aps)
            raise node.fail(f"not complete: state {q} has no transition for the letter {missing}")
