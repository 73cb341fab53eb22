"""A report of a training run: one file that shows what was to be learned, what was, and how it looks.

Examples: docs/examples.md.
"""

from ltlc.reports.run_report import report_of_run

__all__ = ["report_of_run"]
