"""What a notebook shows of the values that a user holds."""

from __future__ import annotations

import shutil
import xml.dom.minidom

import pytest

import ltlc
from ltlc.errors import MissingProgramError
from ltlc.faithful import Candidate, faithfulness
from ltlc.formats import picture
from ltlc.mdp import LabelledMDP
from ltlc.notebook import bar, fragment

LAKE = {"goal": lambda place: place == 15, "hole": lambda place: place in (5, 7, 11, 12)}


def parsed(html: str) -> xml.dom.minidom.Document:
    return xml.dom.minidom.parseString(html)


def two_rooms() -> LabelledMDP:
    return LabelledMDP.from_arrays([[[0, 1], [0, 1]], [[1, 0], [0, 1]]], aps=["goal"], labels=[[], ["goal"]])


@pytest.fixture
def without_graphviz(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(source: str, kind: str) -> bytes:
        raise MissingProgramError("nothing draws")

    monkeypatch.setattr(picture, "draw", missing)


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
@pytest.mark.parametrize("finite", [False, True])
def test_automata_are_pictures(finite: bool) -> None:
    svg = ltlc.compile("F a", finite=finite)._repr_svg_()
    assert svg is not None and "<svg" in svg


def test_automata_without_a_picture_are_text(without_graphviz: None) -> None:
    assert ltlc.compile("F a")._repr_svg_() is None
    assert ltlc.compile("GF a & GF b", form="emerson-lei")._repr_svg_() is None


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
def test_task() -> None:
    document = parsed(ltlc.Task("G(a -> F b)")._repr_html_())
    assert document.getElementsByTagName("svg")
    assert "G(a -> F b)" in document.getElementsByTagName("b")[0].firstChild.data


def test_task_without_graphviz(without_graphviz: None) -> None:
    html = ltlc.Task("F a & G !b")._repr_html_()
    assert not parsed(html).getElementsByTagName("svg")
    assert "F a &amp; G !b" in html and "guarantee" in html


def test_exact_judgement() -> None:
    found = ltlc.judge(lambda observation: 2, "FrozenLake-v1", "F goal & G !hole", labels=LAKE)
    html = found._repr_html_()
    assert "0.0315" in html and "best for the rewards" in html
    assert len(parsed(html).getElementsByTagName("rect")) == 3
    assert found.verdict is not None and "0.0315" in found.verdict._repr_html_()


def test_sampled_judgement() -> None:
    found = ltlc.judge(lambda seen: 2, "FrozenLake-v1", "F goal & G !hole", labels=LAKE, exact=False, episodes=20)
    assert "of 20 episodes" in found._repr_html_() and "<table>" not in found._repr_html_()


def test_faithfulness() -> None:
    report = faithfulness(two_rooms(), "G F goal", [Candidate.from_name("two-discount")])
    cells = [cell.firstChild.data for cell in parsed(report._repr_html_()).getElementsByTagName("td")]
    assert cells[0] == "two-discount" and cells[2:] == ["1", "none"]


def test_texts_are_escaped() -> None:
    assert parsed(fragment("a < b", [("x & y", "<script>")])).getElementsByTagName("script") == []
    assert 'd="M100.00' in bar(0, 0.2, 1, best=0.5)
