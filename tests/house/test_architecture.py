"""The floor plan: a part imports only strictly lower floors and itself.

Every import counts, also those inside functions and under TYPE_CHECKING; only the search for cycles leaves the latter
out, because they never run.
"""

from __future__ import annotations

import ast
import graphlib
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOOR = {"__init__", "__main__"}  # the package's front door stands above all floors

FLOORS = {
    "foundation": 0,
    "grammars": 0,
    "ltl": 1,
    "doctor": 1,
    "automata": 2,
    "minimize": 3,
    "formats": 3,
    "rewards": 3,
    "mdp": 3,
    "translate": 4,
    "prism": 4,
    "compiler": 5,
    "pictures": 5,
    "diagnosis": 6,
    "faithful": 6,
    "envs": 6,
    "judging": 7,
    "agents": 7,
    "bridges": 8,
    "reports": 8,
    "sweeps": 8,
    "cli": 9,
}

# Modules that stand by themselves and make one part.
SAME_PART = dict.fromkeys(
    (
        "arrays",
        "atomic",
        "board",
        "budget",
        "errors",
        "graph",
        "lazy",
        "notebook",
        "registry",
        "scene",
        "splitmix",
        "version",
    ),
    "foundation",
)
SAME_PART |= dict.fromkeys(("many", "monitor", "task"), "compiler")

THIRD_PARTY = {
    "foundation": {"numpy"},
    "grammars": set(),
    "doctor": set(),
    "ltl": {"lark"},
    "automata": {"numpy"},
    "minimize": {"numpy", "pysat"},
    "translate": {"numpy"},
    "formats": {"numpy", "lark"},
    "rewards": {"numpy"},
    "mdp": {"numpy", "scipy"},
    "prism": {"numpy", "scipy"},
    "compiler": {"numpy"},
    "diagnosis": {"numpy"},
    "faithful": {"numpy"},
    "envs": {"numpy", "scipy", "gymnasium"},
    "pictures": {"numpy", "matplotlib"},
    "judging": {"numpy", "gymnasium", "torch"},
    "agents": {"numpy", "scipy", "gymnasium", "torch"},
    "bridges": {
        "numpy",
        "gymnasium",
        "torch",
        "stable_baselines3",
        "sb3_contrib",
        "pettingzoo",
        "torchrl",
        "tensordict",
        "ray",
    },
    "reports": {"numpy", "gymnasium"},
    "sweeps": {"ray"},
    "cli": {"typer", "rich"},
    "__init__": set(),
    "__main__": set(),
}

WITH_TORCH = {"agents", "reports", "sweeps"}  # what is imported late wherever it is used, because it loads torch
HEAVY = ["torch", "gymnasium", "scipy", "matplotlib", "graphviz", "typer", "rich", "pysat"]


@dataclass(frozen=True)
class Import:
    """One imported module, as `ltlc.part.module` or a foreign name."""

    importer: str
    imported: str
    line: int
    runs: bool


@cache
def sources() -> dict[str, Path]:
    """Every module of the installed package, by its installed name."""
    found = {}
    for folder, prefix in (("ltlc", "ltlc"), ("agents", "ltlc.agents"), ("grammars", "ltlc.grammars")):
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            name = ".".join((prefix, *parts)).removesuffix(".__init__")
            found[name if name != "ltlc" else "ltlc.__init__"] = path
    return found


@cache
def imports() -> tuple[Import, ...]:
    """Every import statement of the package, and every `import_module` of a literal name."""
    return tuple(entry for name, path in sources().items() for entry in imports_of(name, path))


def imports_of(name: str, path: Path) -> Iterator[Import]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    typing_only = {
        id(child)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)
        for statement in node.body
        for child in ast.walk(statement)
    }
    for node in ast.walk(tree):
        for target in targets(node, package):
            yield Import(name, target, getattr(node, "lineno", 0), id(node) not in typing_only)


def targets(node: ast.AST, package: str) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            base = ".".join(filter(None, (*package.split(".")[: len(package.split(".")) - node.level + 1], base)))
        modules = [f"{base}.{alias.name}" for alias in node.names if f"{base}.{alias.name}" in sources()]
        yield from modules or [base]
    elif isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) == "import_module":
        yield from (arg.value for arg in node.args[:1] if isinstance(arg, ast.Constant))


def part(module: str) -> str:
    """`ltlc.automata.rabin` is in part `automata`."""
    name = "__init__" if module == "ltlc" else module.split(".")[1]
    return SAME_PART.get(name, name)


def test_every_part_has_a_floor() -> None:
    parts = {part(name) for name in sources()} - DOOR
    assert parts <= set(FLOORS), f"give {sorted(parts - set(FLOORS))} a floor here and in docs/architecture.md"
    assert set(THIRD_PARTY) == set(FLOORS) | DOOR


def test_imports_lead_downwards() -> None:
    breaches = [
        f"{entry.importer}:{entry.line} imports {entry.imported}"
        for entry in imports()
        if entry.imported.split(".")[0] == "ltlc"
        and part(entry.importer) not in DOOR
        and part(entry.imported) != part(entry.importer)
        and (part(entry.imported) in DOOR or FLOORS[part(entry.imported)] >= FLOORS[part(entry.importer)])
    ]
    assert not breaches


@pytest.mark.slow
def test_agents_are_imported_late() -> None:
    # Torch would come along.
    breaches = [
        f"{name}:{node.lineno}"
        for name, path in sources().items()
        if part(name) not in WITH_TORCH
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        for target in targets(node, name.rpartition(".")[0])
        if target.startswith("ltlc.") and part(target) in WITH_TORCH
    ]
    assert not breaches


def test_the_command_line_imports_by_statements() -> None:
    # What is imported by name has no types.
    assert not [name for name, path in sources().items() if part(name) == "cli" and "import_module" in path.read_text()]


@pytest.mark.slow
def test_texts_of_the_library_name_no_options_of_the_command_line() -> None:
    option = re.compile(r"\s--[a-z]|^--[a-z].*\s")
    breaches = [
        f"{name}:{node.lineno}: {node.value:.60}"
        for name, path in sources().items()
        if part(name) != "cli"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and option.search(node.value)
    ]
    assert not breaches


def test_third_party_stays_on_its_floor() -> None:
    known = set(sys.stdlib_module_names) | {"ltlc"}
    breaches = [
        f"{entry.importer}:{entry.line} imports {entry.imported}"
        for entry in imports()
        if entry.imported.split(".")[0] not in known | THIRD_PARTY[part(entry.importer)]
    ]
    assert not breaches


def test_modules_of_a_part_form_no_cycle() -> None:
    graph: dict[str, set[str]] = {}
    for entry in imports():
        inside = entry.imported in sources() and part(entry.imported) == part(entry.importer)
        if entry.runs and inside:
            graph.setdefault(entry.importer, set()).add(entry.imported)
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        pytest.fail(f"imported in a circle: {' <- '.join(error.args[1])}")


def test_no_drawer_for_odds_and_ends() -> None:
    odd = {"utils", "util", "common", "helpers", "misc"}
    assert not [name for name in sources() if odd & set(name.split("."))]


@pytest.mark.slow
def test_nothing_evaluates_or_unpickles_foreign_input() -> None:
    calls = [
        f"{name}:{node.lineno} {node.func.id}"
        for name, path in sources().items()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("eval", "exec")
    ]
    assert not calls
    assert not [entry for entry in imports() if entry.imported.split(".")[0] in ("pickle", "dill", "cloudpickle")]


def run_python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_importing_ltlc_loads_nothing_else() -> None:
    assert run_python("import sys, ltlc; print(*sorted(m for m in sys.modules if 'numpy' in m or 'lark' in m))") == ""


def test_compiling_asks_lark_nothing() -> None:
    assert run_python("import sys, ltlc; ltlc.compile('F(A & F B) & G!C'); print('lark' in sys.modules)") == "False"


def test_compiling_loads_nothing_heavy() -> None:
    code = f"import sys, ltlc; ltlc.compile('F(A & F B) & G!C'); print(*[m for m in {HEAVY} if m in sys.modules])"
    assert run_python(code) == ""
