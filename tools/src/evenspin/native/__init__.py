"""The compiled library: the firmware, the simulated plant and their tables. `native.simulation` runs it."""

from evenspin.native.library import NUMERICS, Library, load
from evenspin.native.refusal import RefusedValueError
from evenspin.native.tables import Effect, Fault, Field, Tables, tables

__all__ = ["NUMERICS", "Effect", "Fault", "Field", "Library", "RefusedValueError", "Tables", "load", "tables"]
