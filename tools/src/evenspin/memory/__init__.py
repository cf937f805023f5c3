"""What the angle observer has learned, as a file: save it, look at it, give it to a drive."""

from evenspin.memory.table import AngleTable, check_table_file, read_table, write_table

__all__ = ["AngleTable", "check_table_file", "read_table", "write_table"]
