"""Pictures drawn with matplotlib, which no other room knows; it is loaded when something is drawn.

See `curves` (learning curves), `policy` (policies on the map of an environment, `ltlc.board.Board`), `grid` (frames of
grid worlds), `faithfulness` (reward schemes), `runtime` (the run-time comparison) and `plotting` (what all share).
"""
