"""The equations of the machine in weak form, held against what a drive logged: what is left, and what explains it.

    torque   1.5 p ((psi + hq) iq + hd id + reluctance) = J dw/dt + B w + load + what is missing     N m
    d axis   vd = R id + d(linkage_d)/dt - we (linkage_q - hd) + what is missing                      V
    q axis   vq = R iq + d(linkage_q)/dt + we (linkage_d + psi + hq) + what is missing                V

Without voltages the first is held against the log alone. No controller is known and no signal is differentiated
(`windows`). What an effect does in the equations stands in its module of `evenspin.effects`. `equations` holds them
against a log, `terms` is what may be missing, `model` makes columns of it, `fit` and `search` choose, `analysis` goes
through it. `beyond` goes on to terms of `evenspin.empirical` that no effect is, and `evidence` keeps those that rows
confirm which no fit saw. `evenspin.driven` uses it for logs of any drive, `evenspin.gap` for what case folders leave.
"""
