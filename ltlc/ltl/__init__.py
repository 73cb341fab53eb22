"""Linear temporal logic: formulas, their text, their rewriting and their meaning.

text -> formula (parser) -> smaller formula (rewrite) -> text (printer)
formula, lasso word -> truth (semantics)

Examples: docs/examples.md.
"""

from typing import TYPE_CHECKING

from ltlc.lazy import on_first_use

if TYPE_CHECKING:
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

_HOME = {
    "Always": "ltlc.ltl.formula",
    "And": "ltlc.ltl.formula",
    "Constant": "ltlc.ltl.formula",
    "Eventually": "ltlc.ltl.formula",
    "FALSE": "ltlc.ltl.formula",
    "Formula": "ltlc.ltl.formula",
    "HierarchyClass": "ltlc.ltl.hierarchy",
    "Historically": "ltlc.ltl.past",
    "Iff": "ltlc.ltl.formula",
    "Implies": "ltlc.ltl.formula",
    "LAST": "ltlc.ltl.finite",
    "LassoWord": "ltlc.ltl.semantics",
    "Letter": "ltlc.ltl.semantics",
    "LtlSyntaxWarning": "ltlc.ltl.diagnosis",
    "Next": "ltlc.ltl.formula",
    "Not": "ltlc.ltl.formula",
    "Once": "ltlc.ltl.past",
    "Or": "ltlc.ltl.formula",
    "Proposition": "ltlc.ltl.formula",
    "Release": "ltlc.ltl.formula",
    "Since": "ltlc.ltl.past",
    "StrongRelease": "ltlc.ltl.formula",
    "Syntax": "ltlc.ltl.syntax",
    "TRUE": "ltlc.ltl.formula",
    "Triggered": "ltlc.ltl.past",
    "Until": "ltlc.ltl.formula",
    "WeakNext": "ltlc.ltl.finite",
    "WeakUntil": "ltlc.ltl.formula",
    "WeakYesterday": "ltlc.ltl.past",
    "Xor": "ltlc.ltl.formula",
    "Yesterday": "ltlc.ltl.past",
    "classify": "ltlc.ltl.hierarchy",
    "fold": "ltlc.ltl.traversal",
    "is_pure_eventuality": "ltlc.ltl.hierarchy",
    "is_pure_universality": "ltlc.ltl.hierarchy",
    "misreadings": "ltlc.ltl.english",
    "nnf": "ltlc.ltl.normal",
    "parse": "ltlc.ltl.parser",
    "parse_letter": "ltlc.ltl.words",
    "parse_trace": "ltlc.ltl.words",
    "parse_word": "ltlc.ltl.words",
    "postorder": "ltlc.ltl.traversal",
    "propositions": "ltlc.ltl.names",
    "read_formulas": "ltlc.ltl.parser",
    "satisfies": "ltlc.ltl.semantics",
    "satisfies_trace": "ltlc.ltl.semantics",
    "simplify": "ltlc.ltl.rewrite",
    "to_english": "ltlc.ltl.english",
    "to_text": "ltlc.ltl.printer",
    "truth_by_position": "ltlc.ltl.semantics",
}

if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = on_first_use(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
