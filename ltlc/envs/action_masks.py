"""Masks of an environment's own: which actions it allows now."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from ltlc.errors import InvalidArgumentError

BoolArray = npt.NDArray[np.bool_]

MASK = "action_mask"
"""of the mask in infos, as Gymnasium's Taxi has it, or in observations that are dicts; 1 where an action is allowed."""


class ActionMasks:
    """The masks that an environment shows, in its observations or else in its infos.

    Where a mask allows nothing, as in states that end an episode, everything is allowed.

    Args:
        observations: space of one observation.
        actions: space of one action; there are masks of discrete actions only.
        num_envs: sub-environments; None: a single environment.

    Attributes:
        observed: whether they are in the observations.
        allowed: now, shape (n_actions,) or (num_envs, n_actions); None where no masks are shown.
    """

    def __init__(
        self, observations: spaces.Space[Any], actions: spaces.Space[Any], num_envs: int | None = None
    ) -> None:
        self._n = int(actions.n) if isinstance(actions, spaces.Discrete) else 0
        self._shape = (self._n,) if num_envs is None else (num_envs, self._n)
        self.observed = isinstance(observations, spaces.Dict) and MASK in observations.spaces
        self.allowed: BoolArray | None = None
        self._seen = False

    def shown_by(self, env: Any) -> bool:
        """Whether an environment shows masks; if it was not yet reset, it is to find out."""
        if not self._seen:
            self.see(*env.reset(seed=0))
        return self.allowed is not None

    def see(self, observation: Any, info: Mapping[str, Any], where: BoolArray | None = None) -> None:
        """Take the masks that come with a reset or step.

        Args:
            observation: or a batch.
            info: or those of a batch; sub-environments that show no mask allow everything.
            where: which sub-environments were reset; None: all, or a step.

        Raises:
            InvalidArgumentError: the masks have another shape.
        """
        self._seen, found = True, self._found(observation, info)
        if found is not None and where is not None and self.allowed is not None:
            found = np.where(where[:, None], found, self.allowed)
        self.allowed = found

    def see_last(self, infos: Mapping[str, Any], ended: BoolArray) -> None:
        """Go back to the masks of last observations where episodes have ended (autoreset mode SAME_STEP)."""
        if self.allowed is None:
            return
        last: Any = None if self.observed else self._found(None, infos["final_info"])
        if self.observed:
            last = self.allowed.copy()
            for i in np.flatnonzero(ended):
                last[i] = usable(np.asarray(infos["final_obs"][i][MASK]) != 0)
        self.allowed = np.where(ended[:, None], True if last is None else last, self.allowed)

    def within(self, mask: BoolArray) -> BoolArray:
        """What is allowed of a mask whose last axis may repeat the actions."""
        if self.allowed is None:
            return mask
        return mask & np.tile(self.allowed, mask.shape[-1] // self._n)

    def _found(self, observation: Any, info: Mapping[str, Any]) -> BoolArray | None:
        masks = observation[MASK] if self.observed else info.get(MASK)
        if masks is None or not self._n:
            return None
        allowed = np.asarray(masks)
        if allowed.shape != self._shape:
            raise InvalidArgumentError(
                f"{MASK!r} of the environment has shape {allowed.shape}; it must be {self._shape}, "
                "1 where an action is allowed"
            )
        shown = None if self.observed else info.get(f"_{MASK}")
        found: BoolArray = usable(allowed != 0)
        return found if shown is None else found | ~np.asarray(shown, dtype=np.bool_)[:, None]


def usable(allowed: Any) -> Any:
    """A mask, bool, of which rows that allow nothing allow everything; an array or a tensor."""
    return allowed | ~allowed.any(-1)[..., None]
