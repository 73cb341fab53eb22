"""`ltlc train`: an agent learns a task."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from ltlc.cli import flags, spec
from ltlc.cli.diagnostics import tell
from ltlc.cli.messages import complain
from ltlc.cli.progress import training_display
from ltlc.cli.values import assignments, kinds_of
from ltlc.cli.verdicts import maximum_text, print_figures, warn_of_shortfall
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.agents.double_dqn.replay import ReplaySize
    from ltlc.agents.training.report import Report
    from ltlc.agents.training.run_folder import RunConfig, RunFolder
    from ltlc.automata import RabinAutomaton
    from ltlc.envs.spec import EnvSpec

COMPARED_UP_TO = 20_000
"""product states; in larger ones the optimum of the rewards takes long, and is compared with what is possible last."""


def train(
    formula: Annotated[
        str | None, typer.Argument(metavar="FORMULA", help="A formula, a .json or .hoa file, or - to read one.")
    ] = None,
    env: Annotated[
        str | None, typer.Option("--env", "-e", metavar="ID", help="An environment of Gymnasium's registry.")
    ] = None,
    labels: spec.Labels = None,
    env_set: spec.EnvArguments = None,
    episode_steps: spec.EpisodeSteps = None,
    initial_label: spec.InitialLabel = "read",
    discretise: spec.Discretise = None,
    reward: spec.Reward = None,
    set_: spec.Parameters = None,
    on_deadlock: spec.OnDeadlock = None,
    on_termination: spec.OnTermination = "repeat",
    acceptance: flags.Acceptance = "state",
    translator: flags.Translator = "auto",
    agent: Annotated[
        str,
        typer.Option("--agent", metavar="NAME", help="What learns: {agents}, or MODULE:NAME. See 'ltlc agents'."),
    ] = "auto",
    hyper: Annotated[
        list[str] | None,
        typer.Option("--hyper", metavar="KEY=VALUE", help="A hyperparameter of the agent. May be repeated."),
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(
            "--steps",
            "-n",
            min=1,
            metavar="N",
            help="Environment steps in all.",
            show_default="300000, or the learner's",
        ),
    ] = None,
    num_envs: Annotated[
        int | None,
        typer.Option(
            "--num-envs",
            min=1,
            metavar="N",
            help="Environments stepped together.",
            show_default="64, or fewer where steps are few; thesis 1",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="N", help="Of everything that is random.")] = 0,
    device: Annotated[
        str | None,
        typer.Option("--device", metavar="NAME", help="cpu, cuda, cuda:1, ...; of double-dqn.", show_default="cpu"),
    ] = None,
    config: Annotated[
        Literal["default", "thesis"],
        typer.Option("--config", "-c", help="What double-dqn starts from; thesis: also its rewards."),
    ] = "default",
    out: Annotated[
        str | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            callback=flags.path_given,
            help="The run folder.",
            show_default="runs/TASK-ENV-SEED",
        ),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in the folder.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace the run in the folder.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")] = False,
    json_: flags.Json = False,
) -> None:
    """Train an agent to satisfy a formula in an environment, and judge it.

    The run folder gets the configuration, metrics, the automaton, the policy,
    a verdict and pictures. Ctrl-C stops cleanly; --resume goes on from the last
    checkpoint, or begins anew where the agent keeps none (tabular learners).

    \b
    Examples:
      ltlc train "F(A & F B) & G !C" --env ltlc/Thesis10x10-v0
      ltlc train "F goal & G !hole" --env FrozenLake-v1 --labels lake:labels --reward zeta-discount
      ltlc train "F(A & F B)" --env ltlc/Thesis5x5-v0 --agent fu-topcu --hyper accuracy=0.05
      ltlc train --resume --out runs/f-a-f-b-g-c-thesis10x10-v0-0
    """
    from ltlc.agents.registry import AGENTS
    from ltlc.agents.training import run_folder as folders
    from ltlc.rewards import RECOMMENDED

    replay = None
    if formula is None or env is None:
        if not resume or out is None:
            raise InvalidArgumentError("give a FORMULA and an environment (--env ID); or --resume with --out DIR")
        run = folders.RunFolder.open(out, lock=True)
    else:
        automaton = spec.automaton_of(formula, acceptance, translator)
        env_spec = spec.env_spec_of(env, labels, env_set, episode_steps, initial_label, discretise)
        _check_actions(env_spec)
        reward = reward or ("thesis" if config == "thesis" else RECOMMENDED)
        frame = folders.RunConfig(
            env_spec=env_spec,
            reward=reward,
            parameters=spec.parameters_of(set_, reward),
            on_deadlock=on_deadlock,
            on_termination=on_termination,
        )
        agent, reason = _chosen(agent, frame, automaton, hyper, config, device)
        if reason is not None and device == "cpu":
            device = None
        entry = AGENTS[agent]
        given = assignments(hyper, "--hyper", kinds_of(type(entry.defaults)))
        if steps is None:
            steps = given.get("total_steps", entry.quick_steps or entry.defaults.total_steps)
        elif given.get("total_steps", steps) != steps:
            raise InvalidArgumentError(
                f"--steps is {steps}, and total_steps is {given['total_steps']}; give one of them"
            )
        if num_envs is None:
            num_envs = 1 if config == "thesis" else folders.num_envs_for(steps, env_spec.episode_steps)
        episodes = num_envs * env_spec.episode_steps
        wanted = replace(
            frame,
            num_envs=num_envs,
            agent=agent,
            agent_reason=reason,
            hyperparameters=_hyperparameters(agent, config, steps, seed, device, episodes, given),
        )
        folder = Path(out) if out is not None else folders.default_folder(automaton.formula or "task", env, seed, agent)
        opened = _opened(folder, wanted, automaton) if resume else None
        if opened is not None:
            run = opened
        else:
            if (folder / folders.CONFIG_FILE).exists() and not force:
                raise InvalidArgumentError(
                    f"{folder} holds a training run; go on with it by --resume, replace it by --force, or give another "
                    "folder with --out"
                )
            replay = folders.RunFolder(folder, wanted, automaton).check(given)
            run = folders.RunFolder.create(folder, wanted, automaton, force=force)
    with run:
        if resume and device is not None:
            run.move_to(device)
        raise typer.Exit(_train(run, resume, quiet or json_, json_, replay))


def _hyperparameters(
    agent: str,
    preset: str,
    steps: int,
    seed: int,
    device: str | None,
    episodes: int,
    given: dict[str, Any],
) -> Any:
    """The hyperparameters of an agent: those given, and else what the other options imply.

    Args:
        agent: its name.
        preset: what double DQN starts from.
        steps: environment steps.
        seed: of everything random.
        device: of the networks, or None.
        episodes: steps of whole episodes in all environments.
        given: hyperparameters.
    """
    from ltlc.agents import DQNConfig, registry
    from ltlc.agents.training.run_folder import on_device

    implied: dict[str, Any] = {"seed": seed, "total_steps": steps}
    if preset == "thesis":
        if agent != registry.DOUBLE_DQN:
            raise InvalidArgumentError(f"--config {preset} is for the agent {registry.DOUBLE_DQN!r}, not for {agent!r}")
        implied = DQNConfig.thesis().to_dict() | implied
    if registry.AGENTS[agent].keeps_checkpoints:
        # A checkpoint begins new episodes, so there must be time for whole ones between two.
        implied |= {"log_every": max(steps // 100, 1), "checkpoint_every": max(steps // 20, episodes, 1)}
    config = registry.hyperparameters(agent, implied | given)
    return config if device is None else on_device(config, device)


def _check_actions(env_spec: EnvSpec) -> None:
    """Check that actions are discrete, or made so."""
    if env_spec.discretise is None and env_spec.continuous:
        raise InvalidArgumentError(
            f"the actions of {env_spec.env} are continuous; the agents choose from a list. Make one of 5 "
            "values of each coordinate by --discretise 5, or wrap the environment in ltlc.envs.DiscretisedActions"
        )


def _chosen(
    agent: str, frame: RunConfig, automaton: RabinAutomaton, hyper: list[str] | None, preset: str, device: str | None
) -> tuple[str, str | None]:
    """The name of the agent, and why it is this one if nobody named it."""
    from ltlc.agents import registry
    from ltlc.agents.choice import choose_agent

    if agent != registry.AUTO:
        return agent, None
    if preset == "thesis":
        return registry.DOUBLE_DQN, "the configuration of the thesis is one of it"
    if device not in (None, "cpu"):
        return registry.DOUBLE_DQN, f"the device {device} was given"
    names = [text.partition("=")[0].strip() for text in hyper or ()]
    with closing(frame.env_spec.vector(frame.task(automaton), 1)) as env:
        chosen = choose_agent(env, names)
    return chosen.agent, chosen.reason


def _opened(folder: Path, wanted: RunConfig, automaton: RabinAutomaton) -> RunFolder | None:
    """The run in the folder, if there is one and it is the one that is wanted; None if there is none."""
    from ltlc.agents.training import run_folder as folders

    if not (folder / folders.CONFIG_FILE).exists():
        complain(f"warning: {folder} holds no run to go on with; a new one begins")
        return None
    run = folders.RunFolder.open(folder, lock=True)
    different = run.differs(wanted, automaton)
    if different:
        run.close()
        raise InvalidArgumentError(
            f"the run in {folder} differs in {', '.join(different)}; go on with it by ltlc train --resume --out "
            f"{folder}, or give another folder"
        )
    return run


def _train(run: RunFolder, resume: bool, quiet: bool, json_: bool, replay: ReplaySize | None) -> int:
    from ltlc.agents.training.artifacts import draw_run, judge_run

    total = run.config.hyperparameters.total_steps
    tell(run.automaton, run.config.env_spec, episodes=True)
    if not quiet:
        print(f"{run.task.formula or 'an automaton without a formula'} in {run.config.env_spec.env}: {run.path}")
        if run.judge is not None:
            print(maximum_text(run.judge))
        if run.config.agent_reason is not None:
            print(f"Agent: {run.config.agent}, since {run.config.agent_reason}")
        if replay is not None:
            print(f"Replay: the last {replay.rows} steps, {replay.size_text}")
    n_states = 0 if run.judge is None or not run.entry.uses_rewards else run.judge.rewards.n_states
    late = n_states > COMPARED_UP_TO
    if late:
        complain(f"note: with {n_states} product states, it is judged last what the rewards teach")
    else:
        warn_of_shortfall(run.shortfall, run.task)
    with training_display(total, quiet=quiet) as display:
        result = run.train(resume=resume, callback=display)
    if result.interrupted:
        again = spec.command_line("ltlc", "train", "--resume", "--out", str(run.path))
        kept = f"the checkpoint of step {result.saved_steps} is in {run.path}. Go on with: {again}"
        anew = f"{run.config.agent} keeps no checkpoint. Begin anew with: {again}"
        what = kept if run.entry.keeps_checkpoints else anew
        return complain(f"interrupted after {result.steps} of {total} steps; {what}", code=130)
    told = {"folder": str(run.path), "seconds": round(result.seconds, 3)}
    who = {"agent": run.config.agent, "agent_reason": run.config.agent_reason}
    lacked = {"shortcomings": list(result.shortcomings)}
    if result.agent is None:
        nothing = {**who, "steps": result.steps, "learned": None, **lacked}
        run.write_result(nothing)
        if json_:
            print(json.dumps(told | nothing, ensure_ascii=False, indent=2))
        return complain(f"nothing was learned in {result.steps} steps: {result.message}", code=1)
    verdict = judge_run(run, result.agent)
    if late:
        warn_of_shortfall(run.shortfall, run.task)
    values = {**who, "steps": result.steps, **verdict.to_dict(), **lacked}
    run.write_result(values)
    pictures = draw_run(run, result.agent, verdict.judge)
    if json_:
        print(json.dumps(told | values, ensure_ascii=False, indent=2))
    elif not quiet:
        print(f"{result.steps} steps in {result.seconds:.1f} s{result.message and f'; {result.message}'}")
        print_figures(verdict.lines(), headings(verdict))
        for shortcoming in result.shortcomings:
            print(f"Note: {shortcoming}")
        print(f"Pictures: {', '.join(map(str, pictures))}")
    return 0


def headings(verdict: Report) -> tuple[str, str]:
    """The columns of a report."""
    return ("learned", "optimal for the rewards") if verdict.exact else ("learned, with 95 % interval", "")
