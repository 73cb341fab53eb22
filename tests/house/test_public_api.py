"""The names a user may rely on."""

from __future__ import annotations

import ast
import importlib
import inspect
import pickle
import shutil
import subprocess
import sys
import types
import typing
from pathlib import Path

import pytest

import ltlc

PROMISED = {
    "DFA",
    "DRA",
    "Formula",
    "Judge",
    "LTLVectorWrapper",
    "LTLWrapper",
    "LassoWord",
    "LimitExceeded",
    "LtlSyntaxError",
    "LtlcError",
    "Monitor",
    "Task",
    "Verdict",
    "__version__",
    "compile",
    "compile_many",
    "judge",
    "load",
    "parse",
    "parse_word",
    "satisfies",
}


def test_exported_names() -> None:
    assert set(ltlc.__all__) == PROMISED
    assert ltlc.__all__ == sorted(ltlc.__all__)
    assert set(ltlc._HOME) == PROMISED - {"__version__"}
    assert set(dir(ltlc)) >= PROMISED


@pytest.mark.parametrize("name", sorted(PROMISED))
def test_every_export_resolves_and_is_documented(name: str) -> None:
    value = getattr(ltlc, name)
    assert isinstance(value, str) or inspect.getdoc(value)


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse(Path(ltlc.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test))
    seen = {alias.name: node.module for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert seen == ltlc._HOME


@pytest.mark.parametrize("name", ["agents", "automata", "formats", "ltl", "minimize", "translate"])
def test_names_that_are_imported_on_first_use(name: str) -> None:
    package = importlib.import_module(f"ltlc.{name}")
    tree = ast.parse(Path(package.__file__ or "").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test))
    seen = {
        alias.name: f".{node.module}" if node.level else node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    for exported in package.__all__:
        assert getattr(package, exported) is not None
    assert set(seen) <= set(package.__all__) <= set(dir(package))
    modules = {path.stem for path in Path(package.__file__ or "").parent.glob("*.py")}
    assert not modules & set(seen), "once the module is imported, it would be the value of the name"
    late = package._HOME
    if name == "agents":
        late = {member: f".{home}" for home, names in late.items() for member in names}
    assert seen == late


def test_unknown_attribute() -> None:
    with pytest.raises(AttributeError, match="module 'ltlc' has no attribute 'complie'"):
        ltlc.complie  # noqa: B018


def test_signature_of_compile() -> None:
    parameters = inspect.signature(ltlc.compile).parameters.values()
    assert [(p.name, p.default) for p in parameters if p.kind is p.KEYWORD_ONLY] == [
        ("finite", False),
        ("form", "rabin"),
        ("acceptance", "state"),
        ("translator", "auto"),
        ("effort", "default"),
        ("max_states", 100_000),
        ("timeout", None),
        ("cache", None),
        ("exclusive", ()),
        ("letters", None),
    ]


def test_annotations_can_be_resolved() -> None:
    for function in (ltlc.compile, ltlc.load):
        assert "return" in typing.get_type_hints(function)


def test_modules_are_attributes_whatever_was_imported() -> None:
    code = "import ltlc.automata, ltlc.translate; print(ltlc.automata.finite.DFA, ltlc.translate.safra.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split()[-1] == "ltlc.translate.safra"


def test_dra() -> None:
    dra = ltlc.compile("F a & G !b")
    assert isinstance(dra, ltlc.DRA)
    assert (dra.initial_state, dra.aps) == (0, ("a", "b"))
    assert len(dra.deadlocks) == 1
    assert dra.step(0, {"b"}) in dra.deadlocks
    assert dra.accepts(prefix=[{"a"}], cycle=[set()])
    assert not dra.accepts(prefix=[{"a"}, {"b"}], cycle=[set()])


def test_values_can_be_pickled() -> None:
    dra = ltlc.compile("F a")
    copy = pickle.loads(pickle.dumps(dra))
    assert copy.to_json() == dra.to_json()
    formula = ltlc.parse("F a")
    assert pickle.loads(pickle.dumps(formula)) is formula


@pytest.mark.parametrize("suffix", ["json", "hoa"])
def test_save_and_load(suffix: str, tmp_path: Path) -> None:
    dra = ltlc.compile("G(a -> F b)")
    path = dra.save(tmp_path / f"dra.{suffix}")
    again = ltlc.load(str(path))
    assert isinstance(again, ltlc.DRA)
    assert again.to_hoa() == dra.to_hoa()


def test_text_forms() -> None:
    dra = ltlc.compile("F a")
    assert repr(dra) == "<DRA of F a: 2 states, 1 pair, state-based>"
    assert dra.to_hoa().startswith("HOA: v1")
    assert dra.to_dot().startswith("digraph")
    assert dra.to_json().startswith("{")
    assert "flowchart" in dra.to_mermaid()


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
def test_notebooks_get_a_picture() -> None:
    svg = ltlc.compile("F a")._repr_svg_()
    assert svg is not None
    assert "<svg" in svg


def test_modules_are_not_shadowed_by_functions() -> None:
    import ltlc.compiler

    assert isinstance(ltlc.compiler, types.ModuleType)
    assert ltlc.compile is ltlc.compiler.compile
