"""The experiments of the source work: its case studies and its run-time comparison."""
