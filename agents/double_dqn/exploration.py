"""How sub-environments explore: exploring starts in automaton states, a ladder of epsilons, whims that last."""

from __future__ import annotations

import torch
from torch import Tensor

from ..tensor_tables import TensorTables
from .config import DQNConfig

_OWN, _FRESH = -1, -2
"""instead of a state: acts for its own; an episode begins."""


class ExploringStarts:
    """The automaton state that each sub-environment acts for: its own, or one that it only acts as if it were in.

    Since every step teaches all automaton states, it need not be made in the one it is best for. So some episodes start
    in a random one that is not decided yet, and go on from there as the automaton does; and wherever what is acted for
    is decided, it goes on in a random one. What comes late in a task is so practised from the beginning, from wherever
    the environment happens to be.

    Args:
        config: `exploring_starts` is used, the part of the episodes.
        tables: of the task.

    References:
        R. S. Sutton, A. G. Barto, Reinforcement learning, 2nd edition, MIT Press 2018, section 5.3,
        http://incompleteideas.net/book/the-book-2nd.html (exploring starts).
    """

    def __init__(self, config: DQNConfig, tables: TensorTables) -> None:
        self._part = config.exploring_starts if config.counterfactual else 0.0
        self._open = tables.open.cpu()
        self._undecided = torch.zeros(len(tables.least), dtype=torch.bool)
        self._undecided[self._open] = True
        self._following, self._options = tables.next_state.cpu(), tables.options.cpu()
        self._state = self._now = torch.zeros(0, dtype=torch.int64)

    def clear(self) -> None:
        """Forget what is under way, since new episodes begin everywhere."""
        self._state = torch.zeros(0, dtype=torch.int64)

    def states(self, own: Tensor, generator: torch.Generator) -> Tensor:
        """The automaton states to act for in this step, shape (n,).

        Draws the same amount from the generator whatever happens, and nothing where no episode starts elsewhere.

        Args:
            own: automaton state of each sub-environment, shape (n,).
            generator: of what is random.
        """
        if not self._part or not len(self._open):
            return own
        if len(self._state) != len(own):
            self._state = torch.full((len(own),), _FRESH)
        chance, which = torch.rand((2, len(own)), generator=generator, dtype=torch.float64)
        drawn = self._open[(which * len(self._open)).long()]
        fresh = self._state == _FRESH
        self._state = torch.where(fresh, torch.where(chance < self._part, drawn, _OWN), self._state)
        self._now = torch.where(self._state == _OWN, own, self._state)
        decided = ~self._undecided[self._now]
        self._state = torch.where(decided, drawn, self._state)
        self._now = torch.where(decided, drawn, self._now)
        return self._now

    def choose(self, choice: Tensor) -> None:
        """Take note of the pairs that are chosen in these states (0: none), shape (n,)."""
        if len(self._state):
            self._now = self._options[self._now, choice]

    def advance(self, copies: Tensor, letter_class: Tensor, ended: Tensor) -> None:
        """Go on as the automaton does.

        Args:
            copies: sub-environments that made a step, shape (m,).
            letter_class: of each step.
            ended: whether its episode is over.
        """
        if len(self._state):
            there = self._state[copies]
            after = torch.where(there == _OWN, _OWN, self._following[self._now[copies], letter_class])
            self._state[copies] = torch.where(ended, _FRESH, after)


class Whims:
    """What each sub-environment does instead of what is best: a random action, for a while.

    Args:
        config: `ladder` and `persistence` are used.
        n_actions: of the environment.

    References:
        W. Dabney, G. Ostrovski, A. Barreto, Temporally-extended epsilon-greedy exploration, ICLR 2021,
        https://arxiv.org/abs/2006.01782. D. Horgan et al., Distributed prioritized experience replay, ICLR 2018,
        https://arxiv.org/abs/1803.00933 (ladder).
    """

    def __init__(self, config: DQNConfig, n_actions: int) -> None:
        self._config, self._n_actions = config, n_actions
        self._action = self._left = torch.zeros(0, dtype=torch.int64)

    def clear(self) -> None:
        """Forget what is under way, since new episodes begin everywhere."""
        self._left = torch.zeros(0, dtype=torch.int64)

    def draw(self, deciding: Tensor, epsilon: float, generator: torch.Generator) -> Tensor:
        """Begin whims by chance, and go on with those that last.

        Draws the same amount from the generator whatever happens.

        Args:
            deciding: which sub-environments are to choose an action, shape (n,), bool; see `HeldActions`.
            epsilon: probability of a whim at the foot of the ladder, wherever an action is chosen.
            generator: of what is random.

        Returns:
            The random actions, or -1 where the policy is to be followed, shape (n,).
        """
        n, most = len(deciding), self._config.persistence
        if len(self._left) != n:
            self._action, self._left = (torch.zeros(n, dtype=torch.int64) for _ in range(2))
        action = torch.randint(self._n_actions, (n,), generator=generator)
        chance, lasting = torch.rand((2, n), generator=generator, dtype=torch.float64)
        rung = torch.arange(n, dtype=torch.float64) / max(n - 1, 1)
        begins = deciding & (self._left == 0) & (chance < epsilon ** (1 + self._config.ladder * rung))
        lasts = torch.arange(n) % 2 == 1
        steps = torch.where(lasts, (1 / (1 - lasting)).long().clamp(max=most), 1)
        self._action = torch.where(begins, action, self._action)
        self._left = torch.where(begins, steps, self._left)
        active = self._left > 0
        self._left = (self._left - 1).clamp(min=0)
        return torch.where(active, self._action, -1)


def with_random_choices(
    actions: Tensor, states: Tensor, tables: TensorTables, n_actions: int, generator: torch.Generator
) -> Tensor:
    """The actions, together with a choice drawn uniformly; none where that one cannot be made.

    Args:
        actions: shape (n,).
        states: table states, shape (n,).
        tables: of the task.
        n_actions: of the environment.
        generator: of what is random.
    """
    choice = torch.randint(tables.n_options, actions.shape, generator=generator)
    allowed = tables.allowed.cpu()[states, choice]
    return actions + n_actions * torch.where(allowed, choice, 0)
