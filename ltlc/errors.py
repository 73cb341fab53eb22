"""Everything that can go wrong on purpose.

    LtlcError
    ├── LtlSyntaxError (ValueError)        a formula or a word does not parse; has line, column, caret
    ├── FileFormatError (ValueError)       a file or a document in it is wrong; has path, line/column or key
    ├── InvalidAutomatonError (ValueError) an automaton is not a complete deterministic Rabin automaton
    ├── InvalidArgumentError (ValueError)  an argument is out of range or does not fit the others
    │   ├── UnknownNameError               a name is not in a registry; suggests the nearest ones
    │   └── ImpossibleLetterError          a letter occurs that was declared impossible
    ├── TrainingDiverged                   the loss of a training run is no longer a finite number
    ├── WorkerLost                         a process that steps environments has ended
    ├── MissingProgramError                an optional program or package is not installed
    └── LimitExceeded                      a budget ran out; nothing was written
        ├── StateLimitExceeded
        ├── TimeLimitExceeded
        ├── MemoryLimitExceeded
        └── AlphabetLimitExceeded

    UserWarning
    └── RewardWarning                      rewards may teach something else than the formula

`str(error)` is one paragraph for a person: what is wrong, where, and what to do about it. What only an error needs is
imported when it is shown.
"""

from __future__ import annotations

from collections.abc import Iterable


class LtlcError(Exception):
    """Root of every error this package raises on purpose."""


class RewardWarning(UserWarning):
    """What is optimal for the rewards may not satisfy the formula; the message says why, and what to take instead."""


class LtlSyntaxError(LtlcError, ValueError):
    """A formula or a word does not parse.

    Attributes:
        message: what is wrong, without position.
        text: the whole input.
        line: 1-based.
        column: 1-based, in characters.
        hint: what to write instead, or an empty string.
    """

    def __init__(self, message: str, text: str, line: int, column: int, hint: str = "") -> None:
        self.message = message
        self.text = text
        self.line = line
        self.column = column
        self.hint = hint
        super().__init__(message, text, line, column, hint)

    def __str__(self) -> str:
        source = self.text.split("\n")[self.line - 1]
        start = max(0, self.column - 41)
        excerpt = "".join(c if c.isprintable() else _in_place_of(c) for c in source[start : start + 80])
        head = f"line {self.line}, column {self.column}: {self.message}"
        caret = " " * sum(map(_columns, excerpt[: self.column - 1 - start])) + "^"
        tail = f"\nhint: {self.hint}" if self.hint else ""
        return f"{head}\n  {excerpt}\n  {caret}{tail}"


def _in_place_of(character: str) -> str:
    """What stands for a character that a terminal cannot show."""
    return " " if character.isspace() else "\N{REPLACEMENT CHARACTER}"


def _columns(character: str) -> int:
    """How many columns of a terminal a character takes."""
    import unicodedata

    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


class FileFormatError(LtlcError, ValueError):
    """A file is not what its name promises. The message names the path and the line or key."""


class InvalidAutomatonError(LtlcError, ValueError):
    """The parts given do not make a complete deterministic Rabin automaton."""


class InvalidArgumentError(LtlcError, ValueError):
    """An argument is out of range, or does not fit the other arguments."""


class UnknownNameError(InvalidArgumentError):
    """A name is not among the known ones."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        super().__init__(kind, name, self.known)

    def __str__(self) -> str:
        import difflib

        near = difflib.get_close_matches(str(self.name), self.known, n=3)
        advice = f"Did you mean {' or '.join(near)}?" if near else f"Known: {', '.join(self.known)}."
        return f"unknown {self.kind} {self.name!r}. {advice}"


class ImpossibleLetterError(InvalidArgumentError):
    """A letter occurs that was declared impossible.

    Attributes:
        together: the propositions that do not hold together, or not without others.
        letter: all propositions that hold.
    """

    def __init__(self, together: Iterable[str], letter: Iterable[str]) -> None:
        self.together, self.letter = frozenset(together), frozenset(letter)
        super().__init__(self.together, self.letter)

    def __str__(self) -> str:
        shown, part = ("{" + ", ".join(sorted(names)) + "}" for names in (self.letter, self.together))
        why = "" if self.together == self.letter else f", since of its propositions {part} was"
        return (
            f"the letter {shown} occurs, and it was declared impossible{why}: correct the labels, or what is declared "
            "as exclusive or as possible letters"
        )


def check_type(value: object, kind: type | tuple[type, ...], name: str, expected: str) -> None:
    """Raise InvalidArgumentError, which says what is expected, unless the value is of that kind.

    A bool is no number here.
    """
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise InvalidArgumentError(f"{name} is {_shown(value)}; it must be {expected}")


def _shown(value: object) -> str:
    """A value for a message: itself if it is a short one of a common type, and what it is otherwise."""
    text = repr(value) if isinstance(value, str | bytes | int | float | None) else ""
    return text if 0 < len(text) <= 40 else f"of type {type(value).__name__}"


class TrainingDiverged(LtlcError):
    """The loss of a training run is no longer finite. The message says at which step, and what to try."""


class WorkerLost(LtlcError):
    """A process that steps environments has ended by itself. The message says how."""


class MissingProgramError(LtlcError):
    """An optional program or package is not installed; the message says how to install it."""

    @classmethod
    def of_library(cls, library: str, extra: str, error: ImportError) -> MissingProgramError:
        """The error of a module whose library cannot be imported.

        Args:
            library: its name in the package index.
            extra: of ours that installs it.
            error: why.
        """
        quoted = f"'{library}'" if "[" in library else library
        how = f"pip install {quoted}, or pip install 'ltlc[{extra}]'"
        return cls(f"{library} cannot be imported ({error}); install it with: {how}")


class LimitExceeded(LtlcError):
    """A budget of states, seconds, letters or depth ran out before the work was done."""


class StateLimitExceeded(LimitExceeded):
    """More states than allowed would be needed."""


class TimeLimitExceeded(LimitExceeded):
    """More seconds than allowed would be needed."""


class MemoryLimitExceeded(LimitExceeded):
    """More memory than allowed, or than is free, would be needed."""


class AlphabetLimitExceeded(LimitExceeded):
    """More atomic propositions than the dense letter tables can hold."""


class DepthLimitExceeded(LimitExceeded):
    """Temporal operators are nested more deeply than the constructions can follow."""
