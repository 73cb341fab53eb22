"""Models for PRISM and Storm: their explicit files in and out, PRISM's language out.

Examples: docs/examples.md.
"""

from ltlc.prism.export import Exported, export_checkable, export_policy
from ltlc.prism.reader import read_explicit, read_state_rewards
from ltlc.prism.writer import (
    induced_process,
    product_process,
    to_prism_language,
    with_one_start,
    with_sure_labels,
    write_explicit,
)

__all__ = [
    "Exported",
    "export_checkable",
    "export_policy",
    "induced_process",
    "product_process",
    "read_explicit",
    "read_state_rewards",
    "to_prism_language",
    "with_one_start",
    "with_sure_labels",
    "write_explicit",
]
