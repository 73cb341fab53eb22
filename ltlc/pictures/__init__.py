"""Pictures drawn with matplotlib: what figures look like, and learning curves."""
