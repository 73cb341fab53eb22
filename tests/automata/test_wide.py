"""Looking at different entries of rows gives what looking at all columns does."""

from __future__ import annotations

import random
from typing import Literal

import numpy as np
import pytest
from random_ltl import random_formula

import ltlc
from ltlc.automata import partition, rabin_pairs, tables, wide
from ltlc.automata.partition import refine
from ltlc.automata.wide import grouped_columns, replaced, told_apart, value_masks

FORMULAS = [
    "GF a & GF b & GF c & G !d",
    "F(a & F(b & F c))",
    "(GF a -> GF b) & (GF c -> GF d)",
    "FG a | FG b & GF c",
    "GF(a & X b) & F(c & X d)",
    "G(a -> F b) | FG(c U d)",
]


def narrow(monkeypatch: pytest.MonkeyPatch, long: int) -> None:
    """Take every table for a wide one, and none for one that is kept as lists."""
    monkeypatch.setattr(tables, "FEW_ENTRIES", 0)
    monkeypatch.setattr(rabin_pairs, "FEW_ENTRIES", 0)
    monkeypatch.setattr(wide, "_WIDE", 1)
    monkeypatch.setattr(wide, "_LARGE", 1)
    monkeypatch.setattr(wide, "LONG", long)
    monkeypatch.setattr(partition, "_WIDE", 1)
    monkeypatch.setattr(partition, "_SOME", 2)


@pytest.mark.parametrize("long", [1, 1 << 11])
@pytest.mark.parametrize("acceptance", ["state", "transition"])
def test_translation_is_the_same(
    acceptance: Literal["state", "transition"], long: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = random.Random(long)
    formulas = [*FORMULAS, *(str(random_formula(rng, 10)) for _ in range(20))]
    wanted = [ltlc.compile(formula, acceptance=acceptance).to_json() for formula in formulas]
    narrow(monkeypatch, long)
    assert [ltlc.compile(formula, acceptance=acceptance).to_json() for formula in formulas] == wanted


@pytest.mark.parametrize("seed", range(20))
def test_partitions(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(seed)
    delta = rng.integers(9, size=(9, 40)).astype(np.int32)
    delta[rng.integers(9, size=4)] = delta[0]
    block = rng.integers(2, size=9).astype(np.int32)
    wanted = refine(delta, block).tolist()
    narrow(monkeypatch, 1)
    assert refine(delta, block).tolist() == wanted


@pytest.mark.parametrize("n_columns", [1, 3, 30])
@pytest.mark.parametrize("largest", [1, 2, 50, 1 << 40])
def test_positions_are_told_apart_by_what_columns_say(n_columns: int, largest: int) -> None:
    rng = np.random.default_rng(n_columns)
    columns = [rng.integers(largest, size=100) * (rng.random(100) < 0.3) for _ in range(n_columns)]
    key = told_apart(columns, 100).tolist()
    rows = list(zip(*(column.tolist() for column in columns), strict=True))
    assert len(set(zip(key, rows, strict=True))) == len(set(key)) == len(set(rows)) == max(key) + 1


def test_values_and_their_places() -> None:
    rng = np.random.default_rng(1)
    row = rng.choice(np.array([7, 100_000, 3, 1 << 40]), size=200)
    masks = list(value_masks(row))
    assert [value for value, _ in masks] == list(dict.fromkeys(row.tolist()))
    assert all((mask == (row == value)).all() for value, mask in masks)
    groups = grouped_columns(row[None])
    assert groups.values[groups.order].tolist() == [value for value, _ in masks]
    new = np.arange(len(masks))
    for shift in (0, 30):  # few values by a table, large ones by search
        codes = row % (1 << 10) << shift
        old = list(dict.fromkeys(codes.tolist()))
        assert replaced(codes, old, new[: len(old)]).tolist() == [old.index(code) for code in codes.tolist()]
