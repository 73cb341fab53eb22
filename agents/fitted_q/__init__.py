"""Fitted Q iteration: a table of values, fitted to all experience at once."""
