"""The oracle: truth on lasso words, and their text."""

from __future__ import annotations

import random

import pytest
from random_ltl import random_formula, random_word

from ltlc.errors import InvalidArgumentError, LtlSyntaxError
from ltlc.ltl import LassoWord, Not, parse, parse_word, satisfies


@pytest.mark.parametrize(
    ("text", "word", "expected"),
    [
        ("a", "a; cycle{!a}", True),
        ("X a", "a; cycle{!a}", False),
        ("X X a", "!a; cycle{b; a}", True),
        ("X X X a", "!a; cycle{b; a}", False),
        ("F b", "a; a; cycle{a; b}", True),
        ("F b", "b; cycle{a}", True),
        ("X F b", "b; cycle{a}", False),
        ("G a", "a; cycle{a; a & b}", True),
        ("G a", "a; cycle{a; b}", False),
        ("G a", "!a; cycle{a}", False),
        ("GF b", "cycle{a; b}", True),
        ("GF b", "b; b; cycle{a}", False),
        ("FG b", "a; cycle{b}", True),
        ("FG b", "cycle{a; b}", False),
        ("a U b", "a; a; b; cycle{1}", True),
        ("a U b", "b; cycle{1}", True),
        ("a U b", "cycle{a}", False),
        ("a U b", "a; 1; cycle{b}", False),
        ("a W b", "cycle{a}", True),
        ("a W b", "a; cycle{1; b}", False),
        ("a R b", "cycle{b}", True),
        ("a R b", "b; a & b; cycle{1}", True),
        ("a R b", "b; a; cycle{b}", False),
        ("a M b", "cycle{b}", False),
        ("a M b", "b; a & b; cycle{1}", True),
        ("a -> b", "cycle{1}", True),
        ("a xor b", "cycle{a & b}", False),
        ("a <-> b", "cycle{a & b}", True),
        ("true & !false", "cycle{1}", True),
        ("G(a -> F b)", "a; b; cycle{!a}", True),
        ("a U (b & X (a U c))", "a; b; cycle{a; a; c}", True),
        ("G(X a xor a)", "cycle{a; !a}", True),
    ],
)
def test_examples(text: str, word: str, expected: bool) -> None:
    assert satisfies(parse(text), parse_word(word)) is expected
    assert satisfies(Not(parse(text)), parse_word(word)) is not expected


LAWS = [
    ("F a", "true U a"),
    ("G a", "!F !a"),
    ("a U b", "b | a & X(a U b)"),
    ("a R b", "!(!a U !b)"),
    ("a W b", "(a U b) | G a"),
    ("a M b", "b U (a & b)"),
    ("a xor b", "!(a <-> b)"),
    ("a <-> b", "(a -> b) & (b -> a)"),
    ("X(a U b)", "X a U X b"),
    ("GF(a | b)", "GF a | GF b"),
]


@pytest.mark.parametrize(("left", "right"), LAWS)
def test_laws(left: str, right: str) -> None:
    rng = random.Random(left)
    for _ in range(200):
        word = random_word(rng)
        assert satisfies(parse(left), word) == satisfies(parse(right), word), word


def test_unrolling_a_word_changes_nothing() -> None:
    rng = random.Random(1)
    for _ in range(300):
        formula, word = random_formula(rng, 10), random_word(rng)
        truth = satisfies(formula, word)
        turned = LassoWord([*word.prefix, word.cycle[0]], [*word.cycle[1:], word.cycle[0]])
        twice = LassoWord(word.prefix, word.cycle * 2)
        assert satisfies(formula, turned) == satisfies(formula, twice) == truth


def test_agrees_with_brute_force_over_the_definition() -> None:
    """Until by its definition, over enough positions to have seen every suffix of the word."""
    rng = random.Random(2)
    until = parse("a U b")
    for _ in range(300):
        word = random_word(rng)
        letters = [*word.prefix, *word.cycle, *word.cycle]
        first_b = next((i for i, letter in enumerate(letters) if "b" in letter), None)
        expected = first_b is not None and all("a" in letter for letter in letters[:first_b])
        assert satisfies(until, word) == expected


@pytest.mark.peer
def test_agrees_with_spot() -> None:
    spot = pytest.importorskip("spot")
    rng = random.Random(3)
    for _ in range(100):
        formula, word = random_formula(rng, rng.randint(1, 9)), random_word(rng)
        # To Spot a letter leaves open what it does not mention, so every letter has to mention all.
        word = LassoWord([{"a", "b", "c"}, *word.prefix], word.cycle)
        automaton = spot.translate(str(formula))
        reading = spot.parse_word(str(word), automaton.get_dict()).as_automaton()
        assert automaton.intersects(reading) == satisfies(formula, word), f"{formula} on {word}"


# --- text -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a; b; cycle{!a}", LassoWord([{"a"}, {"b"}], [set()])),
        ("cycle{a}", LassoWord([], [{"a"}])),
        (" cycle { a ; b } ", LassoWord([], [{"a"}, {"b"}])),
        ("a & !b;\n1; cycle{true; a & b & c}", LassoWord([{"a"}, set()], [set(), {"a", "b", "c"}])),
        ('"x;1" & "cycle{"; cycle{"}"}', LassoWord([{"x;1", "cycle{"}], [{"}"}])),
        ("f; !t; cycle{t}", LassoWord([{"f"}, set()], [{"t"}])),
        ("cycle; cycle{a}", LassoWord([{"cycle"}], [{"a"}])),
        ("(a & b); cycle{not c and d}", LassoWord([{"a", "b"}], [{"d"}])),
    ],
)
def test_words_are_read(text: str, word: LassoWord) -> None:
    assert parse_word(text) == word


def test_words_survive_their_text() -> None:
    rng = random.Random(4)
    for _ in range(200):
        word = random_word(rng, ("a", "x>1", "F", 'q"'))
        assert parse_word(str(word)) == word


WORD_ERRORS = [
    ("", 1, 1, "ends too early"),
    ("a; b", 1, 5, "ends too early"),
    ("a; b;", 1, 6, "ends too early"),
    ("cycle{}", 1, 7, "a letter is missing before '}'"),
    ("cycle{a", 1, 8, "cycle is never closed"),
    ("cycle{a;}", 1, 9, "a letter is missing before '}'"),
    ("a cycle{b}", 1, 3, "'cycle{' stands right after a letter"),
    ("a;; cycle{b}", 1, 3, "a letter is missing before ';'"),
    ("; cycle{b}", 1, 1, "a letter is missing before ';'"),
    ("cycle{a}; b", 1, 9, "';' stands behind the cycle"),
    ("cycle{a} b", 1, 10, "'b' stands behind the cycle"),
    ("{a}; cycle{b}", 1, 1, "not a set in brackets"),
    ("cycle{cycle{a}}", 1, 7, "unexpected 'cycle{'"),
    ("a }; cycle{b}", 1, 3, "unexpected '}'"),
    ("a | b; cycle{b}", 1, 1, "conjunction of literals"),
    ("a; F b; cycle{b}", 1, 4, "conjunction of literals"),
    ("cycle{false}", 1, 7, "conjunction of literals"),
    ("a; b & !b; cycle{b}", 1, 4, "cannot be true and false"),
    ("a; b c; cycle{b}", 1, 6, "'c' stands right after 'b'"),
    ("a;\nb &; cycle{b}", 2, 3, "has no right operand"),
    ('a; "b; cycle{b}', 1, 4, "quote is never closed"),
]


@pytest.mark.parametrize(("text", "line", "column", "message"), WORD_ERRORS, ids=[repr(row[0]) for row in WORD_ERRORS])
def test_word_errors(text: str, line: int, column: int, message: str) -> None:
    with pytest.raises(LtlSyntaxError) as caught:
        parse_word(text)
    error = caught.value
    assert message in error.message
    assert (error.line, error.column) == (line, column)
    assert error.hint
    assert error.text == text


def test_word_soup_ends_in_a_word_or_a_syntax_error() -> None:
    rng = random.Random(5)
    pieces = ["a", "b", "!", "&", ";", "{", "}", "cycle", "cycle{", " ", "1", '"', "|", "(", ")", "\n", "%"]
    for _ in range(3000):
        text = "".join(rng.choice(pieces) for _ in range(rng.randint(0, 10)))
        try:
            word = parse_word(text)
        except LtlSyntaxError as error:
            str(error)
        else:
            assert parse_word(str(word)) == word


def test_words_are_checked() -> None:
    with pytest.raises(InvalidArgumentError, match="at least one letter"):
        LassoWord([{"a"}], [])
    with pytest.raises(InvalidArgumentError, match="set of propositions"):
        LassoWord(["a"], [{"b"}])
    assert LassoWord([], [("a", "b")]) == LassoWord([], [{"b", "a"}])
    assert hash(LassoWord([], [{"a"}])) == hash(LassoWord([], [["a"]]))
