"""`ltlc rewards`: the reward schemes there are."""

from __future__ import annotations

from ltlc.cli import flags
from ltlc.cli.listing import print_listing


def rewards(json_: flags.Json = False) -> None:
    """List the reward schemes, with what they promise and their sources."""
    from ltlc.rewards import SCHEMES

    entries = [
        {
            "name": name,
            "guarantee": scheme.guarantee,
            "requires": scheme.requires,
            "parameters": ", ".join(f"{key}={value}" for key, value in scheme().parameters.items()),
            "citation": scheme.citation,
        }
        for name, scheme in SCHEMES.items()
    ]
    print_listing(entries, json_)
