"""The automaton as a Graphviz drawing.

What a reader should see without looking for it: where a run starts (an arrow from nowhere), where it is lost (a grey
octagon with a cross), where it has won (a green double ring with a tick), and which pair a mark belongs to. A mark is
a badge, `+i` filled for inf and `-i` framed for fin of pair i, so that a print in black and white says the same as
the colours do.
"""

from __future__ import annotations

from html import escape

from ltlc.automata.alphabet import quoted
from ltlc.automata.rabin import RabinAutomaton
from ltlc.formats.edges import Edge, edges, state_marks

PAIR_COLORS = ("#0068a8", "#c44e00", "#7b3f9e", "#a8760a", "#b02a5b", "#3a6f77")
"""Dark enough for white text, told apart with the common kinds of colour blindness; pair 6 starts again."""

INK = "#2b2f36"
FONT = "Helvetica,Arial,sans-serif"
_WIDE_GUARD = 26
_SMALL = 12


def to_dot(automaton: RabinAutomaton, *, hide_deadlock: bool = False) -> str:
    """The automaton in the DOT language, with its formula as title and a legend.

    Args:
        automaton: the automaton.
        hide_deadlock: leave out the states from which nothing is accepted and the edges to them, which the legend
            then says; the initial state is always shown.
    """
    hidden = set(automaton.deadlocks) - {automaton.initial_state} if hide_deadlock else set()
    n_shown = automaton.n_states - len(hidden)
    title = automaton.formula if automaton.formula is not None else "deterministic Rabin automaton"
    lines = [
        "digraph automaton {",
        f'  graph [rankdir={"LR" if n_shown <= _SMALL else "TB"}, fontname="{FONT}", fontcolor="{INK}", fontsize=11,',
        "         nodesep=0.35, ranksep=0.55, pad=0.25, dpi=144, concentrate=false, forcelabels=true,",
        f"         labelloc=b, labeljust=l, label={_legend(automaton, hidden)}]",
        f'  node [fontname="{FONT}", fontcolor="{INK}", fontsize=13, color="{INK}", style=filled, fillcolor=white,',
        "        shape=circle, penwidth=1.2, width=0.5, margin=0.04]",
        f'  edge [fontname="{FONT}", fontcolor="{INK}", fontsize=11, color="{INK}", arrowsize=0.7, penwidth=1.1]',
        "  subgraph cluster_automaton {",
        f'    graph [peripheries=0, labelloc=t, labeljust=c, fontsize=16, label={_title(title)}]',
        '    start [shape=point, style=invis, width=0.01, height=0.01, label=""]',
    ]
    lines += [f"    {_node(automaton, q)}" for q in range(automaton.n_states) if q not in hidden]
    lines.append(f"    start -> {automaton.initial_state} [penwidth=2, arrowsize=0.9]")
    names = [quoted(name) for name in automaton.aps]
    for edge in edges(automaton):
        if edge.source not in hidden and edge.target not in hidden:
            guard = automaton.alphabet.guard(edge.classes).text(names)
            lines.append(f"    {edge.source} -> {edge.target} {_edge(automaton, edge, guard)}")
    lines += ["  }", "}"]
    return "\n".join(lines) + "\n"


def _node(automaton: RabinAutomaton, q: int) -> str:
    name = str(q) if automaton.state_names is None else automaton.state_names[q]
    fin, inf = state_marks(automaton, q)
    text = _text(name)
    options = []
    if q in automaton.deadlocks:
        text = f"{text} ✗"
        options += ["shape=octagon", 'fillcolor="#d9d9d9"', 'color="#8c1c13"', 'fontcolor="#8c1c13"']
    elif q in automaton.accepting_sinks:
        text = f"{text} ✓"
        options += ["shape=doublecircle", 'fillcolor="#d5efd8"', 'color="#1b7a35"', 'fontcolor="#125a26"']
    elif inf:
        options.append(f'fillcolor="{_color(inf[0])}1f"')
    badges = _badges(fin, inf)
    label = _table([[f"<TD COLSPAN=\"{max(1, len(badges))}\">{text}</TD>"], badges]) if badges else f"<{text}>"
    return f"{q} [label={label}{''.join(', ' + option for option in options)}]"


def _edge(automaton: RabinAutomaton, edge: Edge, guard: str) -> str:
    text = "<BR/>".join(_text(line) for line in wrapped(guard))
    badges = _badges(edge.fin, edge.inf)
    options = [f"label={_table([[f'<TD>{text}</TD>', *badges]])}"]
    if edge.target in automaton.deadlocks:
        options += ['color="#8f959e"', 'fontcolor="#6b7078"', "penwidth=0.8"]
    elif edge.inf:
        options += [f'color="{_color(edge.inf[0])}"', "penwidth=2"]
    elif edge.fin:
        options += [f'color="{_color(edge.fin[0])}"', "style=dashed"]
    return f"[{', '.join(options)}]"


def _badges(fin: tuple[int, ...], inf: tuple[int, ...]) -> list[str]:
    """Table cells, filled for inf and framed for fin."""
    return [
        f'<TD BGCOLOR="{_color(i)}" BORDER="1" COLOR="{_color(i)}"><FONT COLOR="white" POINT-SIZE="10"><B>+{i}</B></FONT></TD>'
        for i in inf
    ] + [
        f'<TD BGCOLOR="white" BORDER="1" COLOR="{_color(i)}"><FONT COLOR="{_color(i)}" POINT-SIZE="10"><B>−{i}</B></FONT></TD>'
        for i in fin
    ]


def _table(rows: list[list[str]]) -> str:
    body = "".join(f"<TR>{''.join(cells)}</TR>" for cells in rows)
    return f'<<TABLE BORDER="0" CELLBORDER="0" CELLSPACING="2" CELLPADDING="1">{body}</TABLE>>'


def _title(title: str) -> str:
    return f"<{'<BR/>'.join(_text(line) for line in wrapped(title, 80))}<BR/> >"


def _legend(automaton: RabinAutomaton, hidden: set[int]) -> str:
    rows = []
    for i in range(automaton.n_pairs):
        inf, fin = _badges((), (i,))[0], _badges((i,), ())[0]
        rows.append([inf, fin, f'<TD ALIGN="LEFT">pair {i}: +{i} infinitely often and −{i} finitely often</TD>'])
    head = "accepted: one of these pairs holds" if automaton.n_pairs > 1 else "accepted:"
    rows.insert(0, [f'<TD COLSPAN="3" ALIGN="LEFT">{head}</TD>'])
    return _table(rows)


def _color(pair: int) -> str:
    return PAIR_COLORS[pair % len(PAIR_COLORS)]


def _text(text: str) -> str:
    return escape("".join(c if c.isprintable() else "�" for c in text))


def wrapped(text: str, width: int = _WIDE_GUARD) -> list[str]:
    """The text in lines of about that width, broken before operators where possible."""
    lines: list[str] = [""]
    for word in text.replace(" | ", " \n| ").replace(" & ", " \n& ").split("\n"):
        if lines[-1] and len(lines[-1]) + len(word.rstrip()) > width:
            lines.append("")
        lines[-1] += word
    return [line.strip() for line in lines]
