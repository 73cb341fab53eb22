"""DOT, Mermaid and pictures: what must be seen in them, and that no name breaks them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from random_automata import random_automata

from ltlc.automata import DRA
from ltlc.errors import InvalidArgumentError, MissingProgramError
from ltlc.formats import render, to_dot, to_mermaid, write
from ltlc.formats.dot import wrapped
from ltlc.formats.picture import draw


def three_states() -> DRA:
    """!b U a: state 1 is the accepting sink, state 2 the deadlock."""
    return DRA(
        aps=("a", "b"),
        delta=[[0, 1, 2], [1, 1, 1], [2, 2, 2]],
        letter_class=[0, 1, 2, 1],
        fin=[[0, 0, 1]],
        inf=[[0, 1, 0]],
        formula="!b U a",
    )


def two_pairs() -> DRA:
    """GF a or (GF b and FG !c): marks on transitions, several on parallel ones."""
    letters = range(8)
    return DRA(
        aps=("a", "b", "c"),
        delta=[[0] * 8],
        letter_class=list(letters),
        fin=[[[0] * 8], [[letter >> 2 & 1 for letter in letters]]],
        inf=[[[letter & 1 for letter in letters]], [[letter >> 1 & 1 for letter in letters]]],
        acceptance="transition",
    )


@pytest.fixture(params=["dot", "graphviz-pure"])
def program(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    """What draws: the program `dot`, or the package where there is no such program."""
    name: str = request.param
    if name == "graphviz-pure":
        request.getfixturevalue("monkeypatch").setenv("PATH", str(tmp_path_factory.mktemp("no_programs")))
    try:
        draw("digraph { a }", "svg")
    except MissingProgramError:
        pytest.skip(f"{name} is not installed")
    return name


def words(svg: str) -> str:
    """All text in an SVG."""
    return "\n".join(re.findall(r"<text[^>]*>([^<]*)</text>", svg)).replace("&#160;", " ").replace("&#45;", "-")


def test_dot_shows_states_and_legend() -> None:
    dot = to_dot(three_states())
    assert "!b U a" in dot
    assert "start -> 0 " in dot
    assert re.search(r"^  1 .*✓.*\+0.*doublecircle", dot, re.MULTILINE)
    assert re.search(r"^  2 .*✗.*−0.*octagon", dot, re.MULTILINE)
    assert "✓ everything is accepted" in dot
    assert "✗ deadlock" in dot
    assert "infinitely often and" in dot


def test_dot_has_one_arrow_between_two_states() -> None:
    for automaton in [*random_automata(20), two_pairs()]:
        arrows = re.findall(r"^  (\d+ -> \d+) ", to_dot(automaton), re.MULTILINE)
        assert len(arrows) == len(set(arrows)) > 0


def test_marks_are_readable_without_colour() -> None:
    dot = to_dot(two_pairs())
    for badge in ("+0", "+1", "−1"):
        assert f"<B>{badge}</B>" in dot
    assert "<B>−0</B>" not in dot  # that fin is empty


def test_deadlock_can_be_hidden() -> None:
    dot = to_dot(three_states(), hide_deadlock=True)
    assert not re.search(r"^  (\d -> )?2 ", dot, re.MULTILINE)
    assert "not shown: the deadlock" in dot
    assert "q2" not in to_mermaid(three_states(), hide_deadlock=True)
    nothing = DRA((), [[0]], [0], [[0]], [[0]])
    assert re.search(r"^  0 ", to_dot(nothing, hide_deadlock=True), re.MULTILINE)


def test_long_guards_are_wrapped_outside_brackets() -> None:
    assert wrapped("a & b | c & d", 30) == ["a & b | c & d"]
    assert wrapped("a & b | c & d", 8) == ["a & b", "| c & d"]
    assert wrapped("aaaa & bbbb & (c | d)", 12) == ["aaaa & bbbb", "& (c | d)"]
    assert wrapped('"x | y" & b', 4) == ['"x | y"', "& b"]
    assert wrapped("", 4) == [""]


ODD = ('<b>"x"</b>', "a & b", "back\\slash", "é ∧ \U0001f600", "new\nline", "`code`", "#35;", "]]>", "--> |q| end")


def odd_automaton(name: str) -> DRA:
    return DRA((name,), [[0, 1], [1, 1]], [0, 1], [[0, 0]], [[0, 1]], formula=f'F "{name}"', state_names=(name, name))


@pytest.mark.parametrize("name", ODD)
def test_any_name_can_be_drawn(name: str, program: str) -> None:
    svg = draw(to_dot(odd_automaton(name)), "svg").decode()
    assert svg.count("<ellipse") >= 2


@pytest.mark.parametrize("name", ODD)
def test_any_name_can_be_in_mermaid(name: str) -> None:
    """Nothing inside a quoted label but letters, digits, spaces, entities and our own signs."""
    for line in to_mermaid(odd_automaton(name)).splitlines()[3:]:
        for label in re.findall(r'"([^"]*)"', line):
            assert re.fullmatch(r"(\w|[ −✗✓]|#\d+;|<br/>)*", label), label
        assert line.count('"') in (0, 2)


def test_mermaid_text() -> None:
    assert to_mermaid(three_states()) == (
        "---\n"
        'title: "!b U a"\n'
        "---\n"
        "flowchart LR\n"
        "  start(( )) ==> q0\n"
        '  q0(("0"))\n'
        '  q1((("1 #43;0 ✓")))\n'
        '  q2{{"2 −0 ✗"}}\n'
        '  q0 -->|"#33;a #38; #33;b"| q0\n'
        '  q0 -->|"a"| q1\n'
        '  q0 -->|"#33;a #38; b"| q2\n'
        '  q1 -->|"true"| q1\n'
        '  q2 -->|"true"| q2\n'
        "  style start fill:none,stroke:none\n"
        "  classDef deadlock fill:#dcdcdc,stroke:#8c1c13,color:#8c1c13\n"
        "  class q2 deadlock\n"
        "  classDef sink fill:#d9f0dc,stroke:#1b7a35,color:#125a26\n"
        "  class q1 sink\n"
    )


def test_text_does_not_change_between_runs() -> None:
    for automaton in random_automata(10):
        assert to_dot(automaton) == to_dot(automaton)
        assert to_mermaid(automaton) == to_mermaid(automaton)


def test_svg_has_the_formula_the_guards_and_the_legend(tmp_path: Path, program: str) -> None:
    shown = words(render(three_states(), tmp_path / "a.svg").read_text("utf-8"))
    for wanted in ("!b U a", "!a &amp; !b", "✓", "✗", "+0", "−0", "finitely often"):
        assert wanted in shown


def test_svg_is_not_larger_than_its_frame(program: str) -> None:
    svg = draw(to_dot(three_states()), "svg").decode()
    frame = re.search(r'width="(\d+)pt" height="(\d+)pt"\s+viewBox="0.00 0.00 ([\d.]+) ([\d.]+)"', svg)
    assert frame is not None
    width, height, inner_width, inner_height = map(float, frame.groups())
    assert width == pytest.approx(inner_width, abs=1)
    assert height == pytest.approx(inner_height, abs=1)
    assert "scale(1 1)" in svg


def test_text_fits_where_it_was_laid_out(program: str) -> None:
    """Pieces of a line follow one another: with the widths of another font they would lie upon each other."""
    svg = draw(to_dot(three_states()), "svg").decode()
    assert set(re.findall('font-family="([^"]*)"', svg)) == {"Helvetica,Arial,sans-serif"}
    places = re.findall(r'<text[^>]* x="([^"]*)" y="([^"]*)"[^>]*>(accepted iff a run sees |\+0)<', svg)
    (x, y, _), *rest = places
    after = min(float(one[0]) for one in rest if one[1] == y)
    assert 105 < after - float(x) < 150  # 24 letters of 11 points; 100 in a font with serifs


def test_png_is_crisp(program: str) -> None:
    width_in_points = re.search(r'width="(\d+)pt"', draw(to_dot(three_states()), "svg").decode())
    assert width_in_points is not None
    png = draw(to_dot(three_states()), "png")
    assert int.from_bytes(png[16:20], "big") > 1.5 * int(width_in_points[1])


@pytest.mark.parametrize(("suffix", "magic"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".SVG", b"<?xml")])
def test_pictures(tmp_path: Path, suffix: str, magic: bytes, program: str) -> None:
    if (program, suffix) == ("graphviz-pure", ".pdf"):
        with pytest.raises(MissingProgramError, match=r"draws \.svg and \.png, but no \.pdf, and the program 'dot'"):
            write(two_pairs(), tmp_path / "a.pdf")
        return
    path = write(two_pairs(), tmp_path / f"a{suffix}")
    assert path.read_bytes().startswith(magic)
    assert list(tmp_path.iterdir()) == [path]


def test_without_any_program_the_dot_file_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    monkeypatch.setattr("ltlc.formats.picture._substitute", lambda: None)
    with pytest.raises(MissingProgramError) as caught:
        write(three_states(), tmp_path / "a.svg")
    message = str(caught.value)
    assert str(tmp_path / "a.dot") in message
    for installer in ("apt install graphviz", "brew install graphviz", "choco install graphviz", "ltlc[pictures]"):
        assert installer in message
    assert (tmp_path / "a.dot").read_text("utf-8") == to_dot(three_states())
    assert not (tmp_path / "a.svg").exists()


def test_unknown_picture_suffix(tmp_path: Path) -> None:
    with pytest.raises(InvalidArgumentError, match=r"'\.gif'; known are \.svg \.png \.pdf"):
        render(three_states(), tmp_path / "a.gif")


@pytest.mark.slow
def test_import_loads_neither_graphviz_nor_lark() -> None:
    code = "import sys, ltlc.formats; print(sorted({'graphviz', 'lark', 'scipy', 'torch'} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout == "[]\n"
