"""The measured-log format: what a drive logged, from a simulation, a virtual drive or a bench."""

from evenspin.log.case import Case, read_case, write_case
from evenspin.log.columns import LOG_COLUMNS
from evenspin.log.csvfile import read_csv, write_csv
from evenspin.log.meta import meta_of
from evenspin.output import OutputFolder

__all__ = ["LOG_COLUMNS", "Case", "OutputFolder", "meta_of", "read_case", "read_csv", "write_case", "write_csv"]
