"""Figures from rollouts with confidence intervals: for environments without a known model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import special

from ltlc.errors import InvalidArgumentError


@dataclass(frozen=True)
class Estimate:
    """A number measured on a sample, and the interval that covers the true one with the given confidence.

    Attributes:
        value: measured on the sample.
        low, high: ends of the interval.
        confidence: in (0, 1).
        n: size of the sample.
    """

    value: float
    low: float
    high: float
    confidence: float
    n: int

    def __str__(self) -> str:
        return f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}] ({self.confidence:.0%}, n = {self.n})"


def probability(
    successes: int,
    n: int,
    *,
    confidence: float = 0.95,
    method: Literal["wilson", "clopper-pearson", "anytime"] = "wilson",
) -> Estimate:
    """The probability of an event that was seen in `successes` of `n` independent trials.

    "wilson" covers the truth about as often as it says; "clopper-pearson" at least as often, and is wider. Both are for
    a number of trials that was fixed beforehand. "anytime" is wider again and holds for all numbers of trials at once:
    with the given confidence no interval of the whole sequence misses the truth, so one may stop when one likes what
    one sees.

    Raises:
        InvalidArgumentError: no trials, counts that do not fit, a confidence outside (0, 1), or an unknown method.

    References:
        E. Wilson, Probable inference, the law of succession, and statistical inference, JASA 22, 1927,
        DOI 10.1080/01621459.1927.10502953. C. Clopper, E. Pearson, The use of confidence or fiducial limits illustrated
        in the case of the binomial, Biometrika 26, 1934, DOI 10.1093/biomet/26.4.404. H. Robbins, Statistical methods
        related to the law of the iterated logarithm, Annals of Mathematical Statistics 41(5), 1970,
        DOI 10.1214/aoms/1177696786 (the mixture of likelihood ratios that "anytime" inverts; here over Beta(1/2, 1/2)).

    >>> print(probability(8, 10))
    0.8 [0.4902, 0.9433] (95%, n = 10)
    >>> print(probability(8, 10, method="anytime"))
    0.8 [0.3425, 0.9906] (95%, n = 10)
    """
    _check_sample(n, confidence, at_least=1)
    if not 0 <= successes <= n:
        raise InvalidArgumentError(f"{successes} successes in {n} trials")
    rate = successes / n
    tail = (1 - confidence) / 2
    if method == "wilson":
        z = float(special.ndtri(1 - tail))
        center = (rate + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * np.sqrt(rate * (1 - rate) / n + z * z / (4 * n * n))
        low, high = max(0.0, center - half), min(1.0, center + half)
    elif method == "clopper-pearson":
        low = 0.0 if successes == 0 else float(special.betaincinv(successes, n - successes + 1, tail))
        high = 1.0 if successes == n else float(special.betaincinv(successes + 1, n - successes, 1 - tail))
    elif method == "anytime":
        low, high = _anytime_interval(successes, n - successes, 1 - confidence)
    else:
        raise InvalidArgumentError(f'method is {method!r}, expected "wilson", "clopper-pearson" or "anytime"')
    return Estimate(rate, 0.0 if successes == 0 else float(low), 1.0 if successes == n else float(high), confidence, n)


def mean(
    sample: npt.ArrayLike,
    *,
    confidence: float = 0.95,
    method: Literal["t", "bootstrap"] = "t",
    resamples: int = 10_000,
    seed: int = 0,
) -> Estimate:
    """The mean of independent observations, such as the returns of episodes.

    "t" is Student's interval, good for large samples or normal data; "bootstrap" takes percentiles of resampled means.

    Raises:
        InvalidArgumentError: fewer than two observations, one that is not finite, a confidence outside (0, 1), or an
            unknown method.

    References:
        B. Efron, R. Tibshirani, An Introduction to the Bootstrap, Chapman & Hall 1993, chapters 12 and 13.
    """
    values = np.asarray(sample, dtype=np.float64).ravel()
    n = len(values)
    _check_sample(n, confidence, at_least=2)
    if not np.isfinite(values).all():
        raise InvalidArgumentError(f"observation {np.flatnonzero(~np.isfinite(values))[0]} is not a finite number")
    tail = (1 - confidence) / 2
    center = float(values.mean())
    if method == "t":
        half = float(special.stdtrit(n - 1, 1 - tail) * values.std(ddof=1) / np.sqrt(n))
        return Estimate(center, center - half, center + half, confidence, n)
    if method != "bootstrap":
        raise InvalidArgumentError(f'method is {method!r}, expected "t" or "bootstrap"')
    rng = np.random.default_rng(seed)
    means = np.array([values[rng.integers(n, size=n)].mean() for _ in range(resamples)])
    low, high = np.quantile(means, [tail, 1 - tail])
    return Estimate(center, float(low), float(high), confidence, n)


def ratio(numerators: npt.ArrayLike, denominators: npt.ArrayLike, *, confidence: float = 0.95) -> Estimate:
    """The ratio of two means over independent episodes, such as violations per step.

    The interval is that of the delta method: the residuals numerator - ratio * denominator are averaged.

    Raises:
        InvalidArgumentError: fewer than two episodes, lengths that differ, values that are not finite, denominators
            that are negative or all 0, or a confidence outside (0, 1).

    References:
        W. Cochran, Sampling Techniques, 3rd ed., Wiley 1977, chapter 6.
    """
    top, bottom = (np.asarray(values, dtype=np.float64).ravel() for values in (numerators, denominators))
    n = len(top)
    _check_sample(n, confidence, at_least=2)
    if len(bottom) != n or not (np.isfinite(top).all() and np.isfinite(bottom).all()):
        raise InvalidArgumentError(f"{n} numerators and {len(bottom)} denominators: expected as many, all finite")
    if (bottom < 0).any() or bottom.sum() == 0:
        raise InvalidArgumentError("denominators must not be negative, nor all 0")
    value = float(top.sum() / bottom.sum())
    spread = float((top - value * bottom).std(ddof=1) / np.sqrt(n) / bottom.mean())
    half = float(special.stdtrit(n - 1, (1 + confidence) / 2)) * spread
    return Estimate(value, value - half, value + half, confidence, n)


def _anytime_interval(successes: int, failures: int, error: float) -> tuple[float, float]:
    """The probabilities against which the mixture of likelihood ratios stays below 1 / error, rounded outwards.

    Under the true probability the mixture is a martingale of mean 1, so by Ville's inequality it ever reaches 1 / error
    with probability `error` at most.
    """
    mixture = float(special.betaln(successes + 0.5, failures + 0.5) - special.betaln(0.5, 0.5))
    most, rate = mixture + math.log(error), successes / (successes + failures)

    def refuted(p: float) -> bool:
        if (successes and p <= 0) or (failures and p >= 1):
            return True
        seen = (successes * math.log(p) if successes else 0.0) + (failures * math.log1p(-p) if failures else 0.0)
        return seen <= most

    low, high, below, above = 0.0, 1.0, rate, rate
    for _ in range(80):  # halves what is left, from outside
        middle = (low + below) / 2
        low, below = (middle, below) if refuted(middle) else (low, middle)
        middle = (above + high) / 2
        above, high = (above, middle) if refuted(middle) else (middle, high)
    return low, high


def _check_sample(n: int, confidence: float, *, at_least: int) -> None:
    if n < at_least:
        raise InvalidArgumentError(f"a sample of {n}; at least {at_least} needed")
    if not 0 < confidence < 1:
        raise InvalidArgumentError(f"confidence is {confidence}, expected a number between 0 and 1")
