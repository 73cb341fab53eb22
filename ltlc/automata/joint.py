"""The letters that two automata read in common."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from ltlc.arrays import IntArray, np, npt
from ltlc.automata.alphabet import Alphabet
from ltlc.automata.columns import letter_classes
from ltlc.automata.possible import MAX_APS, LetterNumbers, Possible, check_size
from ltlc.errors import AlphabetLimitExceeded, InvalidArgumentError


class JointLetters(NamedTuple):
    """One letter for each joint class of letters that both automata may read."""

    numbers: LetterNumbers
    """of the joint alphabet: the propositions that matter to either."""
    letters: IntArray
    """shape (n,); the smallest letter of each joint class, as its number."""
    class_a: IntArray
    """shape (n,); the class of that letter in the first automaton,"""
    class_b: IntArray
    """and in the second."""


def joint_letters(a: Alphabet, b: Alphabet) -> JointLetters:
    """The letters that are possible in both alphabets; a proposition that only one of them knows is free.

    Raises:
        AlphabetLimitExceeded: there are too many.
        InvalidArgumentError: there is none.
    """
    if a.aps == b.aps and a.possible == b.possible and np.array_equal(a.letter_class, b.letter_class):
        classes = np.arange(len(a.first_letter), dtype=np.int32)
        return JointLetters(a.numbers, a.first_letter, classes, classes)
    if a.possible is None and b.possible is None:
        aps = tuple(dict.fromkeys([a.aps[i] for i in a.relevant] + [b.aps[i] for i in b.relevant]))
        if len(aps) > MAX_APS:
            raise AlphabetLimitExceeded(
                f"the automata depend on {len(aps)} propositions together; at most {MAX_APS} fit"
            )
        numbers = LetterNumbers(aps)
        column_a, column_b = _column(a, aps), _column(b, aps)
    else:
        numbers = _common(a, b)
        column_a, column_b = (each.letter_class[_seen_by(each, numbers)] for each in (a, b))
    _, letters = letter_classes([column_a, column_b], numbers.size)
    return JointLetters(numbers, letters, column_a[letters], column_b[letters])


def _column(alphabet: Alphabet, aps: tuple[str, ...]) -> IntArray:
    """The class of each letter over `aps`, which name all that matters to the alphabet."""
    bits = {alphabet.aps[i]: 1 << i for i in alphabet.relevant}
    letters = np.zeros(1, dtype=np.int64)
    for name in aps:
        letters = np.concatenate([letters, letters | bits.get(name, 0)])
    return alphabet.letter_class[letters]


def _common(a: Alphabet, b: Alphabet) -> LetterNumbers:
    """The letters over the propositions of both that neither excludes."""
    aps = tuple(dict.fromkeys((*a.aps, *b.aps)))
    index = {name: i for i, name in enumerate(aps)}
    parts: list[tuple[int, tuple[int, ...]]] = []
    for each in (a, b):
        known = 0
        for part in _parts(each):
            masks = tuple(_renamed(mask, each.aps, index) for mask in part)
            support = _union(masks)
            known |= support
            parts.append((support, masks))
        never = sum(1 << index[name] for name in each.aps) & ~known
        if never:
            parts.append((never, (0,)))
    parts.sort(key=lambda part: -len(part[1]))
    joined: list[tuple[int, tuple[int, ...]]] = []
    for support, masks in parts:
        for other in [part for part in joined if part[0] & support]:
            joined.remove(other)
            shared = other[0] & support
            masks = tuple(m | o for m in masks for o in other[1] if m & shared == o & shared)
            support |= other[0]
            check_size(len(masks))
        joined.append((support, tuple(sorted(set(masks)))))
    possible = tuple(masks for _, masks in sorted(joined, key=lambda part: part[0] & -part[0]))
    if not all(possible):
        raise InvalidArgumentError("no letter is possible in both automata, so they have no word to compare")
    return LetterNumbers(aps, possible)


def _seen_by(alphabet: Alphabet, joint: LetterNumbers) -> npt.NDArray[np.int64]:
    """The number, in one alphabet, of each joint letter."""
    own = {name: i for i, name in enumerate(alphabet.aps)}
    assert joint.possible is not None
    place, shares = 1, []
    for part in _parts(alphabet):
        shares.append((_union(part), {mask: place * digit for digit, mask in enumerate(part)}))
        place *= len(part)
    numbers = np.zeros(1, dtype=np.int64)
    for part in joint.possible:
        masks = [_renamed(mask, joint.aps, own) for mask in part]
        inside = _union(masks)
        ours = [(support, share) for support, share in shares if support & inside]
        digit = np.array([sum(share[mask & s] for s, share in ours) for mask in masks], dtype=np.int64)
        numbers = np.add.outer(digit, numbers).ravel()
    ever = _renamed(_union(map(_union, joint.possible)), joint.aps, own)
    return numbers + sum(share[0] for support, share in shares if not support & ever)


def _parts(alphabet: Alphabet) -> Possible:
    free = tuple((0, 1 << i) for i in range(len(alphabet.aps)))
    return free if alphabet.possible is None else alphabet.possible


def _renamed(mask: int, aps: tuple[str, ...], index: dict[str, int]) -> int:
    """A letter over other propositions; those without an index are left out."""
    return sum(1 << index[name] for i, name in enumerate(aps) if mask >> i & 1 and name in index)


def _union(masks: Iterable[int]) -> int:
    union = 0
    for mask in masks:
        union |= mask
    return union
