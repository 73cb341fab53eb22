"""`ltlc translators`: the constructions there are."""

from __future__ import annotations

from ltlc.cli import flags
from ltlc.cli.listing import print_listing


def translators(json_: flags.Json = False) -> None:
    """List the constructions that --translator knows, with their sources."""
    from ltlc.translate import TRANSLATORS

    entries = [
        {"name": name, "description": construction.description, "citation": construction.citation}
        for name, construction in TRANSLATORS.items()
    ]
    print_listing(entries, json_)
