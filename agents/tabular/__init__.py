"""Tabular learners: Q-learning, and the systems that the thesis compares itself with."""
