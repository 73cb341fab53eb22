"""Reward tables as agents take them: as tensors, with rewards in a unit that makes values a few units large."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from ltlc.rewards import RewardTables, ValueBounds

_ALIKE = 1e-9
"""bounds that are nearer to each other leave nothing to learn."""
HORIZON = 100.0
"""steps a reward counts for in the automatic scale, at most."""


@dataclass(frozen=True, eq=False)
class TensorTables:
    """Reward tables as tensors, rewards in units of `scale`."""

    next_state: Tensor
    """shape (n_states, n_classes), int64."""
    reward: Tensor
    """shape (n_states, n_classes), float32; mean over whether the episode stops."""
    discount: Tensor
    """shape (n_states, n_classes), float32; mean weight of what follows, over whether the episode stops."""
    final_value: Tensor
    """shape (n_states, n_classes), float32; of all that follows a step with which the environment ends the episode."""
    learned: Tensor
    """shape (n_learned,), int64; the table states that an episode can be in, in order."""
    options: Tensor
    """shape (n_states, 1 + n_choices), int64; the state itself, and the state after choosing each pair."""
    allowed: Tensor
    """shape (n_states, 1 + n_choices), bool; whether that can be done."""
    least: Tensor
    """shape (n_states,), float32; no value in the state is less; -inf where nothing is known."""
    largest: Tensor
    """shape (n_states,), float32; likewise."""
    open: Tensor
    """shape (n_open,), int64; those of the learned states in which values can differ."""
    scale: float
    """one unit of reward inside the networks."""

    @classmethod
    def of(
        cls,
        tables: RewardTables,
        scale: float | None = None,
        device: str = "cpu",
        bounds: ValueBounds | None = None,
    ) -> TensorTables:
        """Make the tensors of a task.

        Args:
            tables: reward tables.
            scale: one unit of reward; None: see `reward_scale`.
            device: where they are to live.
            bounds: of the values; None: nothing is known of them.
        """
        learned = reachable_states(tables)
        scale = scale or reward_scale(tables, learned)
        unknown = np.full(tables.n_states, np.inf)
        least, largest = (-unknown, unknown) if bounds is None else (bounds.least / scale, bounds.largest / scale)
        differ = learned[(largest - least > _ALIKE)[learned]]
        options = np.hstack((np.arange(tables.n_states, dtype=np.int32)[:, None], tables.select_pair))

        def tensor(values: np.ndarray, dtype: torch.dtype) -> Tensor:
            return torch.as_tensor(np.array(values), dtype=dtype, device=device)

        return cls(
            next_state=tensor(tables.next_state, torch.int64),
            reward=tensor(tables.expected_reward / scale, torch.float32),
            discount=tensor(tables.expected_discount, torch.float32),
            final_value=tensor(tables.final_value / scale, torch.float32),
            learned=tensor(learned, torch.int64),
            options=tensor(options.clip(0), torch.int64),
            allowed=tensor(options >= 0, torch.bool),
            least=tensor(least, torch.float32),
            largest=tensor(largest, torch.float32),
            open=tensor(differ, torch.int64),
            scale=scale,
        )

    @property
    def n_options(self) -> int:
        """1 and the number of pairs that can be chosen between."""
        return self.options.shape[1]

    def join_options(self, values: Tensor, allowed: Tensor) -> Tensor:
        """Values of all actions of a state, those that choose a pair included; -inf where an action does not exist.

        To choose a pair and then act is worth what the action is worth in the state chosen.

        Args:
            values: shape (..., n_options, n_actions), of the actions in each of the options.
            allowed: shape (..., n_options), rows of `allowed`.

        Returns:
            Shape (..., n_options * n_actions).
        """
        return values.masked_fill(~allowed[..., None], -torch.inf).flatten(-2)


def reachable_states(tables: RewardTables) -> np.ndarray:
    """The table states that an episode can be in, in order; those entered only where it surely stops are not."""
    reached, frontier = {tables.initial_state}, [tables.initial_state]
    while frontier:
        state = frontier.pop()
        following = tables.next_state[state][~tables.terminal[state]].tolist()
        following += tables.select_pair[state][tables.select_pair[state] >= 0].tolist()
        frontier += sorted(set(following) - reached)
        reached.update(following)
    return np.array(sorted(reached), dtype=np.int64)


def reward_scale(tables: RewardTables, learned: np.ndarray) -> float:
    """A unit of reward that makes values a few units large: what a fifth of the horizon pays at the median reward.

    The median and not the mean, lest a rare large penalty make the steps to the goal too small to tell apart.
    """
    rewards = np.abs(tables.expected_reward[learned])
    magnitude = float(np.median(rewards[rewards > 0])) if rewards.any() else 1.0
    largest = float(tables.discount[learned].max())
    horizon = HORIZON if largest >= 1 - 1 / HORIZON else 1 / (1 - largest)
    return magnitude * max(horizon / 5, 1.0)


def plain_tables(gamma: float) -> RewardTables:
    """The tables of a task that asks for nothing: one state, reward 0, one discount."""
    one, no = np.ones((1, 1)), np.zeros((1, 1), dtype=np.bool_)
    return RewardTables(
        aps=(), letter_class=np.zeros(1, dtype=np.int32), initial_state=0, next_state=np.zeros((1, 1), dtype=np.int32),
        reward=0 * one, discount=gamma * one, stop=0 * one, stop_reward=0 * one, violated=no, accepted=no,
        automaton_state=np.zeros(1, dtype=np.int32), progress=np.zeros(1),
    )  # fmt: skip


def without_forbidden(values: Tensor, allowed: Tensor | None) -> Tensor:
    """Values of actions, -inf for those that the environment forbids.

    Args:
        values: shape (batch, ..., n_options * n_actions).
        allowed: shape (batch, n_actions); None: everything is.
    """
    if allowed is None:
        return values
    allowed = allowed.repeat(1, values.shape[-1] // allowed.shape[1])
    return values.masked_fill(~allowed.view(len(allowed), *(1,) * (values.ndim - 2), -1), -torch.inf)


def permitted(action: Tensor, allowed: Tensor | None, generator: torch.Generator) -> Tensor:
    """The actions, in place of each that the environment forbids a random one that it allows; -1 stays.

    Args:
        action: shape (n,).
        allowed: shape (n, n_actions), bool; None: everything is, and nothing is drawn.
        generator: of what is random.
    """
    if allowed is None:
        return action
    other = (torch.rand(allowed.shape, generator=generator) + allowed).argmax(dim=-1)
    return torch.where((action < 0) | allowed.gather(1, action.clamp(min=0)[:, None])[:, 0], action, other)
