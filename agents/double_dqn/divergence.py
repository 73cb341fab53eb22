"""What is said where the loss is no longer finite."""

from __future__ import annotations

import torch

from ltlc.errors import TrainingDiverged

from ..transitions import TransitionBatch
from .replay import Segments


def diverged(
    network: torch.nn.Module,
    steps: TransitionBatch | Segments,
    update: int,
    loss: float,
    learning_rate: float,
    scale: float,
) -> TrainingDiverged:
    """Return the error that says what is not finite, and what to try.

    Args:
        network: that learned.
        steps: of the batch.
        update: its number.
        loss: of it.
        learning_rate: of it.
        scale: one unit of reward.
    """
    broken = [name for name, weights in network.named_parameters() if not weights.isfinite().all()]
    rewards = steps.base_reward[~steps.base_reward.isfinite()]
    text = f"the loss is {loss} at update {update} (batch of {steps.letter_class.numel()} steps"
    text += f", {len(rewards)} of them with a reward that is not finite)" if len(rewards) else ")"
    text += f"; weights not finite in {', '.join(broken)}" if broken else "; the weights are finite"
    if len(rewards):
        return TrainingDiverged(f"{text}. The environment pays rewards that are NaN or infinite; repair or wrap it.")
    return TrainingDiverged(
        f"{text}. Try a learning_rate below {learning_rate:g}, max_gradient_norm=10, or a reward_scale above "
        f"{scale:g}; resume from the last checkpoint, which is from before."
    )
