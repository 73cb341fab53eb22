"""Numbers of possible letters, guards over them, and what two alphabets have in common."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

from ltlc.automata import DRA, Alphabet
from ltlc.automata.joint import joint_letters
from ltlc.automata.possible import LetterNumbers, Possible, possible_letters
from ltlc.errors import AlphabetLimitExceeded, ImpossibleLetterError, InvalidArgumentError, InvalidAutomatonError

NAMES = ("a", "b", "c", "d", "e")


def random_groups(rng: random.Random) -> list[set[str]]:
    return [set(rng.sample(NAMES, rng.randint(1, 4))) for _ in range(rng.randint(0, 3))]


def allowed(mask: int, aps: tuple[str, ...], groups: list[set[str]]) -> bool:
    """By the definition: at most one of each group."""
    holds = {name for i, name in enumerate(aps) if mask >> i & 1}
    return all(len(holds & group) <= 1 for group in groups)


def random_possible(rng: random.Random, aps: tuple[str, ...]) -> Possible | None:
    if rng.random() < 0.6:
        return possible_letters(aps, random_groups(rng))
    masks = rng.sample(range(1 << len(aps)), rng.randint(1, 1 << len(aps)))
    return possible_letters(aps, letters=[{n for i, n in enumerate(aps) if m >> i & 1} for m in masks])


def test_numbers_against_the_definition() -> None:
    rng = random.Random(0)
    for _ in range(300):
        aps = tuple(rng.sample(NAMES, rng.randint(1, 5)))
        groups = random_groups(rng)
        numbers = LetterNumbers(aps, possible_letters(aps, groups))
        masks = [mask for mask in range(1 << len(aps)) if allowed(mask, aps, groups)]
        assert numbers.size == len(masks)
        assert sorted(map(numbers.number, masks)) == list(range(len(masks)))
        assert [numbers.mask(numbers.number(mask)) for mask in masks] == masks
        assert numbers.masks(numbers.numbers(np.array(masks))).tolist() == masks
        for i in range(len(aps)):
            table = numbers.holding(i)
            assert all((table >> numbers.number(mask) & 1) == (mask >> i & 1) for mask in masks)
        for mask in set(range(1 << len(aps))) - set(masks):
            with pytest.raises(ImpossibleLetterError) as caught:
                numbers.number(mask)
            assert caught.value.letter == numbers.names(mask)
            assert not allowed(sum(1 << aps.index(name) for name in caught.value.together), aps, groups)


def test_without_a_declaration_numbers_are_bitmasks() -> None:
    assert possible_letters(("a", "b"), [{"a"}, {"a", "c"}]) is None
    assert possible_letters(("a",), letters=[set(), {"a"}]) is None
    free, same = LetterNumbers(("a", "b")), LetterNumbers(("a", "b"), ((0, 1), (0, 2)))
    assert [numbers.number(mask) for numbers in (free, same) for mask in range(4)] == [0, 1, 2, 3] * 2
    assert [free.holding(i) for i in (0, 1)] == [same.holding(i) for i in (0, 1)] == [0b1010, 0b1100]


def test_letters_of_many_propositions() -> None:
    aps = tuple(f"r{i}" for i in range(300))
    numbers = LetterNumbers(aps, possible_letters(aps, [aps[:200], aps[200:]]))
    assert numbers.size == 201 * 101
    masks = np.array([0, 1 << 299, 1 << 150 | 1 << 250], dtype=object)
    assert numbers.masks(numbers.numbers(masks)).tolist() == masks.tolist()
    with pytest.raises(AlphabetLimitExceeded, match="more than 2097152 letters"):
        LetterNumbers(aps, tuple((0, 1 << i) for i in range(300)))


def test_guards_are_exact_among_possible_letters_and_irredundant() -> None:
    rng = random.Random(1)
    seen = 0
    while seen < 300:
        aps = NAMES[: rng.randint(1, 5)]
        possible = random_possible(rng, aps)
        if possible is None:
            continue
        seen += 1
        numbers = LetterNumbers(aps, possible)
        n_classes = rng.randint(1, min(4, numbers.size))
        letter_class = np.array([*range(n_classes), *(rng.randrange(n_classes) for _ in range(numbers.size))])
        alphabet = Alphabet(aps, letter_class[: numbers.size].astype(np.int32), possible)
        chosen = [c for c in range(n_classes) if rng.random() < 0.5]
        guard = alphabet.guard(chosen)

        def value(mask: int, terms: tuple[tuple[tuple[int, bool], ...], ...], disjunctive: bool) -> bool:
            inner, outer = (all, any) if disjunctive else (any, all)
            return outer(inner((mask >> i & 1) == sign for i, sign in term) for term in terms)

        masks = [numbers.mask(k) for k in range(numbers.size)]
        wanted = [int(alphabet.letter_class[k]) in chosen for k in range(numbers.size)]
        assert [value(mask, guard.terms, guard.disjunctive) for mask in masks] == wanted
        for term in guard.terms:
            fewer = tuple(other for other in guard.terms if other != term)
            assert [value(mask, fewer, guard.disjunctive) for mask in masks] != wanted


def test_short_guards_of_exclusive_propositions() -> None:
    aps = tuple(f"r{i}" for i in range(50))
    possible = possible_letters(aps, [aps])
    letter_class = np.zeros(51, dtype=np.int32)
    letter_class[8] = 1
    alphabet = Alphabet(aps, letter_class, possible)
    assert [alphabet.guard([c]).text(aps) for c in (0, 1)] == ["!r7", "r7"]


def test_joint_letters_against_the_definition() -> None:
    rng = random.Random(2)
    for _ in range(300):
        alphabets = []
        for _ in range(2):
            aps = tuple(rng.sample(NAMES, rng.randint(1, 4)))
            possible = random_possible(rng, aps)
            size = LetterNumbers(aps, possible).size
            letter_class = np.unique([rng.randrange(3) for _ in range(size)], return_inverse=True)[1]
            alphabets.append(Alphabet(aps, letter_class.astype(np.int32), possible))
        a, b = alphabets
        if a.possible is None and b.possible is None:
            continue
        every = tuple(dict.fromkeys((*a.aps, *b.aps)))
        wanted = set()
        for mask in range(1 << len(every)):
            holds = {name for i, name in enumerate(every) if mask >> i & 1}
            own = [sum(1 << i for i, name in enumerate(each.aps) if name in holds) for each in alphabets]
            try:
                wanted.add(tuple(int(x.letter_class[x.numbers.number(m)]) for x, m in zip(alphabets, own, strict=True)))
            except ImpossibleLetterError:
                continue
        if not wanted:
            with pytest.raises(InvalidArgumentError, match="no letter is possible in both"):
                joint_letters(a, b)
            continue
        joint = joint_letters(a, b)
        found = list(zip(joint.class_a.tolist(), joint.class_b.tolist(), strict=True))
        assert sorted(found) == sorted(wanted)
        for letter, classes in zip(joint.letters.tolist(), found, strict=True):
            holds = joint.numbers.names(joint.numbers.mask(letter))
            own = [sum(1 << i for i, name in enumerate(each.aps) if name in holds) for each in alphabets]
            assert classes == tuple(
                int(x.letter_class[x.numbers.number(m)]) for x, m in zip(alphabets, own, strict=True)
            )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"exclusive": {"a", "b"}}, "exclusive holds '[ab]'; each group of propositions is a set of names"),
        ({"exclusive": "ab"}, "exclusive holds 'ab'; each group"),
        ({"exclusive": 3}, "exclusive is 3; it must be a list of sets of names"),
        ({"exclusive": [{"a", 1}]}, "a name in exclusive is 1; it must be a text"),
        ({"letters": ["a"]}, "letters holds 'a'; each letter is a set of names"),
        ({"letters": []}, "letters is empty"),
        ({"letters": [{"a"}], "exclusive": [{"a", "b"}]}, "give either exclusive or letters"),
    ],
)
def test_wrong_declarations(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidArgumentError, match=message):
        possible_letters(("a", "b"), **arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("possible", [((0, 1), (0, 1)), ((1, 0),), ((0, 4),), ((),), ((0, 0),)])
def test_wrong_parts(possible: Possible) -> None:
    with pytest.raises(InvalidArgumentError, match="no ascending combinations"):
        LetterNumbers(("a", "b"), possible)


def test_an_automaton_checks_its_letters() -> None:
    one = np.zeros((1, 1), dtype=np.int32)
    marks = np.zeros((0, 1), dtype=np.bool_)
    automaton = DRA(("a", "b"), one, np.zeros(3, dtype=np.int32), marks, marks, possible=((0, 1, 2),))
    assert automaton.letter({"b"}) == 2
    with pytest.raises(InvalidAutomatonError, match="letter_class has shape"):
        replace(automaton, possible=None)
