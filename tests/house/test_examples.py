"""Every example runs; what it prints says that it did what it promises."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def run(monkeypatch: pytest.MonkeyPatch, name: str, *arguments: str) -> None:
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")


@pytest.mark.slow
def test_frozen_lake(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    run(monkeypatch, "wrap_frozen_lake.py")
    printed = capsys.readouterr().out
    assert "Pmax   = 0.8235" in printed
    assert float(printed.split("P(sat) = ")[1][:6]) > 0.7


def test_cartpole(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    run(monkeypatch, "wrap_cartpole.py")
    printed = capsys.readouterr().out
    assert "0 violations" in printed
    assert "still going" in printed


@pytest.mark.peer
def test_stable_baselines3(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("stable_baselines3", reason="stable-baselines3 is not installed", exc_type=ImportError)
    run(monkeypatch, "train_stable_baselines3.py", "--steps", "700")
    assert "after:  satisfies !pit U (key & !pit U goal) with probability" in capsys.readouterr().out


def test_stable_baselines3_is_asked_for_where_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.delitem(sys.modules, "ltlc.bridges.stable_baselines3", raising=False)
    with pytest.raises(SystemExit, match="pip install stable-baselines3"):
        run(monkeypatch, "train_stable_baselines3.py")


@pytest.mark.peer
def test_pettingzoo(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pettingzoo", reason="pettingzoo is not installed")
    run(monkeypatch, "wrap_pettingzoo.py", "500")
    assert int(capsys.readouterr().out.split("satisfied in ")[1].split()[0]) > 80


@pytest.mark.slow
def test_cleanrl_style(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    run(monkeypatch, "train_cleanrl_style.py", "900")
    assert "satisfies !pit U (key & !pit U goal) with probability" in capsys.readouterr().out


@pytest.mark.peer
@pytest.mark.filterwarnings("ignore")
def test_torchrl(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("torchrl", reason="torchrl is not installed", exc_type=ImportError)
    run(monkeypatch, "train_torchrl.py", "600")
    assert "satisfies !pit U (key & !pit U goal) with probability" in capsys.readouterr().out


@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_bridges_are_shown_in_a_few_lines(example: Path) -> None:
    text = example.read_text(encoding="utf-8")
    assert "ltlc.bridges" not in text or len(text.splitlines()) <= 60
