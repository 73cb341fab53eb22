"""Automata over infinite words: letters and guards, the deterministic Rabin automaton, and exact decisions on it."""

from ltlc.automata.alphabet import Alphabet, guard_text
from ltlc.automata.annotate import Annotations, ComponentKind, annotate
from ltlc.automata.buchi import BuchiAutomaton, BuchiEdge
from ltlc.automata.canonical import canonical
from ltlc.automata.collapse import Minimized, collapse
from ltlc.automata.compare import counterexample, equivalent, included, is_empty
from ltlc.automata.languages import equivalent_states
from ltlc.automata.lower_bound import lower_bound
from ltlc.automata.marks import simplify_marks
from ltlc.automata.pair_choice import limit_deterministic
from ltlc.automata.parity import parity_colours, to_parity
from ltlc.automata.rabin import RabinAutomaton, RabinPair
from ltlc.automata.reduce import merge_bisimilar, merge_equivalent, reduce
from ltlc.automata.refinement import Refinement
from ltlc.automata.retarget import merge_by_trial
from ltlc.automata.sat_minimize import minimize
from ltlc.automata.state_based import to_state_based, to_transition_based

__all__ = [
    "Alphabet",
    "Annotations",
    "BuchiAutomaton",
    "BuchiEdge",
    "ComponentKind",
    "Minimized",
    "RabinAutomaton",
    "RabinPair",
    "Refinement",
    "annotate",
    "canonical",
    "collapse",
    "counterexample",
    "equivalent",
    "equivalent_states",
    "guard_text",
    "included",
    "is_empty",
    "limit_deterministic",
    "lower_bound",
    "merge_bisimilar",
    "merge_by_trial",
    "merge_equivalent",
    "minimize",
    "parity_colours",
    "reduce",
    "simplify_marks",
    "to_parity",
    "to_state_based",
    "to_transition_based",
]
