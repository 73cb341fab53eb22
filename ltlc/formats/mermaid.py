def to_mermaid(automaton): return ""
