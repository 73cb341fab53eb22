"""What the parser says: of readings that surprise, of names that other tools reserve, and of errors."""

from __future__ import annotations

import random
import warnings

import pytest

from ltlc.errors import LtlSyntaxError
from ltlc.ltl import (
    Eventually,
    LtlSyntaxWarning,
    Proposition,
    parse,
)
from ltlc.ltl.diagnosis import _misreadings, may_be_misread
from ltlc.ltl.dialects import RESERVED
from ltlc.ltl.parser import _grammar

a, b, c, d = map(Proposition, "abcd")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Goal", "Goal is read as G oal"),
        ("FGoal | a", "FGoal is read as F G oal"),
        ("FIRE", "FIRE is read as F IRE"),
        ("G_home", "G_home is read as G _home"),
        ("aUb", "aUb is read as one proposition; write a U b"),
        ("e & f", "f is read as a proposition; ltl2dstar, LBT and guards in HOA files read false"),
        ("F t", "t is read as a proposition; ltl2dstar, LBT and guards in HOA files read true"),
        ("Xf & g", "f is read as a proposition"),
        ("FGt", "t is read as a proposition"),
        ("G !V", "V is read as a proposition; Spot, SPIN and LTL2BA read the operator release, here R"),
        ("F H & F H", "H is read as a proposition; nuXmv and BLACK read the past operator historically"),
        ("F last", "last is read as a proposition; tools for finite traces"),
        ("F(grasp & X release)", "release is read as a proposition; SPIN reads the operator release, here R"),
        ("G(a -> Oa)", "Oa is read as one proposition; nuXmv and BLACK read O before a as the past operator once"),
    ],
)
def test_surprising_readings_are_told(text: str, said: str) -> None:
    assert may_be_misread(text)
    with pytest.warns(LtlSyntaxWarning) as caught:
        parse(text)
    assert len(caught) == 1
    assert said in str(caught[0].message)
    assert caught[0].filename == __file__


@pytest.mark.parametrize(
    "text",
    [
        "Fa",
        "FGa & GFb12",
        "FA",
        "G(request -> F grant)",
        "F goal & G!goal & GFgoal",
        "Gtrue",
        "isReady",
        'a & "t" & "V"',
        "tt & ff",
        "Ok & On & No & Hat",
        "F(A & F B) & G!C & FG T",
        "FR",
        "X1",
    ],
)
def test_usual_readings_are_not(text: str) -> None:
    parse(text)  # a warning is an error


@pytest.mark.parametrize("name", [*RESERVED, "tt", "ff", "true", "Goal"])
def test_names_that_mean_something_elsewhere_are_written_in_quotes(name: str) -> None:
    formula = Eventually(Proposition(name))
    assert str(formula) == f'F "{name}"'
    assert parse(str(formula)) is formula  # a warning is an error
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LtlSyntaxWarning)
        assert (parse(f"F {name}") is formula) == (name in RESERVED)


ERRORS = [
    # text, line, column, words of the message, words of the hint
    ("", 1, 1, "empty", "true"),
    (" \n ", 1, 1, "empty", ""),
    ("(a", 1, 1, "bracket is never closed", "add a closing bracket"),
    ("F(a & (b | c)", 1, 2, "bracket is never closed", "add a closing bracket"),
    ("(", 1, 1, "bracket is never closed: expected an operand", ""),
    ("a)", 1, 2, "closes nothing: expected an operator or the end", "remove it"),
    ("(a))", 1, 4, "closes nothing", "opening bracket"),
    (")", 1, 1, "closes nothing: expected an operand", ""),
    ("a & ( )", 1, 5, "empty brackets", "between them"),
    ("a &", 1, 3, "'&' (and) has no right operand", "a & b"),
    ("a & )", 1, 3, "'&' (and) has no right operand", ""),
    ("a\n& b\n->", 3, 1, "'->' (implication) has no right operand", "a -> b"),
    ("& a", 1, 1, "'&' (and) has no left operand", "a & b"),
    ("(| a)", 1, 2, "'|' (or) has no left operand", ""),
    ("a & | b", 1, 5, "right after '&': expected an operand between", ""),
    ("a U U b", 1, 5, "'U' (until) stands right after 'U'", '"U"'),
    ("F", 1, 1, "'F' (eventually) has no operand", '"F"'),
    ("G & a", 1, 1, "'G' (always) has no operand", '"G"'),
    ("a U X", 1, 5, "'X' (next) has no operand", '"X"'),
    ("FG", 1, 2, "'G' (always) has no operand", '"G"'),
    ("!", 1, 1, "'!' (negation) has no operand", "! a"),
    ("()", 1, 1, "'()' (next) has no operand", ""),
    ("R", 1, 1, "'R' (release) has no left operand", '"R"'),
    ("a W", 1, 3, "'W' (weak until) has no right operand", '"W"'),
    ("F(M)", 1, 3, "'M' (strong release) has no left operand", '"M"'),
    ("and", 1, 1, "'and' (and) has no left operand", '"and"'),
    ("a & not", 1, 5, "'not' (negation) has no operand", '"not"'),
    ("a b", 1, 3, "'b' stands right after 'a': expected an operator or the end", '"a b"'),
    ("(a b)", 1, 4, "expected an operator or a closing bracket", ""),
    ("a (b)", 1, 3, "'(' stands right after 'a'", "put an operator"),
    ("a !b", 1, 3, "'!' stands right after 'a'", "put an operator"),
    ("a F b", 1, 3, "'F' stands right after 'a'", ""),
    ("true false", 1, 6, "'false' stands right after 'true'", ""),
    ("a until b", 1, 3, "'until' is read as a name", "until is written U"),
    ("a V b", 1, 3, "'V' is read as a name", "V is written R"),
    ("a implies b", 1, 3, "'implies' is read as a name", "implies is written ->"),
    ("always a", 1, 1, "'always' is read as a name", "always is written G"),
    ("(next a)", 1, 2, "expected an operator or a closing bracket", "next is written X"),
    ("a Ub", 1, 3, "'Ub' stands right after 'a'", "blank after it: U b"),
    ("aU b", 1, 4, "'b' stands right after 'aU'", "blank before it: a U"),
    ("a = b", 1, 3, "'=' is not an operator", "write <-> for equivalence"),
    ("a == b", 1, 3, "'==' is not an operator", "write <-> for equivalence"),
    ("a != b", 1, 3, "'!=' is not an operator", "write xor"),
    ("F x>=10", 1, 4, "'>' is not an operator", '"x>=10"'),
    ("position_x>-10 & b", 1, 11, "'>' is not an operator", '"position_x>-10"'),
    ("a < b", 1, 3, "'<' is not an operator", "<> for eventually"),
    ("x-1", 1, 2, "'-' is not an operator", '"x-1"'),
    ("a * b", 1, 3, "'*' is not an operator", "write & "),
    ("a + b", 1, 3, "'+' is not an operator", "write | "),
    ("a / b", 1, 3, "'/' is not an operator", r"write /\ "),
    ("a \\ b", 1, 3, "'\\' is not an operator", r"write \/ "),
    ("a; b", 1, 2, "';' is not an operator", "words have"),
    ("F[3:2] a", 1, 1, "'F[3:2]' has an empty bound", "smaller number first"),
    ("a & O F b", 1, 5, "O speaks about the past", "the past and the present alone"),
    ("F[a & b]", 1, 2, "'[' is not an operator", "round brackets"),
    ("{a}", 1, 1, "'{' is not an operator", "round brackets"),
    ("a'", 1, 2, "''' is not an operator", "double quotes"),
    ("a # b", 1, 3, "'#' is not an operator", "formula files"),
    ("50%", 1, 1, "'50' is neither a name nor a constant", '"50"'),
    ("a & 1st", 1, 5, "'1st' is neither a name nor a constant", '"1st"'),
    ("a%b", 1, 2, "'%' is not an operator", '"a%b"'),
    ("$x", 1, 1, "'$' is not an operator", '"$x"'),
    ("x@home & b", 1, 2, "'@' is not an operator", '"x@home"'),
    ('a & "b', 1, 5, "quote is never closed", 'another "'),
    ('a & ""', 1, 5, "at least one character", ""),
    ("a &\n  b c", 2, 5, "'c' stands right after 'b'", ""),
]


@pytest.mark.parametrize(("text", "line", "column", "message", "hint"), ERRORS, ids=[repr(row[0]) for row in ERRORS])
def test_errors(text: str, line: int, column: int, message: str, hint: str) -> None:
    with pytest.raises(LtlSyntaxError) as caught:
        parse(text)
    error = caught.value
    assert (error.line, error.column) == (line, column)
    assert message in error.message
    assert hint in error.hint
    assert error.hint
    assert error.text == text


def test_an_error_shows_the_place() -> None:
    with pytest.raises(LtlSyntaxError) as caught:
        parse("G(a ->\n  F b c)")
    assert str(caught.value).splitlines()[:3] == [
        "line 2, column 7: 'c' stands right after 'b': expected an operator or a closing bracket",
        "    F b c)",
        "        ^",
    ]


@pytest.mark.parametrize(
    ("text", "excerpt", "caret"),
    [
        ("部屋 b", "  部屋 b", "       ^"),  # two columns each
        ('"e\u0301" b', '  "e\u0301" b', "      ^"),  # no column for the accent
        ("a\x0c&\tb c", "  a & b c", "        ^"),  # a form feed does not end the line
        ("a &\r\n b\u2028c", "   b c", "     ^"),
        ("a " * 500, "  " + "a " * 40, "    ^"),
        ("(" * 500 + "a b", "  " + "(" * 38 + "a b", "  " + " " * 40 + "^"),
    ],
)
def test_the_caret_stands_below_the_place(text: str, excerpt: str, caret: str) -> None:
    with pytest.raises(LtlSyntaxError) as caught:
        parse(text)
    assert str(caught.value).split("\n")[1:3] == [excerpt, caret]


def test_character_soup_ends_in_a_formula_or_a_syntax_error() -> None:
    rng = random.Random(1)
    pieces = [
        *"ab()()!&|^UWRMXFGtfOHTSN10 \"\\'<>[]-=;{}#/~.,\n\t%é∧□",
        "->",
        "<->",
        "true",
        "and",
        "not ",
        "xor",
        "()",
        "FG",
        "U ",
        *("O ", "S ", "AG ", "[0,3]", "P=?", "cycle{", "|->", "\udce9"),
        *("T ", "Y ", "F[1:2]", "U<=3", "X[!]", "WX ", "since "),
    ]
    parsed = 0
    for _ in range(4000):
        text = "".join(rng.choice(pieces) for _ in range(rng.randint(0, 12)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LtlSyntaxWarning)
            try:
                formula = parse(text)
            except LtlSyntaxError as error:
                assert 1 <= error.line <= text.count("\n") + 1
                assert 1 <= error.column <= len(text) + 1
                assert error.hint
                str(error)
            else:
                parsed += 1
                assert parse(str(formula)) is formula
                assert may_be_misread(text) or not list(_misreadings(_grammar(False).scan(text)))
    assert parsed > 100


def test_any_characters_end_in_a_formula_or_a_syntax_error() -> None:
    rng = random.Random(2)
    for _ in range(1000):
        text = "".join(chr(rng.choice((rng.randrange(128), rng.randrange(0x3000)))) for _ in range(rng.randint(0, 8)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LtlSyntaxWarning)
            try:
                parse(text)
            except LtlSyntaxError as error:
                str(error)
