"""`ltlc evaluate`: what a training run has learned."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated

from ltlc.cli import completion, flags, spec
from ltlc.cli.judged import print_judgement
from ltlc.cli.options import Argument, Option
from ltlc.cli.train import headings
from ltlc.cli.verdicts import checks_of, fitted_text, maximum_text, print_checks, print_figures, warn_of_shortfall
from ltlc.errors import InvalidArgumentError

Run = Annotated[
    str,
    Argument(
        metavar="RUN",
        is_path=True,
        help="A run folder, as 'ltlc train' makes it; with --policy, a formula, a .json or .hoa file, or -.",
    ),
]
Policy = Annotated[
    str | None,
    Option(
        "--policy",
        metavar="MODULE:NAME",
        help="A policy learned elsewhere: a function of the observation, a network of PyTorch, a model with "
        "predict, a table; or the .zip of a model of Stable-Baselines3, if you trust it: loading can run any code.",
    ),
]


def evaluate(
    run: Run,
    policy: Policy = None,
    env: Annotated[
        str | None,
        Option(
            "--env",
            "-e",
            metavar="ID",
            help="Of --policy: the environment that it acts in.",
            completion=completion.environments,
        ),
    ] = None,
    labels: spec.Labels = None,
    variables: spec.Variables = None,
    env_set: spec.EnvArguments = None,
    reward: spec.Reward = None,
    set_: spec.Parameters = None,
    episodes: Annotated[
        int, Option("--episodes", "-n", metavar="N", help="Episodes to sample where nothing exact is possible.")
    ] = 100,
    precision: Annotated[
        float, Option("--precision", metavar="X", help="Of --policy: stop where the interval is so narrow.")
    ] = 0.0,
    seed: Annotated[int, Option("--seed", least=0, metavar="N", help="Of the sampling.")] = 0,
    prism: flags.Prism = None,
    json_: flags.Json = False,
) -> None:
    """Judge what was learned: exactly where the environment is known, else by episodes.

    Known are grid worlds and environments with a transition table, such as
    FrozenLake. There, the learned policy is shown beside the best one, and
    --prism writes its Markov chain, so that PRISM or Storm can check it again.
    With --policy, what is judged was learned elsewhere; a function is given
    {"observation": ..., "automaton": ...} and returns an action.

    \b
    Examples:
      ltlc evaluate runs/f-goal-g-hole-frozenlake-v1-0
      ltlc evaluate runs/f-goal-g-hole-frozenlake-v1-0 --prism chain
      ltlc evaluate runs/balance --episodes 1000 --json
      ltlc evaluate "F goal & G !hole" --env FrozenLake-v1 --labels lake:labels --policy mine:act
    """
    if episodes < 2:
        raise InvalidArgumentError(f"--episodes is {episodes}; at least 2 are needed for an interval")
    if policy is not None:
        if env is None:
            raise InvalidArgumentError("--policy needs --env, the environment that it acts in")
        env_spec = spec.env_spec_of(env, labels, env_set, variables=variables)
        how = {"episodes": episodes, "precision": precision, "seed": seed}
        print_judgement(run, policy, env_spec, reward, set_, prism, json_, how)
        return
    _refuse({"--env": env, "--labels": labels, "--variables": variables, "--reward": reward, "--set": set_})
    from ltlc.agents.training.artifacts import export_run, judge_run
    from ltlc.agents.training.run_folder import RunFolder

    folder = RunFolder.open(run)
    agent = folder.load()
    exported = None if prism is None else export_run(folder, agent, prism)
    verdict = judge_run(folder, agent, episodes=episodes, seed=seed)
    warn_of_shortfall(verdict.shortfall, folder.learned_task)
    if json_:
        print(json.dumps(verdict.to_dict() | checks_of(exported), ensure_ascii=False, indent=2))
        return
    print(f"{folder.task.formula or 'an automaton without a formula'} in {folder.config.env_spec.env}")
    if verdict.judge is not None:
        print(maximum_text(verdict.judge))
    if folder.learned_task.scheme != folder.task.scheme:
        print(f"Rewards: {fitted_text(folder)}")
    print_figures(verdict.lines(), headings(verdict))
    if verdict.regret is not None:
        print(f"Lost against the optimum: {max(verdict.regret, 0.0):.2%} of the discounted return.")
    if exported is not None and verdict.verdict is not None:
        print_checks(exported, verdict.verdict.satisfaction)


def _refuse(given: Mapping[str, object]) -> None:
    """Refuse options that a run has decided already."""
    for option, value in given.items():
        if value is not None:
            raise InvalidArgumentError(f"{option} goes with --policy; a run folder says itself what was learned where")
