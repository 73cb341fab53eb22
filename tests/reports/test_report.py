"""The report of a run is one file that says what the run has learned, and that a browser shows without a complaint."""

from __future__ import annotations

import itertools
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ltlc.board import Board
from ltlc.cli.app import run
from ltlc.reports import report_of_run
from ltlc.reports.svg import curve, policy_on_board, ticks, ways_on_board

LABELS = """
MAP = "SFFFFHFHFFFHHFFG"

def lake(state):
    return {"H": {"hole"}, "G": {"goal"}}.get(MAP[state], set())

def odd(state):
    return {"</script><b>&"} if state == 15 else set()

standing = {"fallen": lambda x: bool(abs(x[2]) > 0.1)}
"""
VOID = {"meta", "input", "br", "img", "link", "hr"}
SELF_CLOSING = {
    "polyline",
    "line",
    "rect",
    "circle",
    "polygon",
    "path",
    "ellipse",
    "text",
    "g",
    "svg",
    "title",
    "image",
}


class Page(HTMLParser):
    """Checks that elements are closed in order, and keeps what they refer to and say."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.said = ""
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.references += [value for name, value in attrs if name in ("src", "href", "xlink:href", "action", "data")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: Any) -> None:
        self.references += [value for name, value in attrs if name in ("src", "href", "xlink:href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.said += data


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("runs")
    (place / "sensors.py").write_text(LABELS)
    return place


def trained(folder: Path, name: str, *arguments: str) -> Path:
    if not (folder / name).exists():
        assert run(["train", *arguments, "--out", str(folder / name), "--quiet"]) == 0
    return folder / name


@pytest.fixture
def lake(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(folder)
    where = ("--env", "FrozenLake-v1", "--labels", "sensors.py:lake")
    return trained(folder, "lake", "F goal & G !hole", *where, "--steps", "4000")


@pytest.fixture
def pole(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(folder)
    small = ("--hyper", "hidden=[16]", "--hyper", "batch_size=16", "--hyper", "learning_starts=16", "--num-envs", "2")
    where = ("--env", "CartPole-v1", "--labels", "sensors.py:standing", "--steps", "200", "--episode-steps", "50")
    return trained(folder, "pole", "G !fallen", *where, *small)


def data_of(page: str) -> Any:
    return json.loads(re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[0])


@pytest.mark.slow
def test_a_run_on_a_map(lake: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["report", str(lake)]) == 0
    assert capsys.readouterr().out.strip() == str(lake / "report.html")
    text = (lake / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    for words in ("F goal & G !hole", "is the probability that the learned policy satisfies", "0.8235", "H: hole"):
        assert words in page.said
    assert run(["explain", str(lake)]) == 0
    told = capsys.readouterr().out.splitlines()[1:]
    assert len(told) > 4
    assert all(line.strip().replace(" -> ", " → ") in page.said for line in told)
    assert '<polyline class="way w0"' in text
    assert not [one for one in page.references if not one.startswith(("data:", "#"))]
    assert "http://" not in re.sub(r'xmlns(:xlink)?="[^"]*"', "", text).replace("http://www.w3.org/2000/svg", "")
    assert "{{" not in text
    episode = data_of(text)["episode"]
    assert episode[0].keys() == {"names", "q", "t", "cell"}
    assert episode[0]["cell"] == 0
    assert {"action", "reward", "accepting", "violated"} <= episode[1].keys()
    assert episode[-1]["ended"] in ("terminated", "cut")
    again = report_of_run(lake, lake / "again.html")
    assert again.read_bytes() == (lake / "report.html").read_bytes()


@pytest.mark.slow
def test_a_run_without_a_map(pole: Path) -> None:
    text = report_of_run(pole, episodes=4).read_text(encoding="utf-8")
    page = Page(text)
    assert "of 4 episodes have an accepting step" in page.said
    assert "no map and no scene" in page.said
    assert "episodes fail" in page.said
    assert data_of(text)["episode"][0]["seen"].startswith("[")


@pytest.mark.slow
def test_everything_is_escaped(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    where = ("--env", "FrozenLake-v1", "--labels", "sensors.py:odd", "--steps", "300")
    text = report_of_run(trained(folder, "odd", 'F "</script><b>&"', *where)).read_text(encoding="utf-8")
    page = Page(text)
    assert 'F "</script><b>&"' in page.said
    assert "<b>&" not in re.sub(r"<b>[\d.]+</b>|<b>q\d</b>", "", text)
    assert text.count("</script>") == 2


def test_a_new_run_removes_the_report_of_the_old_one() -> None:
    from ltlc.agents.training import run_folder

    assert run_folder.REPORT_FILE in run_folder._RESULTS


def test_curves() -> None:
    drawn = Page(curve(np.arange(50.0), np.sin(np.arange(50.0)), 1.5, "steps", "return <x>"))
    assert "steps" in drawn.said
    flat = curve(np.array([3.0]), np.array([0.0]), None, "steps", "return")
    assert "nan" not in flat and "best" not in flat


@pytest.mark.parametrize(
    ("low", "high", "most"), [(0, 1, 5), (-3, 1200, 3), (0.001, 0.0011, 5), (-1e6, -9e5, 4), (0, 7, 5)]
)
def test_ticks_are_round_and_few(low: float, high: float, most: int) -> None:
    found = ticks(low, high, most)
    assert 1 <= len(found) <= most + 1
    assert all(low - 1e-9 <= tick <= high + 1e-9 for tick in found)
    assert len({round(b - a, 9) for a, b in itertools.pairwise(found)}) <= 1


def test_maps_have_arrows_where_something_is_decided() -> None:
    board = Board(
        ("..#", ".G."), start=0, actions=("RIGHT", "DOWN", "NONE"), meaning={"G": "goal"}, final=frozenset({4})
    )
    drawn = policy_on_board(board, [0, 1, 0, 2, 0, 0], [True, True, True, True, True, False])
    Page(drawn)
    assert drawn.count('<polygon class="arrow"') == 2  # not on the wall, the goal, or where nobody comes
    assert drawn.count('<circle class="arrow"') == 1
    assert 'class="never"' in drawn and 'class="wall"' in drawn and 'class="start"' in drawn


def test_ways_to_fail_are_the_thicker_the_more_probable() -> None:
    drawn = ways_on_board(Board(("..", ".H"), start=0, actions=("RIGHT", "DOWN")), [((0, 1, 3), 0.5), ((0, 2), 0.25)])
    Page(drawn)
    assert re.findall(r'class="way (w\d)" stroke-width="([\d.]+)" points', drawn) == [("w0", "3.00"), ("w1", "1.80")]
    assert 'points="10,10 30,10 30,30"' in drawn and drawn.count("<path") == 2
    assert "<path" not in ways_on_board(Board(("..",), start=0, actions=("RIGHT",)), [])


BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
PROBE = """<script>
const wide = document.documentElement.scrollWidth, lit = () => [...document.querySelectorAll("#lit g.node.lit")].length;
const said = [innerWidth, wide, lit(), document.getElementById("told").textContent];
document.getElementById("on").click();
document.body.dataset.probe = JSON.stringify([...said, document.getElementById("told").textContent, lit()]);
</script></body>"""


@pytest.mark.peer
@pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed")
@pytest.mark.parametrize("width", [390, 1400])
@pytest.mark.parametrize("name", ["lake", "pole"])
def test_a_browser_shows_it(name: str, width: int, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    folder: Path = request.getfixturevalue(name)
    text = report_of_run(folder, tmp_path / "report.html", episodes=4).read_text(encoding="utf-8")
    # A window cannot be as narrow as a phone, a frame can.
    (tmp_path / "inner.html").write_text(text.replace("</body>", PROBE), encoding="utf-8")
    script = (
        "const frame = document.querySelector('iframe'); frame.onload = () => "
        "{ document.body.dataset.probe = frame.contentDocument.body.dataset.probe; };"
    )
    frame = f'<iframe src="inner.html" width="{width}" height="900" style="border:0"></iframe><script>{script}</script>'
    (tmp_path / "outer.html").write_text(f"<!DOCTYPE html><body>{frame}</body>")
    done = subprocess.run(
        [str(BROWSER), "--headless=new", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files",
         "--enable-logging=stderr", "--window-size=1500,1000", "--virtual-time-budget=3000", "--dump-dom",
         (tmp_path / "outer.html").as_uri()],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert "CONSOLE" not in done.stderr, done.stderr
    probe = re.search(r'data-probe="([^"]*)"', done.stdout)
    assert probe is not None, done.stdout
    inner, wide, lit, first, second, lit_after = json.loads(probe[1].replace("&quot;", '"'))
    assert inner == width
    assert wide <= width
    assert first.startswith("step 0state q") and second.startswith("step 1state q")
    assert "action" in second
    if shutil.which("dot"):
        assert (lit, lit_after) == (1, 1)
