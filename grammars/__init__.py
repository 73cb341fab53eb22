"""The grammars of formulas and of HOA files, as data."""
