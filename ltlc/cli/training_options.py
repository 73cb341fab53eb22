"""Options of `ltlc train` alone."""

from __future__ import annotations

from typing import Annotated, Literal

from ltlc.cli import flags
from ltlc.cli.options import Argument, Option

Preset = Literal["default", "thesis"]
Formula = Annotated[str | None, Argument(metavar="FORMULA", help="A formula, a .json or .hoa file, or - to read one.")]
Agent = Annotated[
    str,
    Option(
        "--agent",
        metavar="NAME",
        help="What learns: {agents}, or MODULE:NAME. See 'ltlc agents'.",
        completion=flags.names_of("agents"),
    ),
]
Hyper = Annotated[
    list[str] | None,
    Option("--hyper", metavar="KEY=VALUE", help="A hyperparameter of the agent. May be repeated."),
]
Steps = Annotated[
    int | None,
    Option("--steps", "-n", least=1, metavar="N", help="Environment steps in all.", shown_default="the agent's"),
]
NumEnvs = Annotated[
    int | None,
    Option(
        "--num-envs",
        least=1,
        metavar="N",
        help="Environments stepped together.",
        shown_default="64, or fewer where steps are few; thesis 1",
    ),
]
Workers = Annotated[
    int | None,
    Option("--workers", least=0, metavar="N", help="Processes that step slow environments.", shown_default="0"),
]
Seed = Annotated[int, Option("--seed", least=0, metavar="N", help="Of everything that is random.")]
Config = Annotated[Preset, Option("--config", "-c", help="What double-dqn starts from; thesis: also its rewards.")]
Callback = Annotated[
    str | None,
    Option(
        "--callback",
        metavar="MODULE:NAME",
        help="A function that is called with each row of metrics, for loggers; a truthy answer ends the training.",
    ),
]
Out = Annotated[
    str | None,
    Option(
        "--out",
        "-o",
        metavar="DIR",
        is_path=True,
        help="The run folder.",
        shown_default="runs/TASK-ENV-SEED",
    ),
]
Resume = Annotated[bool, Option("--resume", help="Go on with the run in the folder.")]
Force = Annotated[bool, Option("--force", help="Replace the run in the folder.")]
Quiet = Annotated[bool, Option("--quiet", "-q", help="Print nothing but warnings and errors.")]
