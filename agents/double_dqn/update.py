"""One update of deep Q-learning on an automaton product: targets by table look-up, and the loss."""

from __future__ import annotations

import torch
from torch import Tensor

from ..encoder import ObservationEncoder
from ..tensor_tables import TensorTables, without_forbidden
from ..transitions import TransitionBatch
from .config import DQNConfig
from .networks import QNetwork


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
    and the next state q' are looked up by (q, letter class); so is V where the environment ends it. Targets are kept
    within what values can be, where that is known. Counterfactually, each of the m / k environment steps is taken in
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
        few = 0 < encoder.n_observations <= config.rows and not config.batch_norm and encoder.mask is None
        enumerated = few and (config.counterfactual or config.state_input == "heads")
        self._all_features = encoder.all_features().to(config.device) if enumerated else None

    def __call__(self, q_network: QNetwork, target_network: QNetwork, steps: TransitionBatch) -> Tensor:
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
        self, q_network: QNetwork, target_network: QNetwork, steps: TransitionBatch, online: Tensor | None = None
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
        return target.clamp(self.tables.least[states], self.tables.largest[states])

    def _states(self, steps: TransitionBatch) -> Tensor:
        """Automaton states each step is taken in, shape (batch, k)."""
        if self.config.counterfactual:
            return self.tables.learned.expand(len(steps.action), -1)
        return steps.state[:, None]  # type: ignore[no-any-return]

    def _values(self, network: QNetwork, steps: TransitionBatch, online: Tensor | None) -> Tensor:
        """Q(s, q, a) for each step and its states q, shape (batch, k)."""
        states, action = self._states(steps), steps.action
        if online is None and network.state_input != "heads":
            pairs = self._pairwise(network, steps.observation, states)
            return pairs.gather(-1, action[:, None, None].expand(-1, states.shape[1], 1))[..., 0]
        rows, row = self._rows(network, steps.observation, online)
        flat = (row[:, None] * network.n_states + states) * network.n_actions + action[:, None]
        values: Tensor = rows.reshape(-1)[flat]
        return values

    def _next_values(
        self, network: QNetwork, target: QNetwork, packed: Tensor, states: Tensor, online: Tensor | None
    ) -> Tensor:
        """V(s', q') for each step and its next states q', shape (batch, k)."""
        double = self.config.double
        if self._all_features is None and target.state_input != "heads":
            valued = self._pairwise_options(target, packed, states)
            chosen = self._pairwise_options(network, packed, states) if double else valued
            chosen = without_forbidden(chosen, self.encoder.allowed(packed))
            valued = valued if double else chosen
            return policy_values(valued, chosen, double)
        rows, row = self._rows(target, packed, None)
        chosen = self._rows(network, packed, online)[0] if double else rows
        if self.tables.n_options > 1:
            rows, chosen = (
                self.tables.join_options(values[:, self.tables.options], self.tables.allowed)
                for values in (rows, chosen)
            )
        if self.encoder.mask is not None:  # then there is a row for each of the batch
            chosen = without_forbidden(chosen, self.encoder.allowed(packed))
            rows = rows if double else chosen
        return policy_values(rows, chosen, double).reshape(-1)[row[:, None] * target.n_states + states]

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
