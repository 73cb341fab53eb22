"""An automaton whose states stand for those of another, with choices that a policy makes and no letter tells."""

from __future__ import annotations

from dataclasses import dataclass

from ltlc.arrays import IntArray, np
from ltlc.automata.rabin import DRA


@dataclass(frozen=True, eq=False)
class Refinement:
    """An automaton with more states than the one it stands for, and the way back.

    Before a letter is read, a policy may go from state q to `select_pair[q, i]`; the automaton then reads the letter
    there. A run of the original automaton is accepted iff some such choices, made at some moments, make a run of this
    one that is accepted. Without choices both accept the same words.

    Attributes:
        automaton: the automaton with refined states.
        origin: shape (n_states,), int32; the original state behind each state, -1 for the sink that broken promises
            lead to.
        select_pair: shape (n_states, n_choices), int32; the state after choice i, or -1 where it cannot be made.
    """

    automaton: DRA
    origin: IntArray
    select_pair: IntArray

    @classmethod
    def trivial(cls, automaton: DRA) -> Refinement:
        """The automaton itself."""
        n = automaton.n_states
        return cls(automaton, np.arange(n, dtype=np.int32), np.zeros((n, 0), dtype=np.int32))
