"""Pictures of what was learned: the policy on the map (thesis, figures 5.2 and 5.3)."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ltlc.automata import DRA, guard_text
from ltlc.board import DIRECTIONS, Board
from ltlc.errors import InvalidArgumentError
from ltlc.pictures.plotting import ARROW, FAINT, INK, LINES, NEVER, PAPER, RULE, WALL, blank, saved
from ltlc.rewards import RewardTables

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

IntArray = npt.NDArray[np.integer[Any]]
BoolArray = npt.NDArray[np.bool_]

MAX_PANELS = 16


def draw_policy(
    path: str | os.PathLike[str],
    board: Board,
    policy: IntArray,
    automaton: DRA,
    tables: RewardTables,
    *,
    title: str,
    subtitle: str = "",
    reached: BoolArray | None = None,
    classes: IntArray | None = None,
) -> Path:
    """Draw a policy: a panel for each automaton state in which there is something to decide.

    Args:
        path: a .png, .svg or .pdf file.
        board: the map.
        policy: action for each cell and table state, shape (n_cells, n_table_states).
        automaton: of the task, for what each state waits for.
        tables: of the rewards.
        title: the heading.
        subtitle: a line below it.
        reached: cells and states that can be visited at all, same shape; the others are drawn grey. None: all.
        classes: letter classes that can occur on the map; None: all.

    Returns:
        The path that was written.

    Raises:
        InvalidArgumentError: the board has not one cell for each state of the policy, or not one action for each.
        OSError: the file cannot be written.
    """
    if len(board.cells) != len(policy):
        raise InvalidArgumentError(f"a board of {len(board.cells)} cells cannot show a policy on {len(policy)} states")
    waiting = waits_for(automaton, np.arange(automaton.n_classes) if classes is None else classes)
    seen = np.ones(policy.shape, dtype=np.bool_) if reached is None else reached
    states = [q for q in range(policy.shape[1]) if seen[:, q].any()][:MAX_PANELS]
    n_columns = min(len(states), 4 if len(states) > 6 or len(states) == 4 else 3)
    n_rows = -(-len(states) // n_columns)
    rows, columns = board.rows, board.columns
    cell = 0.34 if max(rows, columns) > 6 else 0.56
    width, height = columns * cell, rows * cell
    above, below, gap, panel_title = 0.8 if subtitle else 0.55, 0.75, 0.3, 0.48
    size = (
        max(n_columns * width + (n_columns + 1) * gap, 5.2),
        n_rows * (height + panel_title) + above + below,
    )
    figure = blank(*size)
    left = gap
    free = np.array([character == "." for character in board.cells])
    never = bool((~seen[free][:, states]).any())
    for i, state in enumerate(states):
        row, column = divmod(i, n_columns)
        bottom = size[1] - above - (row + 1) * (height + panel_title)
        x = left + column * (width + gap)
        axes = figure.add_axes((x / size[0], bottom / size[1], width / size[0], height / size[1]))
        _panel(axes, board, policy[:, state], seen[:, state], cell)
        own = int(tables.automaton_state[state])
        name = f"q{own}" if tables.n_states == automaton.n_states else f"q{own} ({state})"
        waits = _shortened(waiting[own], int(width * 13))
        axes.text(0, -0.27 / cell, name, fontsize=11, fontweight="bold", color=INK, va="center")
        axes.text(0, -0.1 / cell, waits, fontsize=8, color=FAINT, va="center")
    figure.text(left / size[0], 1 - 0.32 / size[1], title, fontsize=13, color=INK, va="center", fontweight="bold")
    if subtitle:
        figure.text(left / size[0], 1 - 0.62 / size[1], subtitle, fontsize=9, color=FAINT, va="center")
    _legend(figure, board, left, size, never)
    return saved(figure, path)


def waits_for(automaton: DRA, classes: IntArray) -> list[str]:
    """For each state the letters that lead on towards the next accepting step, as a guard; else what the state is.

    Args:
        automaton: the automaton.
        classes: letter classes that can occur; the shortest way uses no others.
    """
    delta = automaton.delta
    possible = np.isin(np.arange(automaton.n_classes), classes)
    on_cycle = _restricted(automaton, classes).annotations.distance == 0
    marked = automaton.edge_inf.any(axis=0) & on_cycle[:, None] & on_cycle[delta]
    steps = np.where((marked & possible).any(axis=1), 1, automaton.n_states + 2)
    for _ in range(automaton.n_states):
        steps = np.minimum(steps, 1 + np.where(possible, steps[delta], automaton.n_states + 1).min(axis=1))
    texts = []
    for state in range(automaton.n_states):
        onward = marked[state] if steps[state] == 1 else steps[delta[state]] < steps[state]
        if automaton.annotations.distance[state] < 0:
            texts.append("violated")
        elif onward.all():
            texts.append("accepting")
        elif steps[state] > automaton.n_states:
            texts.append("cannot accept here")
        else:
            texts.append(f"waits for {guard_text(automaton, np.flatnonzero(onward).tolist())}")
    return texts


def _restricted(automaton: DRA, classes: IntArray) -> DRA:
    """The automaton on some letter classes; what it does on other letters means nothing."""
    number = np.zeros(automaton.n_classes, dtype=np.int32)
    number[classes] = np.arange(len(classes))
    fin, inf = automaton.fin, automaton.inf
    if automaton.acceptance == "transition":
        fin, inf = fin[:, :, classes], inf[:, :, classes]
    letter_class = number[automaton.letter_class]
    return replace(automaton, delta=automaton.delta[:, classes], letter_class=letter_class, fin=fin, inf=inf)


def _panel(axes: Axes, board: Board, actions: IntArray, seen: BoolArray, size: float) -> None:
    from matplotlib.patches import FancyArrowPatch, Rectangle

    rows, columns = board.rows, board.columns
    axes.set(xlim=(-0.02, columns + 0.02), ylim=(rows + 0.02, -0.02), aspect="equal")
    axes.axis("off")
    tint = board.tints
    for cell, character in enumerate(board.cells):
        row, column = divmod(cell, columns)
        face = WALL if character == "#" else tint.get(character, PAPER if seen[cell] else NEVER)
        axes.add_patch(Rectangle((column, row), 1, 1, facecolor=face, edgecolor=RULE, linewidth=0.7))
        if character == "#":
            continue
        marked = character in tint
        if marked:
            axes.text(
                column + 0.09, row + 0.29, character, fontsize=size * 17, color=INK, va="center", fontweight="bold"
            )
        if not seen[cell] or cell in board.final:
            continue
        dx, dy = DIRECTIONS[board.actions[int(actions[cell]) % len(board.actions)]]  # whatever pair it chooses
        x, y = column + (0.58 if marked else 0.5), row + (0.58 if marked else 0.5)
        if dx == dy == 0:
            axes.plot(x, y, "o", color=ARROW, markersize=size * 9, zorder=3)
            continue
        reach = 0.28 if marked else 0.34
        arrow = FancyArrowPatch(
            (x - dx * reach, y - dy * reach),
            (x + dx * reach, y + dy * reach),
            arrowstyle="-|>,head_length=0.38,head_width=0.22",
            mutation_scale=size * 27,
            linewidth=size * 3.4,
            color=ARROW,
            shrinkA=0,
            shrinkB=0,
            zorder=3,
        )
        axes.add_patch(arrow)
    row, column = divmod(board.start, columns)
    axes.add_patch(
        Rectangle(
            (column + 0.06, row + 0.06), 0.88, 0.88, fill=False, edgecolor=LINES[1], linewidth=size * 4.5, zorder=2
        )
    )
    axes.add_patch(Rectangle((0, 0), columns, rows, fill=False, edgecolor=FAINT, linewidth=0.8, zorder=4))


def _legend(figure: Figure, board: Board, left: float, size: tuple[float, float], some_never: bool) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    entries: list[tuple[Any, str]] = [
        (
            Patch(facecolor=colour, edgecolor=RULE),
            meaning if meaning.startswith(character) else f"{character}: {meaning}",
        )
        for character, colour in board.tints.items()
        for meaning in [board.meaning.get(character, character)]
    ]
    entries.append((Patch(facecolor=PAPER, edgecolor=LINES[1], linewidth=1.5), "start"))
    if "NONE" in board.actions:
        entries.append((Line2D([], [], marker="o", linestyle="", color=ARROW, markersize=4), "stay"))
    if some_never:
        entries.append((Patch(facecolor=NEVER, edgecolor=RULE), "never reached"))
    widths = [0.42 + 0.075 * len(text) for _, text in entries]
    room = size[0] - left
    per_row = len(entries) if sum(widths) <= room else max(1, int(room / max(widths)))
    figure.legend(
        [handle for handle, _ in entries],
        [text for _, text in entries],
        loc="center left",
        bbox_to_anchor=(left / size[0], 0.36 / size[1]),
        borderaxespad=0,
        ncols=per_row,
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handlelength=1.1,
        handleheight=1.1,
        columnspacing=1.4,
        borderpad=0,
    )


def _shortened(text: str, limit: int) -> str:
    return text if len(text) <= limit else f"{text[: limit - 1]}…"
