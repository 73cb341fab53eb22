"""What the options --exclusive and --letters declare."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.automata.possible import DeclaredLetters


def declared(exclusive: Sequence[str] | None, letters: str | None = None) -> DeclaredLetters:
    """The possible letters, as `ltlc.compile` takes them.

    Raises:
        InvalidArgumentError: a group has fewer than two names, or both options are given.
        LtlSyntaxError: a letter is none.
    """
    from ltlc.automata.possible import DeclaredLetters

    if not exclusive and letters is None:
        return DeclaredLetters()
    from ltlc.ltl import parse_letter

    if exclusive and letters is not None:
        raise InvalidArgumentError("give either --exclusive or --letters: the latter lists all that are possible")
    groups = tuple(map(parse_letter, exclusive or ()))
    for text, names in zip(exclusive or (), groups, strict=True):
        if len(names) < 2:
            raise InvalidArgumentError(f"--exclusive {text!r}: expected two names or more, as in a,b,c")
    return DeclaredLetters(groups, None if letters is None else tuple(map(parse_letter, letters.split(";"))))


def check_possible(aps: Sequence[str], possible: DeclaredLetters, letters: Iterable[Collection[str]]) -> None:
    """Raise ImpossibleLetterError if a letter is not possible, by what is declared for a formula with these names."""
    from ltlc.automata.possible import LetterNumbers, possible_letters

    parts = possible_letters(tuple(aps), **possible._asdict())
    if parts is not None:
        numbers = LetterNumbers(tuple(aps), parts)
        for letter in letters:
            numbers.number(sum(1 << i for i, name in enumerate(aps) if name in letter))
