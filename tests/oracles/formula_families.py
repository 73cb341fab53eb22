"""The formulas of tests/formulas/, by family."""

from __future__ import annotations

from pathlib import Path

from ltlc.ltl import read_formulas

FOLDER = Path(__file__).parents[1] / "formulas"


def families() -> dict[str, list[str]]:
    files = sorted(FOLDER.glob("*.ltl"))
    return {file.stem: [text for _, text in read_formulas(file.read_text(encoding="utf-8"))] for file in files}
