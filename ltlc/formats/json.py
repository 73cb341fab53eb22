"""The automaton as JSON: the format of record. `dra.schema.json` beside this module is its JSON Schema.

Major versions change the meaning of what was there before and are refused by older readers; minor versions only add
keys, which older readers pass over. What a reader can compute itself (`tool`, `deadlocks`, `accepting_sinks`,
`distance`) is there for people and other programs; it is not trusted on reading, so a file edited by hand stays right.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ltlc.automata.alphabet import Alphabet, quoted
from ltlc.automata.rabin import MAX_APS, Acceptance, RabinAutomaton
from ltlc.errors import FileFormatError, LtlSyntaxError
from ltlc.formats.edges import a_letter_of, all_letters, edges, letters_of, letters_with, tabulate
from ltlc.version import __version__

FORMAT = "ltlc-dra"
MAJOR, MINOR = 1, 0


def to_json(automaton: RabinAutomaton) -> str:
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
    head = {
        "format": FORMAT,
        "version": f"{MAJOR}.{MINOR}",
        "tool": f"ltlc {__version__}",
        "formula": automaton.formula,
        "translator": automaton.translator,
        "acceptance": automaton.acceptance,
        "aps": list(automaton.aps),
        "initial_state": automaton.initial_state,
        "n_states": automaton.n_states,
        "n_pairs": automaton.n_pairs,
    }
    lines = [f"  {_compact(key)}: {_compact(value)}" for key, value in head.items()]
    lines.append(_block("states", states))
    lines.append(_block("transitions", _transitions(automaton)))
    if automaton.acceptance == "state":
        lines.append(_block("pairs", [{"B": sorted(pair.fin), "G": sorted(pair.inf)} for pair in automaton.pairs]))
    lines.append(f'  "deadlocks": {_compact(list(deadlocks))}')
    lines.append(f'  "accepting_sinks": {_compact(list(sinks))}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _transitions(automaton: RabinAutomaton) -> list[dict[str, Any]]:
    alphabet = Alphabet(automaton.aps, automaton.letter_class)
    names = [quoted(name) for name in automaton.aps]
    known: dict[tuple[int, ...], str] = {}
    result = []
    for edge in edges(automaton):
        guard = known.get(edge.classes)
        if guard is None:
            guard = known[edge.classes] = alphabet.guard(edge.classes).text(names)
        transition: dict[str, Any] = {"source": edge.source, "target": edge.target, "guard": guard}
        if automaton.acceptance == "transition":
            transition |= {"B": list(edge.fin), "G": list(edge.inf)}
        result.append(transition)
    return result


def _compact(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _block(key: str, entries: Sequence[object]) -> str:
    body = ",\n".join(f"    {_compact(entry)}" for entry in entries)
    return f'  "{key}": [\n{body}\n  ]' if entries else f'  "{key}": []'


def from_json(text: str) -> RabinAutomaton:
    """The automaton a JSON text describes.

    Raises:
        FileFormatError: it is not JSON, not this format, of a newer major version, or not a complete deterministic
            automaton; the message names the line or the key.
        AlphabetLimitExceeded: it has too many propositions.
    """
    document = _Node(_load(text), "")
    _check_version(document)
    aps = tuple(item.text() for item in document["aps"].items())
    document["aps"].check(len(set(aps)) == len(aps), "a proposition is listed twice")
    document["aps"].check(len(aps) <= MAX_APS, f"{len(aps)} propositions; at most {MAX_APS} are supported")
    acceptance: Acceptance = document["acceptance"].one_of("state", "transition")  # type: ignore[assignment]
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

    if acceptance == "state":
        owners, n_marked = document["pairs"].items(), n_states
        n_pairs = len(owners)
        document["n_pairs"].check(document["n_pairs"].index() == n_pairs, f"there are {n_pairs} pairs")
    else:
        owners, n_marked = transitions, len(transitions)
        n_pairs = document["n_pairs"].index(1 << 16)
    fin = np.zeros((n_pairs, n_marked), dtype=np.bool_)
    inf = np.zeros((n_pairs, n_marked), dtype=np.bool_)
    for i, owner in enumerate(owners):
        for marks, key in ((fin, "B"), (inf, "G")):
            for item in owner[key].items():
                if acceptance == "state":
                    marks[i, item.index(n_states, "states")] = True
                else:
                    marks[item.index(n_pairs, "pairs"), i] = True
    if acceptance == "transition":
        fin, inf = fin[:, edge], inf[:, edge]
    return RabinAutomaton(
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
