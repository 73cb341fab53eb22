"""`ltlc translators`: the constructions there are."""

from __future__ import annotations

import json

from ltlc.cli import flags


def translators(json_: flags.Json = False) -> None:
    """List the constructions that --translator knows, with their sources."""
    from ltlc.translate import TRANSLATORS

    if json_:
        entries = [
            {"name": name, "citation": one.citation, "description": one.description}
            for name, one in TRANSLATORS.items()
        ]
        print(json.dumps(entries, ensure_ascii=False, indent=2))
        return
    from rich.console import Console
    from rich.padding import Padding
    from rich.text import Text

    console = Console(highlight=False)
    for name, one in TRANSLATORS.items():
        console.print(Text(name, style="bold"))
        console.print(Padding(Text(one.description), (0, 2)))
        console.print(Padding(Text(one.citation, style="dim"), (0, 2)))
