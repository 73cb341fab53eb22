"""Many trainings from one file: formulas x environments x rewards x agents x seeds, and one table of what came out.

Examples: docs/examples.md.
"""

from ltlc.sweeps.grid import Cell, Grid, read_grid
from ltlc.sweeps.running import Progress, run_grid
from ltlc.sweeps.table import Row, table_of, write_table

__all__ = ["Cell", "Grid", "Progress", "Row", "read_grid", "run_grid", "table_of", "write_table"]
