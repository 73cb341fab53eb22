"""What a translation depends on besides the formula."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Literal, NamedTuple

from ltlc.automata.possible import Possible
from ltlc.automata.rabin import AcceptanceKind
from ltlc.budget import MAX_STATES
from ltlc.errors import InvalidArgumentError, check_type

Effort = Literal["fast", "default", "best"]
GeneralForm = Literal["emerson-lei", "generalized-rabin", "streett", "limit-deterministic"]
"""what `ltlc.translate.translate_to_form` makes."""


class Options(NamedTuple):
    """What a translation depends on besides the formula.

    Attributes:
        acceptance: marks on states (thesis, definition 2.1.1) or on transitions (often fewer states).
        translator: "auto" or the name of a construction.
        effort: "fast" is content with the construction that wins most often; "default" tries others where they can
            win, with a cap; "best" tries all that apply, then searches for a smaller automaton by SAT.
        max_states: limit for every automaton on the way.
        timeout: seconds, or None. Once a construction has succeeded, the others only use up what is left.
        possible: which letters over the propositions of the formula, in order of appearance, are possible; None: all.
    """

    acceptance: AcceptanceKind = "state"
    translator: str = "auto"
    effort: Effort = "default"
    max_states: int = MAX_STATES
    timeout: float | None = None
    possible: Possible | None = None

    def checked(self) -> Options:
        """The same options with the numbers of Python, which compiled modules insist on.

        Raises:
            InvalidArgumentError: an option is of the wrong type or out of range; translators are looked up later.
        """
        check_type(self.acceptance, str, "acceptance", "'state' or 'transition'")
        check_type(self.effort, str, "effort", "'fast', 'default' or 'best'")
        check_type(self.translator, str, "translator", "a name")
        check_type(self.max_states, Integral, "max_states", "a whole number")
        if self.timeout is not None:
            check_type(self.timeout, Real, "timeout", "a positive number of seconds, or None")
        if self.acceptance not in ("state", "transition"):
            raise InvalidArgumentError(f"acceptance is {self.acceptance!r}; it can be 'state' or 'transition'")
        if self.effort not in ("fast", "default", "best"):
            raise InvalidArgumentError(f"effort is {self.effort!r}; it can be 'fast', 'default' or 'best'")
        if self.max_states < 1:
            raise InvalidArgumentError(f"max_states is {self.max_states}; at least 1 state is needed")
        if self.timeout is not None and not self.timeout > 0:
            raise InvalidArgumentError(f"timeout is {self.timeout:g}; it must be a positive number of seconds, or None")
        seconds = None if self.timeout is None else float(self.timeout)
        return self._replace(max_states=int(self.max_states), timeout=seconds)
