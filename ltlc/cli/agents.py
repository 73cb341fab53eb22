"""`ltlc agents`: what can learn."""

from __future__ import annotations

from importlib import import_module

from ltlc.cli import flags
from ltlc.cli.listing import print_listing


def agents(json_: flags.Json = False) -> None:
    """List the agents that --agent knows, with their hyperparameters and sources."""
    entries = [
        {
            "name": name,
            "description": entry.description,
            "hyperparameters": ", ".join(f"{key}={_plain(value)}" for key, value in entry.defaults.to_dict().items()),
            "citation": entry.citation,
        }
        for name, entry in import_module("ltlc.agents.registry").AGENTS.items()
    ]
    print_listing(entries, json_)


def _plain(value: object) -> object:
    """A value as --hyper takes it."""
    return {None: "null", True: "true", False: "false"}[value] if value is None or isinstance(value, bool) else value
