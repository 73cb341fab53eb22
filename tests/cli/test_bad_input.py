"""Wrong formulas, words, files and flags: what a person is told, where it points, and the exit code."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import ltlc
import ltlc.ltl
from ltlc.cli.app import run
from ltlc.errors import FileFormatError, LtlSyntaxError

PUT = 'put an operator such as & | -> U between two formulas, and quote a name with blanks: "a b"'
WORD = "a word reads: a; b & !c; cycle{d; !d}"
EMPTY = "write 1 for a letter in which nothing holds: cycle{1}"
PAST = "write the formula so that operators of the past stand over the past and the present alone"
FINITE = "words are infinite here, where every position has a next one: write X, or say that traces are finite"

# text, line, column, message, hint
FORMULAS = [
    ("", 1, 1, "the formula is empty: expected an operand", "the shortest formulas are names and true"),
    ("  ", 1, 1, "the formula is empty: expected an operand", "the shortest formulas are names and true"),
    ("a &", 1, 3, "'&' (and) has no right operand: expected a formula after it", "write & between two formulas: a & b"),
    ("& a", 1, 1, "'&' (and) has no left operand: expected a formula before it", "write & between two formulas: a & b"),
    ("a & | b", 1, 5, "'|' (or) stands right after '&': expected an operand between them", "write | between two formulas: a | b"),
    ("a\n& & b", 2, 3, "'&' (and) stands right after '&': expected an operand between them", "write & between two formulas: a & b"),
    ("a U", 1, 3, "'U' (until) has no right operand: expected a formula after it", 'U is an operator; quote a proposition of that name: "U"'),
    ("U a", 1, 1, "'U' (until) has no left operand: expected a formula before it", 'U is an operator; quote a proposition of that name: "U"'),
    ("G", 1, 1, "'G' (always) has no operand: expected a formula after it", 'G is an operator; quote a proposition of that name: "G"'),
    ("!", 1, 1, "'!' (negation) has no operand: expected a formula after it", "write what ! is about: ! a"),
    ("()", 1, 1, "'()' (next) has no operand: expected a formula after it", "write what () is about: () a"),
    ("(a", 1, 1, "this bracket is never closed", "add a closing bracket, or remove this one"),
    ("F(a &\n  (b |\n  c)", 1, 2, "this bracket is never closed", "add a closing bracket, or remove this one"),
    ("a)", 1, 2, "this bracket closes nothing: expected an operator or the end", "remove it, or add an opening bracket before"),
    ("a b", 1, 3, "'b' stands right after 'a': expected an operator or the end", PUT),
    ("F a G", 1, 5, "'G' stands right after 'a': expected an operator or the end", PUT),
    ("a Ub", 1, 3, "'Ub' stands right after 'a': expected an operator or the end", "if U is the operator, put a blank after it: U b"),
    ("a until b", 1, 3, "'until' is read as a name: expected an operator or the end", "until is written U"),
    ("always a", 1, 1, "'always' is read as a name: expected an operator or the end", "always is written G"),
    ("a implies b", 1, 3, "'implies' is read as a name: expected an operator or the end", "implies is written ->"),
    ("a = b", 1, 3, "'=' is not an operator", 'write <-> for equivalence, or quote a comparison: "x=1"'),
    ("a != b", 1, 3, "'!=' is not an operator", 'write xor for exclusive or, or quote a comparison: "x!=1"'),
    ("a <- b", 1, 3, "'<' is not an operator", 'write <> for eventually, or quote a comparison: "<-"'),
    ("a + b", 1, 3, "'+' is not an operator", "write | for disjunction"),
    ("a' & b", 1, 2, "''' is not an operator", 'names are quoted with double quotes: "name"'),
    ('"open', 1, 1, "this quote is never closed", 'end the name with another "'),
    ("2a", 1, 1, "'2a' is neither a name nor a constant", 'a name that starts with a digit needs quotes, "2a"; the constants are 0 and 1'),
    ("a,b", 1, 2, "',' is not an operator", 'a name with such a character needs quotes: "a,b"'),
    ("F[a]", 1, 2, "'[' is not an operator", "only round brackets group, and bounds are numbers: F[2:5] a"),
    ("a; b", 1, 2, "';' is not an operator", "a formula has no sequences, words have: a; b; cycle{c}"),
    ("a & b # c", 1, 7, "'#' is not an operator", "comments belong into formula files"),
    ("\ufeffF a", 1, 1, "the invisible character U+FEFF is not an operator", "remove it; a name may hold any character in quotes"),
    ('F "caf\udce9"', 1, 7, "the text has half a character, U+DCE9, here", "give the formula as valid UTF-8 text"),
    # other tools' syntax
    ("F Y X a", 1, 3, "Y speaks about the past, so it cannot stand over X a, which speaks about the future", PAST),
    ("O F a", 1, 1, "O speaks about the past, so it cannot stand over F a, which speaks about the future", PAST),
    ("G(b ->\n  once (c & (a U b)))", 2, 3, "O speaks about the past, so it cannot stand over c & a U b, which speaks about the future", PAST),
    ("b & H(a -> F a)", 1, 5, "H speaks about the past, so it cannot stand over a -> F a, which speaks about the future", PAST),
    ("G(a S G b)", 1, 5, "S speaks about the past, so it cannot stand over G b, which speaks about the future", PAST),
    ("(a R c) since (b)", 1, 9, "S speaks about the past, so it cannot stand over a R c, which speaks about the future", PAST),
    ("a T X b", 1, 3, "T speaks about the past, so it cannot stand over X b, which speaks about the future", PAST),
    ("Z F[1:2] a", 1, 1, "Z speaks about the past, so it cannot stand over X(a | X a), which speaks about the future", PAST),
    ("a S", 1, 3, "'S' stands right after 'a': expected an operator or the end", PUT),
    ("Y ()", 1, 3, "'()' (next) has no operand: expected a formula after it", "write what () is about: () a"),
    ("O{2} a", 1, 1, "'O{2}' has a bound that is not read", "write O[2:5], O[2:] or O<=5"),
    ("A T", 1, 3, "'T' stands right after 'A': expected an operator or the end", PUT),
    ("N a", 1, 1, "'N' is the weak next of finite traces", FINITE),
    ("a -> WX(b)", 1, 6, "'WX' is the weak next of finite traces", FINITE),
    ("G(a -> X[!] b)", 1, 8, "'X[!]' is the strong next of finite traces", FINITE),
    ("F[3,0] a", 1, 1, "'F[3,0]' has an empty bound: no distance is in it", "write the smaller number first: F[2:5]"),
    ("G F<0 a", 1, 3, "'F<0' has an empty bound: no distance is in it", "write the smaller number first: F[2:5]"),
    ("F[3] a", 1, 1, "'F[3]' has a bound of one number, which tools read in different ways", "write F[0:3] or F<=3"),
    ("X[1:2] a", 1, 1, "'X[1:2]' says no single distance", "write X[3] for three steps"),
    ("X<=2 a", 1, 1, "'X<=2' says no single distance", "write X[3] for three steps"),
    ("a U[2:1] b", 1, 3, "'U[2:1]' has an empty bound: no distance is in it", "write the smaller number first: U[2:5]"),
    ("F[0:10001] a", 1, 1, "'F[0:10001]' looks further than 10000 steps", "take larger steps, or leave the bound out"),
    ("X[99999999999999999999] a", 1, 1, "'X[99999999999999999999]' looks further than 10000 steps", "take larger steps, or leave the bound out"),
    ("F<=300 G<=300 F<=300 a", 1, 1, "'F<=300' stands for a formula of more than 1000000 operators and names", "nest fewer bounds, or make them smaller"),
    ("F[1:2:3] a", 1, 1, "'F[1:2:3]' has a bound that is not read", "write F[2:5], F[2:] or F<=5"),
    ("G[=] a", 1, 1, "'G[=]' has a bound that is not read", "write G[2:5], G[2:] or G<=5"),
    ("a & F[1:2]", 1, 5, "'F[1:2]' (with a bound) has no operand: expected a formula after it", "write what F[1:2] is about: F[1:2] a"),
    ("a U<=3", 1, 3, "'U<=3' (with a bound) has no right operand: expected a formula after it", "write U<=3 between two formulas: a U<=3 b"),
    ("R[1:2] b", 1, 1, "'R[1:2]' (with a bound) has no left operand: expected a formula before it", "write R[1:2] between two formulas: a R[1:2] b"),
    ("F_[0,90] a", 1, 1, "'F_[0,90]' has a bound that is not read", "write F[2:5], F[2:] or F<=5"),
    ("G F^2 a", 1, 3, "'F^2' has a bound that is not read", "write F[2:5], F[2:] or F<=5"),
    ("P=? [ F a & ]", 1, 11, "'&' (and) has no right operand: expected a formula after it", "write & between two formulas: a & b"),
    ("P>=0.5 [ a U b ]", 1, 1, "'P>=0.5' asks for a probability, as properties of PRISM do; a formula is what it asks about", "write a U b"),
    ('R{"steps"}min=? [ F a ]', 1, 1, "'R{\"steps\"}min=?' asks for an expected reward, as properties of PRISM do; a formula is what it asks about", "write F a"),
    ("S=?", 1, 1, "'S=?' asks for a long-run probability, as properties of PRISM do; a formula is what it asks about", "write what stands between [ and ], such as F a"),
    ("& F a G b c", 1, 1, "'&' (and) has no left operand: expected a formula before it", "write & between two formulas: a & b"),
    ("'a & b", 1, 1, "''' is not an operator", 'names are quoted with double quotes: "name"'),
    ("F \u201cat home\u201d", 1, 3, "\u201cat home\u201d is no name: names are quoted with double quotes", 'write "at home"'),
    ("{a;b} |-> c", 1, 1, "'{a;b}' is part of a regular expression, as in PSL and SVA", "write sequences with X: {a; b} is a & X b"),
    ("a[*3]", 1, 2, "'[*3]' is part of a regular expression, as in PSL and SVA", "write sequences with X: {a; b} is a & X b"),
    ("a ##1 b", 1, 3, "'##1' is part of a regular expression, as in PSL and SVA", "write sequences with X: {a; b} is a & X b"),
    ("G(a |=> b)", 1, 5, "'|=>' is an operator of PSL and SVA", "a |-> b is a -> b, and a |=> b is a -> X b"),
    ("AG EF a", 1, 1, "'AG' quantifies over paths, as in CTL; a formula here speaks about one path", "write G a, which a task asks of every path"),
    ("b -> EF a", 1, 6, "'EF' quantifies over paths, as in CTL; a formula here speaks about one path", "EF a, for example, holds where not every path satisfies G !a"),
    ("E [ a U b ]", 1, 1, "'E' quantifies over paths, as in CTL; a formula here speaks about one path", "EF a, for example, holds where not every path satisfies G !a; if E is a name, put an operator such as & behind it"),
    ("A F b", 1, 1, "'A' quantifies over paths, as in CTL; a formula here speaks about one path", "write F a, which a task asks of every path; if A is a name, put an operator such as & behind it"),
    ("G(a ~> b)", 1, 5, "'~>' is 'leads to' of TLA+", "a ~> b is G(a -> F b)"),
    ("cycle{a; b}", 1, 1, "'cycle{' belongs to a word, and a formula is expected", "a formula says what holds for ever by G: G a"),
]  # fmt: skip

WORDS = [
    ("", 1, 1, "the word ends too early: its cycle is missing", WORD),
    ("a; b", 1, 5, "the word ends too early: its cycle is missing", WORD),
    ("cycle{a", 1, 8, "the cycle is never closed", "end it with }"),
    ("cycle{}", 1, 7, "a letter is missing before '}'", EMPTY),
    ("cycle{a;}", 1, 9, "a letter is missing before '}'", EMPTY),
    ("a cycle{b}", 1, 3, "'cycle{' stands right after a letter", "put a ; before it: a; cycle{b}"),
    ("a; cycle{b}; c", 1, 12, "';' stands behind the cycle, which never ends", WORD),
    ("a;; cycle{b}", 1, 3, "a letter is missing before ';'", EMPTY),
    ("{a, b}; cycle{c}", 1, 1, "a letter is not a set in brackets", "join propositions by &: a & b; 1 mentions none"),
    ("a; cycle{O b}", 1, 10, "a letter is a conjunction of literals, such as a & !b", WORD),
    ("`a`; cycle{b}", 1, 1, "`a` is no name: names are quoted with double quotes", 'write "a"'),
    ("cycle{a | b}", 1, 7, "a letter is a conjunction of literals, such as a & !b", WORD),
    ("cycle{F a}", 1, 7, "a letter is a conjunction of literals, such as a & !b", WORD),
    ("a & !a; cycle{b}", 1, 1, "'a' cannot be true and false in one letter", WORD),
    ("a; cycle{b = c}", 1, 12, "'=' is not an operator", 'write <-> for equivalence, or quote a comparison: "x=1"'),
]  # fmt: skip

TRACE = "a finite trace reads: a; b & !c; 1"
TRACES = [
    ("", 1, 1, "the trace is empty", TRACE),
    ("a;", 1, 3, "the trace ends too early: a letter is missing", TRACE),
    ("a; cycle{b}", 1, 4, "a finite trace has no cycle", TRACE),
    ("cycle{b", 1, 1, "a finite trace has no cycle", TRACE),
    ("a; ; b", 1, 4, "a letter is missing before ';'", EMPTY),
    ("a; b }", 1, 6, "unexpected '}'", WORD),
    ("X a", 1, 1, "a letter is a conjunction of literals, such as a & !b", WORD),
    ("a & !a", 1, 1, "'a' cannot be true and false in one letter", WORD),
]

JSON = """{
  "format": "ltlc-dra",
  "version": "1.0",
  "formula": null,
  "acceptance": "state",
  "aps": ["a", "b"],
  "initial_state": 0,
  "n_states": 2,
  "n_pairs": 1,
  "states": [{"id": 0}, {"id": 1}],
  "transitions": [
    {"source": 0, "target": 0, "guard": "a & !b"},
    {"source": 0, "target": 1, "guard": "!a | b"},
    {"source": 1, "target": 1, "guard": "true"}
  ],
  "pairs": [{"B": [], "G": [1]}]
}
"""
HOA = """HOA: v1
States: 2
Start: 0
AP: 1 "a"
Acceptance: 2 Fin(0) & Inf(1)
--BODY--
State: 0
[!0] 0
[0] 1
State: 1 {1}
[t] 1
--END--
"""

# what is replaced in a good file, by what, and the message after the path
JSON_FILES = [
    ("{", "[{", "line 18, column 1: not JSON"),
    (JSON, "", "line 1, column 1: not JSON"),
    (JSON, "[1]", "expected an object with the key 'format'"),
    ('"ltlc-dra"', '"other"', "format: expected 'ltlc-dra', found \"other\""),
    ('"1.0"', '"2.0"', "version: the file has version 2.0"),
    ('"aps": ["a", "b"],', "", "the key 'aps' is missing"),
    ('["a", "b"]', '["a", "a"]', "aps: a proposition is listed twice"),
    ('_state": 0', '_state": "0"', 'initial_state: expected a number, found "0"'),
    ('"state"', '"edges"', "acceptance: expected 'state' or 'transition', found \"edges\""),
    ("a & !b", "a & & b", "transitions[0].guard: column 5: '&' (and) stands right after '&'"),
    ("a & !b", "a & F b", "transitions[0].guard: a guard is about one letter, it cannot hold the temporal operator F"),
    ("!a | b", "!a | c", "transitions[1].guard: 'c' is not one of aps"),
    ("a & !b", "a", "transitions[1].guard: not deterministic: state 0 has this transition and transitions[0]"),
    ("!a | b", "b", "transitions: not complete: state 0 has no transition for the letter !a & !b"),
    ('1, "guard": "true"', '7, "guard": "true"', "transitions[2].target: 7 is out of range, there are 2 states"),
    ('"G": [1]', '"G": [2]', "pairs[0].G[0]: 2 is out of range, there are 2 states"),
]
HOA_FILES = [
    (HOA, "", "there is no automaton: an HOA file starts with 'HOA: v1' and ends with '--END--'"),
    ("v1", "v2", "line 1, column 6: this is HOA v2; only version v1 can be read"),
    ("--END--\n", "", "line 11: the file ends before the --END-- of an automaton"),
    ("--END--\n", f"--END--\n{HOA}", "there is more than one automaton"),
    ("Acceptance: 2 Fin(0) & Inf(1)\n", "", "line 1, column 6: the header Acceptance: is missing"),
    ("Inf(1)", "Inf(3)", "line 5, column 13: the condition speaks of set 3, the number of sets is 2"),
    ("AP: 1", "AP: 2", "line 4, column 5: AP: announces 2 propositions, and 1 names follow"),
    ("Start: 0", "Start: 0&1", "line 3, column 10: universal branching"),
    ("Start: 0\n", "Start: 0\nStart: 1\n", "line 4, column 1: a second initial state"),
    ("[!0] 0", "[t] 0", "line 9, column 5: not deterministic: state 0 has a second edge for the letter a"),
    ("[0] 1", "[1] 1", "line 9, column 1: there is no proposition 1, AP: lists 1"),
    ("[0] 1", "[0 1", "line 9, column 4: unexpected '1'; expected"),
    ("[t] 1", "[t] 5", "line 11, column 5: there is no state 5, 2 are listed"),
    ("{1}", "{9}", "line 10, column 11: there is no acceptance set 9, Acceptance: announces 2"),
]

# arguments, exit code, and what stderr starts with
COMMANDS = [
    (["compile"], 2, "ltlc: give either a FORMULA or, with -F, a file of formulas"),
    (["compile", "a", "-F", "tasks.txt"], 2, "ltlc: give either a FORMULA or, with -F, a file of formulas"),
    (["compile", "a", "b"], 2, "ltlc: Got unexpected extra argument"),
    (["compile", "a", "-o", "a.txt"], 2, "ltlc: a.txt: the suffix must be one of .json .hoa .dot"),
    (["compile", "a", "-o", "automaton"], 2, "ltlc: automaton: the suffix must be one of .json .hoa .dot"),
    (["compile", "a", "-o", "no/a.json"], 2, "ltlc: no/a.json: there is no folder no; create it first"),
    (["compile", "a", "-o", "folder.json"], 2, "ltlc: folder.json: this is a folder"),
    (["compile", "a", "-o", "a.json", "--format", "hoa"], 2, "ltlc: --format is for standard output;"),
    (["compile", "a", "--json", "--format", "hoa"], 2, "ltlc: --json and the automaton cannot both go to"),
    (["compile", "a", "--translator", "saffra"], 2, "ltlc: unknown translator 'saffra'. Did you mean safra"),
    (["compile", "a", "--acceptance", "edge"], 2, "ltlc: Invalid value for '--acceptance'"),
    (["compile", "a", "--max-states", "many"], 2, "ltlc: Invalid value for '--max-states'"),
    (["compile", "a", "--max-states", "0"], 2, "ltlc: max_states is 0; at least 1"),
    (["compile", "a", "--timeout", "-1"], 2, "ltlc: timeout is -1; it must be a positive"),
    (["compile", "-F", "nowhere.txt"], 2, "ltlc: nowhere.txt: No such file or directory"),
    (["compile", "-F", "tasks.txt", "-o", "a.json"], 2, "ltlc: -F writes a stream of automata, which only HOA"),
    (["compile", "-F", "latin1.txt"], 2, "ltlc: the input is not UTF-8 text"),
    (["compile", "GF a & GF b & FG c", "--max-states", "1"], 3, "ltlc: "),
    (["compile", " & ".join(f"F a{i}" for i in range(30))], 3, "ltlc: "),
    (["show"], 2, "ltlc: Missing argument 'SOURCE'. (See: ltlc show --help)"),
    (["show", "nowhere.hoa"], 2, "ltlc: nowhere.hoa: No such file or directory"),
    (["show", "latin1.txt"], 2, "ltlc: latin1.txt: not UTF-8 text"),
    (["show", "tasks.txt"], 2, "ltlc: tasks.txt: neither JSON (which starts with '{') nor HOA"),
    (["check", "F a"], 2, "ltlc: Missing option '--word'"),
    (["comple"], 2, "ltlc: No such command 'comple'. Did you mean 'compile'?"),
    (["compile", "a", "--formt", "hoa"], 2, "ltlc: No such option: --formt"),
]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """A folder of its own for every test, with a few files that are wrong in their ways."""
    Path("folder.json").mkdir()
    Path("tasks.txt").write_text("F a\n")
    Path("latin1.txt").write_bytes(b"F caf\xe9\n")
    return folder


def paragraph(error: str) -> str:
    """What a command has printed to stderr, which must be one paragraph without a traceback."""
    assert error.startswith("ltlc: ")
    assert error.endswith("\n")
    assert "\n\n" not in error
    assert "Traceback" not in error
    return error


def test_the_table_is_long_enough() -> None:
    assert len(FORMULAS) + len(WORDS) + len(JSON_FILES) + len(HOA_FILES) >= 40


@pytest.mark.parametrize(("text", "line", "column", "message", "hint"), FORMULAS)
def test_formula(
    text: str, line: int, column: int, message: str, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(LtlSyntaxError) as raised:
        ltlc.parse(text)
    error = raised.value
    assert (error.line, error.column, error.message, error.hint) == (line, column, message, hint)
    assert run(["compile", text]) == 2
    assert paragraph(capsys.readouterr().err) == f"ltlc: {error}\n"


@pytest.mark.parametrize(("text", "line", "column", "message", "hint"), WORDS)
def test_word(text: str, line: int, column: int, message: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(LtlSyntaxError) as raised:
        ltlc.parse_word(text)
    error = raised.value
    assert (error.line, error.column, error.message, error.hint) == (line, column, message, hint)
    assert run(["check", "F a", "--word", text]) == 2
    assert paragraph(capsys.readouterr().err) == f"ltlc: {error}\n"


@pytest.mark.parametrize(("text", "line", "column", "message", "hint"), TRACES)
def test_trace(text: str, line: int, column: int, message: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(LtlSyntaxError) as raised:
        ltlc.ltl.parse_trace(text)
    error = raised.value
    assert (error.line, error.column, error.message, error.hint) == (line, column, message, hint)
    assert run(["check", "--finite", "F a", "--word", text]) == 2
    assert paragraph(capsys.readouterr().err) == f"ltlc: {error}\n"


def test_the_caret_points(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "G(request ->\n  F grant) & (a = b)"]) == 2
    assert capsys.readouterr().err == (
        "ltlc: line 2, column 17: '=' is not an operator\n"
        "    F grant) & (a = b)\n"
        "                  ^\n"
        'hint: write <-> for equivalence, or quote a comparison: "x=1"\n'
    )


@pytest.mark.parametrize(
    ("suffix", "good", "old", "new", "message"),
    [("json", JSON, *row) for row in JSON_FILES] + [("hoa", HOA, *row) for row in HOA_FILES],
)
def test_file(suffix: str, good: str, old: str, new: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = Path(f"bad.{suffix}")
    path.write_text(good)
    ltlc.load(path)
    path.write_text(good.replace(old, new, 1))
    with pytest.raises(FileFormatError) as raised:
        ltlc.load(path)
    assert str(raised.value).startswith(f"{path}: {message}")
    assert run(["show", str(path)]) == 2
    assert paragraph(capsys.readouterr().err) == f"ltlc: {raised.value}\n"


@pytest.mark.parametrize(("arguments", "code", "message"), COMMANDS, ids=lambda value: str(value)[:40])
def test_command(
    arguments: list[str], code: int, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.iterdir())
    assert run(arguments) == code
    out, err = capsys.readouterr()
    assert paragraph(err).startswith(message)
    assert out == ""
    assert sorted(folder.iterdir()) == before


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_folder_without_permission(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    closed = folder / "closed"
    closed.mkdir(mode=0o500)
    assert run(["compile", "a", "-o", str(closed / "a.json")]) == 2
    assert "Permission denied" in paragraph(capsys.readouterr().err)


def test_without_graphviz(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr("ltlc.formats.picture._substitute", lambda: None)
    assert run(["compile", "F a", "-o", "a.svg"]) == 2
    error = paragraph(capsys.readouterr().err)
    assert "apt install graphviz" in error
    assert "a.dot" in error
    assert Path("a.dot").read_text().startswith("digraph")
    assert not Path("a.svg").exists()
    assert ltlc.compile("F a")._repr_svg_() is None
