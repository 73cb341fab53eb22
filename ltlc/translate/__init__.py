"""LTL to deterministic Rabin automata: a portfolio of constructions and a pipeline that keeps the smallest result.

Examples: docs/examples.md.
"""

from typing import TYPE_CHECKING

from ltlc.lazy import on_first_use
from ltlc.translate.constructions import CONSTRUCTIONS, Construction, register_construction

if TYPE_CHECKING:
    from ltlc.translate.determinisation import determinise
    from ltlc.translate.finite import translate_finite
    from ltlc.translate.general import translate_to_form
    from ltlc.translate.options import Effort, GeneralForm, Options
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

_HOME = {
    "Effort": "ltlc.translate.options",
    "GeneralForm": "ltlc.translate.options",
    "Options": "ltlc.translate.options",
    "determinise": "ltlc.translate.determinisation",
    "translate": "ltlc.translate.pipeline",
    "translate_finite": "ltlc.translate.finite",
    "translate_to_form": "ltlc.translate.general",
}

if not TYPE_CHECKING:  # a type checker would take every name for an attribute
    __getattr__ = on_first_use(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
