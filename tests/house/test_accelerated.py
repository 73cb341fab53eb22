"""The wheel with compiled modules: it passes the tests that pure Python passes, and gives the same automata."""

from __future__ import annotations

import ast
import json
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from formula_families import families

ROOT = Path(__file__).parents[2]
CORE = ("ltl", "automata", "minimize", "translate", "compiler", "house/test_graph.py")
# help() of a compiled function says nothing, and the other test starts Python with the checkout.
PURE = ("ltl/test_docs.py", "ltl/test_parser_size.py::test_a_million_characters_take_seconds_and_little_memory")

WHERE = """
import importlib, json, sys
print(json.dumps([importlib.import_module(name).__file__ for name in json.loads(sys.argv[1])]))
"""
# One line per formula, with a digest of its automata.
DIGEST = """
import hashlib, json, sys
from ltlc.formats import to_json
from ltlc.ltl import parse
from ltlc.translate import Options, translate
for text in json.loads(sys.argv[1]):
    digest = hashlib.sha256()
    for acceptance in ("state", "transition"):
        for effort in ("fast", "default"):
            digest.update(to_json(translate(parse(text), Options(acceptance=acceptance, effort=effort))).encode())
    print(digest.hexdigest(), text)
"""
# Minutes of work in compiled loops, told to stop after half a second.
INTERRUPTED = """
import _thread, threading, time, ltlc
threading.Timer(0.5, _thread.interrupt_main).start()
started = time.monotonic()
try:
    ltlc.compile(" & ".join(f"(GF a{i} | FG b{i})" for i in range(6)), max_states=10**7)
except KeyboardInterrupt:
    print(time.monotonic() - started)
"""
# Python's limit on recursion must hold; without it the process would end without a word.
DEEP = """
import ltlc
for text in ("X " * 50_000 + "a", "".join(f"p{i % 2} U (" for i in range(20_000)) + "q" + ")" * 20_000):
    try:
        ltlc.compile(text)
    except ltlc.LtlcError as error:
        print(type(error).__name__)
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unpacked wheel, built from a clean copy."""
    folder = tmp_path_factory.mktemp("accelerated")
    skipped = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info", "__pycache__", "runs", "tests")
    shutil.copytree(ROOT, folder / "checkout", ignore=skipped)
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--no-build-isolation", "--no-deps")
    built = run(*pip, "--wheel-dir", folder, folder / "checkout", cwd=folder, LTLC_ACCELERATE="1")
    missing = [line for line in built.stdout.splitlines() if line.strip().startswith("LTLC_ACCELERATE is set, but")]
    if missing:
        pytest.skip(missing[0].strip())
    assert built.returncode == 0, built.stdout
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(folder / "site")
    return folder / "site"


def run(*command: str | Path, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """The finished command, with what it said on both channels as its stdout."""
    return subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )


def output(site: Path, script: str, *arguments: str) -> str:
    """What a Python script prints that finds ltlc there."""
    done = run(sys.executable, "-c", script, *arguments, cwd=site.parent, PYTHONPATH=str(site))
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.mark.build
def test_compiled_modules_are_in_use_and_their_sources_are_beside_them(site: Path) -> None:
    assert {path.name.partition("-")[0] for path in site.iterdir()} == {"ltlc"}
    assert "Root-Is-Purelib: false" in next(site.glob("*.dist-info/WHEEL")).read_text(encoding="utf-8")
    modules = {path.parent / path.name.partition(".")[0] for path in site.rglob("*.so")}
    assert {site / "ltlc/graph", site / "ltlc/translate/closure", site / "ltlc/automata/marks"} <= modules
    modules.remove(site / "ltlc/_compiled__mypyc")
    assert all(module.with_suffix(".py").is_file() for module in modules)
    names = [".".join(module.relative_to(site).parts) for module in sorted(modules)]
    assert all(name.endswith(".so") for name in json.loads(output(site, WHERE, json.dumps(names))))
    assert "ltlc 0" in (version := output(site, "from ltlc.cli import main; main()", "--version"))
    assert version.endswith("(compiled)\n")


@pytest.mark.build
def test_the_core_passes_its_tests(site: Path, tmp_path: Path) -> None:
    """Away from the checkout, so that its files are not imported."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for folder in ("tests", "benchmarks", "docs"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    tests = [tmp_path / "tests" / name for name in CORE]
    left_out = [f"--deselect=tests/{name}" for name in PURE]
    options = ("-q", "-p", "no:cacheprovider", *left_out)
    done = run(sys.executable, "-m", "pytest", *options, *tests, cwd=tmp_path, PYTHONPATH=str(site))
    assert done.returncode == 0, done.stdout


@pytest.mark.build
def test_the_same_bytes_as_pure_python(site: Path) -> None:
    formulas = json.dumps([text for texts in families().values() for text in texts])
    assert output(site, DIGEST, formulas) == output(ROOT, DIGEST, formulas)


@pytest.mark.slow
def test_no_iterator_is_unpacked_in_a_compiled_module() -> None:
    """There the error of an iterator is taken for its end: "not enough values to unpack", whatever it was."""
    tree = ast.parse((ROOT / "setup.py").read_text(encoding="utf-8"))
    table = next(node for node in tree.body if ast.unparse(node).startswith("COMPILED = "))
    assert isinstance(table, ast.Assign)
    compiled: dict[str, tuple[str, ...]] = ast.literal_eval(table.value)
    unpacked = [
        f"{folder}/{name}.py:{value.lineno}: {ast.unparse(value)}"
        for folder, names in compiled.items()
        for name in names
        for targets, value in assignments(ast.parse((ROOT / folder / f"{name}.py").read_text(encoding="utf-8")))
        if isinstance(value, ast.GeneratorExp)
        or (isinstance(value, ast.Call) and ast.unparse(value.func) in ("map", "zip", "filter", "iter", "reversed"))
        if any(isinstance(target, ast.Tuple | ast.List) for target in targets)
    ]
    assert not unpacked


def assignments(tree: ast.Module) -> Iterator[tuple[list[ast.expr], ast.expr]]:
    """The targets and the value of each assignment, and of each loop over such values written out."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            yield node.targets, node.value
        elif isinstance(node, ast.For | ast.comprehension) and isinstance(node.iter, ast.GeneratorExp | ast.ListComp):
            yield [node.target], node.iter.elt


@pytest.mark.build
def test_ctrl_c_is_noticed_in_time(site: Path) -> None:
    assert 0.5 <= float(output(site, INTERRUPTED)) < 5


@pytest.mark.build
def test_deep_formulas_end_in_python_errors_too(site: Path) -> None:
    assert output(site, DEEP) == output(ROOT, DEEP)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "environment", "reason"),
    [
        ("bdist_wheel", {"CC": "no-such-compiler"}, "there is no C compiler 'no-such-compiler': install one"),
        ("bdist_wheel", {"PYTHONPATH": "{without_mypy}"}, "mypyc cannot be imported"),
        ("editable_wheel", {}, "an editable install stays pure Python"),
    ],
)
def test_what_is_missing_is_said(command: str, environment: dict[str, str], reason: str, tmp_path: Path) -> None:
    pytest.importorskip("mypyc")
    (tmp_path / "mypyc.py").touch()
    environment = {name: value.format(without_mypy=tmp_path) for name, value in environment.items()}
    done = run(sys.executable, ROOT / "setup.py", command, cwd=tmp_path, LTLC_ACCELERATE="1", **environment)
    assert done.returncode == 1
    assert done.stdout.startswith("LTLC_ACCELERATE is set, but ")
    assert reason in done.stdout
