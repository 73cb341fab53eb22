"""The training loop and what it leaves behind: collected steps, metrics, checkpoints, run folders, verdicts."""
