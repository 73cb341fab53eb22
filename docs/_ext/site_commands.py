"""The reference of the command line, from the help of the commands."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import typer

from ltlc.cli import flags
from ltlc.cli.typer_app import application


def command_pages() -> Iterator[tuple[str, str]]:
    """The page of all commands, and one for each."""
    group: Any = typer.main.get_command(application())
    rows = [f"| [`ltlc {name}`]({name}.md) | {_first(command.help)} |" for name, command in group.commands.items()]
    yield (
        "commands/index.md",
        "\n".join(
            [
                "# Commands",
                "\nThese pages are what `ltlc COMMAND --help` says. Exit codes: 0 done; 1 the answer is no; 2 bad "
                "input; 3 a limit was reached; 70 a bug; 130 interrupted.\n",
                "| command | does |",
                "|---|---|",
                *rows,
                "\n```{toctree}\n:hidden:",
                *group.commands,
                "```\n",
            ]
        ),
    )
    for name, command in group.commands.items():
        yield f"commands/{name}.md", _page(name, command)


def _first(text: str | None) -> str:
    return inspect.cleandoc(text or "").partition("\n")[0]


def _page(name: str, command: Any) -> str:
    text, *blocks = inspect.cleandoc(command.help or "").replace("\\[", "[").split("\b\n")
    arguments = [p for p in command.params if not p.opts[0].startswith("-")]
    options = [p for p in command.params if p.opts[0].startswith("-") and not getattr(p, "hidden", False)]
    usage = " ".join(["ltlc", name, "[OPTIONS]", *(_argument(p) for p in arguments)])
    lines = [f"# ltlc {name}", f"\n{text.strip()}\n", f"```text\n{usage}\n```\n"]
    for block in blocks:
        heading, _, lines_of_block = block.strip().partition("\n")
        lines += [f"## {heading.rstrip(':')}\n", f"```text\n{inspect.cleandoc(lines_of_block)}\n```\n"]
    for heading, parameters in (("Arguments", arguments), ("Options", options)):
        if parameters:
            lines += [f"## {heading}\n", *(_entry(parameter) for parameter in parameters)]
    return "\n".join(lines)


def _argument(parameter: Any) -> str:
    name = parameter.metavar or parameter.name.upper()
    return name if parameter.required else f"[{name}]"


def _entry(parameter: Any) -> str:
    text = parameter.help or ""
    for kind in re.findall(r"{(\w+)}", text):
        if kind in flags.NAMES:
            text = text.replace(f"{{{kind}}}", ", ".join(flags.NAMES[kind]()) or "none yet")
    flag = getattr(parameter, "is_flag", False)
    names = [parameter.metavar or parameter.name.upper()]
    if parameter.opts[0].startswith("-"):
        taken = "" if flag else " " + str(parameter.metavar or parameter.type.name.upper())
        names = [f"{option}{taken}" for option in (*parameter.opts, *parameter.secondary_opts)]
    default = parameter.default
    shown = (
        ""
        if flag or default in (None, "", ()) or callable(default)
        else f" Default: `{getattr(default, 'value', default)}`."
    )
    return ", ".join(f"`{name}`" for name in names) + f"\n: {escape(text)}{shown}\n"


def escape(text: str) -> str:
    """Text of a help as Markdown: what would be mark-up is not."""
    return re.sub(r"([*_<>\[\]|])", r"\\\1", text)
