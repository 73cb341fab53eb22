"""Texts of HOA automata, part by part."""

from __future__ import annotations


def hoa(
    body: str, *, header: str = "", ap: str = '2 "a" "b"', acceptance: str = "1 Inf(0)", start: str = "Start: 0"
) -> str:
    """The text of an automaton."""
    return f"HOA: v1\n{start}\nAP: {ap}\n{header}\nAcceptance: {acceptance}\n--BODY--\n{body}\n--END--\n"
