"""What is built and installed is what the tree says: agents/ and grammars/ inside ltlc, and nothing else beside it."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path, PurePosixPath

import pytest
from packaging.version import Version

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
# Runs away from the checkout; the door and every sub-package must work there too.
PROBE = """
import importlib, importlib.resources, importlib.util, json, sys
import ltlc
for name in json.loads(sys.argv[1]):
    if importlib.util.find_spec(name) is None:
        sys.exit(f"no {name}")
grammar = importlib.resources.files("ltlc.grammars") / "ltl.lark"
assert "start" in grammar.read_text(encoding="utf-8")
assert importlib.util.find_spec("agents") is None and importlib.util.find_spec("grammars") is None
print(ltlc.__file__)
"""


def run(*command: str | Path, cwd: Path) -> str:
    done = subprocess.run([str(word) for word in command], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def wheel_packages() -> dict[str, Path]:
    folders = PROJECT["tool"]["setuptools"]["package-dir"]
    packages = {}
    for name in PROJECT["tool"]["setuptools"]["packages"]:
        home = next(prefix for prefix in sorted(folders, key=len, reverse=True) if f"{name}.".startswith(f"{prefix}."))
        packages[name] = ROOT / folders[home] / name.removeprefix(home).replace(".", "/").lstrip("/")
    return packages


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clean copy: building in place would leave build/ behind, and pick up what an earlier build left there."""
    copy = tmp_path_factory.mktemp("checkout") / "ltlc"
    skipped = shutil.ignore_patterns(".*", "build", "dist", "*.egg-info", "__pycache__", "runs")
    shutil.copytree(ROOT, copy, ignore=skipped)
    return copy


@pytest.fixture(scope="module")
def dist(checkout: Path) -> Path:
    """The sdist, and the wheel built from it."""
    folder = checkout.parent / "dist"
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, checkout, cwd=checkout.parent)
    return folder


def test_package_list_equals_the_tree() -> None:
    listed = wheel_packages()
    present = {
        path.parent for folder in ("ltlc", "agents", "grammars") for path in (ROOT / folder).rglob("__init__.py")
    }
    assert set(listed.values()) == present


def test_the_oldest_versions_tested_are_those_allowed() -> None:
    lines = (ROOT / "constraints-oldest.txt").read_text(encoding="utf-8").splitlines()
    pinned = [re.fullmatch(r"([\w-]+)==([\d.]+)(; python_version < .*)?", line) for line in lines]
    tested = {pin[1]: pin[2] for pin in pinned if pin}
    allowed = {}
    for requirement in PROJECT["project"]["dependencies"] + PROJECT["project"]["optional-dependencies"]["dev"]:
        name, bound = re.match(r"([\w-]+)>=([\d.]+)", requirement).groups()
        allowed[name] = bound
    assert tested.keys() <= allowed.keys()
    assert {"gymnasium", "lark", "numpy", "scipy"} <= tested.keys()
    for name, version in tested.items():
        assert Version(version) == Version(allowed[name]), name


@pytest.mark.build
def test_every_module_and_grammar_is_in_the_wheel(dist: Path) -> None:
    expected = {
        f"{name.replace('.', '/')}/{path.name}"
        for name, folder in wheel_packages().items()
        for path in folder.iterdir()
        if path.is_file()
    }
    with zipfile.ZipFile(next(dist.glob("*-py3-none-any.whl"))) as wheel:
        names = {name for name in wheel.namelist() if not name.endswith("/")}
    assert {PurePosixPath(name).parts[0].partition("-")[0] for name in names} == {"ltlc"}
    assert {name for name in names if name.startswith("ltlc/")} == expected
    assert {"ltlc/agents/__init__.py", "ltlc/grammars/ltl.lark", "ltlc/grammars/ltl.json", "ltlc/py.typed"} <= names
    assert {"ltlc/reports/report.html", "ltlc/formats/dra.schema.json"} <= names


@pytest.mark.build
def test_wheel_metadata(dist: Path) -> None:
    with zipfile.ZipFile(next(dist.glob("*.whl"))) as wheel:
        texts = {
            PurePosixPath(name).name: wheel.read(name).decode() for name in wheel.namelist() if "dist-info" in name
        }
    assert "ltlc = ltlc.cli:main" in texts["entry_points.txt"]
    assert "License-Expression: MIT" in texts["METADATA"]
    assert "MIT License" in texts["LICENSE"]


@pytest.mark.build
def test_sdist_can_build_and_explain_itself(dist: Path) -> None:
    with tarfile.open(next(dist.glob("*.tar.gz"))) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    assert {"pyproject.toml", "setup.py", "README.md", "LICENSE", "agents/__init__.py"} <= names
    assert {"grammars/ltl.lark", "grammars/ltl.json"} <= names


def test_versions_agree() -> None:
    version: dict[str, str] = {}
    exec((ROOT / "ltlc" / "version.py").read_text(encoding="utf-8"), version)
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{version['__version__']}]" in changelog or "## [Unreleased]" in changelog
    assert f"\nversion: {version['__version__']}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_workflows_try_every_python_that_is_promised() -> None:
    promised = re.findall(r"Python :: (3\.\d+)", " ".join(PROJECT["project"]["classifiers"]))
    tests = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    tried = re.search(r"python: (\[.*\])", tests)
    assert tried is not None and sorted(promised) == sorted(re.findall(r"3\.\d+", tried[1]))


@pytest.mark.build
@pytest.mark.parametrize("mode", ["normal", "editable", "strict"])
def test_installed(mode: str, checkout: Path, dist: Path, tmp_path: Path) -> None:
    """Every sub-package is found, `import agents` is not, and the script runs, away from the checkout."""
    venv.create(tmp_path / "venv", with_pip=False, symlinks=True)
    python = tmp_path / "venv" / "bin" / "python"
    site = next((tmp_path / "venv").rglob("site-packages"))
    # The dependencies are those of the running interpreter, by a path file: copying them would take minutes.
    (site / "outer.pth").write_text("\n".join(path for path in sys.path if path.endswith("site-packages")))
    source = {
        "normal": [next(dist.glob("*.whl"))],
        "editable": ["-e", checkout],
        "strict": ["-e", checkout, "--config-settings", "editable_mode=strict"],
    }[mode]
    pip = [sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check"]
    run(*pip, "install", "--quiet", "--no-deps", "--no-build-isolation", "--ignore-installed", *source, cwd=tmp_path)
    names = str(sorted(wheel_packages())).replace("'", '"')
    where = run(python, "-c", PROBE, names, cwd=tmp_path).strip()
    assert where.startswith(str(tmp_path if mode == "normal" else checkout))
    for program in ([tmp_path / "venv" / "bin" / "ltlc"], [python, "-m", "ltlc"]):
        assert "compile" in run(*program, "--help", cwd=tmp_path)
