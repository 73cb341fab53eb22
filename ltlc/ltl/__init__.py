"""Linear temporal logic: formulas, their text, their rewriting and their meaning.

text -> formula (parser) -> smaller formula (rewrite) -> text (printer)
formula, lasso word -> truth (semantics)

Examples: docs/examples.md.
"""

from ltlc.ltl.diagnosis import LtlSyntaxWarning
from ltlc.ltl.english import misreadings, to_english
from ltlc.ltl.finite import LAST, WeakNext
from ltlc.ltl.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
)
from ltlc.ltl.hierarchy import HierarchyClass, classify, is_pure_eventuality, is_pure_universality
from ltlc.ltl.names import propositions
from ltlc.ltl.normal import nnf
from ltlc.ltl.parser import parse, read_formulas
from ltlc.ltl.past import Historically, Once, Since, Triggered, WeakYesterday, Yesterday
from ltlc.ltl.printer import to_text
from ltlc.ltl.rewrite import simplify
from ltlc.ltl.semantics import LassoWord, Letter, satisfies, satisfies_trace, truth_by_position
from ltlc.ltl.syntax import Syntax
from ltlc.ltl.traversal import fold, postorder
from ltlc.ltl.words import parse_letter, parse_trace, parse_word

__all__ = [
    "FALSE",
    "LAST",
    "TRUE",
    "Always",
    "And",
    "Constant",
    "Eventually",
    "Formula",
    "HierarchyClass",
    "Historically",
    "Iff",
    "Implies",
    "LassoWord",
    "Letter",
    "LtlSyntaxWarning",
    "Next",
    "Not",
    "Once",
    "Or",
    "Proposition",
    "Release",
    "Since",
    "StrongRelease",
    "Syntax",
    "Triggered",
    "Until",
    "WeakNext",
    "WeakUntil",
    "WeakYesterday",
    "Xor",
    "Yesterday",
    "classify",
    "fold",
    "is_pure_eventuality",
    "is_pure_universality",
    "misreadings",
    "nnf",
    "parse",
    "parse_letter",
    "parse_trace",
    "parse_word",
    "postorder",
    "propositions",
    "read_formulas",
    "satisfies",
    "satisfies_trace",
    "simplify",
    "to_english",
    "to_text",
    "truth_by_position",
]
