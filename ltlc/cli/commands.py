"""The commands by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ltlc.cli import listing

_LISTS: Mapping[str, Callable[..., int | None]] = {
    "translators": listing.translators,
    "rewards": listing.rewards,
    "agents": listing.agents,
    "formats": listing.formats,
    "labellers": listing.labellers,
}
COMMANDS = (
    "compile",
    "show",
    "check",
    "monitor",
    "explain",
    "train",
    "sweep",
    "evaluate",
    "report",
    "solve",
    "faithful",
    "reproduce",
    "doctor",
    *_LISTS,
)
"""In the order of the help."""


def command_of(name: str) -> Callable[..., int | None]:
    """The function of a command, whose file is only then imported; what it returns is the exit code, None is 0."""
    match name:
        case "compile":
            from ltlc.cli.compile import compile_

            return compile_
        case "show":
            from ltlc.cli.show import show

            return show
        case "check":
            from ltlc.cli.check import check

            return check
        case "monitor":
            from ltlc.cli.monitor import monitor

            return monitor
        case "explain":
            from ltlc.cli.explain import explain

            return explain
        case "train":
            from ltlc.cli.train import train

            return train
        case "sweep":
            from ltlc.cli.sweep import sweep

            return sweep
        case "evaluate":
            from ltlc.cli.evaluate import evaluate

            return evaluate
        case "report":
            from ltlc.cli.report import report

            return report
        case "solve":
            from ltlc.cli.solve import solve

            return solve
        case "faithful":
            from ltlc.cli.faithful import faithful

            return faithful
        case "reproduce":
            from ltlc.cli.reproduce import reproduce

            return reproduce
        case "doctor":
            from ltlc.cli.doctor import doctor

            return doctor
    return _LISTS[name]
