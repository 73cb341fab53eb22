"""PRISM's explicit files in, written by PRISM, by Storm or here."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import sparse

from ltlc.errors import AlphabetLimitExceeded, FileFormatError, InvalidArgumentError, StateLimitExceeded
from ltlc.mdp.explicit import FloatArray
from ltlc.mdp.model import LabelledMDP

_DECLARED = re.compile(r'([0-9]+)="([^"]*)"')
_REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|nan|[+-]?inf")
_FRACTION = re.compile(r"([0-9]{1,300})/([0-9]{1,300})")
_LARGEST = 1 << 31
"""Numbers of states and the like are below."""
_MAX_APS = 62
"""Labels at most: a letter is a bit mask in 64 bits."""
_MAX_TABLE = 1 << 25
"""States times actions, at most, which bounds the memory of the model."""
_FOREIGN = {
    "ctmc": "a continuous-time Markov chain",
    "ma": "a Markov automaton, which has continuous time",
    "lts": "a labelled transition system, which has no probabilities",
    "pomdp": "a partially observable MDP",
    "idtmc": "a Markov chain whose probabilities are intervals",
    "imdp": "an MDP whose probabilities are intervals",
    "pta": "a probabilistic timed automaton",
    "popta": "a partially observable timed automaton",
    "smg": "a stochastic game",
}
"""Kinds of models that are not read, by PRISM's and Storm's names for them."""


@dataclass(frozen=True)
class _Line:
    path: Path
    number: int
    """1-based."""
    text: str
    words: list[str]

    def fail(self, what: str, word: int | None = None) -> FileFormatError:
        """The error, at a word if one is to blame."""
        column = ""
        if word is not None:
            starts = [match.start() for match in re.finditer(r"\S+", self.text)]
            column = f", column {starts[word] + 1}"
        return FileFormatError(f"{self.path}, line {self.number}{column}: {what}")

    def whole(self, word: int, what: str, below: int | None = None) -> int:
        """A word as a natural number below a bound."""
        return self.natural(self.words[word], word, what, below)

    def natural(self, text: str, word: int, what: str, below: int | None = None) -> int:
        """A natural number that is written in a part of a word."""
        if not text.isascii() or not text.isdigit():
            raise self.fail(f"{_short(text)} is not {what}", word)
        if len(text) > 10 or int(text) >= _LARGEST:
            raise self.fail(f"{what} {_short(text)}: numbers are below 2^31", word)
        if below is not None and int(text) >= below:
            raise self.fail(f"{what} {text}, but there are {below}, numbered from 0", word)
        return int(text)

    def real(self, word: int, what: str) -> float:
        """A word as a decimal number or a fraction."""
        text = self.words[word]
        if _REAL.fullmatch(text):
            return float(text)
        fraction = _FRACTION.fullmatch(text)
        if fraction and int(fraction[2]):
            return int(fraction[1]) / int(fraction[2])
        raise self.fail(f"{_short(text)} is not {what}", word)


def read_explicit(
    tra: str | os.PathLike[str],
    lab: str | os.PathLike[str] | None = None,
    sta: str | os.PathLike[str] | None = None,
) -> LabelledMDP:
    """A process from its .tra file, labelled by a .lab file, with states named by a .sta file.

    Both ways of writing are read: PRISM's, with numbers of states and transitions in the first line, and Storm's, with
    the kind of model. A dtmc has one action. Choices that carry an action name are that action; others are numbered.
    The initial state is the one labelled init, or 0. The labels init and deadlock are no propositions. Lines that begin
    with # are comments, but for those that say what is in the file.

    Raises:
        FileFormatError: a file is malformed, or is of another kind of model; the message has the path and the line, and
            the column where it is about one entry.
        AlphabetLimitExceeded: there are more than 62 labels.
        StateLimitExceeded: there are too many states for so many actions.
        OSError: a file cannot be read.
    """
    lines = _lines(Path(tra), "Transitions")
    n_states, choices = _choices(lines, Path(tra))
    names = _action_names(choices, n_states)
    if n_states * len(names) > _MAX_TABLE:
        raise StateLimitExceeded(
            f"{os.fspath(tra)}: {n_states} states and {len(names)} actions; their product may be {_MAX_TABLE}, at most"
        )
    index = {name: i for i, name in enumerate(names)}
    entries: list[tuple[list[int], list[int], list[float]]] = [([], [], []) for _ in names]
    for (state, number, action), branches in choices.items():
        rows, columns, data = entries[index[action or str(number)]]
        for target, p in branches:
            rows.append(state)
            columns.append(target)
            data.append(p)
    shape = (n_states, n_states)
    transitions = [sparse.csr_array((data, (rows, columns)), shape=shape) for rows, columns, data in entries]
    aps, labels, start = _labels(Path(lab), n_states) if lab is not None else ((), {}, 0)
    state_names = None if sta is None else _state_names(Path(sta), n_states)
    try:
        return LabelledMDP.from_arrays(
            transitions,
            aps=aps,
            labels=labels,
            initial_state=start,
            state_names=state_names,
            action_names=tuple(names),
        )
    except InvalidArgumentError as error:
        raise FileFormatError(f"{os.fspath(tra)}: {error}") from error


def read_state_rewards(srew: str | os.PathLike[str], n_states: int) -> FloatArray:
    """The reward of each state, shape (n_states,), from a .srew file of PRISM or Storm.

    Raises:
        FileFormatError: the file is malformed; the message has the path and the line.
        OSError: it cannot be read.
    """
    reward = np.zeros(n_states)
    lines = list(_lines(Path(srew), "State rewards"))
    if lines and len(lines[0].words) == 2 and lines[0].words == [str(n_states), str(len(lines) - 1)]:
        del lines[0]  # PRISM's header
    for line in lines:
        _expect(line, 2, "a state and its reward")
        value = line.real(1, "a reward")
        if not np.isfinite(value):
            raise line.fail(f"the reward {value} is not finite", 1)
        reward[line.whole(0, "state", n_states)] = value
    return reward


_Choices = dict[tuple[int, int, str], list[tuple[int, float]]]


def _choices(lines: Iterator[_Line], path: Path) -> tuple[int, _Choices]:
    """Number of states, and the branches of each choice (state, number, action name or nothing)."""
    head = next(lines, None)
    if head is None:
        raise FileFormatError(f"{path}: the file is empty")
    declared: list[int] | None = None
    if head.words in (["mdp"], ["dtmc"]):
        chain = head.words == ["dtmc"]
    else:
        declared = _declared(head)
        chain = len(declared) == 2
    bound = None if declared is None else declared[0]
    choices: _Choices = {}
    action_of: dict[tuple[int, int], str] = {}
    most = count = 0
    for line in lines:
        state, number, target, p, action = _transition(line, chain, bound)
        if action_of.setdefault((state, number), action) != action:
            other = _short(action_of[state, number])
            raise line.fail(f"choice {number} of state {state} has two actions, {other} and {_short(action)}")
        choices.setdefault((state, number, action), []).append((target, p))
        most, count = max(most, state, target), count + 1
    if declared is not None and (count != declared[-1] or (not chain and len(choices) != declared[1])):
        raise head.fail(
            f"the header promises {' '.join(head.words)}; the file has {len(choices)} choices and {count} transitions"
        )
    if not count:
        raise head.fail("there are no transitions")
    n_states = most + 1 if declared is None else declared[0]
    _check_numbering(path, n_states, action_of)
    return n_states, choices


def _declared(head: _Line) -> list[int]:
    """The numbers in the first line, of states, (choices) and transitions."""
    kind = head.words[0].lower()
    if len(head.words) == 1 and kind in _FOREIGN:
        raise head.fail(f"this is {_FOREIGN[kind]}; an MDP or a Markov chain in discrete time can be read", 0)
    if len(head.words) == 4 and all(word.isdigit() for word in head.words):
        raise head.fail(
            f"four numbers in the first line mean {_FOREIGN['pomdp']}; an MDP or a Markov chain can be read"
        )
    if len(head.words) not in (2, 3) or not all(word.isdigit() for word in head.words):
        raise head.fail("expected the numbers of states, (choices) and transitions, or mdp, or dtmc")
    return [head.whole(word, "a number") for word in range(len(head.words))]


def _transition(line: _Line, chain: bool, n_states: int | None) -> tuple[int, int, int, float, str]:
    """State, choice, next state, probability and action of a line."""
    width = 3 if chain else 4
    foreign = ""
    if any(word.startswith("[") for word in line.words[width - 1 : width]):
        foreign = _FOREIGN["idtmc" if chain else "imdp"]
    elif not chain and len(line.words) == 3 and line.words[2].isdigit():
        foreign = _FOREIGN["lts"]
    elif ":" in "".join(line.words[1:2]):
        foreign = "an export by rows"
    if foreign:
        raise line.fail(f"this seems to be {foreign}; an MDP or a Markov chain, a line per transition, can be read")
    if len(line.words) not in (width, width + 1):
        what = "state, next state, probability" if chain else "state, choice, next state, probability"
        raise line.fail(f"{len(line.words)} entries; expected {what}, and perhaps an action")
    p = line.real(width - 1, "a probability")
    if not 0 <= p <= 1 + 1e-9:
        rates = (
            "; if it is a rate, this is a continuous-time Markov chain, which cannot be read" if chain and p > 1 else ""
        )
        raise line.fail(f"{p} is not a probability{rates}", width - 1)
    return (
        line.whole(0, "state", n_states),
        0 if chain else line.whole(1, "choice"),
        line.whole(width - 2, "state", n_states),
        p,
        line.words[width] if len(line.words) > width and not chain else "",
    )


def _check_numbering(path: Path, n_states: int, choices: Collection[tuple[int, int]]) -> None:
    """Check that every state has choices, numbered from 0: memory is then bounded by what the file holds."""
    count = Counter(state for state, _ in choices)
    if len(count) < n_states:
        state = next(state for state in range(n_states) if state not in count)
        raise FileFormatError(
            f"{path}: state {state} has no available action; let one lead back to the state itself "
            f"({n_states} states, of which {len(count)} have transitions)"
        )
    for state, number in choices:
        if number >= count[state]:
            raise FileFormatError(
                f"{path}: choice {number} of state {state}, which has {count[state]}; they are numbered from 0"
            )


def _action_names(choices: _Choices, n_states: int) -> list[str]:
    """Names of the actions; where a state has one twice, some have none or there are too many, choices go by number."""
    pairs = [(state, action) for state, _, action in choices]
    names = sorted({action for _, action in pairs})
    if names[0] and len(set(pairs)) == len(pairs) and len(names) * n_states <= _MAX_TABLE:
        return names
    renamed = {(state, number, ""): branches for (state, number, _), branches in choices.items()}
    choices.clear()
    choices.update(renamed)
    return [str(number) for number in range(max(number for _, number, _ in choices) + 1)]


def _labels(path: Path, n_states: int) -> tuple[tuple[str, ...], dict[int, list[str]], int]:
    """Propositions, those of each state, and the initial state."""
    lines = _lines(path, "Labels")
    head = next(lines, None)
    if head is None:
        raise FileFormatError(f"{path}: the file is empty")
    named: dict[str, str]
    if head.words == ["#DECLARATION"]:
        declared = next(lines, head)
        named = {name: name for name in declared.words}
        if declared is head or next(lines, head).words != ["#END"]:
            raise head.fail("expected a line with the labels and a line #END after #DECLARATION")
    else:
        named = dict(_DECLARED.findall(" ".join(head.words)))
        if not named or len(named) != len(head.words):
            raise head.fail('expected labels such as 0="init" 1="goal", or #DECLARATION')
    aps = tuple(name for name in named.values() if name not in ("init", "deadlock"))
    if len(set(aps)) < len(aps) or "" in aps:
        raise head.fail("a label is declared twice, or has no name")
    if len(aps) > _MAX_APS:
        raise AlphabetLimitExceeded(f"{path}: {len(aps)} labels; at most {_MAX_APS} can be read")
    found: dict[int, list[str]] = {}
    for line in lines:
        state = line.natural(line.words[0].rstrip(":"), 0, "state", n_states)
        for i, word in enumerate(line.words[1:], start=1):
            if word not in named:
                raise line.fail(f"label {_short(word)} is not declared in line {head.number}", i)
        found.setdefault(state, []).extend(named[word] for word in line.words[1:])
    start = [state for state, names in found.items() if "init" in names]
    if len(start) > 1:
        raise head.fail(f"{len(start)} states are labelled init; expected one")
    labels = {state: [name for name in names if name in aps] for state, names in found.items()}
    return aps, labels, start[0] if start else 0


def _state_names(path: Path, n_states: int) -> tuple[str, ...]:
    names = [""] * n_states
    lines = _lines(path, "States")
    next(lines, None)  # the variables
    for line in lines:
        number, colon, name = " ".join(line.words).partition(":")
        if not colon:
            raise line.fail("expected a number, a colon and the values of the variables")
        names[line.natural(number.rstrip(), 0, "state", n_states)] = name
    return tuple(names)


def _lines(path: Path, content: str) -> Iterator[_Line]:
    """The lines that are neither empty nor comments.

    Args:
        path: the file.
        content: what PRISM calls it in a comment before the first line, such as `# Transitions (MDP)`.
    """
    try:
        with path.open(encoding="utf-8") as file:
            for number, text in enumerate(file, start=1):
                line = _Line(path, number, text, text.split())
                if text.startswith("#") and line.words[0] not in ("#DECLARATION", "#END"):
                    _check_comment(line, content)
                elif line.words:
                    yield line
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{path}: not UTF-8 text (byte {error.start})") from None


def _check_comment(line: _Line, content: str) -> None:
    match = re.fullmatch(
        r"#\s*(Transitions|Transition rewards|State rewards|States|Labels)(?:\s*\(([A-Z]+)\))?\s*", line.text
    )
    if match is None:
        return
    if match[1] != content:
        raise line.fail(f"this file has {match[1].lower()}; expected {content.lower()}")
    kind = (match[2] or "mdp").lower()
    if kind not in ("mdp", "dtmc"):
        what = _FOREIGN.get(kind, f"a model of the kind {match[2]}")
        raise line.fail(f"this is {what}; an MDP or a Markov chain in discrete time can be read")


def _short(text: str) -> str:
    """A word of the file in quotes, however long it is."""
    return repr(text if len(text) <= 40 else f"{text[:37]}...")


def _expect(line: _Line, width: int, what: str) -> None:
    if len(line.words) != width:
        raise line.fail(f"{len(line.words)} entries; expected {what}")
