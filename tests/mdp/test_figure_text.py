"""Figures for people: nothing is printed as 0 or 1 that is known to be neither, and rounding alone as nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ltlc.mdp import LabelledMDP
from ltlc.mdp.figures import PRECISION, exact_lines, figure_text
from ltlc.mdp.verdict import Judge
from ltlc.task import Task


@pytest.mark.parametrize(("value", "bounds", "text"), [
    (5.437e-17, None, "0"),
    (-5.437e-17, None, "0"),
    (0.0, None, "0"),
    (-0.0, None, "0"),
    (1 - 1e-16, None, "1"),
    (1 + 2e-16, None, "1"),
    (0.99996, None, "0.99996"),
    (0.9999999, None, "0.9999999"),
    (1.00001, None, "1.00001"),
    (3e-9, None, "3e-09"),
    (5.437e-17, (5.4e-17, 5.5e-17), "5.437e-17"),
    (1 - 2**-50, (1 - 2**-49, 1 - 2**-51), "0.999999999999999"),
    (2e-17, (0.0, 1e-6), "0"),
    (math.inf, None, "∞"),
    (-math.inf, None, "-∞"),
    (math.nan, None, "undefined"),
    (3.0, None, "3"),
    (-7424748.25, None, "-7424748.2"),
    (118.74, None, "118.7"),
    (0.82352941, None, "0.8235"),
])  # fmt: skip
def test_texts(value: float, bounds: tuple[float, float] | None, text: str) -> None:
    assert figure_text(value, bounds) == text


def test_any_figure_is_near_its_text_and_keeps_its_side_of_0_and_1() -> None:
    rng = np.random.default_rng(5)
    for value in np.concatenate((10 ** rng.uniform(-14, 1, 2000), 1 - 10 ** rng.uniform(-11.5, 0, 2000))).tolist():
        for digits in (4, 6):
            shown = float(figure_text(value, digits=digits))
            assert shown == pytest.approx(value, rel=0.6 * 10 ** (1 - digits), abs=PRECISION)
            if value > PRECISION:
                assert shown > 0
            if abs(value - 1) > 2 * PRECISION:
                assert (shown < 1) == (value < 1)


def test_a_proved_probability_is_not_rounded_away() -> None:
    """A chain of forty coins: 2**-40 is less than the precision of other figures, and yet it is no 0."""
    matrix = np.zeros((1, 42, 42))
    for i in range(40):
        matrix[0, i, [i + 1, 41]] = 0.5
    matrix[0, [40, 41], [40, 41]] = 1
    task = Task("F a")
    mdp = LabelledMDP.from_arrays(matrix, aps=("a",), labels={40: "a"})
    judge = Judge(mdp, task)
    assert judge.optimum is not None
    line = exact_lines(judge.optimum, None)[0]
    assert isinstance(line.learned, float)
    assert line.learned < PRECISION
    assert float(figure_text(line.learned, line.learned_bounds)) == pytest.approx(2.0**-40, rel=1e-3)
