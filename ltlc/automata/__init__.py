"""Automata over infinite words and finite traces: letters and guards, DRA and DFA, and exact decisions on them.

Examples: docs/examples.md.
"""

from typing import TYPE_CHECKING

from ltlc.automata.annotate import Annotations, ComponentKind, annotate
from ltlc.automata.canonical import canonical
from ltlc.lazy import on_first_use

if TYPE_CHECKING:
    from ltlc.automata.alphabet import Alphabet, guard_text
    from ltlc.automata.buchi import BuchiAutomaton
    from ltlc.automata.compare import counterexample, equivalent, included, is_empty
    from ltlc.automata.emerson_lei import LetterEdge
    from ltlc.automata.finite import DFA
    from ltlc.automata.forms import with_form
    from ltlc.automata.languages import equivalent_states
    from ltlc.automata.marks import buchi_edges, simplify_marks
    from ltlc.automata.omega import OmegaAutomaton
    from ltlc.automata.pair_choice import limit_deterministic
    from ltlc.automata.parity import parity_colours, to_parity
    from ltlc.automata.rabin import DRA, RabinPair
    from ltlc.automata.refinement import Refinement
    from ltlc.automata.transition_based import to_transition_based

__all__ = [
    "DFA",
    "DRA",
    "Alphabet",
    "Annotations",
    "BuchiAutomaton",
    "ComponentKind",
    "LetterEdge",
    "OmegaAutomaton",
    "RabinPair",
    "Refinement",
    "annotate",
    "buchi_edges",
    "canonical",
    "counterexample",
    "equivalent",
    "equivalent_states",
    "guard_text",
    "included",
    "is_empty",
    "limit_deterministic",
    "parity_colours",
    "simplify_marks",
    "to_parity",
    "to_transition_based",
    "with_form",
]

_HOME = {
    "Alphabet": "ltlc.automata.alphabet",
    "BuchiAutomaton": "ltlc.automata.buchi",
    "DFA": "ltlc.automata.finite",
    "DRA": "ltlc.automata.rabin",
    "LetterEdge": "ltlc.automata.emerson_lei",
    "OmegaAutomaton": "ltlc.automata.omega",
    "RabinPair": "ltlc.automata.rabin",
    "Refinement": "ltlc.automata.refinement",
    "buchi_edges": "ltlc.automata.marks",
    "counterexample": "ltlc.automata.compare",
    "equivalent": "ltlc.automata.compare",
    "equivalent_states": "ltlc.automata.languages",
    "guard_text": "ltlc.automata.alphabet",
    "included": "ltlc.automata.compare",
    "is_empty": "ltlc.automata.compare",
    "limit_deterministic": "ltlc.automata.pair_choice",
    "parity_colours": "ltlc.automata.parity",
    "simplify_marks": "ltlc.automata.marks",
    "to_parity": "ltlc.automata.parity",
    "to_transition_based": "ltlc.automata.transition_based",
    "with_form": "ltlc.automata.forms",
}

if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = on_first_use(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
