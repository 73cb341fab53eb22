"""Fitted Q iteration on counted experience: a table of values, swept to convergence."""
