"""The automaton as a Graphviz drawing.

What a reader should see without looking for it: where a run starts (a bold arrow from nowhere), where it is lost (a
grey octagon with a cross), where it has won (a green double ring with a tick), and which pair a mark belongs to. A
mark is a badge: `+i` on a filled ground for inf, `−i` in a frame for fin of pair i, so that a print in black and white
says the same as the colours do.
"""

from __future__ import annotations

from html import escape

from ltlc.automata.finite import DFA
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time
from ltlc.formats.edges import LabelledEdge, arrows, hidden_states, state_marks

PAIR_COLORS = ("#0068a8", "#c44e00", "#7b3f9e", "#8f6a00", "#b02a5b", "#2f6f6f")
"""Dark enough for white text, told apart with the common kinds of colour blindness; pair 6 starts again."""

_PAIR_TINTS = ("#e3eff7", "#fbeadf", "#efe6f4", "#f6efd9", "#f8e4ec", "#e2efef")
_INK = "#24292f"
_FAINT = "#8a9099"
_FAINT_INK = "#57606a"
FONT = "Helvetica,Arial,sans-serif"
_GUARD_WIDTH = 28
_NARROW_GUARD_WIDTH = 18
_TITLE_WIDTH = 90
_MAX_STATES_SIDEWAYS = 12
_LONG_NAME = 4


def to_dot(automaton: DRA | DFA, *, hide_deadlock: bool = False) -> str:
    """The automaton in the DOT language, with its formula as title and a legend.

    Args:
        automaton: the automaton.
        hide_deadlock: leave out the states from which nothing is accepted and the edges to them, which the legend
            then says; the initial state is always shown.
    """
    return _Drawing(automaton, hide_deadlock).text()


class _Drawing:
    def __init__(self, automaton: DRA | DFA, hide_deadlock: bool) -> None:
        self.automaton = automaton
        self.hidden = hidden_states(automaton, hide_deadlock)
        # A pair whose inf is everywhere asks for fin alone, and is drawn so.
        self.fin_only = {i for i, marks in enumerate(automaton.inf) if marks.all()}
        self.n_shown = automaton.n_states - len(self.hidden)

    def text(self) -> str:
        automaton = self.automaton
        sideways = self.n_shown <= _MAX_STATES_SIDEWAYS
        on_states = automaton.acceptance == "state" and bool(automaton.n_pairs)
        lines = [
            "digraph automaton {",
            f"  graph [rankdir={'LR' if sideways else 'TB'}, nodesep=0.3, ranksep=0.5, pad=0.2, bgcolor=white,",
            f'         concentrate=false, labelloc=t, fontname="{FONT}", fontcolor="{_INK}",',
            f"         label=<{self._heading()}>]",
            f"  node [shape=circle, width={0.72 if on_states else 0.5}, margin=0.03, style=filled, fillcolor=white,",
            f'        color="{_INK}", penwidth=1.2, fontname="{FONT}", fontcolor="{_INK}", fontsize=13]',
            f'  edge [color="{_INK}", penwidth=1.1, arrowsize=0.7,',
            f'        fontname="{FONT}", fontcolor="{_INK}", fontsize=11]',
            '  start [shape=point, style=invis, width=0.01, height=0.01, label=""]',
            *(self._node(q) for q in range(automaton.n_states) if q not in self.hidden),
            f"  start -> {automaton.initial_state} [penwidth=2.2, arrowsize=0.9]",
            *self._edges(),
            "}",
        ]
        return "\n".join(lines) + "\n"

    def _node(self, q: int) -> str:
        automaton = self.automaton
        name = str(q) if automaton.state_names is None else automaton.state_names[q]
        fin, inf = state_marks(automaton, q)
        badges = self._badges(fin, inf)
        text, style = _printable(name), ""
        if q in automaton.deadlocks:
            text += " ✗"
            style = ', shape=octagon, fillcolor="#dcdcdc", color="#8c1c13", fontcolor="#8c1c13"'
        elif q in automaton.accepting_sinks:
            text += " ✓"
            style = ', shape=doublecircle, fillcolor="#d9f0dc", color="#1b7a35", fontcolor="#125a26"'
        elif len(name) > _LONG_NAME:
            style = ', shape=box, style="filled,rounded"'
        if not style and (wanted := [i for i in inf if i not in self.fin_only]):
            style = f', fillcolor="{_PAIR_TINTS[wanted[0] % len(_PAIR_TINTS)]}"'
        label = _html(f"<TR><TD>{text}</TD></TR><TR><TD>{_html_table(badges)}</TD></TR>") if badges else f"<{text}>"
        return f"  {q} [label={label}{style}]"

    def _edges(self) -> list[str]:
        """One arrow from a state to another, with a row per set of marks: parallel arrows would hide each other."""
        width = _GUARD_WIDTH if self.n_shown <= _MAX_STATES_SIDEWAYS else _NARROW_GUARD_WIDTH
        result = []
        for (source, target), parallel in arrows(self.automaton, self.hidden).items():
            check_time()
            rows = ""
            for edge in parallel:
                badges = self._badges(edge.fin, edge.inf)
                rows += f"<TR><TD>{_lines(edge.guard, width)}</TD>{_beside(badges)}</TR>"
            result.append(f"  {source} -> {target} [label={_html(rows)}{self._stroke(target, parallel)}]")
        return result

    def _stroke(self, target: int, parallel: list[LabelledEdge]) -> str:
        shown = {tuple(i for i in edge.inf if i not in self.fin_only) for edge in parallel}
        if target in self.automaton.deadlocks:
            return f', color="{_FAINT}", fontcolor="{_FAINT}", penwidth=0.8'
        if len(shown) == 1 and (inf := shown.pop()):
            return f', color="{_color(inf[0])}", penwidth=2'
        return ""

    def _badges(self, fin: tuple[int, ...], inf: tuple[int, ...]) -> list[str]:
        return [_badge(i, filled=True) for i in inf if i not in self.fin_only] + [_badge(i, filled=False) for i in fin]

    def _heading(self) -> str:
        """The formula, below it what the signs mean.

        Both are the label of the whole graph, and text only: labels of clusters collide with edges, and tables are
        stretched to the width of the longest line.
        """
        # What stands around a large drawing has to be read at the same distance as the whole of it.
        scale = min(4.0, max(1.0, (self.n_shown / _MAX_STATES_SIDEWAYS) ** 0.75))
        formula = self.automaton.formula
        kind = "automaton over finite traces" if isinstance(self.automaton, DFA) else "deterministic Rabin automaton"
        title = _lines(kind if formula is None else formula, _TITLE_WIDTH)
        legend = (f'<FONT COLOR="{_FAINT_INK}">{_sized(line, 11 * scale)}</FONT>' for line in self._legend())
        return "<BR/>".join([_sized(title, 15 * scale), _sized(" ", 4), *legend, _sized(" ", 11)])

    def _legend(self) -> list[str]:
        automaton = self.automaton
        lines = []
        if isinstance(automaton, DFA):
            lines.append(f'accepted iff a trace ends in a state with <FONT COLOR="{_color(0)}"><B>+0</B></FONT>')
        for i in range(0 if isinstance(automaton, DFA) else automaton.n_pairs):
            wanted = []
            if i not in self.fin_only:
                wanted.append(f'<FONT COLOR="{_color(i)}"><B>+{i}</B></FONT> infinitely often')
            if automaton.fin[i].any():
                wanted.append(f'<FONT COLOR="{_color(i)}"><B>−{i}</B></FONT> only finitely often')
            begin = "accepted iff a run sees" if i == 0 else "or"
            lines.append(f"{begin} {' and '.join(wanted) or 'whatever'}")
        if not lines:
            lines.append("no pair: nothing is accepted")
        signs = []
        if automaton.accepting_sinks:
            signs.append("✓ everything is accepted from here on")
        if set(automaton.deadlocks) - self.hidden:
            signs.append("✗ deadlock: nothing is accepted any more")
        if self.hidden:
            signs.append("✗ not shown: the deadlock and the way there")
        return [*lines, *(["     ".join(signs)] if signs else [])]


def _sized(text: str, points: float) -> str:
    return f'<FONT POINT-SIZE="{points:.0f}">{text}</FONT>'


def _badge(pair: int, *, filled: bool) -> str:
    color = _color(pair)
    ground, ink, sign = (color, "white", "+") if filled else ("white", color, "−")
    return (
        f'<TD BGCOLOR="{ground}" BORDER="1" COLOR="{color}" CELLPADDING="1">'
        f'<FONT COLOR="{ink}" POINT-SIZE="9"><B>{sign}{pair}</B></FONT></TD>'
    )


def _beside(badges: list[str]) -> str:
    return f"<TD>{_html_table(badges)}</TD>" if badges else ""


def _html_table(cells: list[str]) -> str:
    return f'<TABLE BORDER="0" CELLBORDER="0" CELLSPACING="2" CELLPADDING="0"><TR>{"".join(cells)}</TR></TABLE>'


def _html(rows: str) -> str:
    return f'<<TABLE BORDER="0" CELLBORDER="0" CELLSPACING="2" CELLPADDING="1">{rows}</TABLE>>'


def _color(pair: int) -> str:
    return PAIR_COLORS[pair % len(PAIR_COLORS)]


def _lines(text: str, width: int) -> str:
    return "<BR/>".join(map(_printable, wrapped(text, width)))


def _printable(text: str) -> str:
    if not text.isprintable():
        text = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text)
    return escape(text) or " "


def wrapped(text: str, width: int) -> list[str]:
    """The text in lines of about that width, broken before outer `|`, and before outer `&` where that is not enough."""
    lines: list[str] = []
    for term in _split(text, "|"):
        for part in [term] if len(term) <= width else _split(term, "&"):
            if lines and len(lines[-1]) + len(part) < width:
                lines[-1] += f" {part}"
            else:
                lines.append(part)
    return lines


def _split(text: str, operator: str) -> list[str]:
    """The text cut before each occurrence of the operator outside brackets and quotes."""
    if not {"(", '"'} & {*text}:  # most are such, and there may be very many
        first, *others = text.split(f" {operator} ")
        return [first, *(f"{operator} {other}" for other in others)]
    parts, depth, quoted_part = [""], 0, False
    for i, letter in enumerate(text):
        quoted_part ^= letter == '"' and text[i - 1 : i] != "\\"
        depth += not quoted_part and (letter == "(") - (letter == ")")
        if depth == 0 and not quoted_part and text[i : i + 3] == f" {operator} ":
            parts.append("")
        else:
            parts[-1] += letter
    return parts
