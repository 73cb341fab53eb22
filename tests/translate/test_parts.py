"""The parts of the translation one by one, each against a slow truth."""

from __future__ import annotations

import random
from functools import reduce as fold
from itertools import combinations

import pytest
from closures import accepts, letters_of, random_closures
from formula_of_node import closure_of, unlimited
from random_automata import random_buchi
from random_ltl import random_formula, random_nesting, random_word

from ltlc.automata import equivalent_states
from ltlc.automata.acceptance import (
    ALWAYS,
    NEVER,
    holds,
)
from ltlc.automata.emerson_lei import EmersonLei, LetterEdge, complement, localized, minimized_weak, reduced
from ltlc.automata.rabin_pairs import to_rabin
from ltlc.automata.simulation import reduced_buchi
from ltlc.budget import Budget
from ltlc.errors import StateLimitExceeded
from ltlc.graph import bits
from ltlc.ltl import Formula, LassoWord, parse, satisfies, simplify
from ltlc.translate import Options, translate
from ltlc.translate.closure import Closure
from ltlc.translate.components import Breakpoint, Complement, Finite
from ltlc.translate.decomposition import decompose
from ltlc.translate.product import assign, combine
from ltlc.translate.safra import determinize, parity
from ltlc.translate.tableau import tableau


def assert_complete(automaton: EmersonLei, letters: int) -> None:
    for edges in automaton.edges:
        assert fold(int.__or__, (e.letters for e in edges)) == letters
        assert all(not e.letters & f.letters for e, f in combinations(edges, 2))


# -- tableau and Safra trees ------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_tableau_accepts_the_models() -> None:
    for rng, formula, closure in random_closures(6, 120):
        automaton = tableau(closure, closure.root, unlimited(formula))
        for _ in range(10):
            word = random_word(rng, closure.letters.aps)
            assert automaton.accepts(*letters_of(closure, word)) == satisfies(formula, word), f"{formula} on {word}"


def test_simulation_is_not_given_up_for_a_tableau_of_hundreds_of_states() -> None:
    """Without it there are 379 left, and too many macro-states."""
    formula = simplify(
        parse(
            "F(!X c -> (!G(b U e) <-> !((d <-> (b | d) M !(d & F a)) M (c W (c -> a) & (G c -> b M true))))"
            " xor X(F e M d) W (e U c) U G e)"
        )
    )
    closure = closure_of(formula)
    automaton = tableau(closure, closure.root, unlimited(formula))
    assert automaton.n_states > 500
    assert reduced_buchi(automaton).n_states < 200


@pytest.mark.slow
def test_determinization_keeps_the_language() -> None:
    """Random nondeterministic automata reach corners that tableaux do not."""
    rng = random.Random(7)
    verdicts = {True: 0, False: 0}
    for _ in range(400):
        automaton = random_buchi(rng)
        letters = (1 << automaton.n_letters) - 1
        deterministic = determinize(reduced_buchi(automaton), Budget("random", 100_000))
        assert_complete(deterministic, letters)
        together = determinize(reduced_buchi(automaton), Budget("random", 100_000), apart=False)
        forms = [deterministic, localized(deterministic), reduced(deterministic), together]
        for _ in range(15):
            prefix = [rng.randrange(automaton.n_letters) for _ in range(rng.randint(0, 4))]
            cycle = [rng.randrange(automaton.n_letters) for _ in range(rng.randint(1, 6))]
            truth = automaton.accepts(prefix, cycle)
            verdicts[truth] += 1
            assert [accepts(form, prefix, cycle) for form in forms] == [truth] * 4, (automaton, prefix, cycle)
            assert accepts(complement(deterministic), prefix, cycle) != truth
    assert min(verdicts.values()) > 1000


def test_parity_means_that_the_least_priority_is_odd() -> None:
    for n in range(7):
        for seen in range(1 << n):
            least = next(iter(bits(seen)), 0)
            assert holds(parity(n), seen) == (least % 2 == 1)


# -- components and their products ------------------------------------------------------------------------------------


def run_component(component: Finite | Breakpoint | Complement, letters: int) -> EmersonLei:
    return combine((1,), [component], letters, Budget("component", 100_000))


def random_low(rng: random.Random, level: str) -> tuple[Formula, Closure]:
    while True:
        kind = random_nesting if rng.random() < 0.5 else lambda r, names: random_formula(r, r.randint(3, 12), names)
        closure = closure_of(formula := kind(rng, "ab"))
        if closure.level(closure.root) == level:
            return formula, closure


@pytest.mark.parametrize("level", ["sigma1", "pi1", "sigma2", "pi2"])
def test_components_without_reduction(level: str) -> None:
    """Progression and breakpoints alone; the many implied subformulas of nested G and F are the hard part."""
    rng = random.Random(level)
    for _ in range(60):
        formula, closure = random_low(rng, level)
        root = closure.root
        component: Finite | Breakpoint | Complement
        if level in ("sigma1", "pi1"):
            component = Finite(closure, root, safety=level == "pi1")
        elif level == "pi2":
            component = Breakpoint(closure, root)
        else:
            component = Complement(Breakpoint(closure, closure.negation(root)))
        automaton = run_component(component, closure.letters.all)
        assert_complete(automaton, closure.letters.all)
        for _ in range(25):
            word = random_word(rng, closure.letters.aps)
            assert accepts(automaton, *letters_of(closure, word)) == satisfies(formula, word), f"{formula} on {word}"


@pytest.mark.slow
def test_products_without_reduction() -> None:
    for rng, formula, closure in random_closures(8, 120):
        budget = unlimited(formula)
        try:
            skeleton, components = decompose(closure, closure.root, budget.within(500))
            automaton = combine(skeleton, components, closure.letters.all, budget.within(2000))
        except StateLimitExceeded:
            continue
        assert_complete(automaton, closure.letters.all)
        for _ in range(15):
            word = random_word(rng, closure.letters.aps)
            assert accepts(automaton, *letters_of(closure, word)) == satisfies(formula, word), f"{formula} on {word}"


def test_fairness_rests_until_the_rest_has_settled() -> None:
    """Six states of X-memory for G F(a & X X b) would multiply the way to the goal; suspended, they are added."""
    alone = translate(parse("G F(a & X X b)"), Options(translator="normal-form", acceptance="transition")).n_states
    way = translate(parse("F(c & X F(c & X F c))"), Options(translator="normal-form", acceptance="transition")).n_states
    both = parse("F(c & X F(c & X F c)) & G F(a & X X b)")
    assert translate(both, Options(translator="normal-form", acceptance="transition")).n_states == way - 1 + alone


def test_decided_components_leave_the_skeleton() -> None:
    assert assign((0b011, 0b101), 0, True) == (0b010, 0b100)
    assert assign((0b011, 0b101), 0, False) == ()
    assert assign((0b001, 0b010), 0, True) == (0,)
    assert assign((0b001, 0b010), 0, False) == (0b010,)


# -- weak automata ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_weak_automata_become_as_small_as_their_language_allows() -> None:
    for rng, formula, closure in random_closures(12, 400):
        if not closure.is_obligation(closure.root):
            continue
        budget = unlimited(formula)
        skeleton, components = decompose(closure, closure.root, budget)
        automaton = localized(combine(skeleton, components, closure.letters.all, budget))
        smallest = minimized_weak(automaton)
        arrays = to_rabin(smallest, closure.letters.aps, closure.letters.letter_class, budget)
        assert len(set(equivalent_states(arrays).tolist())) == smallest.n_states, formula
        for _ in range(8):
            word = random_word(rng, closure.letters.aps)
            assert accepts(smallest, *letters_of(closure, word)) == satisfies(formula, word)


def test_colors_of_trivial_components_follow_their_successors() -> None:
    """0 -> 1 -> 2 with an accepting sink, trivial states before it: all three have the same language."""
    chain = [(LetterEdge(1, 1, 0),), (LetterEdge(1, 2, 0),), (LetterEdge(1, 2, 0),)]
    assert minimized_weak(EmersonLei(tuple(chain), (NEVER, NEVER, ALWAYS))).n_states == 1


# -- budget -----------------------------------------------------------------------------------------------------------


def test_budgets_narrow_but_do_not_widen() -> None:
    budget = Budget("f", 10)
    assert budget.within(5).max_states == 5
    assert budget.within(50).max_states == 10


@pytest.mark.parametrize(
    ("text", "states"),
    [
        (" | ".join(f"F G a{i}" for i in range(16)), 16),
        (" & ".join(f"G F a{i}" for i in range(8)) + " & (" + " | ".join(f"F G a{i}" for i in range(8, 16)) + ")", 8),
    ],
)
def test_many_parts_take_turns(text: str, states: int) -> None:
    """A state of their product has more moves than are allowed, one for each set of marks."""
    formula, rng = parse(text), random.Random(1)
    automaton = translate(formula, Options(acceptance="transition"))
    assert automaton.n_states == states
    names = automaton.aps
    for _ in range(60):
        cycle = [frozenset(name for name in names if rng.random() < 0.9) for _ in range(rng.randint(1, 3))]
        assert automaton.accepts([], cycle) == satisfies(formula, LassoWord((), tuple(cycle)))
