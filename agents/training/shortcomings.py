"""What a training lacked, told while it runs and with the verdict: episodes that end, accepting steps, updates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

EARLY = 0.25
"""part of the steps after which it is told while the training runs."""


@dataclass(frozen=True)
class Seen:
    """What a training has come across; everything since it began."""

    num_envs: int
    episodes: int
    """that ended."""
    accepting: bool
    """whether a step carried an acceptance mark."""
    accepting_elsewhere: bool
    """whether one would have, had the labels come in another order."""
    never: tuple[str, ...] = ()
    """propositions of the task that have not held yet."""


def shortcomings(
    seen: Seen, steps: int, *, counterfactual: bool = False, updates: int | None = None, wait: int = 0
) -> list[str]:
    """What is missing after so many steps, with what to try; a sentence or two each, empty where all is well.

    Args:
        seen: what there was.
        steps: environment steps so far.
        counterfactual: whether each step teaches every automaton state, so that the order of labels does not matter.
        updates: of networks; None: of another learner.
        wait: environment steps that the first update waits for.
    """
    found = []
    if not seen.episodes:
        found.append(
            f"No episode has ended in {steps} steps, {steps // max(seen.num_envs, 1)} in each of {seen.num_envs} "
            "environments, so there is no return to show, and what comes late in an episode has not been seen. Try "
            "more steps, fewer environments, or shorter episodes."
        )
    if not (seen.accepting_elsewhere if counterfactual else seen.accepting):
        lacking = f"; never true so far: {_listed(seen.never)}" if seen.never else ""
        found.append(
            f"No step has been accepting in {steps} steps{lacking}, so nothing tells good policies from others. Check "
            "the labels; then try more steps, more exploration (epsilon_final, epsilon_steps), longer episodes, or "
            "rewards shaped by the distance to acceptance (shaping)."
        )
    if updates == 0:
        found.append(
            f"The network has not been updated in {steps} steps: the first update waits for {wait}. Try more steps, or "
            "a smaller learning_starts and batch_size."
        )
    return found


def _listed(names: Sequence[str], most: int = 8) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
