"""Logs of any drive, explained by the equations of the machine with the measured voltages and currents as inputs.

    torque   1.5 p ((psi + hq) iq + hd id + reluctance) = J dw/dt + B w + load + what is missing     N m
    d axis   vd = R id + d(linkage_d)/dt - we (linkage_q - hd) + what is missing                      V
    q axis   vq = R iq + d(linkage_q)/dt + we (linkage_d + psi + hq) + what is missing                V

Without voltages the first is held against the log alone. No controller is known and no signal is differentiated
(`windows`). What an effect does in the equations stands in its module of `evenspin.effects`. `equations` holds them
against a log, `terms` is what may be missing, `model` makes columns of it, `fit` and `search` choose, `analysis` goes
through it, `judge` makes names of it.
"""

from evenspin.driven.read import serves
from evenspin.driven.run import DrivenResult, run_driven

__all__ = ["DrivenResult", "run_driven", "serves"]
