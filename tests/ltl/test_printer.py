"""Formula to text and back."""

from __future__ import annotations

import random

import pytest
from random_ltl import random_formula, random_word

from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.ltl import And, Formula, Or, Proposition, Until, Xor, nnf, parse, satisfies, to_text
from ltlc.ltl.printer import Syntax

NAMES = [
    "a",
    "position_x>-10",
    "and",
    "U",
    "F",
    "Goal",
    "t",
    "true",
    'say "hi"',
    "back\\slash",
    'both\\"',
    "a b",
    "1",
    "x.y",
    "Tür",
    "V",
    "F1",
    "FR",
    "\\",
    "two\nlines",
    "()",
    "NOT",
    "tRuE",
]


@pytest.mark.slow
def test_parse_undoes_str() -> None:
    rng = random.Random(1)
    for _ in range(1500):
        formula = random_formula(rng, rng.randint(1, 20), rng.sample(NAMES, 3))
        assert parse(str(formula)) is formula
        assert parse(to_text(formula, "unicode")) is formula
        assert parse(to_text(formula, "spot")) is formula


def test_every_name_survives() -> None:
    for name in NAMES:
        assert parse(str(Proposition(name))) is Proposition(name)


def test_brackets_are_minimal() -> None:
    rng = random.Random(2)
    for _ in range(300):
        text = str(random_formula(rng, rng.randint(2, 12)))
        for opened in [i for i, sign in enumerate(text) if sign == "("]:
            closed = _partner(text, opened)
            fewer = text[:opened] + " " + text[opened + 1 : closed] + " " + text[closed + 1 :]
            assert parse(fewer) is not parse(text), f"{text} needs no bracket at {opened}"


def _partner(text: str, opened: int) -> int:
    depth = 0
    for i in range(opened, len(text)):
        depth += (text[i] == "(") - (text[i] == ")")
        if depth == 0:
            return i
    raise AssertionError(text)


TEXT = 'G(a -> F "Goal") & !(b U X c) xor d R (true M e) <-> (a | b) W false'


@pytest.mark.parametrize(
    ("syntax", "expected"),
    [
        ("plain", 'G(a -> F "Goal") & !(b U X c) xor d R true M e <-> (a | b) W false'),
        ("unicode", '□(a → ◇"Goal") ∧ ¬(b U ○c) ⊕ d R ⊤ M e ↔ (a ∨ b) W ⊥'),
        ("spot", 'G(a -> F "Goal") & !(b U X c) xor d R 1 M e <-> (a | b) W 0'),
    ],
)
def test_syntaxes(syntax: Syntax, expected: str) -> None:
    assert to_text(parse(TEXT), syntax) == expected


def test_latex() -> None:
    text = to_text(parse('G(a -> F near_goal) & !(b U "50% \\{x}")'), "latex")
    assert text == (
        r"\mathsf{G}\,(a \rightarrow \mathsf{F}\,\mathrm{near\_goal}) \wedge "
        r"\neg(b \;\mathsf{U}\; \mathrm{50\%\ \backslash{}\{x\}})"
    )


def test_prism() -> None:
    assert to_text(parse("F(A & F B) & G!C & FG T"), "prism") == '(F("A" & (F "B"))) & (G !"C") & (F G "T")'
    assert to_text(parse("a U b | !F a"), "prism") == '("a" U "b") | !(F "a")'
    assert to_text(parse("a W b"), "prism") == '("a" U "b") | (G "a")'
    assert to_text(parse("a xor true"), "prism") == '("a" & !true) | (!"a" & true)'
    with pytest.raises(InvalidArgumentError, match="Rename the proposition"):
        to_text(parse('"x>1"'), "prism")


def test_prism_means_the_same() -> None:
    rng = random.Random(3)
    for _ in range(300):
        formula = random_formula(rng, rng.randint(1, 8))
        reread = parse(to_text(formula, "prism"))
        for _ in range(5):
            word = random_word(rng)
            assert satisfies(formula, word) == satisfies(reread, word)


@pytest.mark.peer
def test_prism_is_read_by_storm() -> None:
    stormpy = pytest.importorskip("stormpy")
    rng = random.Random(4)
    for _ in range(30):
        text = to_text(random_formula(rng, rng.randint(1, 8), constants=0), "prism")
        assert len(stormpy.parse_properties(f"P=? [{text}]")) == 1


@pytest.mark.peer
def test_spot_reads_what_is_meant() -> None:
    spot = pytest.importorskip("spot")
    rng = random.Random(5)
    for _ in range(60):
        formula = random_formula(rng, rng.randint(1, 10), rng.sample([name for name in NAMES if "\n" not in name], 2))
        theirs = spot.formula(to_text(formula, "spot"))
        # Our normal form is written with other operators, so agreement says something about all of them.
        assert spot.are_equivalent(theirs, spot.formula(to_text(nnf(formula), "spot")))
        assert {str(ap.ap_name()) for ap in spot.atomic_prop_collect(theirs)} <= set(NAMES)


@pytest.mark.peer
def test_plain_text_is_read_alike_by_spot() -> None:
    spot = pytest.importorskip("spot")
    rng = random.Random(6)
    for _ in range(60):
        formula = random_formula(rng, rng.randint(1, 10))
        assert spot.are_equivalent(spot.formula(str(formula)), spot.formula(to_text(formula, "spot")))


def test_repr_can_be_evaluated_by_a_reader() -> None:
    assert repr(parse("G a")) == "parse('G a')"
    assert f"{parse('a & b')}" == "a & b"


def test_operators_build_formulas() -> None:
    a, b = Proposition("a"), Proposition("b")
    assert str(~a & b | a >> b) == "!a & b | (a -> b)"
    assert And() is parse("true")
    assert Or() is parse("false")
    assert str(Xor(a, Xor(b, a))) == "a xor (b xor a)"
    assert str(Until(Until(a, b), a)) == "(a U b) U a"


def test_formulas_are_immutable_values() -> None:
    formula: Formula = parse("a U b")
    with pytest.raises(AttributeError, match="immutable"):
        formula.args = ()  # type: ignore[misc]
    with pytest.raises(UnknownNameError, match="plain"):
        to_text(formula, "plane")  # type: ignore[arg-type]
    with pytest.raises(InvalidArgumentError, match="name"):
        Proposition("")


@pytest.mark.parametrize(
    "text",
    [
        "FGa",
        "GF a",
        "G!C",
        "XXa",
        'FG"x"',
        "FG T",
        "F1 & G0b",
        "FFU1",
        "XG1",
        "FF0",
        "GF(a)",
        "FG []a",
        "GF ()a",
        "Gtrue & Ffalse",
        "a xor b & c | d -> e <-> a",
        "a W b M c U d R e",
        "a.b & c_d",
        "F(A & F B) & G!C & FG T",
    ],
)
@pytest.mark.peer
def test_operator_runs_are_read_as_spot_reads_them(text: str) -> None:
    spot = pytest.importorskip("spot")
    assert spot.are_equivalent(spot.formula(text), spot.formula(to_text(parse(text), "spot")))
