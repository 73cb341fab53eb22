"""What is known of a task beforehand, said once."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ltlc.automata import DRA
    from ltlc.envs.spec import EnvSpec
    from ltlc.mdp import MaxSatisfaction


def tell(
    automaton: DRA,
    env_spec: EnvSpec,
    *,
    episodes: bool = False,
    maximum: MaxSatisfaction | None = None,
) -> None:
    """Print to stderr, a paragraph each, what can be said before anything is learned.

    Args:
        automaton: of the task.
        env_spec: the environment; where its dynamics are not known, only the formula is looked at.
        episodes: whether episodes are cut where the environment says.
        maximum: the largest satisfaction probability, where it has been computed before.
    """
    from ltlc.diagnosis import diagnose

    found = diagnose(
        automaton,
        env_spec.model,
        episode_steps=env_spec.episode_steps if episodes else None,
        initial_label=env_spec.initial_label,
        maximum=maximum,
    )
    sys.stdout.flush()
    for diagnostic in found:
        print(f"ltlc: note: {diagnostic.text}", file=sys.stderr)
