"""What a drive has learned over the angle, as a file: save it, show it, load it into a drive."""

from evenspin.memory.learned import Learned, LearnedTable, is_learned_file, read_learned, write_learned
from evenspin.memory.table import AngleTable, check_table_file, read_table, write_table

__all__ = [
    "AngleTable",
    "Learned",
    "LearnedTable",
    "check_table_file",
    "is_learned_file",
    "read_learned",
    "read_table",
    "write_learned",
    "write_table",
]
