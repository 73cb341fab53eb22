"""The examples in the docstrings run."""

from __future__ import annotations

import doctest
import importlib

import pytest

import ltlc.ltl

MODULES = [
    "bounds",
    "context",
    "diagnosis",
    "english",
    "finite",
    "formula",
    "grammar",
    "hierarchy",
    "implication",
    "lbt",
    "names",
    "normal",
    "parser",
    "past",
    "printer",
    "recall",
    "rewrite",
    "rule",
    "rules_binary",
    "rules_boolean",
    "rules_informed",
    "rules_unary",
    "semantics",
    "syntax",
    "traversal",
    "words",
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name: str) -> None:
    assert doctest.testmod(importlib.import_module(f"ltlc.ltl.{name}")).failed == 0


def test_every_public_name_is_described() -> None:
    for name in ltlc.ltl.__all__:
        thing = getattr(ltlc.ltl, name)
        assert name == "Syntax" or thing.__doc__, name
