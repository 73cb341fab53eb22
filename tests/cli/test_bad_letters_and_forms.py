"""Wrong letters, tables, bounds, forms and files with possible letters: what a person is told, and the exit code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import ltlc
from ltlc.cli.app import run

# formula, message, hint
FORMULAS = [
    ("G(", "this bracket is never closed: expected an operand", "write a formula behind it and close it: G(a)"),
    ("F(a & !(", "this bracket is never closed: expected an operand", "write a formula behind it and close it: !(a)"),
    ("(", "this bracket is never closed: expected an operand", "write a formula behind it and close it: (a)"),
    ("O[3] a", "'O[3]' has a bound of one number, which tools read", "write O[0:3] or O<=3"),
    ("H[5:2] a", "'H[5:2]' has an empty bound: no distance is in it", "write the smaller number first: H[2:5]"),
    ("a S[3] b", "'S[3]' has a bound of one number, which tools read", "write S[0:3] or S<=3"),
    ("a T[9:1] b", "'T[9:1]' has an empty bound", "write the smaller number first: T[2:5]"),
    ("Y[1:2] a", "'Y[1:2]' says no single distance", "write Y[3] for three steps"),
    ("Z[2:] a", "'Z[2:]' says no single distance", "write Z[3] for three steps"),
    ("once{2} a", "'{' is not an operator", ""),
    ("H{2} a", "'H{2}' has a bound that is not read", "write H[2:5], H[2:] or H<=5"),
    ("Y{2} a", "'Y{2}' has a bound that is not read", "write Y[3]"),
    ("O<=20000 a", "'O<=20000' looks further than 10000 steps", "take larger steps, or leave the bound out"),
    ("O[1:2] F a", "Y speaks about the past, so it cannot stand over F a", "write the formula so that operators of"),
    ("a S<=2 G b", "Y speaks about the past, so it cannot stand over", "write the formula so that operators of"),
    ("S<=2 a", "'S<=2' (with a bound) has no left operand", "write S<=2 between two formulas"),
    ("G O<=2", "'O<=2' (with a bound) has no operand", "write what O<=2 is about"),
]

# arguments, standard input, exit code, what stderr starts with
COMMANDS = [
    (["compile", "F a", "--exclusive", "a"], "", 2, "ltlc: --exclusive 'a': expected two names or more"),
    (["compile", "F a", "--exclusive", "a,a"], "", 2, "ltlc: --exclusive 'a,a': expected two names or more"),
    (["compile", "F a", "--exclusive", ""], "", 2, "ltlc: --exclusive '': expected two names or more"),
    (["compile", "F a", "--exclusive", "a,b", "--letters", "a"], "", 2, "ltlc: give either --exclusive or --letters"),
    (["compile", "F a", "--exclusive", "a,("], "", 2, "ltlc: line 1, column 3: '(' is no name"),
    (["compile", "F a", "--letters", "a | b"], "", 2, "ltlc: line 1, column 3: '| b' is no name"),
    (["compile", "F a", "--letters", "a & !a"], "", 2, "ltlc: line 1, column 5: 'a' cannot be true and false"),
    (["show", "F a", "--exclusive", "a"], "", 2, "ltlc: --exclusive 'a': expected two names or more"),
    (["monitor", "F a", "--exclusive", "a"], "a\n", 2, "ltlc: --exclusive 'a': expected two names or more"),
    (["check", "F(a & F b)", "--exclusive", "a,b", "-w", "cycle{a & b}"], "", 2, "ltlc: the letter {a, b} occurs"),
    (["check", "F(a & F b)", "--letters", "a; b", "-w", "cycle{1}"], "", 2, "ltlc: the letter {} occurs, and it was"),
    (["check", "rooms.json", "-w", "cycle{hall & kitchen}"], "", 2, "ltlc: the letter {hall, kitchen} occurs"),
    (["check", "rooms.hoa", "-w", "hall & kitchen; cycle{1}"], "", 2, "ltlc: the letter {hall, kitchen} occurs"),
    (["monitor", "F(a & F b)", "--exclusive", "a,b"], "a b\n", 2, "ltlc: the letter {a, b} occurs"),
    (["compile", " & ".join(f"GF a{i}" for i in range(25))], "", 3, "ltlc: 25 atomic propositions; tables over"),
    (["compile", " & ".join(f"GF a{i}" for i in range(25)), "--exclusive", "a0,a1"], "", 3, "ltlc: more than 2097152"),
    (["compile", "F a", "--form", "muller"], "", 2, "ltlc: Invalid value for '--form'"),
    (["compile", "F a", "--finite", "--form", "streett"], "", 2, "ltlc: --form is about infinite words"),
    (["compile", "GF a", "--form", "streett", "-o", "a.json"], "", 2, "ltlc: automata of the form streett are written"),
    (["compile", "GF a", "--form", "streett", "-o", "a.svg"], "", 2, "ltlc: automata of the form streett are written"),
    (["compile", "GF a", "--form", "emerson-lei", "-f", "dot"], "", 2, "ltlc: automata of the form emerson-lei are"),
    (["compile", "GF a", "--form", "co-buchi"], "", 2, "ltlc: no deterministic co-Buchi automaton accepts the words"),
    (["show", "choosing.hoa"], "", 2, "ltlc: choosing.hoa: line "),
    (["show", "choosing.hoa", "--determinise", "--max-states", "1"], "", 3, "ltlc: F G a | G F b needs more than 1"),
    (["show", "rabin.hoa", "--determinise"], "", 2, "ltlc: rabin.hoa: line 5, column 13: only Buchi and generalized"),
    (["show", "lost.json"], "", 2, "ltlc: lost.json: possible[0][2][0]: 'attic' is not one of aps"),
    (["show", "lost.hoa"], "", 2, "ltlc: lost.hoa: line "),
    (["show", "twice.json"], "", 2, "ltlc: twice.json: possible: expected parts that have no proposition in common"),
    (["monitor", "G a", "--csv"], "", 2, "ltlc: there is no line with the names of the columns"),
    (["monitor", "G a", "--csv"], "b,c\n1,1\n", 2, "ltlc: line 1: there is no column 'a'; there are: b, c"),
    (["monitor", "G a", "--csv"], "a,a\n1,1\n", 2, "ltlc: line 1: the column 'a' is there twice"),
    (["monitor", "G a", "--csv"], "a\nperhaps\n", 2, "ltlc: line 2, column 'a': 'perhaps' is no truth value"),
    (["monitor", "G a", "--csv"], "a,b\n1,2\n1\n", 2, "ltlc: line 3: 1 values, and there are 2 columns"),
    (["monitor", 'G "x < 2"', "--csv"], "x\nfast\n", 2, "ltlc: line 2, column 'x': 'fast' is no number"),
    (["monitor", 'G "x < 2"', "--csv"], "y\n1\n", 2, "ltlc: line 1: there is no column 'x'; there are: y"),
    (["monitor", 'G "x < 2"'], '{"y": 1}\n', 2, "ltlc: letter on line 1: the variable 'x' is no number"),
    (["monitor", 'G "x < 2"'], '{"x": "1"}\n', 2, "ltlc: letter on line 1: the variable 'x' is no number"),
    (["monitor", 'G "x <"'], "a\n", 2, "ltlc: line 1, column 4: "),
    (["monitor", "G a"], '{"a": 1}\n', 2, "ltlc: letter on line 1: expected a list of names"),
    (["monitor", "G a"], "3\n", 2, "ltlc: letter on line 1: "),
    (["monitor", "G a"], '{"a": \n', 2, "ltlc: letter on line 1: not JSON"),
    (["explain", "folder"], "", 2, "ltlc: folder is no run folder: there is no config.json"),
    (["explain", "folder", "F a"], "", 2, "ltlc: folder is a folder: explain it alone"),
    (["explain", "F a", "-o", "lost.png"], "", 2, "ltlc: -o draws what a run loses, and 'F a' is no folder"),
    (["explain", "F a", "--episodes", "0"], "", 2, "ltlc: Invalid value for '--episodes'"),
]

RABIN = """HOA: v1
States: 1
Start: 0
AP: 1 "a"
Acceptance: 1 Fin(0)
--BODY--
State: 0
[t] 0
[0] 0 {0}
--END--
"""


@pytest.fixture(autouse=True)
def files(folder: Path) -> None:
    """Files that are wrong in their ways, and some that are right."""
    Path("folder").mkdir()
    rooms = ltlc.compile("F(hall & F kitchen)", exclusive=[{"hall", "kitchen"}])
    rooms.save("rooms.json")
    rooms.save("rooms.hoa")
    Path("lost.json").write_text(rooms.to_json().replace('["kitchen"]]]', '["attic"]]]'))
    Path("twice.json").write_text(rooms.to_json().replace('["kitchen"]]]', '["kitchen"]], [[], ["hall"]]]'))
    Path("lost.hoa").write_text(rooms.to_hoa().replace("[@possible & (0)] 1\n", ""))
    Path("rabin.hoa").write_text(RABIN)
    ltlc.compile("FG a | GF b", form="limit-deterministic").save("choosing.hoa")


@pytest.mark.parametrize(("text", "message", "hint"), FORMULAS)
def test_formula(text: str, message: str, hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ltlc.LtlSyntaxError) as raised:
        ltlc.parse(text)
    assert raised.value.message.startswith(message)
    assert raised.value.hint.startswith(hint)
    assert run(["compile", text]) == 2
    assert capsys.readouterr().err == f"ltlc: {raised.value}\n"


@pytest.mark.parametrize(
    ("arguments", "text", "code", "message"), COMMANDS, ids=[" ".join(row[0])[:60] for row in COMMANDS]
)
def test_command(
    arguments: list[str],
    text: str,
    code: int,
    message: str,
    type_in: Callable[[str], None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    type_in(text)
    assert run(arguments) == code
    error = capsys.readouterr().err
    assert error.startswith(message)
    assert error.endswith("\n")
    assert "\n\n" not in error
    assert "Traceback" not in error


def test_the_table_is_long_enough() -> None:
    assert len(FORMULAS) + len(COMMANDS) >= 60
