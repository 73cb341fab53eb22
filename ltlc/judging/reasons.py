"""Why a policy satisfies its formula with a probability below 1, in words, with exact numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ltlc.errors import LtlcError
from ltlc.ltl import And, Formula, parse
from ltlc.mdp import Judge
from ltlc.mdp.failure import Failure, Trap, failure
from ltlc.monitor import Monitor, Verdict
from ltlc.pictures.policy import waits_for
from ltlc.task import Task

_SHOWN = 8
"""routes, entries and traps that are printed; the data have all."""
_LONG = 24
"""states of a path that are printed."""


@dataclass(frozen=True, eq=False)
class Reasons:
    """How a policy fails in a known environment.

    Attributes:
        judge: of the task there.
        task: the task.
        policy: as `Judge` takes it.
        failure: the numbers.
    """

    judge: Judge
    task: Task
    policy: npt.NDArray[Any]
    failure: Failure

    def lines(self) -> list[str]:
        """What there is to say, for a person."""
        found = self.failure
        bounds = found.satisfaction
        lines = [f"satisfied with probability {bounds.probability:.6g}; {found.loss:.6g} is lost"]
        if found.loss <= 0:
            return [*lines, "Nothing is lost: every run satisfies the formula, but for a set of probability 0."]
        if found.routes:
            lines.append(f"Ways to fail, with detours left out; they carry {found.routes_carry:.1%} of what is lost:")
            lines += [f"  {r.probability:.4g}  {self.told(r.states)}" for r in found.routes[:_SHOWN]]
            lines += _more(len(found.routes))
        if not found.routes or found.routes_carry < found.entries_carry:
            lines.append(f"Steps into what is lost; they carry {found.entries_carry:.1%} of it:")
            lines += [
                f"  {e.probability:.4g}  {self.told((e.target,) if e.source is None else (e.source, e.target))}"
                for e in found.entries[:_SHOWN]
            ]
            lines += _more(len(found.entries))
        if found.paths:
            n, path = len(found.paths), found.paths[0]
            lines.append(
                f"Single paths, with all detours: the {n} most probable carry {found.paths_carry:.1%}; the first, "
                f"{path.probability:.4g}: {self.told(path.states)}"
            )
        lines += [found.why[0].upper() + found.why[1:] + "."] if found.why else []
        lines.append("Where lost runs stay:")
        lines += [f"  {trap.probability:.4g}  {self.trap_text(trap)}" for trap in found.traps[:_SHOWN]]
        return lines + _more(len(found.traps))

    def to_dict(self) -> dict[str, Any]:
        """All of it as JSON values; states are those of the model."""
        found = self.failure
        return {
            "formula": self.task.formula,
            "satisfaction": found.satisfaction.probability,
            "satisfaction_bounds": [found.satisfaction.lower, found.satisfaction.upper],
            "loss": found.loss,
            "steps": found.steps,
            "routes_carry": found.routes_carry,
            "routes": [self._path(route.states, route.probability) for route in found.routes],
            "paths_carry": found.paths_carry,
            "paths": [self._path(path.states, path.probability) for path in found.paths],
            "entries_carry": found.entries_carry,
            "entries": [
                {
                    "probability": entry.probability,
                    "from": None if entry.source is None else self._place(entry.source),
                    "to": self._place(entry.target),
                    "path": self._path(entry.path.states, entry.path.probability),
                }
                for entry in found.entries
            ],
            "traps": [
                {
                    "probability": trap.probability,
                    "violated": trap.violated,
                    "states": [self._place(state) for state in trap.states],
                    "reason": self.trap_text(trap),
                }
                for trap in found.traps
            ],
            "why": found.why,
        }

    def told(self, states: Sequence[int]) -> str:
        """A path of product states in words, with what it breaks."""
        names = [self._named(state) for state in states]
        if len(names) > _LONG:
            names = [*names[: _LONG // 2], f"... {len(names) - _LONG} more ...", *names[-_LONG // 2 :]]
        broken = self.broken(states)
        ending = f": breaks {' and '.join(map(str, broken))}" if broken else ""
        return " -> ".join(names) + ending

    def broken(self, states: Sequence[int]) -> tuple[Formula, ...]:
        """The parts of the formula that no word satisfies which begins with the labels of these product states."""
        if states[-1] not in self._violated:
            return ()
        letters = [self._label(state) for state in states]
        if self._parts is None or any(letter is None for letter in letters):
            return ()
        first = 0 if self.judge.initial_label == "read" else 1
        return tuple(part for part in self._parts if _breaks(part, [letter or () for letter in letters[first:]]))

    def trap_text(self, trap: Trap) -> str:
        """Why nothing is satisfied any more where runs stay."""
        places = list(dict.fromkeys(self._named(state) for state in trap.states))
        where = ", ".join(places[:_SHOWN]) + (f" and {len(places) - _SHOWN} more" if len(places) > _SHOWN else "")
        if trap.violated:
            return f"violated, on entering {where}"
        behind = sorted({self._behind(state) for state in trap.states})
        waits = "; ".join(f"q{q} {self._waits[q]}" if q >= 0 else "violated" for q in behind[:_SHOWN])
        return f"for ever in {where}: {waits}"

    @cached_property
    def _parts(self) -> tuple[Formula, ...] | None:
        """What the formula is a conjunction of, or None where it is not known."""
        try:
            formula = parse(self.task.formula or "")
        except LtlcError:
            return None
        return formula.args if isinstance(formula, And) else (formula,)

    @cached_property
    def _violated(self) -> frozenset[int]:
        """Product states from which no word is accepted any more."""
        words = self.judge.words
        return frozenset(np.flatnonzero(np.isin(words.machine_state, words.automaton.deadlocks)).tolist())

    @cached_property
    def _waits(self) -> list[str]:
        return waits_for(self.task.automaton, self.judge.letter_classes)

    def _behind(self, state: int) -> int:
        """The state of the automaton of the task, or -1 after a violation."""
        machine = int(self.judge.words.machine_state[state])
        behind = self.task.tables.automaton_state
        return int(behind[machine]) if machine < len(behind) else -1

    def _named(self, state: int) -> str:
        mdp = self.judge.words.mdp
        place = int(self.judge.words.mdp_state[state])
        name = str(place) if mdp.state_names is None else mdp.state_names[place]
        label = self._label(state)
        return f"{name} {{{', '.join(sorted(label))}}}" if label else name

    def _label(self, state: int) -> frozenset[str] | None:
        """What holds in the state of the model behind, or None where that is drawn at random."""
        mdp = self.judge.words.mdp
        row = mdp.label_probability[[int(self.judge.words.mdp_state[state])]]
        if row.nnz != 1:
            return None
        letter = int(mdp.letters[int(row.indices[0])])
        known = self.task.aps
        return frozenset(name for i, name in enumerate(mdp.aps) if letter >> i & 1 and name in known)

    def _place(self, state: int) -> dict[str, Any]:
        label = self._label(state)
        return {
            "state": int(self.judge.words.mdp_state[state]),
            "automaton_state": self._behind(state),
            "label": None if label is None else sorted(label),
        }

    def _path(self, states: Sequence[int], probability: float) -> dict[str, Any]:
        return {
            "probability": probability,
            "states": [int(self.judge.words.mdp_state[state]) for state in states],
            "breaks": [str(part) for part in self.broken(states)],
        }


def reasons(judge: Judge, task: Task, policy: npt.ArrayLike) -> Reasons:
    """Why a policy fails in a known environment.

    Args:
        judge: of the task.
        task: the task.
        policy: as `Judge.judge` takes it.

    Raises:
        InvalidArgumentError: the policy is of another shape.

    Example:
        >>> import ltlc
        >>> from ltlc.mdp import LabelledMDP
        >>> ice = LabelledMDP.from_arrays(
        ...     [[[0.5, 0.3, 0.2], [0, 1, 0], [0, 0, 1]]], aps=["goal", "hole"], labels=[[], ["goal"], ["hole"]]
        ... )
        >>> task = ltlc.Task("F goal & G !hole")
        >>> judge = ltlc.Judge(ice, task)
        >>> reasons(judge, task, judge.optimal_policy).lines()[2]
        '  0.4  0 -> 2 {hole}: breaks G !hole'
    """
    return Reasons(judge, task, np.asarray(policy), failure(judge.words, judge.on_words(policy)))


def _breaks(part: Formula, letters: Sequence[frozenset[str] | tuple[()]]) -> bool:
    """Whether no word that begins with the letters satisfies the formula."""
    monitor = Monitor(part)
    verdict = monitor.verdict
    for letter in letters:
        verdict = monitor.step(set(letter) & set(monitor.aps))
    return verdict is Verdict.VIOLATED


def _more(n: int) -> list[str]:
    return [f"  and {n - _SHOWN} more"] if n > _SHOWN else []
