"""A model and what is to be checked of it, in files that PRISM and Storm take as they are."""

from __future__ import annotations

import os
import shlex
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ltlc.atomic import atomic_write
from ltlc.automata import DFA
from ltlc.errors import InvalidArgumentError
from ltlc.ltl import Formula, Next, parse, to_text
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.product_exploration import InitialLabel
from ltlc.mdp.verdict import Judge, JudgedTask
from ltlc.prism.writer import induced_process, to_prism_language, with_one_start, with_sure_labels, write_explicit


@dataclass(frozen=True)
class Exported:
    """Where a model and its property are.

    Attributes:
        model: in PRISM's module language.
        properties: a file with the one thing to check.
    """

    model: Path
    properties: Path

    @property
    def prism(self) -> str:
        """The command that checks it with PRISM."""
        return shlex.join(("prism", str(self.model), str(self.properties)))

    @property
    def storm(self) -> str:
        """The command that checks it with Storm."""
        return shlex.join(("storm", "--prism", str(self.model), "--prop", str(self.properties)))


def export_checkable(
    process: LabelledMDP,
    formula: Formula,
    folder: str | os.PathLike[str],
    stem: str,
    *,
    initial_label: InitialLabel = "read",
) -> Exported:
    """Write a process, once as `stem`.prism and once as explicit files, and how probable a formula is in `stem`.props.

    Random labels become states, a random start becomes a state before it. Where the first label is not to be read, or
    there is such a state, the property speaks of what comes after (X).

    Args:
        process: an MDP, of which the largest probability is asked, or with a single action a Markov chain.
        formula: to be satisfied.
        folder: made if it is not there.
        stem: name of the files.
        initial_label: whether the label of the first state is a letter of the word.

    Raises:
        InvalidArgumentError: a proposition cannot be the name of a label in PRISM.
        OSError: a file cannot be written.
    """
    model, later = with_one_start(with_sure_labels(process)[0])
    for unread in (later, initial_label == "skip"):
        formula = Next(formula) if unread else formula
    question = "Pmax" if model.n_actions > 1 else "P"
    text = f"{question}=? [ {to_text(formula, 'prism')} ]\n"
    module = to_prism_language(model)
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    write_explicit(model, place / stem)
    return Exported(atomic_write(place / f"{stem}.prism", module), atomic_write(place / f"{stem}.props", text))


def export_policy(
    mdp: LabelledMDP,
    task: JudgedTask,
    policy: npt.ArrayLike,
    folder: str | os.PathLike[str],
    stem: str = "policy",
    *,
    initial_label: InitialLabel = "read",
) -> Exported:
    """Write the Markov chain that a policy induces, and how probable the formula of its task is in it.

    Args:
        mdp: the environment.
        task: an `ltlc.Task`, or anything else that an `ltlc.Judge` takes.
        policy: as an `ltlc.Judge` takes it.
        folder: made if it is not there.
        stem: name of the files.
        initial_label: whether the label of the first state is a letter of the word.

    Raises:
        InvalidArgumentError: the formula is not known, the policy has another shape, or a proposition cannot be the
            name of a label in PRISM.
        OSError: a file cannot be written.
    """
    formula = task.automaton.formula
    if formula is None or task.automaton.translator == DFA.translator:
        raise InvalidArgumentError("the automaton of the task has no formula that another program could check")
    sure, origin = with_sure_labels(mdp)
    judge = Judge(sure, task, initial_label=initial_label)
    chain = induced_process(judge.words, judge.on_words(np.asarray(policy)[origin]))
    return export_checkable(chain, parse(formula), folder, stem, initial_label=initial_label)
