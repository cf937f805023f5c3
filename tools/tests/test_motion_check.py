"""The checks of the motion: no false trip, and a slip that takes its time. `make motion` drives for longer."""

import math

import pytest
from evenspin.native import tables
from evenspin.native.simulation import Simulation
from motion_campaign import CASES, CHECKED, outcome


@pytest.mark.parametrize("numeric", ["float", "fixed"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.model} {case.text}".strip())
def test_a_drive_that_works_is_not_taken_for_one_that_has_lost_its_motion(case, numeric):
    for seed in range(2):
        one = outcome(case, numeric, seed, run_s=3.0)

        assert one.fault not in CHECKED or (one.fault == "stall" and case.locks), str(one)


def slipping(slip_rad, slip_s, speed_rad_s=100.0):
    """The default drive, and an encoder that slips from 0.3 s on: the fault, and when it came after that."""
    simulation = Simulation()
    for name in ("offset_calibration_periods", "align_periods"):
        simulation.set_param(name, 0.0)
    simulation.set_param("auto_run", 1.0)
    simulation.set_input("speed_ref_rad_s", [0.0], [speed_rad_s])
    simulation.set_input("encoder_slip_rad", [0.0, 0.3, 0.3 + slip_s], [0.0, 0.0, slip_rad], linear=True)
    simulation.start()
    simulation.skip(3000)
    assert simulation.read("fault") == 0.0
    while simulation.read("fault") == 0.0 and simulation.time_s() < 1.0:
        simulation.skip(1)
    return tables().faults[int(simulation.read("fault"))].name, simulation.time_s() - 0.3


@pytest.mark.parametrize("periods", [1, 2, 3, 5, 8])
def test_a_slip_that_takes_some_periods_is_found_when_it_is_larger_than_the_limit_in_each(periods):
    """0.05 rad and two of 4000 counts: 0.0531 rad a period."""
    found, after_s = slipping(math.copysign(0.058 * periods, (-1.0) ** periods), periods * 1e-4)
    passed, _ = slipping(0.048 * periods, periods * 1e-4, 20.0)

    assert found == "encoder_lost"
    assert after_s <= 4e-4
    assert passed != "encoder_lost"
