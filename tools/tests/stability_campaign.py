"""Random drives: what the design check says of the speed loop, and what the simulated firmware does.

    python tools/tests/stability_campaign.py [COUNT] [FIRST_SEED]

The simulation knows nothing of the design check: it is the firmware on the simulated motor, at constant speed, with
a small step of the load. `oscillates`: the distance of the speed to its reference after the step does not die away. It
stays above half of its largest value, or loses less than a fifth from the third to the last fifth of the run; a drive
that has run away to another speed counts, too. A thousandth of the largest and 2e-6 of the speed are rounding in
single precision. No limit is touched before the distance has grown by orders of magnitude.
"""

from __future__ import annotations

import math
import random
import sys
from collections import Counter
from dataclasses import dataclass

import numpy as np
from evenspin.design.source import repetitive_of
from evenspin.design.stability import Stability, Verdict, judge
from evenspin.errors import NativeError
from evenspin.model.setup import InputCurve, Setup
from evenspin.native import tables
from evenspin.sim import simulate

STEP_S = 0.3
SIGNALS = ("t_s", "true_speed_rad_s", "fault", "state")
Q = ((0.45, 0.10), (0.25, 0.50), (0.05, 0.90), (0.30, 0.30))


@dataclass(frozen=True)
class Case:
    plant: dict[str, float]
    drive: dict[str, float]
    speed_rad_s: float
    step_nm: float
    seconds: float

    @property
    def method(self) -> str:
        return tables().params["method"].to_text(self.drive["method"])


def random_case(seed: int) -> Case:
    """A motor, a current loop and a speed loop of ordinary to excessive bandwidth, a repetitive controller, a speed."""
    draw = random.Random(seed)

    def log(low: float, high: float) -> float:
        return math.exp(draw.uniform(math.log(low), math.log(high)))

    params = tables().params
    word = {name: params[name].to_number for name in ("method", "speed_source", "current_controller")}
    plant = {name: field.default for name, field in tables().model.items()}
    drive = {name: field.default for name, field in params.items()}
    pairs, psi, inertia = draw.randint(2, 8), log(3e-3, 0.2), log(2e-5, 5e-3)
    resistance, inductance = log(0.05, 2.0), log(5e-5, 5e-3)
    saliency = draw.choice((1.0, 1.0, draw.uniform(0.7, 1.4)))
    lead = draw.randint(0, 10)
    samples = draw.uniform(lead + 12, 250)
    speed = 2.0 * math.pi / (pairs * 1e-3 * samples)
    edges = float(round(min(2.0**20, 20e6 / speed * 2.0 * math.pi)))  # M/T counts up to 32767 in a millisecond
    plant |= {
        "pole_pairs": float(pairs),
        "resistance_ohm": resistance,
        "ld_h": inductance * saliency,
        "lq_h": inductance,
        "psi_wb": psi,
        "inertia_kgm2": inertia,
        "viscous_nms": inertia * log(0.01, 3.0),
        "dc_link_v": 900.0,
        "counts_per_rev": 0.0,  # ideal; what M/T sees is encoder_counts
        "current_range_a": 1000.0,
        "initial_speed_rad_s": speed,
    }
    current_rad_s = 2.0 * math.pi * log(150.0, 2500.0)
    speed_gain = draw.choice((1.0, float(pairs)))
    bandwidth = log(20.0, 1500.0)
    kp = inertia * bandwidth / (1.5 * pairs * psi * speed_gain)
    side, centre = draw.choice(Q)
    wrong = 1.0 + draw.uniform(-0.2, 0.2)
    drive |= {
        "pole_pairs": float(pairs),
        "encoder_counts": edges,
        "motor_resistance_ohm": resistance * wrong,
        "motor_ld_h": plant["ld_h"] * wrong,
        "motor_lq_h": inductance * wrong,
        "motor_psi_wb": psi,
        "current_controller": word["current_controller"](draw.choice(("pi", "pi", "pi", "deadbeat"))),
        "current_kp_v_per_a": min(current_rad_s * inductance, 999.0),
        "current_ki_v_per_as": current_rad_s * resistance * log(0.3, 3.0),
        "speed_source": word["speed_source"](draw.choice(("mt", "mt", "pll", "fir"))),
        "speed_inline": float(draw.random() < 0.25),
        "speed_error_gain": speed_gain,
        "speed_kp_a_per_unit": min(kp, 999.0),
        "speed_ki_a_per_unit_s": min(kp * bandwidth * log(0.02, 0.5), 9e4),
        "method": word["method"](draw.choice(("pi", "forc", "crc"))),
        "rc_gain": draw.uniform(0.05, 2.0),
        "rc_lead": float(lead),
        "rc_order": float(draw.randint(1, 3)),
        "rc_q_side": side,
        "rc_q_centre": centre,
        # wide limits: a loop that grows is to be seen growing
        "rc_limit_unit": 1e6,
        "iq_limit_a": 500.0,
        "id_limit_a": 500.0,
        "over_current_a": 1000.0,
        "over_voltage_v": 1000.0,
        "over_speed_rad_s": 20.0 * speed + 500.0,
        "encoder_jump_rad": 3.0,
        "stall_s": 0.0,
        "offset_calibration_periods": 0.0,
        "align_periods": 0.0,
        "auto_run": 1.0,
    }
    step_nm = min(0.1 * 1.5 * pairs * psi, 0.02 * speed * inertia * min(bandwidth, 200.0))
    seconds = STEP_S + max(1.5, 100.0 * samples * 1e-3) if drive["method"] else STEP_S + 8.0
    return Case(plant, drive, speed, step_nm, min(seconds, 25.0))


def designed(case: Case) -> Stability:
    rc = None if case.method == "pi" else repetitive_of(case.drive)
    return judge(case.plant, case.drive, case.speed_rad_s, rc, whole=case.method == "crc")


def distance(case: Case) -> list[float]:
    """rms of the distance to the reference, rad/s, in fifths of the run after the step: largest, third, last.

    The last is infinite when the drive tripped.
    """
    setup = Setup(
        "random", case.plant, case.drive, {},
        {
            "speed_ref_rad_s": InputCurve((0.0,), (case.speed_rad_s,)),
            "load_torque_nm": InputCurve((0.0, STEP_S), (0.0, case.step_nm)),
        },
        (), case.seconds, 1000.0, 1,
    )  # fmt: skip
    try:
        record = simulate(setup, SIGNALS)
    except NativeError:  # it has run away beyond all numbers
        return [1.0, 1.0, math.inf]
    if record["fault"].any():
        return [1.0, 1.0, math.inf]
    window_s = 0.2 * (case.seconds - STEP_S)
    starts = [STEP_S + k * window_s for k in range(5)]
    pieces = [record.between(start, start + window_s)["true_speed_rad_s"] for start in starts]
    rms = [float(np.sqrt(np.mean((piece - case.speed_rad_s) ** 2))) for piece in pieces]
    return [max(rms), rms[2], rms[4]]


def oscillates(case: Case) -> bool:
    largest, before, late = distance(case)
    rounding = 2e-6 * case.speed_rad_s + 1e-3 * largest
    return late > rounding and (late > 0.5 * largest or late > 0.8 * before)


def main(count: int, first: int) -> int:
    table: Counter[tuple[str, bool]] = Counter()
    for seed in range(first, first + count):
        case = random_case(seed)
        said, seen = designed(case), oscillates(case)
        table[said.verdict, seen] += 1
        if (said.verdict is Verdict.STABLE) is seen and said.verdict is not Verdict.MARGINAL:
            figures = ", ".join(f"{value:.3g}" for value in distance(case))
            print(f"seed {seed}: {case.method}, {said.verdict}, radius {said.radius:.6f}; distance {figures}")
    print(f"{'design check':<14}{'settles':>10}{'oscillates':>12}")
    for verdict in Verdict:
        print(f"{verdict:<14}{table[verdict, False]:>10}{table[verdict, True]:>12}")
    clear = sum(n for (verdict, _), n in table.items() if verdict is not Verdict.MARGINAL)
    agree = table[Verdict.STABLE, False] + table[Verdict.UNSTABLE, True]
    print(f"agreement: {agree} of {clear} clear verdicts, {count - clear} marginal")
    return int(agree < 0.99 * clear or table[Verdict.STABLE, True] > 0)


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    sys.exit(main(*(given + [200, 1][len(given) :])))
