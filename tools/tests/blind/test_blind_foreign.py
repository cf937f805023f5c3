"""Logs with causes that no table lists: what is planned, and that each cause shows in what the drive measures."""

from __future__ import annotations

import numpy as np
import pytest
from evenspin.blind import bench_drives
from evenspin.blind.bench_profile import draw_inputs
from evenspin.blind.foreign_effects import FOREIGN, placed
from evenspin.blind.logs import FOREIGN_MIX, plan_foreign_logs
from evenspin.blind.referee import simulate, with_effects
from evenspin.native import tables


def test_a_set_has_every_cause_alone_and_beside_a_known_effect_and_clean_units() -> None:
    plans = plan_foreign_logs(120, 3)

    assert plans == plan_foreign_logs(120, 3) != plan_foreign_logs(120, 4)
    kinds = [plan.kind for plan in plans]
    assert {kind: kinds.count(kind) for kind in FOREIGN_MIX} == FOREIGN_MIX
    assert {plan.names[0] for plan in plans if plan.kind == "foreign"} == set(FOREIGN)
    for plan in plans:
        known = [name for name in plan.names if name in tables().effects]
        assert len(known) == (plan.kind in ("beside", "single"))
        assert all(name in FOREIGN for name in plan.names if name not in known)
    assert all(plan.voltages for plan in plans)


@pytest.mark.parametrize("cause", FOREIGN)
def test_each_cause_changes_what_the_drive_measures(cause: str) -> None:
    """The same drive, noise and inputs with and without it: a smallest draw is beyond the noise of the current sensor,
    or, for what acts on the voltage alone, a thousandth of the dc link."""
    rng = np.random.default_rng(11)
    drive = bench_drives.draw_drive(rng)
    while drive.controller["other.most_torque_per_ampere"]:
        drive = bench_drives.draw_drive(rng)
    nominal = bench_drives.nominal_of(drive)
    inputs = draw_inputs(rng, drive, 4.0, 0.5 * drive.meta["motor"]["rated_torque_nm"])
    values = FOREIGN[cause].draw(rng, drive, 0)
    if cause == "position":
        values = placed(values, inputs, drive.meta["pwm_hz"])
    clean = simulate(nominal, inputs, 8)
    foreign = simulate(with_effects(nominal, {FOREIGN[cause].referee: values}), inputs, 8)
    amps = np.max(np.abs(foreign["iq_a"] - clean["iq_a"]))
    volts = max(np.max(np.abs(foreign[key] - clean[key])) for key in ("vd_v", "vq_v"))
    assert np.all(np.isfinite(foreign["iq_a"]))
    assert amps > 3.0 * drive.meta["current_noise_a"] or volts > 1e-3 * drive.meta["dc_link_v"]
