"""The extension of Sphinx that writes the generated pages before a build, and llms.txt after it.

What is generated stands in `docs/generated`, which git ignores: the Python interface, the commands, a page for each
world, reward scheme, agent and construction, and the documents and programs of other folders.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

from site_api import ROOT, api_pages, exports
from site_commands import command_pages
from site_parts import part_pages, world_pictures

from ltlc.errors import LtlcError
from ltlc.registry import import_object

FOREWORD = (
    "ltlc compiles tasks in linear temporal logic into deterministic Rabin automata and into rewards, trains agents of "
    "reinforcement learning on them, and proves how probably what was learned satisfies the task."
)
_ROOT_DOCUMENT = re.compile(r"\]\((?:\.\./)+(README|CONTRIBUTING|CHANGELOG)\.md(#[^)]*)?\)")

_CODE = re.compile(r"(`+[^`]*`+)")


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir, "generated")))
    app.connect("source-read", _lead_to_generated)
    app.connect("autodoc-process-docstring", _before_napoleon, priority=100)
    app.connect("autodoc-process-bases", _without_object)
    app.connect("missing-reference", _unexported)
    app.connect("object-description-transform", _attributes)
    app.connect("env-updated", _only_our_sources)
    app.connect("build-finished", _write_llms)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def generated_pages() -> Iterator[tuple[str, str]]:
    """Every generated page: its path beneath `docs/generated`, and its text."""
    yield from api_pages()
    yield from command_pages()
    yield from part_pages()
    yield from _documents()
    yield (
        "schema.md",
        (
            '# Schema of JSON files\n\nThe JSON Schema (draft 2020-12) of what `dra.save("task.json")` writes; '
            "[file formats](../formats.md#json) explains it.\n\n"
            "```{literalinclude} ../../ltlc/formats/dra.schema.json\n:language: json\n```\n"
        ),
    )


def _documents() -> Iterator[tuple[str, str]]:
    for name in ("CHANGELOG", "CONTRIBUTING"):
        text = (ROOT / f"{name}.md").read_text(encoding="utf-8")
        text = re.sub(r"\]\((README|CHANGELOG|CONTRIBUTING)\.md", lambda found: f"](../{found[1]}.md", text)
        text = re.sub(r"\]\(docs/", "](../", text)
        yield f"{name.lower()}.md", re.sub(r"\]\((?=[A-Z]\w+(?:\.cff)?\))", "](../../", text)
    parts = ["# Example programs\n\nEach is run by the tests.\n"]
    for path in sorted((ROOT / "examples").glob("*.py")):
        text = path.read_text(encoding="utf-8")
        parts.append(f"## {path.name}\n\n{text.split(chr(34) * 3)[1].strip()}\n")
        parts.append(f"```{{literalinclude}} ../../examples/{path.name}\n:language: python\n```\n")
    yield "programs.md", "\n".join(parts)


def write(folder: Path) -> None:
    """Write what is generated, and remove what no longer is; files that stay the same keep their times."""
    pages = {path: text.encode() for path, text in generated_pages()}
    for path, pixels in world_pictures():
        pages[path] = _png(pixels)
    for old in [path for path in folder.rglob("*") if path.is_file()]:
        if old.relative_to(folder).as_posix() not in pages:
            old.unlink()
    for path, content in pages.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_bytes() != content:
            target.write_bytes(content)


def _png(pixels: Any) -> bytes:
    import io

    from matplotlib.image import imsave

    buffer = io.BytesIO()
    imsave(buffer, pixels, format="png")
    return buffer.getvalue()


def _lead_to_generated(app: Any, name: str, source: list[str]) -> None:
    """Links to the documents of the repository's root become links to their pages."""

    def page(found: re.Match[str]) -> str:
        target = "/index.md" if found[1] == "README" else f"/generated/{found[1].lower()}.md"
        return f"]({target}{found[2] or ''})"

    text = _ROOT_DOCUMENT.sub(page, source[0])
    source[0] = re.sub(r"\]\((?:\.\./)+examples/(\w+)\.py\)", lambda m: f"](/generated/programs.md#{m[1]}py)", text)


def _before_napoleon(app: Any, what: str, name: str, obj: object, options: Any, lines: list[str]) -> None:
    for i, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...", "* ")):  # outside code, stars are stars
            lines[i] = "".join(part if part[:1] == "`" else part.replace("*", r"\*") for part in _CODE.split(line))
    if what in ("property", "attribute") and lines:
        lines.insert(0, "")  # else what stands before a colon in the first line would be taken for a type


def _without_object(app: Any, name: str, obj: object, options: Any, bases: list[object]) -> None:
    bases[:] = [base for base in bases if base is not object] or bases


def _unexported(app: Any, env: Any, node: Any, content: Any) -> Any:
    """What no package exports has no page, and its name stands there as text; other names have to be found."""
    target = str(node.get("reftarget", ""))
    described = {id(part) for names in exports().values() for part in names.values()}
    try:
        found = import_object(":".join(target.rsplit(".", 1)), target)
    except LtlcError:
        return None
    return content if isinstance(found, TypeVar) or id(found) not in described else None


def _attributes(app: Any, domain: str, kind: str, content: Any) -> None:
    from docutils import nodes

    for name in content.findall(nodes.field_name):
        if name.astext() == "Variables":
            name.clear()
            name += nodes.Text("Attributes")


def _only_our_sources(app: Any, env: Any) -> None:
    getattr(env, "_viewcode_modules", {}).pop("builtins", None)  # it has no source, and would be listed


def _write_llms(app: Any, problem: Exception | None) -> None:
    """Write llms.txt: every page with its first sentence, under the captions of the first page."""
    if problem is not None or app.builder.format != "html":
        return
    from docutils import nodes
    from sphinx.addnodes import toctree

    env, lines = app.env, [f"# {app.config.project}", f"\n> {FOREWORD}"]
    for contents in env.get_doctree("index").findall(toctree):
        lines.append(f"\n## {contents['caption']}\n")
        for top in contents["includefiles"]:
            for name in _in_order(env, top, [top]):
                paragraph = next(iter(env.get_doctree(name).findall(nodes.paragraph)), None)
                first = " ".join(paragraph.astext().split()) if paragraph is not None else ""
                sentence = re.split(r"(?<=[.:]) ", first)[0][:200]
                title = env.titles[name].astext()
                lines.append(f"- [{title}]({name}.html)" + (f": {sentence}" if sentence else ""))
    Path(app.outdir, "llms.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _in_order(env: Any, name: str, seen: list[str]) -> list[str]:
    """Documents in the order of the tables of contents."""
    for child in env.toctree_includes.get(name, []):
        if child not in seen:
            seen.append(child)
            _in_order(env, child, seen)
    return seen
