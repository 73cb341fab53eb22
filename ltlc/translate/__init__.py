"""LTL to deterministic Rabin automata: a portfolio of constructions and a pipeline that keeps the smallest result.

Examples: docs/examples.md.
"""

from ltlc.translate.constructions import CONSTRUCTIONS, Construction, register_construction
from ltlc.translate.determinise import determinise
from ltlc.translate.finite import translate_finite
from ltlc.translate.general import GeneralForm, translate_to_form
from ltlc.translate.options import Effort, Options
from ltlc.translate.pipeline import translate

TRANSLATORS = CONSTRUCTIONS

__all__ = [
    "TRANSLATORS",
    "Construction",
    "Effort",
    "GeneralForm",
    "Options",
    "determinise",
    "register_construction",
    "translate",
    "translate_finite",
    "translate_to_form",
]
