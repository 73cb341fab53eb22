"""The loss of segments of steps: what follows is followed for as long as it was greedy, in every automaton state."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, huber_loss

from ..encoder import ObservationEncoder
from ..tensor_tables import TensorTables, without_forbidden
from .config import DQNConfig
from .networks import QNetwork
from .replay import Segments

_NEARER = 0.98
"""what is a step away is worth so much of what is here, to curiosity."""
_SHARE = 0.5
"""of curiosity in the loss."""


def seek(outputs: Tensor, tries: Tensor) -> Tensor:
    """What actions are worth to curiosity: by what they lead to, or by themselves; both of shape (..., n_actions)."""
    return torch.maximum(torch.sigmoid(outputs), (1 + tries).to(outputs.dtype).rsqrt())


class TraceLoss:
    """The loss of segments, in which every step is taken in all automaton states q at once.

    The target of a step is r + g W(q'), where the reward r, the weight g of what follows and the next state q' are
    looked up by (q, letter class). W(q') is the target of the next step from q' (a part `trace_decay` of it), if the
    action made there was the best one in q', and else what the target network says the best one is worth; as long as
    an action is held, all of it. So targets go back from the end of the segment, for all states at once, and are those
    of the greedy policy though another one acted. They are kept within what values can be.

    Squashed outputs are compared by the cross entropy, where target and value are parts of the width of the bounds, and
    other outputs by Huber's loss.

    The target of an action is lowered by a part `advantage_learning` of what the target network thinks that the action
    is behind the best one. The best one keeps its value, and others fall behind until the distance is 1 / (1 - part)
    times what it would be. Where a world moves a little at a time, all actions are worth almost the same, and else the
    errors of the network would say which is the best.

    With curiosity, a second set of outputs learns how near, in steps discounted by 0.98, an action is that was little
    tried: being where one was tried n times is worth 1 / sqrt(1 + n), by the counts of today and not of then.

    Args:
        encoder: of the observations.
        tables: of the task.
        config: `double`, `trace_decay`, and `advantage_learning` at the start are used.
        tries: how often each action was tried, shape (n_states, n_places, n_actions); the agent goes on counting.

    Attributes:
        advantage_learning: the part by which targets are lowered now.

    References:
        C. J. C. H. Watkins, Learning from delayed rewards, Cambridge 1989, https://www.cs.rhul.ac.uk/~chrisw/thesis.html
        (traces that end where the action is not greedy). A. Harutyunyan, M. G. Bellemare, T. Stepleton, R. Munos,
        Q(lambda) with off-policy corrections, ALT 2016, https://arxiv.org/abs/1602.04951. R. Toro Icarte et al., Reward
        machines, JAIR 2022, https://doi.org/10.1613/jair.1.12440 (counterfactual experiences). R. I. Brafman,
        M. Tennenholtz, R-max, JMLR 2002, https://www.jmlr.org/papers/v3/brafman02a.html (curiosity). M. G. Bellemare,
        G. Ostrovski, A. Guez, P. S. Thomas, R. Munos, Increasing the action gap, AAAI 2016,
        https://doi.org/10.1609/aaai.v30i1.10303 (advantage learning).
    """

    def __init__(self, encoder: ObservationEncoder, tables: TensorTables, config: DQNConfig, tries: Tensor) -> None:
        self.encoder, self.tables, self.config, self.tries = encoder, tables, config, tries
        self.advantage_learning = config.advantage_learning_at(0)

    def __call__(self, q_network: QNetwork, target_network: QNetwork, segments: Segments) -> Tensor:
        """The loss of sampled segments; differentiable in the weights of `q_network` alone."""
        count, length = segments.letter_class.shape[:2]
        shape = (count, length + 1, q_network.n_states, q_network.n_actions)
        rows, which = self._distinct(segments.observation.flatten(0, 1))
        features = self.encoder.features(rows)
        inputs = q_network.inputs(features)
        outputs, seeking = _spread(q_network.outputs_and_novelty(inputs), which)
        taken = segments.action[:, :-1, None, None].expand(-1, -1, q_network.n_states, 1)
        with torch.no_grad():
            following = target_network.inputs(features) if inputs.requires_grad else inputs
            ahead, sought = _spread(target_network.outputs_and_novelty(following), which)
            allowed = self.encoder.allowed(segments.observation.flatten(0, 1))
            valued = target_network.values(ahead)
            worth = online = without_forbidden(valued, allowed).view(shape)
            if self.config.double:
                online = without_forbidden(q_network.values(outputs.detach()), allowed).view(shape)
            targets = self.targets(segments, worth[:, 1:], online[:, 1:])
            behind = worth[:, :-1].amax(dim=-1) - valued.view(shape)[:, :-1].gather(3, taken)[..., 0]
            targets -= self.advantage_learning * behind
            targets = targets.clamp(self.tables.least, self.tables.largest)
        learned, real = self.tables.open, segments.real[:, :-1, None].to(targets.dtype)
        part = real / real.sum().clamp(min=1)
        found, wanted = outputs.view(shape)[:, :-1].gather(3, taken)[..., learned, 0], targets[..., learned]
        if q_network.bounds is None:
            each = huber_loss(found, wanted, reduction="none")
        else:
            low, high = q_network.bounds[:, learned]
            each = binary_cross_entropy_with_logits(found, (wanted - low) / (high - low), reduction="none")
        loss = (part * each).sum()
        if len(seeking):
            with torch.no_grad():
                sought = without_forbidden(sought, allowed).view(shape)
                near = self.novelty(segments, sought[:, 1:])[..., learned]
            seeking = seeking.view(shape)[:, :-1].gather(3, taken)[..., learned, 0]
            each = binary_cross_entropy_with_logits(seeking, near, reduction="none")
            loss = loss + _SHARE * (part * each).sum()
        return loss

    def _distinct(self, rows: Tensor) -> tuple[Tensor, Tensor | None]:
        """Rows that differ, and which of them each row is; None: all of them are passed on."""
        if not self.encoder.n_observations or self.encoder.mask is not None:
            return rows, None
        numbers, which = torch.unique(self.encoder.index(rows), return_inverse=True)
        first = torch.zeros_like(numbers).scatter_(0, which, torch.arange(len(rows), device=rows.device))
        return rows[first], which

    def novelty(self, segments: Segments, sought: Tensor) -> Tensor:
        """The targets of curiosity.

        Args:
            segments: the steps.
            sought: outputs of the second set after each step; shape (count, length, n_states, n_actions).

        Returns:
            Shape (count, length, n_states), in [0, 1].
        """
        tries = self.tries[:, segments.place[:, 1:]].permute(1, 2, 0, 3)
        value = seek(sought, tries).amax(dim=-1)
        goes_on = _NEARER * (self.tables.discount.T[segments.letter_class[..., 0]] > 0) * ~segments.terminated
        following = self.tables.next_state.T[segments.letter_class[..., 0]]
        target, found = torch.zeros_like(value[:, 0]), []
        for t in reversed(range(value.shape[1])):
            after = torch.maximum(value[:, t], target * segments.real[:, t + 1, None])
            target = goes_on[:, t] * after.gather(1, following[:, t])
            found.append(target)
        return torch.stack(found[::-1], dim=1)

    def targets(self, segments: Segments, worth: Tensor, online: Tensor) -> Tensor:
        """The targets of each action and automaton state.

        Args:
            segments: the steps.
            worth: values of the actions after each action, by the target network; shape (count, length, n_states,
                n_actions).
            online: the values that say which action is best; of the same shape.

        Returns:
            Shape (count, length, n_states).
        """
        tables, n_actions = self.tables, worth.shape[-1]
        if tables.n_options > 1:
            worth, online = (tables.join_options(v[:, :, tables.options], tables.allowed) for v in (worth, online))
        best = online.argmax(dim=-1)
        value = worth.gather(-1, best[..., None])[..., 0]
        options = tables.options[torch.arange(best.shape[-1], device=best.device), best // n_actions]
        greedy = (best % n_actions == segments.action[:, 1:, None]) & segments.real[:, 1:, None]
        part = self.config.trace_decay * greedy.to(value.dtype)
        part[:, -1] = 0.0
        classes, over = segments.letter_class, segments.terminated[..., None]
        reward, weight, following, final = (
            table.T[classes] for table in (tables.reward, tables.discount, tables.next_state, tables.final_value)
        )
        # target = known + traced * (target of the next step, in the state that follows, or is chosen after it)
        known = reward + segments.base_reward[..., None] / tables.scale + torch.where(over, weight * final, 0.0)
        traced, stay = torch.where(over, 0.0, weight), torch.arange(known.shape[-1], device=known.device)
        if not (made := segments.made[..., None]).all():  # nothing happens where no step was made
            known, traced = torch.where(made, known, 0.0), torch.where(made, traced, 1.0)
            following = torch.where(made, following, stay)
        chosen, last = following.clone(), following[:, :, -1]
        known[:, :, -1] += traced[:, :, -1] * ((1 - part) * value).gather(2, last)
        traced[:, :, -1] *= part.gather(2, last)
        chosen[:, :, -1] = options.gather(2, last)
        target, found = torch.zeros_like(value[:, 0]), []
        steps = zip(*(x.flatten(1, 2).unbind(1)[::-1] for x in (known, traced, chosen)), strict=True)
        for known_t, traced_t, chosen_t in steps:
            target = torch.addcmul(known_t, traced_t, target.gather(1, chosen_t)).clamp(tables.least, tables.largest)
            found.append(target)
        return torch.stack(found[::-1][:: classes.shape[2]], dim=1)


def _spread(sets: tuple[Tensor, Tensor], which: Tensor | None) -> tuple[Tensor, Tensor]:
    """Outputs of rows, given those of the rows that differ."""
    if which is None:
        return sets
    first, second = (part.index_select(0, which) if len(part) else part for part in sets)
    return first, second
