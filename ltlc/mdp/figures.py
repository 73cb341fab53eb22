"""The figures of a verdict as lines of a table, as text and as JSON values."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ltlc.mdp.estimate import Estimate
from ltlc.mdp.verdict import EXACT_TITLES, Bounds, PolicyVerdict

PRECISION = 1e-12
"""what the linear systems of a verdict leave uncertain of a figure without proved bounds: 0 comes out as 1e-17."""


class Line(NamedTuple):
    """One figure of a policy, beside the same one of the best policy.

    Attributes:
        optimum: of the policy that is optimal for the rewards; None where it is not known.
        learned_bounds: proved bounds on `learned`, where there are any.
        optimum_bounds: likewise on `optimum`.
    """

    title: str
    learned: float | Estimate
    optimum: float | None
    learned_bounds: Bounds | None = None
    optimum_bounds: Bounds | None = None


def exact_lines(verdict: PolicyVerdict, optimum: PolicyVerdict | None) -> list[Line]:
    """The figures of a policy, beside those of the one that is optimal for the rewards."""
    return [
        Line(
            title,
            getattr(verdict, name),
            None if optimum is None else getattr(optimum, name),
            getattr(verdict, f"{name}_bounds", None),
            getattr(optimum, f"{name}_bounds", None),
        )
        for name, title in EXACT_TITLES.items()
    ]


def figure_text(value: float, bounds: Bounds | None = None, *, digits: int = 4) -> str:
    """A figure in a few characters, never rounded to the 0 or the 1 that it is known not to be.

    Args:
        value: the figure.
        bounds: proved bounds on it; None: it is right up to `PRECISION`.
        digits: that are shown, at least.

    Example:
        >>> figure_text(5.4e-17), figure_text(5.4e-17, (5.3e-17, 5.5e-17)), figure_text(0.99996)
        ('0', '5.4e-17', '0.99996')
    """
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if math.isnan(value):
        return "undefined"
    low, high = bounds or (value - PRECISION, value + PRECISION)
    for limit in (0, 1):
        if abs(value - limit) <= PRECISION and low <= limit <= high:
            return str(limit)
    if value == int(value) and abs(value) < 1e6:
        return str(int(value))
    if abs(value) >= 100:
        return f"{value:.1f}"
    texts = (f"{value:.{shown}g}" for shown in range(digits, 18))
    return next((text for text in texts if float(text) != 1), "1")


def verdict_values(verdict: PolicyVerdict) -> dict[str, Any]:
    """The figures as JSON values; infinities as text."""
    return {name: plain(getattr(verdict, name)) for name in EXACT_TITLES}


def plain(value: float | None) -> float | str | None:
    """A figure as a JSON value."""
    return value if value is None or math.isfinite(value) else str(value)
