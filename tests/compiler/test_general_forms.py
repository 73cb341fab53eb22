"""Forms beyond Rabin: that the language stays, what HOA calls them, and nondeterministic automata read back."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from random_ltl import random_formula, random_nesting, random_task

import ltlc
from ltlc.automata import BuchiAutomaton, OmegaAutomaton, counterexample, equivalent
from ltlc.automata.acceptance import Clause
from ltlc.automata.emerson_lei import LetterEdge
from ltlc.errors import FileFormatError, InvalidArgumentError, InvalidAutomatonError, StateLimitExceeded
from ltlc.formats import from_hoa
from ltlc.ltl import (
    Always,
    And,
    Eventually,
    Formula,
    LassoWord,
    Next,
    Or,
    Proposition,
    Release,
    Until,
    WeakUntil,
    parse,
    satisfies,
)
from ltlc.translate import GeneralForm, determinise

DETERMINISTIC: tuple[GeneralForm, ...] = ("emerson-lei", "generalized-rabin", "streett")


def random_texts(seed: int, n: int) -> list[Formula]:
    rng = random.Random(seed)
    kinds = (
        lambda: random_formula(rng, rng.randint(2, 10), "abc"[: rng.randint(1, 3)]),
        lambda: random_nesting(rng, "abc"),
        lambda: random_task(rng, "abc"),
    )
    return [rng.choice(kinds)() for _ in range(n)]


def random_word(rng: random.Random, names: str = "abc") -> LassoWord:
    def letters(least: int) -> tuple[frozenset[str], ...]:
        return tuple(
            frozenset(name for name in names if rng.random() < 0.5) for _ in range(rng.randint(least, least + 3))
        )

    return LassoWord(letters(0), letters(1))


def same(automaton: OmegaAutomaton, formula: Formula, plain: ltlc.DRA) -> None:
    """The words of the formula, by three ways: runs, the file read back, and the Rabin automaton made of it."""
    rng = random.Random(str(formula))
    for _ in range(10):
        word = random_word(rng)
        own = [[letter & set(automaton.aps) for letter in part] for part in (word.prefix, word.cycle)]
        assert automaton.accepts(*own) == satisfies(formula, word), (formula, automaton.form, word)
    read = from_hoa(automaton.to_hoa(), nondeterministic=True)
    assert not isinstance(read, ltlc.DFA)
    for found in (determinise(automaton), determinise(read) if isinstance(read, OmegaAutomaton) else read):
        assert equivalent(found, plain), f"{formula} as {automaton.form} on {counterexample(found, plain)}"


@pytest.mark.parametrize("form", [*DETERMINISTIC, "limit-deterministic"])
@pytest.mark.slow
def test_random_formulas(form: GeneralForm) -> None:
    for formula in random_texts(7, 60):
        plain = ltlc.compile(formula, acceptance="transition")
        automaton = ltlc.compile(formula, form=form)
        same(automaton, formula, plain)
        if form in DETERMINISTIC:
            assert automaton.is_deterministic
        if form in DETERMINISTIC[:2]:
            assert automaton.n_states <= plain.n_states
        if form == "streett":
            assert automaton.n_states <= ltlc.compile(f"!({formula})", acceptance="transition").n_states


@pytest.mark.parametrize(
    ("text", "form", "states", "name"),
    [
        ("GF a & GF b & GF c", "emerson-lei", 1, "generalized-Buchi 3"),
        ("(GF a -> GF b) & (GF c -> GF d)", "streett", 1, "Streett 2"),
        ("(GF a -> GF b) & (GF c -> GF d)", "emerson-lei", 1, None),
        ("GF a & GF b & FG c", "generalized-rabin", 1, "generalized-Rabin 1 2"),
        ("(GF a & GF b) | FG c", "generalized-rabin", 1, "generalized-Rabin 2 2 0"),
        ("FG a | GF b", "limit-deterministic", 4, "Buchi"),
        ("true", "emerson-lei", 1, "all"),
        ("true", "streett", 1, "Streett 1"),
        ("false", "emerson-lei", 1, "none"),
        ("false", "generalized-rabin", 1, "none"),
        ("F a", "limit-deterministic", 2, "Buchi"),
    ],
)
def test_what_they_are_called(text: str, form: GeneralForm, states: int, name: str | None) -> None:
    automaton = ltlc.compile(text, form=form)
    assert automaton.n_states == states
    hoa = automaton.to_hoa()
    assert f"acc-name: {name}\n" in hoa if name else "acc-name" not in hoa
    same(automaton, parse(text), ltlc.compile(text))


@pytest.mark.peer
def test_other_tools_read_them() -> None:
    spot = pytest.importorskip("spot")
    for formula in random_texts(8, 40):
        for form in (*DETERMINISTIC, "limit-deterministic"):
            automaton = ltlc.compile(formula, form=form)
            (read,) = spot.automata(automaton.to_hoa())
            assert spot.are_equivalent(read, spot.formula(str(formula))), (formula, form)
            assert spot.is_deterministic(read) == automaton.is_deterministic


@pytest.mark.peer
def test_nondeterministic_automata_of_another_tool(tmp_path: Path) -> None:
    spot = pytest.importorskip("spot")
    n_nondeterministic = 0
    for formula in random_texts(9, 60):
        for options in (("buchi",), ("buchi", "sbacc"), ("generic",), ("tgba",)):
            path = tmp_path / "automaton.hoa"
            path.write_text(spot.translate(spot.formula(str(formula)), *options).to_str("hoa"))
            found = ltlc.load(path, determinise=True)
            assert isinstance(found, ltlc.DRA)
            assert equivalent(found, ltlc.compile(formula, acceptance="transition"))
            try:
                ltlc.load(path)
            except FileFormatError as error:
                assert "not deterministic" in str(error) or "a second initial state" in str(error)
                n_nondeterministic += 1
    assert n_nondeterministic > 20


@pytest.mark.slow
def test_random_nondeterministic_automata() -> None:
    rng = random.Random(1)
    for _ in range(60):
        n, n_sets = rng.randint(1, 4), rng.randint(0, 2)
        edges = tuple(
            tuple(
                LetterEdge(rng.randrange(1, 16), rng.randrange(n), rng.randrange(1 << n_sets))
                for _ in range(rng.randint(0, 3))
            )
            for _ in range(n)
        )
        starts = tuple(sorted(rng.sample(range(n), rng.randint(1, n))))
        condition = (Clause(0, (1 << n_sets) - 1),)
        letters = ltlc.compile("G(a -> X b)").letter_class
        automaton = OmegaAutomaton(("a", "b"), letters, edges, n_sets, condition, "nondeterministic", starts)
        read = from_hoa(automaton.to_hoa(), nondeterministic=True)
        made = [determinise(automaton), determinise(read) if isinstance(read, OmegaAutomaton) else read]
        oracle = BuchiAutomaton(4, starts, edges, n_sets)
        for _ in range(25):
            prefix, cycle = ([rng.randrange(4) for _ in range(rng.randint(k, 4))] for k in (0, 1))
            wanted = oracle.accepts([int(letters[a]) for a in prefix], [int(letters[a]) for a in cycle])
            names = [[{n for i, n in enumerate("ab") if a >> i & 1} for a in part] for part in (prefix, cycle)]
            assert automaton.accepts(*names) == wanted
            assert [found.accepts(*names) for found in made] == [wanted, wanted]


def recurrence_formula(rng: random.Random, size: int) -> Formula:
    """A formula that is a recurrence property by its form: no until above a greatest fixpoint in its scope."""

    def guarantee(size: int) -> Formula:
        if size <= 1:
            return Proposition(rng.choice("ab"))
        operator = rng.choice((And, Or, Until, Eventually, Next))
        if operator in (Eventually, Next):
            return operator(guarantee(size - 1))
        left = rng.randint(1, size - 1)
        return operator(guarantee(left), guarantee(size - left))

    if size <= 1 or rng.random() < 0.2:
        return guarantee(size)
    operator = rng.choice((And, Or, WeakUntil, Release, Always, Next))
    if operator in (Always, Next):
        return operator(recurrence_formula(rng, size - 1))
    left = rng.randint(1, size - 1)
    return operator(recurrence_formula(rng, left), recurrence_formula(rng, size - left))


def test_recurrence_formulas_are_buchi() -> None:
    rng = random.Random(2)
    for _ in range(120):
        formula = recurrence_formula(rng, rng.randint(2, 9))
        automaton = ltlc.compile(formula, form="buchi")
        assert not automaton.fin.any()
        assert equivalent(automaton, ltlc.compile(formula, translator="safra"))


def test_errors(tmp_path: Path) -> None:
    choosing = ltlc.compile("FG a | GF b", form="limit-deterministic")
    with pytest.raises(InvalidArgumentError, match=r"is not deterministic; ltlc\.translate\.determinise"):
        choosing.to_rabin()
    for suffix in ("json", "svg", "dot"):
        with pytest.raises(InvalidArgumentError, match="form limit-deterministic are written as hoa"):
            choosing.save(tmp_path / f"automaton.{suffix}")
    with pytest.raises(InvalidArgumentError, match="the cycle of a lasso word needs"):
        choosing.accepts([], [])
    with pytest.raises(InvalidAutomatonError, match="out of range"):
        OmegaAutomaton(("a",), choosing.letter_class[:2], choosing.edges, 0, (), "odd")
    both = OmegaAutomaton(
        ("a",),
        ltlc.compile("X a").letter_class,
        ((LetterEdge(3, 0, 0), LetterEdge(1, 0, 1)),),
        1,
        (Clause(1, 0),),
        "nondeterministic",
    )
    with pytest.raises(InvalidArgumentError, match=r"is not .generalized. Buchi"):
        determinise(both)
    with pytest.raises(FileFormatError, match="only Buchi and generalized Buchi automata are read"):
        from_hoa(both.to_hoa(), nondeterministic=True)
    hoa = choosing.to_hoa()
    with pytest.raises(FileFormatError, match=r"not deterministic: .* read with determinise"):
        from_hoa(hoa)
    claimed = hoa.replace("trans-acc\n", "trans-acc deterministic\n")
    with pytest.raises(FileFormatError, match=r"two edges for one letter, though line .* claims `deterministic`"):
        from_hoa(claimed, nondeterministic=True)
    (tmp_path / "choosing.hoa").write_text(hoa)
    with pytest.raises(StateLimitExceeded):
        ltlc.load(tmp_path / "choosing.hoa", determinise=True, max_states=1)
    assert ltlc.load(tmp_path / "choosing.hoa", determinise=True).n_states == 1
