"""Many trainings from one file: formulas x environments x rewards x agents x seeds, and one table of what came out.

`ltlc.sweeps.ray_engine` and `ltlc.sweeps.ray_tune` need Ray and are imported by who asks for them. Examples:
docs/examples.md and docs/runs.md.
"""

from ltlc.sweeps.engine import Engine, train_cell
from ltlc.sweeps.grid import Cell, Grid, read_grid
from ltlc.sweeps.processes import Processes
from ltlc.sweeps.running import Progress, run_grid
from ltlc.sweeps.table import Row, table_of, write_table

__all__ = [
    "Cell",
    "Engine",
    "Grid",
    "Processes",
    "Progress",
    "Row",
    "read_grid",
    "run_grid",
    "table_of",
    "train_cell",
    "write_table",
]
