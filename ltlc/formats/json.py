"""The automaton as JSON: the format of record. `dra.schema.json` beside this module is its JSON Schema.

Major versions change the meaning of what was there before and are refused by older readers; minor versions only add
keys, which older readers pass over. What a reader can compute itself (`tool`, `deadlocks`, `accepting_sinks`,
`distance`) is there for people and other programs; it is not trusted on reading, so a file edited by hand stays right.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from ltlc.arrays import BoolArray, IntArray, np
from ltlc.automata.finite import DFA, from_table
from ltlc.automata.possible import MAX_APS, LetterNumbers, Possible
from ltlc.automata.rabin import DRA, AcceptanceKind
from ltlc.errors import FileFormatError, InvalidArgumentError, LtlSyntaxError
from ltlc.formats.edges import MAX_TABLE, a_letter_of, edges, letters_of, tabulate
from ltlc.formats.json_document import Node, describe, load_json
from ltlc.formats.wide_edges import Names
from ltlc.version import __version__

FORMAT, FORMAT_OF_TRACES = "ltlc-dra", "ltlc-dfa"
MAJOR, MINOR = 1, 1


def to_json(automaton: DRA | DFA) -> str:
    """The automaton as JSON text, one line per state, transition and pair; the same automaton gives the same bytes."""
    is_finite = isinstance(automaton, DFA)
    head = {
        "format": FORMAT_OF_TRACES if is_finite else FORMAT,
        "version": f"{MAJOR}.{MINOR if automaton.possible is not None else 0}",
        "tool": f"ltlc {__version__}",
        "formula": automaton.formula,
        "translator": automaton.translator,
        "acceptance": automaton.acceptance,
        "aps": list(automaton.aps),
        "possible": _possible(automaton),
        "initial_state": int(automaton.initial_state),
        "n_states": automaton.n_states,
        "n_pairs": automaton.n_pairs,
    }
    if automaton.possible is None:
        del head["possible"]
    if is_finite:
        del head["translator"], head["acceptance"], head["n_pairs"]
    lines = [f'  "{key}": {_compact(value)}' for key, value in head.items()]
    lines.append(_block("states", _states(automaton)))
    lines.append(_block("transitions", _transitions(automaton)))
    if is_finite:
        lines.append(f'  "accepting": {_compact(np.flatnonzero(automaton.inf[0]).tolist())}')
    elif not isinstance(automaton, DFA) and automaton.acceptance == "state":
        lines.append(_block("pairs", [_compact({"B": sorted(p.fin), "G": sorted(p.inf)}) for p in automaton.pairs]))
    lines.append(f'  "deadlocks": {_compact(automaton.deadlocks)}')
    lines.append(f'  "accepting_sinks": {_compact(automaton.accepting_sinks)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _possible(automaton: DRA | DFA) -> list[list[list[str]]]:
    """The possible letters: for each part of the alphabet, its combinations, as names."""
    aps = automaton.aps
    return [
        [[name for i, name in enumerate(aps) if mask >> i & 1] for mask in part] for part in automaton.possible or ()
    ]


def _states(automaton: DRA | DFA) -> list[str]:
    """Each state as JSON."""
    names, deadlocks, sinks = automaton.state_names, set(automaton.deadlocks), set(automaton.accepting_sinks)
    result = []
    for q, distance in enumerate(automaton.annotations.distances):
        name = "" if names is None else f', "name": {_compact(names[q])}'
        known = ', "deadlock": true' * (q in deadlocks) + ', "accepting_sink": true' * (q in sinks)
        result.append(f'{{"id": {q}{name}, "distance": {distance if distance >= 0 else "null"}{known}}}')
    return result


def _transitions(automaton: DRA | DFA) -> list[str]:
    """Each transition as JSON; written by hand, since there may be very many."""
    names = Names([_compact(name)[1:-1] for name in automaton.alphabet.names])
    on_edges = automaton.acceptance == "transition"
    marks: dict[tuple[tuple[int, ...], tuple[int, ...]], str] = {}
    result = []
    for source, target, guard, fin, inf in edges(automaton, names):
        pairs = fin, inf
        if pairs not in marks:
            marks[pairs] = f', "B": {list(fin)}, "G": {list(inf)}' if on_edges else ""
        result.append(f'{{"source": {source}, "target": {target}, "guard": "{guard}"{marks[pairs]}}}')
    return result


_compact = json.JSONEncoder(ensure_ascii=False).encode
"""A value on one line; made once, as an encoder is not cheap."""


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
    document = Node(load_json(text), "")
    is_finite = _check_version(document)
    aps = tuple(item.name() for item in document["aps"].items())
    document["aps"].check(len(set(aps)) == len(aps), "a proposition is listed twice")
    possible = _read_possible(document["possible"], aps) if document.has("possible") else None
    fits = possible is not None or len(aps) <= MAX_APS
    document["aps"].check(
        fits, f"{len(aps)} propositions; at most {MAX_APS} are supported where every letter is possible"
    )
    numbers = LetterNumbers(aps, possible)
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
    guards = _guards(transitions, sources, numbers)
    _check_complete(document["transitions"], sources, guards, n_states, numbers)
    letter_class, edge = tabulate(numbers.size, n_states, sources, guards)
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
        possible=possible,
    )
    return from_table(automaton) if is_finite else automaton


def _read_possible(node: Node, aps: tuple[str, ...]) -> Possible:
    """The parts of the alphabet."""
    index = {name: i for i, name in enumerate(aps)}
    parts = []
    for part in node.items():
        masks = set()
        for combination in part.items():
            names = [(item.name(), item) for item in combination.items()]
            for name, item in names:
                item.check(name in index, f"{name!r} is not one of aps")
            masks.add(sum(1 << index[name] for name in {name for name, _ in names}))
        parts.append(tuple(sorted(masks)))
    try:
        LetterNumbers(aps, tuple(parts))
    except InvalidArgumentError:
        raise node.fail("expected parts that have no proposition in common, each a list of lists of names") from None
    return tuple(parts)


def _read_marks(
    document: Node, acceptance: AcceptanceKind, transitions: list[Node], edge: IntArray
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


def _check_version(document: Node) -> bool:
    """Whether the automaton reads finite traces, if the version can be read."""
    document.check(isinstance(document.value, dict), "expected an object with the key 'format'")
    document.check(document.has("format"), f"not an automaton: the key 'format' is missing, it should be {FORMAT!r}")
    found = document["format"]
    known = found.value in (FORMAT, FORMAT_OF_TRACES)
    found.check(known, f"expected {FORMAT!r}, found {describe(found.value)}")
    version = document["version"]
    major, dot, minor = version.text().partition(".")
    numbers = [part.isascii() and part.isdigit() and len(part) <= 6 for part in (major, minor)]
    version.check(all(numbers) and bool(dot), f"expected a version like '1.0', found {describe(version.value)}")
    version.check(
        int(major) <= MAJOR,
        f"the file has version {version.value}, this is ltlc {__version__}, which reads up to {MAJOR}.x. "
        "Update ltlc, or write the file with an older one.",
    )
    version.check(int(major) == MAJOR, f"there is no version {version.value}; the first one is 1.0")
    return bool(found.value == FORMAT_OF_TRACES)


def _guards(transitions: list[Node], sources: list[int], numbers: LetterNumbers) -> list[int]:
    """The letters of each guard, checked to be disjoint for each source."""
    known: dict[str, int] = {}
    seen: dict[int, int] = {}
    result: list[int] = []
    for transition, source in zip(transitions, sources, strict=True):
        node = transition["guard"]
        text = node.text()
        if text not in known:
            known[text] = _parse_guard(node, text, numbers)
        letters = known[text]
        overlap = letters & seen.get(source, 0)
        if overlap:
            other = next(j for j, q in enumerate(sources) if q == source and result[j] & overlap)
            raise node.fail(
                f"not deterministic: state {source} has this transition and transitions[{other}] for the letter "
                + a_letter_of(overlap & result[other], numbers)
            )
        seen[source] = seen.get(source, 0) | letters
        result.append(letters)
    return result


def _parse_guard(node: Node, text: str, numbers: LetterNumbers) -> int:
    from ltlc.ltl.parser import parse_silently

    def atom(name: str) -> int:
        if name not in numbers.aps:
            raise node.fail(f"{name!r} is not one of aps")
        return numbers.holding(numbers.aps.index(name))

    try:
        return letters_of(parse_silently(text), atom, numbers.all)
    except LtlSyntaxError as error:
        raise node.fail(f"column {error.column}: {error.message}") from None
    except FileFormatError:
        raise
    except ValueError as error:
        raise node.fail(f"a guard is about one letter, it cannot hold the temporal operator {error}") from None


def _check_complete(node: Node, sources: list[int], guards: list[int], n_states: int, numbers: LetterNumbers) -> None:
    covered = [0] * n_states
    for source, letters in zip(sources, guards, strict=True):
        covered[source] |= letters
    universe = numbers.all
    for q, letters in enumerate(covered):
        if letters != universe:
            missing = a_letter_of(universe ^ letters, numbers)
            raise node.fail(f"not complete: state {q} has no transition for the letter {missing}")
