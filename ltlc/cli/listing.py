"""Registries as lists: what there is, and who is to be cited for it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from ltlc.cli import flags


def translators(json_: flags.Json = False) -> None:
    """List the constructions that --translator knows, with their sources."""
    from ltlc.translate import TRANSLATORS

    _print(
        [
            {"name": name, "description": construction.description, "citation": construction.citation}
            for name, construction in TRANSLATORS.items()
        ],
        json_,
    )


def rewards(json_: flags.Json = False) -> None:
    """List the reward schemes, with what they promise and their sources."""
    from ltlc.rewards import SCHEMES

    _print(
        [
            {
                "name": name,
                "guarantee": scheme.guarantee,
                "requires": scheme.requires,
                "parameters": _assignments(scheme().parameters),
                "citation": scheme.citation,
            }
            for name, scheme in SCHEMES.items()
        ],
        json_,
    )


def agents(json_: flags.Json = False) -> None:
    """List the agents that --agent knows, with their hyperparameters and sources."""
    from ltlc.agents.registry import AGENTS

    _print(
        [
            {
                "name": name,
                "description": agent.description,
                "hyperparameters": _assignments(agent.defaults.to_dict()),
                "citation": agent.citation,
            }
            for name, agent in AGENTS.items()
        ],
        json_,
    )


def formats(json_: flags.Json = False) -> None:
    """List the file formats that -o and --format know."""
    from ltlc.formats import FORMATS

    _print(
        [
            {
                "name": name,
                "description": form.help,
                "suffixes": " ".join(form.suffixes),
                "read": "no" if form.reader is None else "yes",
            }
            for name, form in FORMATS.items()
        ],
        json_,
    )


def labellers(json_: flags.Json = False) -> None:
    """List the named labels that --labels knows beside MODULE:NAME."""
    from ltlc.envs.labels import LABELLERS, Source

    _print(
        [
            {
                "name": name,
                "description": (labels.__doc__ or "").strip().partition("\n")[0] if callable(labels) else "",
                "propositions": ", ".join(Source(labels).propositions or ()),
            }
            for name, labels in LABELLERS.items()
        ],
        json_,
    )


def _assignments(values: Mapping[str, object]) -> str:
    """Values as --set and --hyper take them."""
    words: dict[object, str] = {None: "null", True: "true", False: "false"}
    plain = {key: words[value] if value is None or isinstance(value, bool) else value for key, value in values.items()}
    return ", ".join(f"{key}={value}" for key, value in plain.items())


def _print(entries: Sequence[Mapping[str, str]], as_json: bool) -> None:
    """Print entries with a `name`, and any other texts, for a person or as JSON."""
    if as_json:
        print(json.dumps(entries, ensure_ascii=False, indent=2))
        return
    from rich.console import Console
    from rich.padding import Padding
    from rich.text import Text

    console = Console(highlight=False)
    for entry in entries:
        console.print(Text(entry["name"], style="bold"))
        for key, value in entry.items():
            if key != "name" and value:
                label = "" if key in ("description", "citation") else f"{key}: "
                console.print(Padding(Text(label + value, style="dim" if key == "citation" else ""), (0, 2)))
