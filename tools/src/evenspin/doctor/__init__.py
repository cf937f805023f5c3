"""Is everything here that building, testing and the chip need?"""

from evenspin.doctor.checks import run_checks
from evenspin.doctor.finding import Finding, Purpose, State

__all__ = ["Finding", "Purpose", "State", "run_checks"]
