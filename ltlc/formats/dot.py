"""The automaton as a Graphviz drawing.

What a reader should see without looking for it: where a run starts (a bold arrow from nowhere), where it is lost (a
grey octagon with a cross), where it has won (a green double ring with a tick), and which pair a mark belongs to. A
mark is a badge: `+i` on a filled ground for inf, `−i` in a frame for fin of pair i, so that a print in black and white
says the same as the colours do.
"""

from __future__ import annotations

from html import escape

from ltlc.automata.alphabet import quoted
from ltlc.automata.rabin import RabinAutomaton
from ltlc.formats.edges import Edge, edges, state_marks

PAIR_COLORS = ("#0068a8", "#c44e00", "#7b3f9e", "#8f6a00", "#b02a5b", "#2f6f6f")
"""Dark enough for white text, told apart with the common kinds of colour blindness; pair 6 starts again."""

_PAIR_TINTS = ("#e3eff7", "#fbeadf", "#efe6f4", "#f6efd9", "#f8e4ec", "#e2efef")
_INK = "#24292f"
_FAINT = "#8a9099"
_FONT = "Helvetica,Arial,sans-serif"
_GUARD_WIDTH = 28
_NARROW_GUARD_WIDTH = 18
_TITLE_WIDTH = 90
_MAX_STATES_SIDEWAYS = 12


def to_dot(automaton: RabinAutomaton, *, hide_deadlock: bool = False) -> str:
    """The automaton in the DOT language, with its formula as title and a legend.

    Args:
        automaton: the automaton.
        hide_deadlock: leave out the states from which nothing is accepted and the edges to them, which the legend
            then says; the initial state is always shown.
    """
    return _Drawing(automaton, hide_deadlock).text()


class _Drawing:
    def __init__(self, automaton: RabinAutomaton, hide_deadlock: bool) -> None:
        self.automaton = automaton
        self.hidden = set(automaton.deadlocks) - {automaton.initial_state} if hide_deadlock else set()
        # A pair whose inf is everywhere asks for fin alone, and is drawn so.
        self.fin_only = {i for i, marks in enumerate(automaton.inf) if marks.all()}
        self.n_shown = automaton.n_states - len(self.hidden)

    def text(self) -> str:
        automaton = self.automaton
        sideways = self.n_shown <= _MAX_STATES_SIDEWAYS
        # What stands around a large drawing has to be read at the same distance as the whole of it.
        scale = min(4.0, max(1.0, (self.n_shown / _MAX_STATES_SIDEWAYS) ** 0.75))
        on_states = automaton.acceptance == "state" and bool(automaton.n_pairs)
        title = "deterministic Rabin automaton" if automaton.formula is None else automaton.formula
        lines = [
            "digraph automaton {",
            f'  graph [rankdir={"LR" if sideways else "TB"}, nodesep=0.3, ranksep=0.5, pad=0.2,',
            f'         dpi={144 if sideways else 96}, bgcolor=white,',
            f'         fontname="{_FONT}", fontcolor="{_INK}", fontsize={11 * scale:.0f}, labelloc=b,',
            f"         labeljust=l, label={_html(self._legend())}]",
            f'  node [shape=circle, width={0.72 if on_states else 0.5}, margin=0.03, style=filled, fillcolor=white,',
            f'        color="{_INK}", penwidth=1.2, fontname="{_FONT}", fontcolor="{_INK}", fontsize=13]',
            f'  edge [color="{_INK}", penwidth=1.1, arrowsize=0.7,',
            f'        fontname="{_FONT}", fontcolor="{_INK}", fontsize=11]',
            "  subgraph cluster_automaton {",
            f"    graph [peripheries=0, margin=12, labelloc=t, labeljust=c, fontsize={15 * scale:.0f},",
            f'           label=<{_lines(title, _TITLE_WIDTH)}<BR/><FONT POINT-SIZE="6"> </FONT>>]',
            '    start [shape=point, style=invis, width=0.01, height=0.01, label=""]',
            *(self._node(q) for q in range(automaton.n_states) if q not in self.hidden),
            f"    start -> {automaton.initial_state} [penwidth=2.2, arrowsize=0.9]",
            *self._edges(),
            "  }",
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
        elif wanted := [i for i in inf if i not in self.fin_only]:
            style = f', fillcolor="{_PAIR_TINTS[wanted[0] % len(_PAIR_TINTS)]}"'
        label = _html(f"<TR><TD>{text}</TD></TR><TR><TD>{_html_table(badges)}</TD></TR>") if badges else f"<{text}>"
        return f"    {q} [label={label}{style}]"

    def _edges(self) -> list[str]:
        """One arrow from a state to another, with a row per set of marks: parallel arrows would hide each other."""
        arrows: dict[tuple[int, int], list[Edge]] = {}
        for edge in edges(self.automaton):
            if edge.source not in self.hidden and edge.target not in self.hidden:
                arrows.setdefault((edge.source, edge.target), []).append(edge)
        names = [quoted(name) for name in self.automaton.aps]
        width = _GUARD_WIDTH if self.n_shown <= _MAX_STATES_SIDEWAYS else _NARROW_GUARD_WIDTH
        result = []
        for (source, target), parallel in arrows.items():
            rows = ""
            for edge in parallel:
                guard = self.automaton.alphabet.guard(edge.classes).text(names)
                badges = self._badges(edge.fin, edge.inf)
                rows += f"<TR><TD>{_lines(guard, width)}</TD>{_beside(badges)}</TR>"
            result.append(f"    {source} -> {target} [label={_html(rows)}{self._stroke(target, parallel)}]")
        return result

    def _stroke(self, target: int, parallel: list[Edge]) -> str:
        shown = {tuple(i for i in edge.inf if i not in self.fin_only) for edge in parallel}
        if target in self.automaton.deadlocks:
            return f', color="{_FAINT}", fontcolor="{_FAINT}", penwidth=0.8'
        if len(shown) == 1 and (inf := shown.pop()):
            return f', color="{_color(inf[0])}", penwidth=2'
        return ""

    def _badges(self, fin: tuple[int, ...], inf: tuple[int, ...]) -> list[str]:
        return [_badge(i, filled=True) for i in inf if i not in self.fin_only] + [_badge(i, filled=False) for i in fin]

    def _legend(self) -> str:
        """The rows of one table, so that the badges of all pairs stand below each other."""
        automaton = self.automaton
        empty = "<TD></TD>"
        rows = []
        for i in range(automaton.n_pairs):
            needs_inf, needs_fin = i not in self.fin_only, bool(automaton.fin[i].any())
            inf = _badge(i, filled=True) + _words("infinitely often") if needs_inf else empty * 2
            fin = _badge(i, filled=False) + _words("only finitely often") if needs_fin else empty * 2
            begin = "accepted iff a run sees" if i == 0 else "or"
            between = "and" if needs_inf and needs_fin else "" if needs_inf or needs_fin else "whatever"
            rows.append(_words(begin) + inf + _words(between) + fin)
        signs = [] if rows else ["no pair: nothing is accepted"]
        if automaton.accepting_sinks:
            signs.append("✓ everything is accepted from here on")
        if set(automaton.deadlocks) - self.hidden:
            signs.append("✗ deadlock: nothing is accepted any more")
        if self.hidden:
            signs.append("✗ not shown: the deadlock and the way there")
        rows += [f'<TD COLSPAN="6" ALIGN="LEFT">{sign}</TD>' for sign in signs]
        return "".join(f"<TR>{row}</TR>" for row in rows)


def _words(text: str) -> str:
    return f'<TD ALIGN="LEFT">{text}</TD>'


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
    return escape("".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text)) or " "


def wrapped(text: str, width: int) -> list[str]:
    """The text in lines of about that width, broken before an outer `|` or `&` only."""
    words, depth = [""], 0
    for i, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and text[i : i + 3] in (" | ", " & "):
            words.append("")
        else:
            words[-1] += letter
    lines = [words[0]]
    for word in words[1:]:
        if len(lines[-1]) + len(word) + 1 > width:
            lines.append(word)
        else:
            lines[-1] += f" {word}"
    return lines
