"""`ltlc solve`: the exact answer, where the environment is known."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from ltlc.cli import flags, spec
from ltlc.cli.diagnostics import tell
from ltlc.cli.messages import complain
from ltlc.cli.options import Argument, Option
from ltlc.cli.verdicts import checks_of, maximum_text, print_checks, print_figures, warn_of_shortfall
from ltlc.errors import InvalidArgumentError

if TYPE_CHECKING:
    from ltlc.envs.spec import EnvSpec
    from ltlc.faithful import Shortfall
    from ltlc.mdp import Judge
    from ltlc.prism import Exported
    from ltlc.task import Task

Picture = Annotated[
    str | None,
    Option(
        "--output",
        "-o",
        metavar="FILE",
        is_path=True,
        help="Draw the policy that is optimal for the rewards.",
    ),
]


def solve(
    formula: Annotated[str, Argument(metavar="FORMULA", help="A formula, a .json or .hoa file, or -.")],
    env: spec.GivenEnv,
    labels: spec.Labels = None,
    variables: spec.Variables = None,
    env_set: spec.EnvArguments = None,
    initial_label: spec.InitialLabel = "read",
    reward: spec.Reward = None,
    set_: spec.Parameters = None,
    gamma: Annotated[
        float | None, Option("--gamma", metavar="X", help="Short for --set gamma=X.", shown_default="the scheme's")
    ] = None,
    on_deadlock: spec.OnDeadlock = None,
    on_termination: spec.OnTermination = "repeat",
    finite: flags.Finite = False,
    goal: flags.Goal = "reach",
    exclusive: flags.Exclusive = None,
    acceptance: flags.Acceptance = "state",
    translator: flags.Translator = "auto",
    output: Picture = None,
    prism: flags.Prism = None,
    json_: flags.Json = False,
) -> None:
    """Compute what is possible in a known environment, without learning.

    The largest probability of satisfying the formula, with proved bounds; the
    largest return of the rewards; and how probably a policy that is optimal
    for the rewards satisfies the formula. --prism writes the model, in PRISM's
    language and as explicit files, with the formula as a property.

    \b
    Examples:
      ltlc solve "F goal & G !hole" --env FrozenLake-v1 --labels lake:labels
      ltlc solve "F(A & F B) & G !C" --env ltlc/Thesis10x10-v0 --reward zeta-reach -o policy.png
      ltlc solve "!C U A" --env ltlc/Thesis10x10-v0 --prism check
    """
    from ltlc.faithful import shortfall
    from ltlc.mdp.figures import exact_lines
    from ltlc.mdp.verdict import Judge
    from ltlc.rewards import RECOMMENDED, get_scheme
    from ltlc.task import Task

    reward = reward or RECOMMENDED
    parameters = spec.parameters_of(set_, reward) | ({} if gamma is None else {"gamma": gamma})
    scheme = get_scheme(reward, **parameters)
    env_spec = spec.env_spec_of(env, labels, env_set, initial_label=initial_label, variables=variables)
    automaton = spec.automaton_of(formula, env_spec, acceptance, translator, finite, goal, exclusive)
    task = Task(automaton, scheme, on_deadlock=on_deadlock, on_termination=on_termination)
    if env_spec.model is None:
        raise InvalidArgumentError(
            f"{env_spec.why_no_model}; train an agent with ltlc train, and judge it by episodes with ltlc evaluate"
        )
    tell(task.automaton, env_spec)
    judge = Judge(env_spec.model, task, initial_label=initial_label)
    found = shortfall(judge, task)
    warn_of_shortfall(found, task)
    if output is not None:
        _draw(Path(output), env_spec, task, judge, reward)
    exported = None if prism is None else _export(prism, env_spec, task)
    if json_:
        print(json.dumps(_values(judge, found) | checks_of(exported), ensure_ascii=False, indent=2))
        return
    print(f"{task.formula or 'an automaton without a formula'} in {env}: {judge.rewards.n_states} product states")
    print(maximum_text(judge))
    if exported is not None:
        print_checks(exported, judge.maximum.probability)
    if judge.optimum is None:
        complain(f"warning: the rewards {reward!r} can be collected for ever without a discount: no optimal return")
        return
    print_figures(exact_lines(judge.optimum, None), (f"optimal for the rewards '{reward}'", ""))
    if output is not None:
        print(f"The policy is in {output}.")


def _export(folder: str, env_spec: EnvSpec, task: Task) -> Exported:
    from ltlc.automata import DFA
    from ltlc.ltl import parse
    from ltlc.prism import export_checkable

    if task.formula is None or env_spec.model is None or task.automaton.translator == DFA.translator:
        raise InvalidArgumentError("--prism: the automaton has no formula that another program could check")
    return export_checkable(env_spec.model, parse(task.formula), folder, "model", initial_label=env_spec.initial_label)


def _values(judge: Judge, found: Shortfall | None) -> dict[str, Any]:
    """The answer as JSON values; infinities as text."""
    from ltlc.mdp.figures import verdict_values

    optimum = None if judge.optimum is None else verdict_values(judge.optimum)
    maximum = judge.maximum
    return {
        "maximum_satisfaction": [maximum.lower, maximum.probability, maximum.upper],
        "optimal": optimum,
        "shortfall": None if found is None else found.to_dict(),
        "product_states": judge.rewards.n_states,
    }


def _draw(path: Path, env_spec: EnvSpec, task: Task, judge: Judge, reward: str) -> None:
    from ltlc.pictures.policy import draw_policy

    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InvalidArgumentError(f"{path}: the suffix must be .png, .svg or .pdf")
    board = env_spec.board
    if board is None or judge.optimal_policy is None:
        raise InvalidArgumentError(f"{env_spec.env} has no map to draw a policy on; leave -o out")
    draw_policy(
        path,
        board,
        judge.optimal_policy,
        task.automaton,
        task.tables,
        title=task.formula or "policy",
        subtitle=f"optimal in {env_spec.env} for the rewards '{reward}'",
        reached=judge.reached,
        classes=judge.letter_classes,
    )
