"""The report of a training run, put together from what its folder holds."""

from __future__ import annotations

import base64
import json
import os
import re
from collections.abc import Mapping
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ltlc.agents.agent import Agent
from ltlc.agents.training.artifacts import judge_run
from ltlc.agents.training.failed_episodes import FailedEpisodes
from ltlc.agents.training.report import Report, tabular_policy
from ltlc.agents.training.run_folder import REPORT_FILE, TRAJECTORIES_PICTURE, RunFolder
from ltlc.atomic import atomic_write
from ltlc.automata import DRA
from ltlc.board import Board
from ltlc.errors import LtlcError, MissingProgramError
from ltlc.formats.dot import to_dot
from ltlc.formats.picture import draw
from ltlc.judging.reasons import Reasons
from ltlc.ltl import parse, to_english
from ltlc.mdp import expected_return_within
from ltlc.mdp.figures import figure_text
from ltlc.pictures.policy import MAX_PANELS, waits_for
from ltlc.reports.episode import episode_of
from ltlc.reports.failing import ways_on_map, why_of_run
from ltlc.reports.svg import curve, policy_on_board, ways_on_board

MOST_WAYS = 8
"""ways to fail that are drawn: as many as are told."""


def report_of_run(
    folder: str | os.PathLike[str], path: str | os.PathLike[str] | None = None, *, episodes: int = 100, seed: int = 0
) -> Path:
    """Write a page about a run: one HTML file that needs no network.

    It shows the verdict, the automaton, the learning curve, the policy in each automaton state (on environments with a
    map) or trajectories, why runs fail, on the map where there is one, and an episode to step through.

    Args:
        folder: of the run.
        path: of the page; None: `report.html` in the folder.
        episodes: to sample where nothing exact is possible.
        seed: of the sampling and of the episode that is shown.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: there is no run in the folder, or it has learned nothing yet.
        FileFormatError: one of its files is damaged.
        OSError: the page cannot be written.
    """
    run = RunFolder.open(folder)
    agent = run.load()
    report = judge_run(run, agent, episodes=episodes, seed=seed)
    board = run.config.env_spec.board if report.judge is not None else None
    task = run.learned_task
    steps = episode_of(run, agent, board, seed)
    data = {"episode": steps, "start": run.automaton.initial_state}
    spec, n_pairs = run.config.env_spec, run.automaton.n_pairs
    about = {
        "environment": spec.env,
        "labels": spec.labels,
        "agent": run.config.agent,
        "rewards": str(task.scheme),
        "automaton": f"{run.automaton.n_states} states" + (f", {n_pairs} pairs" if n_pairs != 1 else ", one pair"),
        "steps": str(max((int(row["steps"] or 0) for row in run.metrics()), default=0)),
        "seed": str(run.config.hyperparameters.to_dict().get("seed", "")),
        "run": run.id,
    }
    parts = {
        "title": escape(run.task.formula or "a task without a formula"),
        "english": escape(_in_english(run.task.formula)),
        "headline": _headline(report),
        "warning": "" if report.shortfall is None else f'<p class="warning">{escape(report.shortfall.text)}</p>',
        "verdict": _table(report),
        "about": "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in about.items() if value),
        "automaton": _automaton(run.automaton),
        "curve": _curve(run, report),
        "policy": _policy(run, agent, report),
        "reasons": _reasons(why_of_run(run, agent, episodes=episodes, seed=seed), board),
        "data": _json(data),
    }
    template = (resources.files("ltlc.reports") / "report.html").read_text(encoding="utf-8")
    page = re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], template)
    return atomic_write(Path(path) if path is not None else run.path / REPORT_FILE, page)


def _json(values: Any) -> str:
    """JSON that may stand in a script element: no text in it ends the element or begins a comment."""
    text = json.dumps(values, ensure_ascii=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _in_english(formula: str | None) -> str:
    if formula is None:
        return ""
    try:
        return to_english(parse(formula))
    except LtlcError:  # an automaton can carry any text as its formula
        return ""


def _headline(report: Report) -> str:
    if report.verdict is None or report.judge is None:
        assert report.rollouts is not None
        seen = report.rollouts.satisfied
        return (
            f'<p class="headline"><b>{seen.value:.3g}</b> of {seen.n} episodes have an accepting step and no violation '
            f"<small>({seen.confidence:.0%} interval {seen.low:.3g} to {seen.high:.3g})</small></p>"
        )
    best = report.judge.maximum
    value = figure_text(report.verdict.satisfaction, report.verdict.satisfaction_bounds)
    most = figure_text(best.probability, (best.lower, best.upper))
    low, high = report.verdict.satisfaction_bounds
    proved = "exact" if low == high else f"exact: proved between {low:.14g} and {high:.14g}"
    return (
        f'<p class="headline"><b>{value}</b> is the probability that the learned policy satisfies the formula; the '
        f"largest possible is <b>{most}</b> <small>({proved})</small></p>"
    )


def _table(report: Report) -> str:
    lines = report.lines()
    compared = any(line.optimum is not None for line in lines)
    head = "<tr><th></th><th>learned</th>" + ("<th>optimal for the rewards</th></tr>" if compared else "</tr>")
    rows = []
    for line in lines:
        if isinstance(line.learned, float | int):
            cells = [figure_text(line.learned, line.learned_bounds)]
        else:
            cells = [f"{line.learned.value:.4g} [{line.learned.low:.4g}, {line.learned.high:.4g}]"]
        if compared:
            cells.append("" if line.optimum is None else figure_text(line.optimum, line.optimum_bounds))
        rows.append(f"<tr><th>{escape(line.title)}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>")
    return f"<table>{head}{''.join(rows)}</table>"


def _automaton(automaton: DRA) -> str:
    """The drawing, or its source where nothing draws here."""
    try:
        svg = draw(to_dot(automaton), "svg").decode("utf-8")
    except MissingProgramError:
        source = escape(to_dot(automaton))
        return f"<p>Nothing that draws automata is installed; this is the source for Graphviz.</p><pre>{source}</pre>"
    body = svg[svg.index("<svg") :]
    size = re.match(r'<svg[^>]*width="([\d.]+)pt"', body)
    wide = f' style="--width:{float(size[1]) * 4 / 3:.0f}px"' if size else ""
    return f'<div class="drawing"{wide}>{body}</div>'


def _curve(run: RunFolder, report: Report) -> str:
    rows = run.metrics()
    sampled = any(row.get("episode_return") is not None for row in rows)
    column = "episode_return" if sampled else "discounted_return"
    rows = [row for row in rows if row.get(column) is not None]
    if not rows:
        return "<p>No returns were recorded.</p>"
    best, judge = None, report.judge
    if judge is not None and not sampled:
        best = judge.value
    elif judge is not None and judge.optimal_policy is not None:
        lifted = judge.rewards.lift(judge.optimal_policy)
        best = expected_return_within(judge.rewards, lifted, run.config.env_spec.episode_steps)
    planned = len(rows) > 1 and len({row["steps"] for row in rows}) == 1
    axis, label = ("seconds", "seconds of planning") if planned else ("steps", "environment steps")
    x, y = (np.array([row[key] for row in rows], dtype=np.float64) for key in (axis, column))
    what = "return of an episode, with exploration" if sampled else "expected return, discounted, of the policy so far"
    legend = f"{what}" + ("" if best is None else "; dashed: the best possible for the rewards")
    return f"<figure>{curve(x, y, best, label, what)}<figcaption>{escape(legend)}</figcaption></figure>"


def _policy(run: RunFolder, agent: Agent, report: Report) -> str:
    board, judge = run.config.env_spec.board, report.judge
    if board is None or judge is None:
        return _trajectories(run.path / TRAJECTORIES_PICTURE)
    table = tabular_policy(agent, judge.rewards.mdp)
    table = table if table.ndim == 2 else table.argmax(axis=2)
    tables, reached = run.learned_task.tables, judge.reached
    waiting = waits_for(run.automaton, judge.letter_classes)
    panels = []
    for state in [q for q in range(table.shape[1]) if reached[:, q].any()][:MAX_PANELS]:
        own = int(tables.automaton_state[state])
        name = f"q{own}" if tables.n_states == run.automaton.n_states else f"q{own} ({state})"
        drawn = policy_on_board(board, table[:, state].tolist(), reached[:, state].tolist())
        panels.append(
            f'<figure class="panel" data-state="{state}">{drawn}'
            f"<figcaption><b>{name}</b> {escape(waiting[own])}</figcaption></figure>"
        )
    signs = "".join(_sign(character, colour, board.meaning) for character, colour in board.tints.items())
    return f'<div class="panels">{"".join(panels)}</div><p class="signs">{signs}</p>'


def _sign(character: str, colour: str, meaning: Mapping[str, str]) -> str:
    text = meaning.get(character, character)
    shown = text if text.startswith(character) else f"{character}: {text}"
    return f'<span><i style="background:{escape(colour)}"></i>{escape(shown)}</span>'


def _reasons(found: Reasons | FailedEpisodes, board: Board | None) -> str:
    """The lines of `ltlc explain RUN`: those that are indented are a list."""
    parts, inside = [], False
    for line in found.lines():
        if line.startswith("  ") != inside:
            inside = not inside
            parts.append("<ul>" if inside else "</ul>")
        kind = "li" if inside else "p"
        parts.append(f"<{kind}>{escape(line.strip().replace(' -> ', ' → '))}</{kind}>")
    text = "".join(parts) + "</ul>" * inside
    if board is None or not isinstance(found, Reasons) or found.failure.loss <= 0:
        return text
    drawn = ways_on_board(board, ways_on_map(found)[:MOST_WAYS])
    legend = "ways to fail, the thicker the more probable; a cross is where a run is lost"
    return f'<div class="two"><div>{text}</div><figure>{drawn}<figcaption>{legend}</figcaption></figure></div>'


def _trajectories(picture: Path) -> str:
    if not picture.is_file():
        return "<p>This environment has no map and no scene to draw on; see the episode below.</p>"
    encoded = base64.b64encode(picture.read_bytes()).decode("ascii")
    return f'<img class="picture" alt="trajectories of the learned policy" src="data:image/png;base64,{encoded}">'
