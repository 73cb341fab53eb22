"""The automaton as a Mermaid flowchart, which Markdown pages on many sites draw in place."""

from __future__ import annotations

from ltlc.automata.finite import DFA
from ltlc.automata.rabin import DRA
from ltlc.budget import check_time
from ltlc.formats.edges import arrows, hidden_states, state_marks

_CLASSES = (
    ("deadlock", "fill:#dcdcdc,stroke:#8c1c13,color:#8c1c13"),
    ("sink", "fill:#d9f0dc,stroke:#1b7a35,color:#125a26"),
)


def to_mermaid(automaton: DRA | DFA, *, hide_deadlock: bool = False) -> str:
    """A flowchart with the signs of the Graphviz drawing: `+i` for inf and `−i` for fin of pair i.

    Args:
        automaton: the automaton.
        hide_deadlock: leave out the states from which nothing is accepted, and the edges to them.
    """
    hidden = hidden_states(automaton, hide_deadlock)
    shown = [q for q in range(automaton.n_states) if q not in hidden]
    lines = [] if automaton.formula is None else ["---", f"title: {_yaml(automaton.formula)}", "---"]
    lines += ["flowchart LR", f"  start(( )) ==> q{automaton.initial_state}"]
    lines += [_node(automaton, q) for q in shown]
    for (source, target), parallel in arrows(automaton, hidden).items():
        check_time()
        rows = [edge.guard + _marks(edge.fin, edge.inf) for edge in parallel]
        lines.append(f'  q{source} -->|"{"<br/>".join(map(_entities, rows))}"| q{target}')
    lines.append("  style start fill:none,stroke:none")
    for (name, style), members in zip(_CLASSES, (automaton.deadlocks, automaton.accepting_sinks), strict=True):
        if visible := [f"q{q}" for q in members if q not in hidden]:
            lines += [f"  classDef {name} {style}", f"  class {','.join(visible)} {name}"]
    return "\n".join(lines) + "\n"


def to_markdown(automaton: DRA | DFA) -> str:
    """Write the flowchart of `to_mermaid` in a Markdown fence."""
    return f"```mermaid\n{to_mermaid(automaton)}```\n"


def _node(automaton: DRA | DFA, q: int) -> str:
    name = str(q) if automaton.state_names is None else automaton.state_names[q]
    text = _entities(name + _marks(*state_marks(automaton, q)))
    if q in automaton.deadlocks:
        return f'  q{q}{{{{"{text} ✗"}}}}'
    if q in automaton.accepting_sinks:
        return f'  q{q}((("{text} ✓")))'
    return f'  q{q}(("{text}"))'


def _marks(fin: tuple[int, ...], inf: tuple[int, ...]) -> str:
    return "".join(f" +{i}" for i in inf) + "".join(f" −{i}" for i in fin)


def _entities(text: str) -> str:
    """The text for a quoted label: numeric entities for all that Mermaid, Markdown or HTML could read as markup."""
    return "".join(c if c.isalnum() or c in " −✗✓" else f"#{ord(c)};" if c.isprintable() else "#65533;" for c in text)


def _yaml(text: str) -> str:
    return '"' + _printable(text).replace("\\", "\\\\").replace('"', '\\"') + '"'


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
