"""MTPA and field weakening on the salient machine that comes with the package, and what is refused."""

from collections.abc import Mapping

import evenspin as es
import numpy as np
import pytest
from evenspin.errors import EvenspinError

PSI, LD, LQ, OHM, PAIRS, LINK_V = 0.0594, 0.9e-3, 1.2e-3, 0.5, 5, 310.0  # docs/reference/tang2020.md
BASE_RAD_S = 0.95 * LINK_V / np.sqrt(3.0) / (PAIRS * PSI)
FAST = {
    "mtpa": True, "field_weakening": True, "id_limit_a": 40.0, "over_speed_rad_s": 1300.0, "link_withstand_v": 700.0,
}  # fmt: skip


def run(drive: Mapping[str, object], **event: float) -> es.Run:
    scenario = {
        "name": "weak", "model": "tang2020-rig1", "duration_s": 1.0, "seed": 1, "log_rate_hz": 1000.0,
        "drive": {"method": "pi", **drive}, "event": [{"at_s": 0.0} | event],
    }  # fmt: skip
    return es.load(scenario).change(viscous_nms=1e-3).simulate()


@pytest.mark.parametrize("controller", ["pi", "deadbeat"])
def test_twice_the_base_speed_with_the_least_current(controller: str) -> None:
    """The torque of the losses at that speed, below the voltage: searched over the d current.

    2 %: a voltage vector that is held while the rotor turns by 0.54 rad electrical is 1.2 % off in its mean.
    """
    speed_rad_s = 2.0 * BASE_RAD_S
    end = run(FAST | {"current_controller": controller}, speed_rad_s=speed_rad_s).between(0.8, 1.0)
    d = np.linspace(-40.0, 0.0, 40001)
    q = 1e-3 * speed_rad_s / (1.5 * PAIRS * (PSI + (LD - LQ) * d))
    w = PAIRS * speed_rad_s
    volts = np.hypot(OHM * d - w * LQ * q, OHM * q + w * (PSI + LD * d))
    least_a = np.hypot(d, q)[volts <= 0.95 * LINK_V / np.sqrt(3.0)].min()
    assert end["fault"].max() == 0
    assert end["true_speed_rad_s"].mean() == pytest.approx(speed_rad_s, rel=1e-3)
    assert np.hypot(end["true_id_a"].mean(), end["true_iq_a"].mean()) == pytest.approx(least_a, rel=0.02)


def test_a_speed_whose_voltage_the_link_does_not_withstand_is_refused_with_both_names() -> None:
    """sqrt(3) 5 0.0594 Wb 1300 rad/s = 669 V."""
    with pytest.raises(EvenspinError, match=r"over_speed_rad_s.*link_withstand_v"):
        run(FAST | {"link_withstand_v": 660.0}, speed_rad_s=100.0)


def test_a_d_current_is_not_commanded_where_mtpa_makes_it() -> None:
    with pytest.raises(EvenspinError, match=r"id_ref_a.*mtpa|mtpa.*id_ref_a"):
        run(FAST, speed_rad_s=100.0, id_ref_a=-1.0)
