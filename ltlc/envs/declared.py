"""What an environment declares about the letters that occur in it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

from ltlc.automata import DFA, DRA
from ltlc.automata.possible import DeclaredLetters, names_in
from ltlc.ltl import Formula
from ltlc.mdp import LabelledMDP
from ltlc.task import Task


def declared_letters(env: Any) -> DeclaredLetters:
    """What an environment says in its attributes `exclusive` and `possible_letters`, each a list of sets of names.

    Args:
        env: an environment, or a vector environment; wrappers are looked through.

    Example:
        >>> import gymnasium
        >>> class Rooms(gymnasium.Env):
        ...     exclusive = [{"kitchen", "hall"}]
        >>> declared_letters(Rooms()).exclusive == (frozenset({"kitchen", "hall"}),)
        True
    """
    base = env.unwrapped
    exclusive, letters = _attribute(base, "exclusive"), _attribute(base, "possible_letters")
    if letters is not None:
        return DeclaredLetters(letters=tuple(map(frozenset, letters)))
    return DeclaredLetters(exclusive=tuple(map(frozenset, exclusive or ())))


def letters_in(mdp: LabelledMDP) -> DeclaredLetters:
    """The letters that occur in an exact model."""
    return DeclaredLetters(letters=tuple(names_in(mdp.aps, letter) for letter in mdp.letters.tolist()))


def task_in(env: Any, task: Task | Formula | str | DRA | DFA) -> Task:
    """The task of a formula or automaton, over the letters that the environment declares."""
    if isinstance(task, Task):
        return task
    if isinstance(task, DRA | DFA):
        return Task(task)
    return Task(task, **declared_letters(env)._asdict())


def _attribute(base: Any, name: str) -> Iterable[Iterable[str]] | None:
    value = getattr(base, name, None)
    if value is None and isinstance(base, SyncVectorEnv | AsyncVectorEnv) and all(base.call("has_wrapper_attr", name)):
        value = base.get_attr(name)[0]
    return None if callable(value) else value
