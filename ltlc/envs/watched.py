"""An environment watched by a monitor."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
from gymnasium.utils import RecordConstructorArgs

from ltlc.automata import DFA
from ltlc.automata.possible import names_in
from ltlc.envs.declared import declared_letters
from ltlc.envs.labeller import labeller_for
from ltlc.envs.labels import LabelSource, importable
from ltlc.errors import check_type
from ltlc.ltl import Formula
from ltlc.monitor import Monitor


class MonitorWrapper(gym.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Says of each step what is known of a formula, and changes nothing else.

    `info["monitor"]` is the verdict after the letter of the observation, an `ltlc.Verdict`; the first letter of an
    episode is that of the observation of `reset`.

    Args:
        env: any environment.
        formula: what to watch: a formula, its text, or an automaton over finite traces.
        labels: what holds in an observation; as of `ltlc.LTLWrapper`.
        finite: whether the formula is about finite traces; see `ltlc.Monitor`.

    Raises:
        LtlSyntaxError: the text is not a formula.
        InvalidArgumentError: the labels do not fit.

    Example:
        >>> import gymnasium
        >>> lake = gymnasium.make("FrozenLake-v1", is_slippery=False)
        >>> labels = {"goal": lambda state: state == 15, "hole": lambda state: state in (5, 7, 11, 12)}
        >>> env = MonitorWrapper(lake, "F goal & G !hole", labels)
        >>> _, info = env.reset(seed=0)
        >>> info["monitor"].value
        'presumably violated'
        >>> [env.step(action)[4]["monitor"].value for action in (1, 2)]
        ['presumably violated', 'violated']
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        formula: Formula | str | DFA,
        labels: LabelSource = None,
        *,
        finite: bool = False,
    ) -> None:
        RecordConstructorArgs.__init__(
            self,
            formula=str(formula) if isinstance(formula, Formula) else formula,
            labels=importable(labels),
            finite=finite,
        )
        check_type(env, gym.Env, "env", "an environment of Gymnasium")
        super().__init__(env)
        self.monitor = Monitor(formula, finite=finite, **declared_letters(env)._asdict())
        self.labeller = labeller_for(labels, self.monitor.aps, env)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, and another word."""
        observation, info = self.env.reset(seed=seed, options=options)
        self.monitor.reset()
        return observation, self._seen(observation, info)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step the environment and the monitor."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, self._seen(observation, info)

    def _seen(self, observation: Any, info: dict[str, Any]) -> dict[str, Any]:
        letter = names_in(self.monitor.aps, self.labeller.letter(observation, info))
        return {**info, "monitor": self.monitor.step(letter)}
