"""The gap of a drive without torque constant, voltages or load sensor: a torque balance in ampere equivalents.

    iq = (J/Kt) dw/dt + (B/Kt) w + what is missing            [A]

Torque is given in the amperes of q current that make it, so that no torque constant is needed.
"""

from evenspin.balance.run import BalanceResult, run_balance

__all__ = ["BalanceResult", "run_balance"]
