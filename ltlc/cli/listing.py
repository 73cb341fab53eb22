"""A registry as a list: what there is, and who is to be cited for it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence


def print_listing(entries: Sequence[Mapping[str, str]], as_json: bool) -> None:
    """Print entries with a `name`, a `citation` and any other texts, for a person or as JSON."""
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
