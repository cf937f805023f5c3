"""A scenario for other simulators: as a co-simulation unit of FMI 3.0."""

from evenspin.export.fmu import KINDS, fmu_bytes

__all__ = ["KINDS", "fmu_bytes"]
