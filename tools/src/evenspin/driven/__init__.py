"""Logs of any drive, explained by the equations of the machine with the measured voltages and currents as inputs.

`evenspin.weakform` has the equations, the fit and the choice of terms. Here `read` makes signals of logs and numbers of
a model file, `judge` makes names of the choice, and `run` writes what was found.
"""

from evenspin.driven.read import serves
from evenspin.driven.run import DrivenResult, run_driven

__all__ = ["DrivenResult", "run_driven", "serves"]
