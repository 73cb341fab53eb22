"""The wheel with compiled modules: it passes the tests that pure Python passes, and gives the same automata."""

from __future__ import annotations

import hashlib
import json
import os
import runpy
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CORE = ("test_ltl", "test_automata", "test_translate", "test_graph", "test_compiler")
# help() of a compiled function says nothing.
PURE = ("test_ltl_docs.py",)

WHERE = """
import importlib, json, sys
print(json.dumps([importlib.import_module(name).__file__ for name in json.loads(sys.argv[1])]))
"""
# One line per formula, with a digest of its automata.
DIGEST = """
import hashlib, json, sys
from ltlc.formats import to_json
from ltlc.ltl import parse
from ltlc.translate import translate
for text in json.loads(sys.argv[1]):
    digest = hashlib.sha256()
    for acceptance in ("state", "transition"):
        for effort in ("fast", "default"):
            digest.update(to_json(translate(parse(text), acceptance=acceptance, effort=effort)).encode())
    print(digest.hexdigest(), text)
"""
# More than a second of work in compiled loops, told to stop after half of one.
INTERRUPTED = """
import _thread, threading, time, ltlc
threading.Timer(0.5, _thread.interrupt_main).start()
started = time.monotonic()
try:
    ltlc.compile(" & ".join(f"(GF a{i} | FG b{i})" for i in range(6)), max_states=10**7)
except KeyboardInterrupt:
    print(time.monotonic() - started)
"""
# Python's limit on recursion holds; without it the process would end without a word.
DEEP = """
import ltlc
for text in ("X " * 50_000 + "a", "".join(f"p{i % 2} U (" for i in range(20_000)) + "q" + ")" * 20_000):
    try:
        ltlc.compile(text)
    except (RecursionError, ltlc.LtlcError) as error:
        print(type(error).__name__)
"""


def compiled_modules() -> list[str]:
    table: Mapping[str, tuple[str, ...]] = namespace(["setup.py", "--version"])["COMPILED"]
    return [f"{folder}/{name}" for folder, names in table.items() for name in names]
