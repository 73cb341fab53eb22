"""Options of `ltlc train` alone."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from ltlc.cli import flags

Preset = Literal["default", "thesis"]
Formula = Annotated[
    str | None, typer.Argument(metavar="FORMULA", help="A formula, a .json or .hoa file, or - to read one.")
]
Agent = Annotated[
    str,
    typer.Option(
        "--agent",
        metavar="NAME",
        help="What learns: {agents}, or MODULE:NAME. See 'ltlc agents'.",
        autocompletion=flags.names_of("agents"),
    ),
]
Hyper = Annotated[
    list[str] | None,
    typer.Option("--hyper", metavar="KEY=VALUE", help="A hyperparameter of the agent. May be repeated."),
]
Steps = Annotated[
    int | None,
    typer.Option("--steps", "-n", min=1, metavar="N", help="Environment steps in all.", show_default="the agent's"),
]
NumEnvs = Annotated[
    int | None,
    typer.Option(
        "--num-envs",
        min=1,
        metavar="N",
        help="Environments stepped together.",
        show_default="64, or fewer where steps are few; thesis 1",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option("--workers", min=0, metavar="N", help="Processes that step slow environments.", show_default="0"),
]
Seed = Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Of everything that is random.")]
Config = Annotated[
    Preset, typer.Option("--config", "-c", help="What double-dqn starts from; thesis: also its rewards.")
]
Callback = Annotated[
    str | None,
    typer.Option(
        "--callback",
        metavar="MODULE:NAME",
        help="A function that is called with each row of metrics, for loggers; a truthy answer ends the training.",
    ),
]
Out = Annotated[
    str | None,
    typer.Option(
        "--out",
        "-o",
        metavar="DIR",
        callback=flags.path_given,
        help="The run folder.",
        show_default="runs/TASK-ENV-SEED",
    ),
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with the run in the folder.")]
Force = Annotated[bool, typer.Option("--force", help="Replace the run in the folder.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]
