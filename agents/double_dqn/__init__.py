"""Double deep Q-learning: networks, replayed steps, and the update that teaches every automaton state."""
