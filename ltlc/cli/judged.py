"""`ltlc evaluate --policy`: the verdict on a policy that was learned elsewhere."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ltlc.cli import spec
from ltlc.cli.verdicts import checks_of, maximum_text, print_checks, print_figures
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.envs.spec import EnvSpec


def print_judgement(
    source: str,
    policy: str,
    env_spec: EnvSpec,
    reward: str | None,
    parameters: list[str] | None,
    prism: str | None,
    as_json: bool,
    how: Mapping[str, Any],
) -> None:
    """Judge a policy and print the verdict.

    Args:
        source: the formula, or a file with an automaton.
        policy: `module:name`, or the zip file of a model.
        env_spec: where.
        reward: name of the scheme that the policy was learned with.
        parameters: of the scheme, as texts.
        prism: folder for the Markov chain.
        as_json: whether to print JSON.
        how: further arguments of `ltlc.judge`.
    """
    from ltlc.envs.comparisons import Variables
    from ltlc.judging import judge
    from ltlc.mdp.figures import exact_lines
    from ltlc.rewards import RECOMMENDED, get_scheme
    from ltlc.task import Task

    name = reward or RECOMMENDED
    task = Task(spec.automaton_of(source, env_spec), get_scheme(name, **spec.parameters_of(parameters, name)))
    labels = env_spec.label_source
    if isinstance(labels, Variables):
        labels = labels.labels(task.aps)
    found = judge(_loaded(policy), env_spec.single, task, labels=labels, max_steps=env_spec.episode_steps, **how)
    exported = None if prism is None else found.export(prism)
    if as_json:
        print(json.dumps(found.to_dict() | checks_of(exported), ensure_ascii=False, indent=2))
        return
    print(f"{policy} {found}." if found.exact else f"{policy} {found}; sampled, because {found.why_sampled}.")
    if found.judge is not None and found.verdict is not None:
        print(maximum_text(found.judge))
        print_figures(exact_lines(found.verdict, found.judge.optimum), ("the policy", f"optimal for '{name}'"))
    if exported is not None:
        print_checks(exported, found.satisfaction)


def _loaded(policy: str) -> Any:
    if policy.endswith(".zip"):
        from ltlc.bridges.stable_baselines3 import load_model

        return load_model(policy)
    if ":" not in policy:
        raise InvalidArgumentError(
            f"--policy {policy!r}: expected module:name, such as mine:act for what mine.py calls act, or the .zip of a "
            "model of Stable-Baselines3"
        )
    from ltlc.registry import import_object

    return import_object(policy, "--policy")
