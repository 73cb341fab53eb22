"""One update of deep Q-learning on an automaton product: targets by table look-up, and the loss."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from ltlc.rewards import RewardTables

from ..encoder import ObservationEncoder
from .config import DQNConfig
from .networks import QNetwork
from .replay import Steps

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
    scale: float
    """one unit of reward inside the networks."""

    @classmethod
    def of(cls, tables: RewardTables, config: DQNConfig) -> TensorTables:
        """The tensors for a configuration."""
        learned = reachable_states(tables)
        scale = config.reward_scale or reward_scale(tables, learned)
        options = np.hstack((np.arange(tables.n_states, dtype=np.int32)[:, None], tables.commit))

        def tensor(values: np.ndarray, dtype: torch.dtype) -> Tensor:
            return torch.as_tensor(np.array(values), dtype=dtype, device=config.device)

        return cls(
            next_state=tensor(tables.next_state, torch.int64),
            reward=tensor(tables.expected_reward / scale, torch.float32),
            discount=tensor(tables.expected_discount, torch.float32),
            final_value=tensor(tables.final_value / scale, torch.float32),
            learned=tensor(learned, torch.int64),
            options=tensor(options.clip(0), torch.int64),
            allowed=tensor(options >= 0, torch.bool),
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
        following += tables.commit[state][tables.commit[state] >= 0].tolist()
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


def policy_values(target: Tensor, online: Tensor, double: bool) -> Tensor:
    """What the next state is worth: value of its best action, the last dimension.

    With `double`, the online network says which action is best and the target network what it is worth; else the
    target network says both.

    References:
        H. van Hasselt, A. Guez, D. Silver, Deep reinforcement learning with double Q-learning, AAAI 2016,
        https://doi.org/10.1609/aaai.v30i1.10295, equation 4.
    """
    if double:
        return target.gather(-1, online.argmax(dim=-1, keepdim=True)).squeeze(-1)
    return target.amax(dim=-1)


class TDLoss:
    """The loss 1/(2m) sum (y - Q(s, q, a))^2 + C ||weights||^2 of a batch (thesis, algorithm 1, lines 14-22).

    The target y is r + g V(s', q') where the reward r, the weight g of what follows (0 where the task ends the episode)
    and the next state q' are looked up by (q, letter class); so is V where the environment ends it. Counterfactually,
    each of the m / k environment steps is taken in
    all k reachable automaton states q at once.

    Args:
        encoder: of the observations.
        tables: of the task.
        config: `double`, `counterfactual`, `l2`, `batch_size`, `batch_norm` are used.

    References:
        R. Toro Icarte et al., Reward machines: exploiting reward function structure in reinforcement learning, JAIR
        2022, https://doi.org/10.1613/jair.1.12440, section 4.2 (counterfactual experiences).
        C. Voloshin, A. Verma, Y. Yue, Eventual discounting temporal logic counterfactual experience replay, ICML 2023,
        https://arxiv.org/abs/2303.02135.
    """

    def __init__(self, encoder: ObservationEncoder, tables: TensorTables, config: DQNConfig) -> None:
        self.encoder, self.tables, self.config = encoder, tables, config
        # Few observations: each passes through the network once and not once per step of the batch. Batch
        # normalisation needs the batch as it is.
        few = 0 < encoder.n_observations <= config.batch_size and not config.batch_norm
        enumerated = few and (config.counterfactual or config.state_input == "heads")
        self._all_features = encoder.all_features().to(config.device) if enumerated else None

    def __call__(self, q_network: QNetwork, target_network: QNetwork, steps: Steps) -> Tensor:
        """The loss of a batch of sampled steps; differentiable in the weights of `q_network` alone."""
        online = None if self._all_features is None else q_network(self._all_features)
        values = self._values(q_network, steps, online)
        error = values - self.targets(q_network, target_network, steps, online)
        loss = error.square().mean() / 2
        if self.config.l2 > 0:
            squares = [weights.square().sum() for weights in q_network.parameters()]
            loss = loss + self.config.l2 * torch.stack(squares).sum()
        return loss

    @torch.no_grad()
    def targets(
        self, q_network: QNetwork, target_network: QNetwork, steps: Steps, online: Tensor | None = None
    ) -> Tensor:
        """The targets y of each step and automaton state, in units of the reward scale.

        Args:
            q_network: chooses the next action, if `double`.
            target_network: values it.
            steps: the sampled steps.
            online: values of all observations by `q_network`, if the caller has them.

        Returns:
            Shape (batch, n_learned), or (batch, 1) if not counterfactual.
        """
        states, classes = self._states(steps), steps.letter_class[:, None]
        reward = self.tables.reward[states, classes] + steps.base_reward[:, None] / self.tables.scale
        weight = self.tables.discount[states, classes]
        next_states = self.tables.next_state[states, classes]
        training = q_network.training
        q_network.eval()
        following = self._next_values(q_network, target_network, steps.next_observation, next_states, online)
        q_network.train(training)
        following = torch.where(steps.terminated[:, None], self.tables.final_value[states, classes], following)
        target: Tensor = reward + weight * following
        return target

    def _states(self, steps: Steps) -> Tensor:
        """Automaton states each step is taken in, shape (batch, k)."""
        if self.config.counterfactual:
            return self.tables.learned.expand(len(steps.action), -1)
        return steps.state[:, None]  # type: ignore[no-any-return]

    def _values(self, network: QNetwork, steps: Steps, online: Tensor | None) -> Tensor:
        """Q(s, q, a) for each step and its states q, shape (batch, k)."""
        states, action = self._states(steps), steps.action
        if online is None and network.state_input != "heads":
            pairs = self._pairwise(network, steps.observation, states)
            return pairs.gather(-1, action[:, None, None].expand(-1, states.shape[1], 1))[..., 0]
        rows, row = self._rows(network, steps.observation, online)
        flat = (row[:, None] * network.n_states + states) * network.n_actions + action[:, None]
        values: Tensor = rows.view(-1)[flat]
        return values

    def _next_values(
        self, network: QNetwork, target: QNetwork, packed: Tensor, states: Tensor, online: Tensor | None
    ) -> Tensor:
        """V(s', q') for each step and its next states q', shape (batch, k)."""
        double = self.config.double
        if self._all_features is None and target.state_input != "heads":
            valued = self._pairwise_options(target, packed, states)
            chosen = self._pairwise_options(network, packed, states) if double else valued
            return policy_values(valued, chosen, double)
        rows, row = self._rows(target, packed, None)
        chosen = self._rows(network, packed, online)[0] if double else rows
        if self.tables.n_options > 1:
            rows, chosen = (
                self.tables.join_options(values[:, self.tables.options], self.tables.allowed)
                for values in (rows, chosen)
            )
        return policy_values(rows, chosen, double).view(-1)[row[:, None] * target.n_states + states]

    def _rows(self, network: QNetwork, packed: Tensor, known: Tensor | None) -> tuple[Tensor, Tensor]:
        """Values (n_rows, n_states, n_actions) of the observations that occur, and the row of each of the batch."""
        if self._all_features is not None:
            return network(self._all_features) if known is None else known, self.encoder.index(packed)
        return network(self.encoder.features(packed)), torch.arange(len(packed), device=packed.device)

    def _pairwise_options(self, network: QNetwork, packed: Tensor, states: Tensor) -> Tensor:
        """Values of all actions of given pairs, shape (batch, k, n_options * n_actions)."""
        options, allowed = self.tables.options[states], self.tables.allowed[states]
        values = self._pairwise(network, packed, options.flatten(1))
        return self.tables.join_options(values.view(*options.shape, -1), allowed)

    def _pairwise(self, network: QNetwork, packed: Tensor, states: Tensor) -> Tensor:
        """Values of given pairs of observation and state, shape (batch, k, n_actions)."""
        k = states.shape[1]
        features = self.encoder.features(packed).repeat_interleave(k, dim=0)
        return network(features, states.reshape(-1)).view(-1, k, network.n_actions)  # type: ignore[no-any-return]
