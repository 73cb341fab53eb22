"""What the shell offers behind --env and --labels, found without importing what the names stand for."""

from __future__ import annotations

import ast
import contextlib
import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path

MOST_FILES = 100
"""files of a folder that are looked into."""


def environments(incomplete: str) -> list[str]:
    """Ids of Gymnasium's registry and of the worlds of ltlc, and `module:id` for what files here register."""
    ids = sorted({*_of_gymnasium(), *_ids(Path(__file__).parents[1] / "envs" / "registration.py")})
    return [name for name in (*ids, *_members(incomplete, _registered)) if name.startswith(incomplete)]


def _of_gymnasium() -> list[str]:
    """Ids of the environments that come with Gymnasium."""
    found = find_spec("gymnasium")
    if found is None or found.origin is None:
        return []
    return list(_registered(_parsed(Path(found.origin).parent / "envs" / "__init__.py")))


def labels(incomplete: str) -> list[str]:
    """Labels that are registered, and `module:name` for the functions and tables of files here."""
    from importlib.metadata import entry_points

    offered = [point.name for point in entry_points(group="ltlc.labellers")]
    loaded = sys.modules.get("ltlc.envs.labels")  # by a plugin that registers some; else there are none
    names = {*offered, *(() if loaded is None else loaded.LABELLERS)}
    return [name for name in (*sorted(names), *_members(incomplete, _functions)) if name.startswith(incomplete)]


def _members(incomplete: str, found_in: Callable[[ast.Module], Iterator[str]]) -> list[str]:
    """`place:name` for all names that a function finds in the files of a folder, or in the file before the colon."""
    place, colon, _ = incomplete.partition(":")
    if colon:
        files = {place: Path(place) if place.endswith(".py") else Path(*place.split(".")).with_suffix(".py")}
    else:
        folder = Path(os.path.dirname(place))  # "dir/se" asks for files of dir
        paths = sorted(folder.glob("*.py"))[:MOST_FILES] if folder.is_dir() else []
        files = {path.stem if folder == Path() else str(path): path for path in paths}
    return [f"{name}:{member}" for name, path in files.items() for member in found_in(_parsed(path))]


def _parsed(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return ast.Module(body=[], type_ignores=[])


def _ids(path: Path) -> list[str]:
    """Keys of tables in a file that are ids of environments."""
    tables = (node for node in ast.walk(_parsed(path)) if isinstance(node, ast.Dict))
    keys = (key.value for table in tables for key in table.keys if isinstance(key, ast.Constant))
    return [key for key in keys if isinstance(key, str) and key.startswith("ltlc/")]


def _registered(module: ast.Module) -> Iterator[str]:
    for node in ast.walk(module):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) == "register":
            named = [keyword.value for keyword in node.keywords if keyword.arg == "id"]
            for value in [*node.args[:1], *named]:
                if isinstance(value, ast.Constant) and isinstance(value.value, str):
                    yield value.value


def _functions(module: ast.Module) -> Iterator[str]:
    for node in module.body:
        if isinstance(node, ast.FunctionDef):
            names = [node.name]
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict | ast.Call | ast.Lambda):
            names = [target.id for target in node.targets if isinstance(target, ast.Name)]
        else:
            continue
        yield from (name for name in names if not name.startswith("_"))


def joined(words: Sequence[str], at: int) -> tuple[list[str], int, str]:
    """Words of a command line that bash has broken at colons, whole again.

    Args:
        words: as bash has them.
        at: which of them is to be completed.

    Returns:
        The words, which of them is to be completed, and what stands before its last colon, that one included: bash
        replaces only the rest.

    Example:
        >>> joined(["ltlc", "train", "-l", "lake", ":", "la"], 5)
        (['ltlc', 'train', '-l', 'lake:la'], 3, 'lake:')
        >>> joined(["ltlc", "train", "-l", "la"], 3)
        (['ltlc', 'train', '-l', 'la'], 3, '')
    """
    whole: list[str] = []
    place = 0
    for index, word in enumerate(words[: at + 1]):
        if whole and (word == ":" or (index and words[index - 1] == ":" and not word.startswith("-"))):
            whole[-1] += word
        else:
            whole.append(word)
        place = len(whole) - 1
    broken = ":" in words[: at + 1][-2:]
    kept = whole[place].rpartition(":")[0] + ":" if broken and ":" in whole[place] else ""
    return whole, place, kept


@contextlib.contextmanager
def words_of_bash() -> Iterator[None]:
    """Where bash asks for completions, let it ask for whole words, and answer with what it replaces; else nothing."""
    if os.environ.get("_LTLC_COMPLETE") != "complete_bash":
        yield
        return
    words, at = os.environ.get("COMP_WORDS", "").split("\n"), int(os.environ.get("COMP_CWORD", "0"))
    kept = ""
    if at < len(words):  # else they are separated by something else, so nothing can be told
        whole, place, kept = joined(words, at)
        os.environ["COMP_WORDS"], os.environ["COMP_CWORD"] = "\n".join(whole), str(place)
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            yield
    finally:
        for line in filter(None, said.getvalue().splitlines()):
            print(line.removeprefix(kept))
