"""One scenario over grids of its parameters: every combination is simulated, and all numbers go into one frame.

axes      what is varied, from the command line or from a program
work      the runs, on all cores
result    columns, CSV and Parquet, tables
pictures  the numbers over the axes, as a page
"""

from evenspin.grid.axes import Axes, axes_of, parsed_axes
from evenspin.grid.result import Grid
from evenspin.grid.work import run_grid

__all__ = ["Axes", "Grid", "axes_of", "parsed_axes", "run_grid"]
