"""Automata over infinite words: letters and guards, the deterministic Rabin automaton, and exact decisions on it."""

from ltlc.automata.alphabet import Alphabet, guard_text
from ltlc.automata.annotate import Annotations, ComponentKind, annotate
from ltlc.automata.canonical import canonical
from ltlc.automata.rabin import RabinAutomaton, RabinPair

__all__ = [
    "Alphabet",
    "Annotations",
    "ComponentKind",
    "RabinAutomaton",
    "RabinPair",
    "annotate",
    "canonical",
    "guard_text",
]
