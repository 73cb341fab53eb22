"""The parts of the translation one by one, each against a slow truth."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from functools import reduce as fold
from itertools import combinations

import pytest
from formula_of_node import closure_of, formula_of_node, formula_of_obligation, unlimited
from random_ltl import random_formula, random_nesting, random_task, random_word

from ltlc.automata import equivalent_states
from ltlc.automata.acceptance import (
    ALWAYS,
    NEVER,
    Acceptance,
    Clause,
    conjunction,
    disjunction,
    holds,
    negation,
    restrict,
    simplify,
    without_implied,
)
from ltlc.automata.buchi import BuchiAutomaton, BuchiEdge
from ltlc.automata.cycles import CycleDecomposition, InnerEdge
from ltlc.automata.emerson_lei import Edge, EmersonLei, complement, localized, minimized_weak, reduced
from ltlc.automata.rabin_pairs import Counters, CycleMemory, to_rabin
from ltlc.budget import Budget
from ltlc.errors import StateLimitExceeded
from ltlc.graph import bits
from ltlc.ltl import Formula, LassoWord, parse, satisfies
from ltlc.translate import Options, translate
from ltlc.translate.closure import Closure
from ltlc.translate.components import Breakpoint, Complement, Finite
from ltlc.translate.decomposition import decompose
from ltlc.translate.normal_form import normal_form
from ltlc.translate.product import assign, combine
from ltlc.translate.safra import determinize, parity
from ltlc.translate.tableau import tableau


def random_closures(seed: int, count: int, size: int = 9) -> Iterator[tuple[random.Random, Formula, Closure]]:
    rng = random.Random(seed)
    for _ in range(count):
        names = "abc"[: rng.randint(1, 3)]
        kind = rng.randrange(4)
        if kind == 0:
            formula = random_nesting(rng, names)
        elif kind == 1:
            formula = random_task(rng, names)
        else:
            formula = random_formula(rng, rng.randint(2, size), names)
        yield rng, formula, closure_of(formula)


def letters_of(closure: Closure, word: LassoWord) -> tuple[list[int], list[int]]:
    """The word in letter classes."""
    aps, letter_class = closure.letters.aps, closure.letters.letter_class

    def number(letter: Iterable[str]) -> int:
        return int(letter_class[sum(1 << aps.index(name) for name in letter)])

    return [number(letter) for letter in word.prefix], [number(letter) for letter in word.cycle]


def accepts(automaton: EmersonLei, prefix: list[int], cycle: list[int]) -> bool:
    """Truth by running: the marks of the loop, judged by the condition of a state on it."""

    def read(state: int, letters: list[int]) -> tuple[int, int]:
        seen = 0
        for letter in letters:
            edge = next(e for e in automaton.edges[state] if e.letters >> letter & 1)
            state, seen = edge.target, seen | edge.marks
        return state, seen

    state, _ = read(0, prefix)
    for _ in range(automaton.n_states):
        state, _ = read(state, cycle)
    start, seen = state, 0
    while True:
        state, more = read(state, cycle)
        seen |= more
        if state == start:
            return holds(automaton.acceptance[state], seen)


def assert_complete(automaton: EmersonLei, letters: int) -> None:
    for edges in automaton.edges:
        assert fold(int.__or__, (e.letters for e in edges)) == letters
        assert all(not e.letters & f.letters for e, f in combinations(edges, 2))


# -- closure ----------------------------------------------------------------------------------------------------------


def test_letter_classes_are_those_the_formula_tells_apart() -> None:
    closure = closure_of(parse("G(a & b) | F c"))
    assert closure.letters.n_classes == 4
    assert closure_of(parse("G(a1 & a2 & a3 & a4 & a5)")).letters.n_classes == 2
    assert closure_of(parse("true")).letters.n_classes == 1


def test_what_remains_after_a_letter() -> None:
    """a.w satisfies f iff w satisfies after(f, a); the derivative has one obligation for each letter."""
    for rng, formula, closure in random_closures(1, 120):
        closure.register(closure.root)
        derivative = closure.after(closure.obligation(closure.root))
        assert fold(int.__or__, derivative.values()) == closure.letters.all
        assert all(not x & y for x, y in combinations(derivative.values(), 2))
        for _ in range(8):
            word = random_word(rng, closure.letters.aps)
            letter = random_word(rng, closure.letters.aps).cycle[0]
            (number,), _ = letters_of(closure, LassoWord([letter], [letter]))
            remaining = next(f for f, letters in derivative.items() if letters >> number & 1)
            longer = LassoWord((letter, *word.prefix), word.cycle)
            assert satisfies(formula, longer) == satisfies(formula_of_obligation(closure, remaining), word)


def test_obligations_are_equivalent_to_their_nodes() -> None:
    for rng, formula, closure in random_closures(2, 150):
        closure.register(closure.root)
        for node in range(len(closure.nodes)):
            obligation = formula_of_obligation(closure, closure.obligation(node))
            for _ in range(4):
                word = random_word(rng, closure.letters.aps)
                truth = satisfies(formula_of_node(closure, node), word)
                assert satisfies(obligation, word) == truth, f"{formula}: node {closure.nodes[node]}"


def test_syntactic_implication_is_sound_and_transitively_closed() -> None:
    found = 0
    for rng, formula, closure in random_closures(3, 120, size=14):
        closure.register(closure.root)
        closure.register_finite_parts(closure.root)
        nodes = [formula_of_node(closure, node) for node in range(len(closure.nodes))]
        words = [random_word(rng, closure.letters.aps) for _ in range(12)]
        truth = [[satisfies(f, word) for word in words] for f in nodes]
        for f in range(len(nodes)):
            for g in range(len(nodes)):
                if f != g and closure.implies(f, g):
                    found += 1
                    wrong = [str(w) for w, x, y in zip(words, truth[f], truth[g], strict=True) if x and not y]
                    assert not wrong, f"{nodes[f]} does not imply {nodes[g]} on {wrong[0]} ({formula})"
            if closure.obligation(f) == (1 << f,):
                implied = closure.closed(1 << f)
                assert closure.closed(implied) == implied
    assert found > 1000


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("a & X b", "sigma1"),
        ("F(a & X(b U c))", "sigma1"),
        ("a M b", "sigma1"),
        ("G(a | X b)", "pi1"),
        ("(G a) W b", "pi1"),
        ("F G a", "sigma2"),
        ("a U G b", "sigma2"),
        ("(a W b) & F c", "sigma2"),
        ("G(a | F b)", "pi2"),
        ("G F a", "pi2"),
        ("(F a) R b", "pi2"),
        ("G(F G a | b)", ""),
        ("F(G F a & b)", ""),
        ("G F a | F G b", ""),
    ],
)
def test_level_in_the_hierarchy(text: str, level: str) -> None:
    closure = closure_of(parse(text))
    assert closure.level(closure.root) == level


@pytest.mark.parametrize(
    ("text", "obligation", "fair", "low"),
    [
        ("G a | F b & G c", True, True, True),
        ("G F a & G b", False, True, True),
        ("G F X a & G b", False, False, True),
        ("G(a | F b) | F G c", False, False, True),
        ("G(F a | G b)", False, False, True),
        ("G(F G a | F b)", False, False, False),
    ],
)
def test_shapes(text: str, obligation: bool, fair: bool, low: bool) -> None:
    closure = closure_of(parse(text))
    root = closure.root
    assert closure.is_obligation(root) == obligation
    assert closure.is_fair_obligation(root) == fair
    assert closure.is_low(root) == low


def test_constants_are_folded() -> None:
    closure = closure_of(parse("G(a | F b) & c"))
    true, false = closure.constant(True), closure.constant(False)
    a, b = (closure.node("letters", letters=letters) for letters in (1, 2))
    make = closure.make
    for kind in "&|XFGURWM":
        args = [a] if kind in "XFG" else [a, b]
        assert closure.nodes[make(kind, *args)].kind in (kind, "letters")
    assert make("&", a, false) == false and make("|", a, true) == true
    assert make("&") == true and make("|") == false
    assert make("&", a, a, true) == a
    for kind, left, right, expected in [
        ("U", a, true, true),
        ("U", a, false, false),
        ("U", true, a, make("F", a)),
        ("U", false, a, a),
        ("W", a, true, true),
        ("W", a, false, make("G", a)),
        ("W", true, a, true),
        ("W", false, a, a),
        ("R", a, true, true),
        ("R", a, false, false),
        ("R", true, a, a),
        ("R", false, a, make("G", a)),
        ("M", a, true, make("F", a)),
        ("M", a, false, false),
        ("M", true, a, a),
        ("M", false, a, false),
    ]:
        assert make(kind, left, right) == expected, (kind, left, right)


def test_folding_and_negation_keep_the_meaning() -> None:
    for rng, _, closure in random_closures(4, 150):
        rebuilt: dict[int, int] = {}
        for node in range(len(closure.nodes)):
            kind, args, _ = closure.nodes[node]
            rebuilt[node] = node if kind == "letters" else closure.make(kind, *(rebuilt[arg] for arg in args))
        for _ in range(6):
            word = random_word(rng, closure.letters.aps)
            truth = satisfies(formula_of_node(closure, closure.root), word)
            assert satisfies(formula_of_node(closure, rebuilt[closure.root]), word) == truth
            assert satisfies(formula_of_node(closure, closure.negation(closure.root)), word) != truth


# -- normal form ------------------------------------------------------------------------------------------------------


def test_normal_form_is_equivalent_and_low() -> None:
    rewritten = 0
    for rng, formula, closure in random_closures(5, 300):
        try:
            node = normal_form(closure, closure.root)
        except StateLimitExceeded:
            continue
        rewritten += node != closure.root
        assert closure.is_low(node)
        normal = formula_of_node(closure, node)
        for _ in range(10):
            word = random_word(rng, closure.letters.aps)
            assert satisfies(normal, word) == satisfies(formula, word), f"{formula} on {word}"
    assert rewritten > 50


# -- tableau and Safra trees ------------------------------------------------------------------------------------------


def test_the_tableau_accepts_the_models() -> None:
    for rng, formula, closure in random_closures(6, 120):
        automaton = tableau(closure, closure.root, unlimited(formula))
        for _ in range(10):
            word = random_word(rng, closure.letters.aps)
            assert automaton.accepts(*letters_of(closure, word)) == satisfies(formula, word), f"{formula} on {word}"


def random_buchi(rng: random.Random) -> BuchiAutomaton:
    n_letters, n_states, n_sets = rng.randint(1, 3), rng.randint(1, 4), rng.randint(0, 3)

    def edge() -> BuchiEdge:
        marks = sum(1 << i for i in range(n_sets) if rng.random() < 0.4)
        return BuchiEdge(rng.randrange(1, 1 << n_letters), rng.randrange(n_states), marks)

    edges = tuple(tuple(edge() for _ in range(rng.randint(0, 3))) for _ in range(n_states))
    return BuchiAutomaton(n_letters, tuple(range(rng.randint(1, n_states))), edges, n_sets)


def test_determinization_keeps_the_language() -> None:
    """Random nondeterministic automata reach corners that tableaux do not."""
    rng = random.Random(7)
    verdicts = {True: 0, False: 0}
    for _ in range(400):
        automaton = random_buchi(rng)
        letters = (1 << automaton.n_letters) - 1
        deterministic = determinize(automaton, Budget("random", 100_000))
        assert_complete(deterministic, letters)
        forms = [deterministic, localized(deterministic), reduced(deterministic)]
        for _ in range(15):
            prefix = [rng.randrange(automaton.n_letters) for _ in range(rng.randint(0, 4))]
            cycle = [rng.randrange(automaton.n_letters) for _ in range(rng.randint(1, 6))]
            truth = automaton.accepts(prefix, cycle)
            verdicts[truth] += 1
            assert [accepts(form, prefix, cycle) for form in forms] == [truth] * 3, (automaton, prefix, cycle)
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


# -- acceptance conditions --------------------------------------------------------------------------------------------


def random_condition(rng: random.Random, n_marks: int, n_promises: int = 0) -> Acceptance:
    def some() -> int:
        return sum(1 << m for m in range(n_marks) if rng.random() < 0.3)

    def promises() -> Iterator[tuple[int, int]]:
        for _ in range(rng.randint(0, n_promises)):
            yield 1 << rng.randrange(n_marks), 1 << rng.randrange(n_marks)

    return tuple(Clause(some(), some(), tuple(promises())) for _ in range(rng.randint(0, 4)))


def test_conditions_by_truth_table() -> None:
    rng = random.Random(9)
    n_marks = 4
    for _ in range(400):
        a, b = random_condition(rng, n_marks, 2), random_condition(rng, n_marks, 2)
        possible = rng.randrange(1 << n_marks)
        certain = possible & rng.randrange(1 << n_marks)
        for seen in range(1 << n_marks):
            x, y = holds(a, seen), holds(b, seen)
            assert holds(simplify(a), seen) == x
            assert holds(negation(a), seen) == (not x)
            assert holds(negation(a, with_promises=True), seen) == (not x)
            assert holds(conjunction(a, b), seen) == (x and y)
            assert holds(disjunction(a, b), seen) == (x or y)
            if not seen & ~possible and not certain & ~seen:
                assert holds(restrict(a, possible, certain), seen) == x
    for _ in range(400):
        edges = [rng.randrange(1 << n_marks) for _ in range(rng.randint(1, 4))]
        implied = {m: fold(int.__and__, (e for e in edges if e >> m & 1), -1) for m in range(n_marks)}
        a = random_condition(rng, n_marks, 2)
        for chosen in range(1, 1 << len(edges)):
            seen = fold(int.__or__, (e for i, e in enumerate(edges) if chosen >> i & 1))
            assert holds(without_implied(a, implied), seen) == holds(a, seen)
    assert negation(ALWAYS) == NEVER and negation(NEVER) == ALWAYS


# -- Rabin pairs ------------------------------------------------------------------------------------------------------


def cycle_memory(condition: Acceptance, edges: list[InnerEdge]) -> CycleMemory:
    return CycleMemory(CycleDecomposition(condition, edges, 1000))


def run_memory(memory: Counters | CycleMemory, cycle: list[InnerEdge]) -> bool:
    """Whether the pairs accept the cycle taken for ever."""
    at = memory.start(cycle[0].source)
    rounds: list[list[tuple[int, int]]] = []
    starts: list[int] = []
    while at not in starts:
        starts.append(at)
        rounds.append([])
        for edge in cycle:
            at, fins, infs = memory.move(at, edge)
            rounds[-1].append((fins, infs))
    seen = [marks for marks_of_round in rounds[starts.index(at) :] for marks in marks_of_round]
    fins, infs = (fold(int.__or__, column) for column in zip(*seen, strict=True))
    return any(infs >> i & 1 and not fins >> i & 1 for i in range(memory.n_pairs))


def test_pairs_express_any_condition_on_any_component() -> None:
    """Random strong components, random walks around them: counters and cycle decomposition agree with the condition."""
    rng = random.Random(10)
    for _ in range(250):
        n = rng.randint(1, 4)
        edges = [InnerEdge(q, (q + 1) % n, rng.randrange(16)) for q in range(n)]
        edges += [InnerEdge(rng.randrange(n), rng.randrange(n), rng.randrange(16)) for _ in range(rng.randint(0, 5))]
        edges = list(dict.fromkeys(edges))
        condition = simplify(random_condition(rng, 4))
        memories = Counters(condition), cycle_memory(condition, edges)
        for _ in range(12):
            walk = [rng.choice([e for e in edges if e.source == 0])]
            while walk[-1].target != 0 or rng.random() < 0.6:
                walk.append(rng.choice([e for e in edges if e.source == walk[-1].target]))
            truth = holds(condition, fold(int.__or__, (e.marks for e in walk)))
            assert [run_memory(memory, walk) for memory in memories] == [truth, truth], (condition, walk)


def test_cycle_decomposition_by_hand() -> None:
    loops = [InnerEdge(0, 0, 1 << m) for m in range(3)]
    needs_all = (Clause(0, 0b111),)
    assert cycle_memory(needs_all, loops).size([0]) == 3  # one leaf for each pair of loops that lacks one
    assert Counters(needs_all).size([0]) == 3
    assert cycle_memory((Clause(0, 1), Clause(0, 2), Clause(0, 4)), loops).size([0]) == 1
    parity_like = (Clause(0, 0b001), Clause(0b010, 0b100))
    assert cycle_memory(parity_like, loops).size([0]) == 1
    streett = (Clause(0b001, 0), Clause(0, 0b110))  # Fin(0) | Inf(1) & Inf(2)
    assert cycle_memory(streett, loops).n_pairs >= 1
    everything = cycle_memory(ALWAYS, loops)
    assert (everything.n_pairs, everything.size([0])) == (1, 1)


def test_clauses_with_equal_lists_share_a_counter() -> None:
    assert Counters((Clause(0b100, 0b011), Clause(0b1000, 0b011))).size([0, 1]) == 4
    assert Counters((Clause(0b100, 0b011), Clause(0b100, 0b11000))).size([0, 1]) == 8
    assert Counters((Clause(0, 1), Clause(2, 4))).size([0, 1]) == 2


# -- weak automata ----------------------------------------------------------------------------------------------------


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
    chain = [(Edge(1, 1, 0),), (Edge(1, 2, 0),), (Edge(1, 2, 0),)]
    assert minimized_weak(EmersonLei(tuple(chain), (NEVER, NEVER, ALWAYS))).n_states == 1


# -- budget -----------------------------------------------------------------------------------------------------------


def test_budgets_narrow_but_do_not_widen() -> None:
    budget = Budget("f", 10)
    assert budget.within(5).max_states == 5
    assert budget.within(50).max_states == 10
