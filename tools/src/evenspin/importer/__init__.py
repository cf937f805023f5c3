"""Logs of any drive and any program, brought into the columns and units of the measured-log format.

From the file up: `read` finds the reader, `delimited` and `binary` give a table of named columns, `names` and `units`
read its header, `guess` joins that with what the data decide (`motion`, `choose`), `mapping` is the result as a file
that a person corrects, `convert` applies it, with `frames` for phase quantities.
"""

from evenspin.importer.convert import Imported, import_table
from evenspin.importer.guess import Known, guess_map
from evenspin.importer.mapping import ColumnMap, Mapping, UndecidedError, read_map, write_map
from evenspin.importer.read import read_table

__all__ = [
    "ColumnMap",
    "Imported",
    "Known",
    "Mapping",
    "UndecidedError",
    "guess_map",
    "import_table",
    "read_map",
    "read_table",
    "write_map",
]
