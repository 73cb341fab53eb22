"""`ltlc train`: an agent learns a task."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ltlc.cli import flags, spec
from ltlc.cli import training_options as options
from ltlc.cli.diagnostics import tell
from ltlc.cli.messages import complain
from ltlc.cli.progress import training_display
from ltlc.cli.values import assignments, kinds_of
from ltlc.cli.verdicts import fitted_text, maximum_text, print_figures, warn_of_shortfall
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.agents.training.progress import TrainingResult
    from ltlc.agents.training.report import Report
    from ltlc.agents.training.run_config import RunConfig
    from ltlc.agents.training.run_folder import RunFolder
    from ltlc.automata import DRA
    from ltlc.envs.spec import EnvSpec

COMPARED_UP_TO = 20_000
"""product states; in larger ones the optimum of the rewards takes long, and is compared with what is possible last."""


# A parameter for each option makes it longer than functions are elsewhere.
def train(
    formula: options.Formula = None,
    env: spec.Env = None,
    labels: spec.Labels = None,
    variables: spec.Variables = None,
    robustness: spec.Robustness = None,
    env_set: spec.EnvArguments = None,
    episode_steps: spec.EpisodeSteps = None,
    initial_label: spec.InitialLabel = "read",
    discretise: spec.Discretise = None,
    reward: spec.Reward = None,
    set_: spec.Parameters = None,
    on_deadlock: spec.OnDeadlock = None,
    on_termination: spec.OnTermination = "repeat",
    finite: flags.Finite = False,
    goal: flags.Goal = "reach",
    exclusive: flags.Exclusive = None,
    acceptance: flags.Acceptance = "state",
    translator: flags.Translator = "auto",
    agent: options.Agent = "auto",
    hyper: options.Hyper = None,
    steps: options.Steps = None,
    num_envs: options.NumEnvs = None,
    workers: options.Workers = None,
    seed: options.Seed = 0,
    device: flags.Device = None,
    config: options.Config = "default",
    callback: options.Callback = None,
    out: options.Out = None,
    resume: options.Resume = False,
    force: options.Force = False,
    quiet: options.Quiet = False,
    json_: flags.Json = False,
) -> int:
    """Train an agent to satisfy a formula in an environment, and judge it.

    The run folder gets the configuration, metrics, the automaton, the policy,
    a verdict and pictures. Ctrl-C stops cleanly; --resume goes on from the last
    checkpoint.

    \b
    Examples:
      ltlc train "F(A & F B) & G !C" --env ltlc/Thesis10x10-v0
      ltlc train "F goal & G !hole" --env FrozenLake-v1 --labels lake:labels --reward zeta-discount
      ltlc train "F(A & F B)" --env ltlc/Thesis5x5-v0 --agent fu-topcu --hyper accuracy=0.05
      ltlc train --resume --out runs/f-a-f-b-g-c-thesis10x10-v0-0
    """
    from ltlc.agents.training.run_config import RunConfig, default_folder
    from ltlc.agents.training.run_folder import RunFolder
    from ltlc.rewards import RECOMMENDED

    memory = None
    if formula is None or env is None:
        if not resume or out is None:
            raise InvalidArgumentError("give a FORMULA and an environment (--env ID); or --resume with --out DIR")
        run = RunFolder.open(out, lock=True)
    else:
        env_spec = spec.env_spec_of(env, labels, env_set, episode_steps, initial_label, discretise, variables)
        automaton = spec.automaton_of(formula, env_spec, acceptance, translator, finite, goal, exclusive)
        reward = reward or ("thesis" if config == "thesis" else RECOMMENDED)
        frame = RunConfig(
            env_spec=env_spec,
            reward=reward,
            parameters=spec.parameters_of(set_, reward),
            on_deadlock=on_deadlock,
            on_termination=on_termination,
            workers=workers or 0,
        )
        _check_actions(frame.env_spec)
        hyper = spec.with_robustness(hyper, robustness, variables, agent)
        agent, reason = _chosen(agent, frame, automaton, hyper, config, device)
        device = None if reason and device == "cpu" else device  # where any agent will do, it need not have a device
        wanted, given = _with_agent(frame, agent, reason, hyper, steps, num_envs, seed, device, config)
        folder = Path(out) if out else default_folder(automaton.formula or "task", env, seed, wanted.agent)
        run, memory = _begun(folder, wanted, automaton, given, resume=resume, force=force)
    with run:
        if resume and device is not None:
            run.move_to(device)
        if resume and workers is not None:
            run.config = replace(run.config, workers=workers)
        return _train(run, resume, quiet or json_, json_, memory, _called(callback))


def _with_agent(
    frame: RunConfig,
    agent: str,
    reason: str | None,
    hyper: Sequence[str] | None,
    steps: int | None,
    num_envs: int | None,
    seed: int,
    device: str | None,
    preset: options.Preset,
) -> tuple[RunConfig, Collection[str]]:
    """A run with an agent, whose hyperparameters are those given, and else what the other options imply.

    Args:
        frame: the run with another agent.
        agent: its name.
        reason: why it is this one; None: somebody named it.
        hyper: hyperparameters as typed.
        steps: environment steps, or None.
        num_envs: environments stepped together, or None.
        seed: of everything random.
        device: of the networks, or None.
        preset: what double DQN starts from.

    Returns:
        The run, and the names of the hyperparameters that were given.
    """
    from ltlc.agents import registry
    from ltlc.agents.config import OffPolicyConfig
    from ltlc.agents.double_dqn.config import DQNConfig
    from ltlc.agents.training.run_config import num_envs_for

    defaults = registry.AGENTS[agent].defaults
    given = assignments(hyper, "--hyper", kinds_of(type(defaults)))
    if steps is not None and given.get("total_steps", steps) != steps:
        raise InvalidArgumentError(f"--steps is {steps}, and total_steps is {given['total_steps']}; give one of them")
    steps = steps or given.get("total_steps", defaults.total_steps)
    episode_steps = frame.env_spec.episode_steps
    if num_envs is None:
        num_envs = 1 if preset == "thesis" else num_envs_for(steps, episode_steps)
    # A checkpoint begins new episodes, so there must be time for whole ones between two.
    every = max(steps // 20, num_envs * episode_steps, 1)
    implied: dict[str, Any] = {"seed": seed, "total_steps": steps, "checkpoint_every": every}
    if isinstance(defaults, OffPolicyConfig):  # others plan anew at each row
        implied["log_every"] = max(steps // 100, 1)
    if preset == "thesis":
        if agent != registry.DOUBLE_DQN:
            raise InvalidArgumentError(f"--config {preset} is for the agent {registry.DOUBLE_DQN!r}, not for {agent!r}")
        implied = DQNConfig.thesis().to_dict() | implied
    config = registry.hyperparameters(agent, implied | given)
    wanted = replace(frame, num_envs=num_envs, agent=agent, agent_reason=reason, hyperparameters=config)
    return wanted if device is None else wanted.on_device(device), given


def _begun(
    folder: Path,
    wanted: RunConfig,
    automaton: DRA,
    given: Collection[str],
    *,
    resume: bool,
    force: bool,
) -> tuple[RunFolder, Any]:
    """The run in the folder, to go on with, or a new one; and the size of the memory of a new one, if it is large."""
    from ltlc.agents.training.run_folder import CONFIG_FILE, RunFolder

    there = (folder / CONFIG_FILE).exists()
    if not resume or not there:
        if resume:
            complain(f"warning: {folder} holds no run to go on with; a new one begins")
        elif there and not force:
            raise InvalidArgumentError(
                f"{folder} holds a training run; go on with it by --resume, replace it by --force, or give another "
                "folder with --out"
            )
        memory = RunFolder(folder, wanted, automaton).check(given)
        return RunFolder.create(folder, wanted, automaton, force=force), memory
    run = RunFolder.open(folder, lock=True)
    different = run.differs(wanted, automaton)
    if different:
        run.close()
        raise InvalidArgumentError(
            f"the run in {folder} differs in {', '.join(different)}; go on with it by ltlc train --resume --out "
            f"{folder}, or give another folder"
        )
    return run, None


def _check_actions(env_spec: EnvSpec) -> None:
    """Check that actions are discrete, or made so."""
    if env_spec.discretise is None and env_spec.continuous:
        raise InvalidArgumentError(
            f"the actions of {env_spec.env} are continuous; the agents choose from a list. Make one of 5 "
            "values of each coordinate by --discretise 5, or wrap the environment in ltlc.envs.DiscretisedActions"
        )


def _chosen(
    agent: str,
    frame: RunConfig,
    automaton: DRA,
    hyper: Sequence[str] | None,
    preset: options.Preset,
    device: str | None,
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


def _called(source: str | None) -> Callable[[Any], Any]:
    """The function that --callback names."""
    if source is None:
        return lambda progress: None
    from ltlc.registry import import_object

    function = import_object(source, "--callback")
    if not callable(function):
        raise InvalidArgumentError(f"--callback {source!r} is {function!r:.60}; it must be a function of the progress")
    return cast("Callable[[Any], Any]", function)


def _train(run: RunFolder, resume: bool, quiet: bool, json_: bool, memory: Any, called: Callable[[Any], Any]) -> int:
    """Train, judge and draw; the exit code."""
    total = run.config.hyperparameters.total_steps
    tell(run.automaton, run.config.env_spec, episodes=True)
    if not quiet:
        _print_run(run, memory)
    n_states = 0 if run.judge is None or not run.entry.uses_rewards else run.judge.rewards.n_states
    late = n_states > COMPARED_UP_TO
    if late:
        complain(f"note: with {n_states} product states, it is judged last what the rewards teach")
    else:
        warn_of_shortfall(run.shortfall, run.learned_task)
    with training_display(total, quiet=quiet, judge=run.judge) as display:
        result = run.train(resume=resume, callback=lambda now: (display(now), called(now))[1])
    if result.interrupted:
        again = spec.command_line("ltlc", "train", "--resume", "--out", str(run.path))
        kept = f"the checkpoint of step {result.saved_steps} is in {run.path}. Go on with: {again}"
        return complain(f"interrupted after {result.steps} of {total} steps; {kept}", code=130)
    return _conclude(run, result, quiet, json_, late)


def _print_run(run: RunFolder, memory: Any) -> None:
    print(f"{run.task.formula or 'an automaton without a formula'} in {run.config.env_spec.env}: {run.path}")
    if run.judge is not None:
        print(maximum_text(run.judge))
    if run.config.agent_reason is not None:
        print(f"Agent: {run.config.agent}, since {run.config.agent_reason}")
    if run.learned_task.scheme != run.task.scheme:
        print(f"Rewards: {fitted_text(run)}")
    if memory is not None:
        print(f"Replay: the last {memory.rows} steps, {memory.size_text}")


def _conclude(run: RunFolder, result: TrainingResult, quiet: bool, json_: bool, late: bool) -> int:
    """Judge and draw what was learned, and print it; the exit code."""
    from ltlc.agents.training.artifacts import draw_run, judge_run

    told = {"folder": str(run.path), "seconds": round(result.seconds, 3)}
    values: dict[str, Any] = {"agent": run.config.agent, "agent_reason": run.config.agent_reason, "steps": result.steps}
    values["rewards"] = str(run.learned_task.scheme)
    verdict = None if result.agent is None else judge_run(run, result.agent)
    if late and verdict is not None:
        warn_of_shortfall(run.shortfall, run.learned_task)
    values |= {"learned": None} if verdict is None else verdict.to_dict()
    values["shortcomings"] = list(result.shortcomings)
    run.write_result(values)
    pictures = [] if verdict is None else draw_run(run, result.agent, verdict.judge)
    if json_:
        print(json.dumps(told | values, ensure_ascii=False, indent=2))
    if verdict is None:
        return complain(f"nothing was learned in {result.steps} steps: {result.message}", code=1)
    if not quiet:
        print(f"{result.steps} steps in {result.seconds:.1f} s{result.message and f'; {result.message}'}")
        print_figures(verdict.lines(), headings(verdict))
        for shortcoming in result.shortcomings:
            print(f"Note: {shortcoming}")
        print(f"Pictures: {', '.join(map(str, pictures))}")
    return 0


def headings(verdict: Report) -> tuple[str, str]:
    """The columns of a report."""
    return ("learned", "optimal for the rewards") if verdict.exact else ("learned, with 95 % interval", "")
