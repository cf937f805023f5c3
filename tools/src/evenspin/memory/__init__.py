"""What the angle observer has learned, as a file: save it, show it, load it into a drive."""

from evenspin.memory.table import AngleTable, check_table_file, read_table, write_table

__all__ = ["AngleTable", "check_table_file", "read_table", "write_table"]
