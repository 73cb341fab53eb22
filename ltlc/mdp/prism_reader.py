"""PRISM's explicit files in, written by PRISM, by Storm or here."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import sparse

from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.mdp.explicit import FloatArray
from ltlc.mdp.model import LabelledMDP

_DECLARED = re.compile(r'(\d+)="([^"]*)"')


@dataclass(frozen=True)
class _Line:
    path: Path
    number: int
    """1-based."""
    words: list[str]

    def fail(self, what: str) -> FileFormatError:
        return FileFormatError(f"{self.path}, line {self.number}: {what}")

    def whole(self, word: int, what: str, below: int | None = None) -> int:
        """A word as a natural number below a bound."""
        text = self.words[word]
        if not text.isascii() or not text.isdigit():
            raise self.fail(f"{text!r} is not {what}")
        if below is not None and int(text) >= below:
            raise self.fail(f"{what} {text}, but there are {below}, numbered from 0")
        return int(text)

    def real(self, word: int, what: str) -> float:
        try:
            return float(self.words[word])
        except ValueError:
            raise self.fail(f"{self.words[word]!r} is not {what}") from None


def read_explicit(
    tra: str | os.PathLike[str],
    lab: str | os.PathLike[str] | None = None,
    sta: str | os.PathLike[str] | None = None,
) -> LabelledMDP:
    """A process from its .tra file, labelled by a .lab file, with states named by a .sta file.

    Both ways of writing are read: PRISM's, with numbers of states and transitions in the first line, and Storm's, with
    the kind of model. A dtmc has one action. Choices that carry an action name are that action; others are numbered.
    The initial state is the one labelled init, or 0. The labels init and deadlock are no propositions.

    Raises:
        FileFormatError: a file is malformed; the message has the path and the line.
        OSError: a file cannot be read.
    """
    lines = _lines(Path(tra))
    n_states, choices = _choices(lines, Path(tra))
    names = _action_names(choices)
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
    lines = [line for line in _lines(Path(srew)) if not line.words[0].startswith("#")]
    if lines and len(lines[0].words) == 2 and lines[0].words == [str(n_states), str(len(lines) - 1)]:
        del lines[0]  # PRISM's header
    for line in lines:
        _expect(line, 2, "a state and its reward")
        value = line.real(1, "a reward")
        if not np.isfinite(value):
            raise line.fail(f"the reward {value} is not finite")
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
    elif len(head.words) in (2, 3) and all(word.isdigit() for word in head.words):
        declared = [int(word) for word in head.words]
        chain = len(declared) == 2
    else:
        raise head.fail("expected the numbers of states, (choices) and transitions, or mdp, or dtmc")
    width = 3 if chain else 4
    bound = None if declared is None else declared[0]
    choices: _Choices = {}
    action_of: dict[tuple[int, int], str] = {}
    most = count = 0
    for line in lines:
        if len(line.words) not in (width, width + 1):
            what = "state, next state, probability" if chain else "state, choice, next state, probability"
            raise line.fail(f"{len(line.words)} entries; expected {what}, and perhaps an action")
        state, target = line.whole(0, "state", bound), line.whole(width - 2, "state", bound)
        number = 0 if chain else line.whole(1, "choice")
        p = line.real(width - 1, "a probability")
        if not 0 <= p <= 1 + 1e-9:
            raise line.fail(f"{p} is not a probability")
        action = line.words[width] if len(line.words) > width and not chain else ""
        if action_of.setdefault((state, number), action) != action:
            raise line.fail(
                f"choice {number} of state {state} has two actions, {action_of[state, number]} and {action}"
            )
        choices.setdefault((state, number, action), []).append((target, p))
        most, count = max(most, state, target), count + 1
    if declared is not None and (count != declared[-1] or (not chain and len(choices) != declared[1])):
        raise head.fail(
            f"the header promises {' '.join(head.words)}; the file has {len(choices)} choices and {count} transitions"
        )
    if not count:
        raise head.fail("there are no transitions")
    return (most + 1 if declared is None else declared[0]), choices


def _action_names(choices: _Choices) -> list[str]:
    """Names of the actions; where a state has one twice or some have none, all choices go by number."""
    pairs = [(state, action) for state, _, action in choices]
    if all(action for _, action in pairs) and len(set(pairs)) == len(pairs):
        return sorted({action for _, action in pairs})
    renamed = {(state, number, ""): branches for (state, number, _), branches in choices.items()}
    choices.clear()
    choices.update(renamed)
    return [str(number) for number in range(max(number for _, number, _ in choices) + 1)]


def _labels(path: Path, n_states: int) -> tuple[tuple[str, ...], dict[int, list[str]], int]:
    """Propositions, those of each state, and the initial state."""
    lines = _lines(path)
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
    found: dict[int, list[str]] = {}
    for line in lines:
        line.words[0] = line.words[0].rstrip(":")
        state = line.whole(0, "state", n_states)
        for word in line.words[1:]:
            if word not in named:
                raise line.fail(f"label {word!r} is not declared in line {head.number}")
        found.setdefault(state, []).extend(named[word] for word in line.words[1:])
    start = [state for state, names in found.items() if "init" in names]
    if len(start) > 1:
        raise head.fail(f"{len(start)} states are labelled init; expected one")
    aps = tuple(name for name in named.values() if name not in ("init", "deadlock"))
    labels = {state: [name for name in names if name in aps] for state, names in found.items()}
    return aps, labels, start[0] if start else 0


def _state_names(path: Path, n_states: int) -> tuple[str, ...]:
    names = [""] * n_states
    lines = _lines(path)
    next(lines, None)  # the variables
    for line in lines:
        number, colon, name = " ".join(line.words).partition(":")
        line.words[0] = number
        if not colon:
            raise line.fail("expected a number, a colon and the values of the variables")
        names[line.whole(0, "state", n_states)] = name
    return tuple(names)


def _lines(path: Path) -> Iterator[_Line]:
    with path.open(encoding="utf-8") as file:
        for number, text in enumerate(file, start=1):
            words = text.split()
            if words:
                yield _Line(path, number, words)


def _expect(line: _Line, width: int, what: str) -> None:
    if len(line.words) != width:
        raise line.fail(f"{len(line.words)} entries; expected {what}")
