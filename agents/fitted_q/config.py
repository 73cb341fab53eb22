"""Hyperparameters of fitted Q iteration."""

from __future__ import annotations

from dataclasses import dataclass

from ..config import OffPolicyConfig


@dataclass(frozen=True, kw_only=True)
class FittedQConfig(OffPolicyConfig):
    """Hyperparameters of fitted Q iteration with a table; see `OffPolicyConfig` for all of them.

    Epsilon is the part of the sub-environments that look for what was seldom tried.

    Raises:
        InvalidArgumentError: a value is out of range.

    Example:
        >>> round(FittedQConfig(total_steps=20_000, epsilon_steps=5_000).epsilon_at(5_000), 6)
        0.3

    References:
        D. Ernst, P. Geurts, L. Wehenkel, Tree-based batch mode reinforcement learning, JMLR 2005,
        https://www.jmlr.org/papers/v6/ernst05a.html.
        A. L. Strehl, M. L. Littman, An analysis of model-based interval estimation for Markov decision processes, JCSS
        2008, https://doi.org/10.1016/j.jcss.2007.08.009 (exploration).
        R. Toro Icarte et al., Reward machines: exploiting reward function structure in reinforcement learning, JAIR
        2022, https://doi.org/10.1613/jair.1.12440 (counterfactual experience).
    """
