"""LTL to deterministic Rabin automata: a portfolio of constructions and a pipeline that keeps the smallest result.

Examples: docs/examples.md.
"""

from ltlc.translate.constructions import CONSTRUCTIONS, Construction, register_construction
from ltlc.translate.pipeline import Effort, translate

TRANSLATORS = CONSTRUCTIONS

__all__ = ["TRANSLATORS", "Construction", "Effort", "register_construction", "translate"]
