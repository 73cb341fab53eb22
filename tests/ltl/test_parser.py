"""Text to formula: syntax, precedence, files, and the table against the parser that made it."""

from __future__ import annotations

import random
from importlib.resources import files
from typing import Any

import pytest
from lark import Lark, Tree, UnexpectedCharacters
from lark import UnexpectedToken as UnexpectedByLark
from random_ltl import random_formula

from ltlc.ltl import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
    parse,
    propositions,
    read_formulas,
)
from ltlc.ltl.grammar import UnexpectedToken
from ltlc.ltl.parser import _builders, _grammar
from ltlc.ltl.tables import UNKNOWN, as_json, load, work_out

a, b, c, d = map(Proposition, "abcd")


@pytest.mark.parametrize(
    ("spellings", "formula"),
    [
        (["!a", "~a", "not a", "NOT a", "¬a", "! a", "!(a)"], Not(a)),
        (["a & b", "a && b", "a and b", "a AND b", r"a /\ b", "a ∧ b", "a&b", "(a)and(b)"], And(a, b)),
        (["a | b", "a || b", "a or b", "a OR b", r"a \/ b", "a ∨ b"], Or(a, b)),
        (["a -> b", "a => b", "a --> b", "a → b", "a ⇒ b"], Implies(a, b)),
        (["a <-> b", "a <=> b", "a <--> b", "a ↔ b", "a ⇔ b"], Iff(a, b)),
        (["a xor b", "a XOR b", "a ^ b", "a ⊕ b"], Xor(a, b)),
        (["X a", "Xa", "()a", "X(a)", "○a", "◯ a"], Next(a)),
        (["F a", "Fa", "<>a", "<> a", "◇a", "F(a)", 'F"a"'], Eventually(a)),
        (["G a", "Ga", "[]a", "[] a", "□a", "G\ta", "G\na"], Always(a)),
        (["a U b", "(a)U(b)", '"a"U"b"'], Until(a, b)),
        (["a R b"], Release(a, b)),
        (["a W b"], WeakUntil(a, b)),
        (["a M b"], StrongRelease(a, b)),
        (["true", "TRUE", "True", "1", "tt", "⊤"], TRUE),
        (["false", "FALSE", "False", "0", "ff", "⊥"], FALSE),
        (["FGa", "FG a", "F G a", "<>[]a", "<>G a", "F[]a"], Eventually(Always(a))),
        (["GFa", "GF(a)", "GF\na", "G<>a"], Always(Eventually(a))),
        (["G!C", "G !C", "G! C"], Always(Not(Proposition("C")))),
        (["XXa", "XX a", "X X a", "()()a"], Next(Next(a))),
        (['FG"x"', 'F G "x"'], Eventually(Always(Proposition("x")))),
        (["Gtrue", "G 1", "G(true)", "Gtt"], Always(TRUE)),
        (["!!a", "a", "!!!!a", "!(!a)"], a),
        (["FFa", "F a", "F(F a)", "<><>a"], Eventually(a)),
        (["GGGa", "G a"], Always(a)),
    ],
)
def test_spellings(spellings: list[str], formula: Formula) -> None:
    for text in spellings:
        assert parse(text) is formula, text


@pytest.mark.parametrize(
    ("text", "bracketed"),
    [
        ("!a U b", "(!a) U b"),
        ("F a U b", "(F a) U b"),
        ("a U F b U c", "a U ((F b) U c)"),
        ("a U b U c", "a U (b U c)"),
        ("a W b M c R d", "a W (b M (c R d))"),
        ("a U b & c", "(a U b) & c"),
        ("a & b xor c", "(a & b) xor c"),
        ("a xor b | c", "(a xor b) | c"),
        ("a xor b xor c", "(a xor b) xor c"),
        ("a & b | c & d", "(a & b) | (c & d)"),
        ("a | b -> c", "(a | b) -> c"),
        ("a -> b -> c", "a -> (b -> c)"),
        ("a <-> b -> c", "a <-> (b -> c)"),
        ("a -> b <-> c", "a -> (b <-> c)"),
        ("G a -> F b", "(G a) -> (F b)"),
        ("X a & b", "(X a) & b"),
        ("a & b & c", "(a & b) & c"),
    ],
)
def test_precedence(text: str, bracketed: str) -> None:
    assert parse(text) is parse(bracketed)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("F(A & F B) & G!C & FG T", "A B C T"),
        ("F1 | XG1 | FF0", "F1 G1 F0"),
        ("FR & GU & FGM", "FR GU FGM"),
        ("F Ma & FMa & GUb & Ub", "Ma Ub"),
        ("near_goal.left & x1", "near_goal.left x1"),
        ("Tür", "Tür"),
        ("T & E & P & TT & FF1", "T E P TT F1"),
        ('"and" & "F" & "x>=1.5" & "a b"', "and|F|x>=1.5|a b"),
    ],
)
def test_names(text: str, names: str) -> None:
    assert propositions(parse(text)) == tuple(names.split("|" if "|" in names else " "))


def test_quoted_names_may_hold_anything() -> None:
    assert parse(r'"say \"hi\" \\ \n"') is Proposition(r'say "hi" \ \n')
    assert parse('"two\nlines"') is Proposition("two\nlines")


def test_formula_files() -> None:
    text = '# header\nF a\n\n  // nothing\nG "x#1" & b # why\n"a//b" U c // so\n   \nX d'
    expected = [(2, "F a"), (5, 'G "x#1" & b'), (6, '"a//b" U c'), (8, "X d")]
    assert list(read_formulas(text)) == expected
    assert list(read_formulas(text.splitlines(keepends=True))) == expected


def test_the_tables_that_are_kept_are_those_of_the_grammar() -> None:
    folder = files("ltlc.grammars")
    grammar = folder.joinpath("ltl.lark").read_text(encoding="utf-8")
    assert folder.joinpath("ltl.json").read_text(encoding="utf-8") == as_json(grammar)  # else: `ltlc.ltl.tables.keep`
    assert load() == work_out(grammar)


# --- against Lark's own loop ------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_table_is_run_as_lark_runs_it() -> None:
    grammar = _grammar(False)
    lark = Lark.open_from_package("ltlc.grammars", "ltl.lark", parser="lalr", lexer="basic")
    pieces = ["a", "b", "(", ")", " U ", " W ", " & ", " | ", " xor ", "!", "X ", "F", "()", "->", "<->", "1", '"c"']
    pieces += ["G", "X", "R", "tt", "F[0:2]", "U<=2"]
    rng = random.Random(4)
    texts = ["".join(rng.choice(pieces) for _ in range(rng.randint(1, 12))) for _ in range(6000)]
    texts += [str(random_formula(rng, rng.randint(1, 30))) for _ in range(500)]
    parsed = 0
    for text in texts:
        tokens = list(grammar.scan(text))
        kinds = [token.kind for token in tokens]
        try:
            assert [(token.type, str(token)) for token in lark.lex(text)] == [token[:2] for token in tokens]
            tree = lark.parse(text)
        except UnexpectedCharacters:
            assert UNKNOWN in kinds
        except UnexpectedByLark as error:
            with pytest.raises(UnexpectedToken) as caught:
                grammar.parse(text)
            starts = [*(token.start for token in tokens), "end"]
            assert starts[caught.value.index] == ("end" if error.token.type == "$END" else error.token.start_pos)
        else:
            parsed += 1
            assert grammar.parse(text) is _built(tree), text
    assert parsed > 500


def _built(tree: Tree[Any]) -> Formula:
    """The formula of a parse tree, by the names of the rules."""
    rules = {rule: build for rule, build in vars(_builders(finite=False)).items() if not rule.startswith("_")}
    done: dict[int, Any] = {}
    for node in tree.iter_subtrees():  # children first
        done[id(node)] = rules[str(node.data)]([done.get(id(child), child) for child in node.children])
    formula = done[id(tree)]
    assert isinstance(formula, Formula)
    return formula
