"""`ltlc rewards`: the reward schemes there are."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING, Any

from ltlc.cli import flags

if TYPE_CHECKING:
    from ltlc.rewards import RewardScheme


def rewards(json_: flags.Json = False) -> None:
    """List the reward schemes that --reward knows, what they need and what they promise."""
    from ltlc.rewards import SCHEMES

    if json_:
        print(json.dumps([_entry(name, scheme) for name, scheme in SCHEMES.items()], ensure_ascii=False, indent=2))
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(highlight=False)
    for name, scheme in SCHEMES.items():
        entry = _entry(name, scheme)
        console.print(Text(name, style="bold"))
        table = Table.grid(padding=(0, 2))
        table.add_column(style="dim", min_width=10)
        table.add_column()
        parameters = "  ".join(f"{key}={value}" for key, value in entry["parameters"].items())
        for key in ("needs", "guarantee"):
            table.add_row(f"  {key}", Text(entry[key]))
        table.add_row("  parameters", Text(parameters or "none"))
        table.add_row("  source", Text(entry["citation"], style="dim"))
        console.print(table)


def _entry(name: str, scheme: type[RewardScheme]) -> dict[str, Any]:
    """A scheme as JSON values; parameters with their defaults."""
    return {
        "name": name,
        "citation": scheme.citation,
        "needs": scheme.needs,
        "guarantee": scheme.guarantee,
        "on_deadlock": scheme.on_deadlock,
        "parameters": {
            field.name: None if field.default is dataclasses.MISSING else field.default
            for field in dataclasses.fields(scheme)
        },
    }
