"""The speed loop as the drive runs it, linear about one speed: every sample, every delay.

One speed period is walked PWM period by PWM period, in the order of the firmware: sample, tracking filter, speed loop,
current control, and the voltage that acts one period later. Each signal is a row of coefficients over the state at the
start, so that the walk itself gives the matrices of

    x+ = A x + B y,    speed measured at the tick = C x                                                    (1)

where y is what repetitive control adds to the speed error. The motor has both axes, their coupling and the back-EMF;
the voltage is held in the frame of the stator. PI or deadbeat current control; M/T, tracking filter or FIR speed.

Left out: limits, steps of encoder and converter, dead time, friction other than viscous, observers of torque. An
encoder that gives less than one edge in a speed period delays more than this knows: `edges_per_sample`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from evenspin.blocks import Fir
from evenspin.errors import InputError
from evenspin.native import tables

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Numbers = Mapping[str, float]

TURN = np.array([[0.0, -1.0], [1.0, 0.0]])  # d and q of a vector turned by a quarter
POSITIVE_PLANT = ("resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2", "pwm_hz", "pole_pairs")
POSITIVE_DRIVE = ("speed_kp_a_per_unit", "speed_error_gain")
STATES = ("xd", "xq", "cd", "cq", "x", "edge_before")  # that a drive may not have
ANGLES = ("ahead", "pll_th", "theta_before", "edge_before")
CONTROLLERS = ("pi", "deadbeat")  # of the currents, that this file has equations for


@dataclass(frozen=True)
class Sampled:
    """Equation (1) with its sample time. `unit`: of the speed error, per mechanical rad/s."""

    a: Array
    b: Array
    c: Array
    ts_s: float
    unit: float
    edges_per_sample: float

    @functools.cached_property
    def poles(self) -> Complex:
        return np.asarray(np.linalg.eigvals(self.a), dtype=np.complex128)

    @property
    def radius(self) -> float:
        """Largest magnitude of a pole; below 1: stable."""
        return float(np.abs(self.poles).max())

    def as_json(self) -> dict[str, float]:
        return {"ts_s": self.ts_s, "largest_pole": self.radius, "edges_per_sample": self.edges_per_sample}

    def closed(self, f_hz: Array) -> Complex:
        """M: correction to measured speed, both in units of the error."""
        z = np.exp(2j * np.pi * np.asarray(f_hz, dtype=float) * self.ts_s)
        size = len(self.a)
        state = np.linalg.solve(z[:, None, None] * np.eye(size) - self.a, self.b[None, :, None])[:, :, 0]
        return np.asarray(self.unit * (state @ self.c), dtype=np.complex128)


def sampled_loop(plant: Numbers, drive: Numbers, speed_rad_s: float, delay_periods: int = 0) -> Sampled:
    """The loop at this speed; `delay_periods`: PWM periods by which the current reference comes later than it does."""
    return _Walk(plant, drive, speed_rad_s, delay_periods).loop()


@dataclass
class _Walk:
    plant: Numbers
    drive: Numbers
    speed_rad_s: float
    delay_periods: int
    rows: dict[str, Array] = field(default_factory=dict)
    correction: Array = field(default_factory=lambda: np.zeros(0))
    seen: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        for names, numbers in ((POSITIVE_PLANT, self.plant), (POSITIVE_DRIVE, self.drive)):
            for name in names:
                if not 0.0 < numbers[name] < math.inf:
                    raise InputError("design rc", name, numbers[name], "finite and above 0", "correct the model")
        if self.drive.get("speed_notch_hz", 0.0) > 0.0:
            hz, must = self.drive["speed_notch_hz"], "0: repetitive control does not go with a notch filter"
            raise InputError("design rc", "speed_notch_hz", hz, must, "leave it out of [drive]")
        params = tables().params
        self.ts_s = 1.0 / self.plant["pwm_hz"]
        self.divider = int(self.drive["speed_divider"])
        self.source = params["speed_source"].to_text(self.drive["speed_source"])
        controller = params["current_controller"].to_text(self.drive["current_controller"])
        if controller not in CONTROLLERS:
            must = f"{' or '.join(CONTROLLERS)}: there is no model of another one here"
            raise InputError("design rc", "current_controller", controller, must, "choose one of them in [drive]")
        self.deadbeat = controller == "deadbeat"
        self.inline = self.drive["speed_inline"] > 0.0
        self.taps = np.zeros(1)
        if self.source == "fir":
            order = int(self.drive["observer_fir1_order"])
            self.taps = np.array(Fir(order, self.drive["observer_fir1_hz"] * self.ts_s).taps)
        counts = self.plant["counts_per_rev"] or self.drive["encoder_counts"]
        self.edges_per_s = counts * abs(self.speed_rad_s) / (2.0 * math.pi)
        self.motor = self._motor()

    # ---- the motor over one PWM period

    def _motor(self) -> Array:
        """State id, iq, speed, angle, then the voltage that acts (d, q, and how far it was turned ahead)."""
        m, w = self.plant, self.speed_rad_s
        p, psi = m["pole_pairs"], m["psi_wb"]
        ld, lq, resistance = m["ld_h"], m["lq_h"], m["resistance_ohm"]
        we = p * w
        iq0 = m["viscous_nms"] * w / (1.5 * p * psi)
        volt = np.array([-we * lq * iq0, resistance * iq0 + we * psi])
        turned = p * (TURN @ volt)  # what a mechanical radian ahead adds
        a = np.zeros((7, 7))
        a[0, :4] = np.array([-resistance, we * lq, p * lq * iq0, -turned[0]]) / ld
        a[1, :4] = np.array([-we * ld, -resistance, -p * psi, -turned[1]]) / lq
        a[2, :3] = np.array([1.5 * p * (ld - lq) * iq0, 1.5 * p * psi, -m["viscous_nms"]]) / m["inertia_kgm2"]
        a[3, 2] = 1.0
        a[0, 4], a[1, 5] = 1.0 / ld, 1.0 / lq
        a[0, 6], a[1, 6] = turned[0] / ld, turned[1] / lq
        a[4:6, 4:6] = -we * TURN
        return expm(a * self.ts_s)

    # ---- the walk

    def loop(self) -> Sampled:
        names = self._names()
        self.size = len(names)
        unit = np.eye(self.size + 1)
        self.rows = {name: np.zeros(self.size + 1) for name in STATES} | {name: unit[k] for k, name in enumerate(names)}
        self.correction = unit[self.size]
        for period in range(self.divider):
            self._period(tick=period == 0)
        after = np.array([self.rows[name] for name in names])
        # Only differences of angles count: every angle is taken from that of the rotor, which then drops out.
        at = names.index("theta")
        relative = np.eye(self.size)
        for name in ANGLES:
            if name in names:
                relative[names.index(name), at] = -1.0
        back = np.linalg.inv(relative)
        kept = np.delete(np.arange(self.size), at)
        return Sampled(
            (relative @ after[:, :-1] @ back)[np.ix_(kept, kept)],
            (relative @ after[:, -1])[kept],
            (self.seen[:-1] @ back)[kept],
            self.ts_s * self.divider,
            self.drive["speed_error_gain"],
            self.edges_per_s * self.ts_s * self.divider,
        )

    def _names(self) -> list[str]:
        """State that this drive has: an integrator without a gain would only stay where it is."""
        names = ["id", "iq", "w", "theta", "vd", "vq", "ahead", "pll_th", "pll_w", "theta_before", "iq_ref"]
        if self.deadbeat:
            names += ["guess_d", "guess_q", "last_d", "last_q"]
            names += ["cd", "cq"] if self.drive["deadbeat_correction"] > 0.0 else []
        else:
            names += ["xd", "xq"] if self.drive["current_ki_v_per_as"] > 0.0 else []
        names += ["x"] if self.drive["speed_ki_a_per_unit_s"] > 0.0 else []
        names += ["edge_before"] if self.source == "mt" else []
        names += [f"travel{k}" for k in range(len(self.taps))]
        return names + [f"ref{k}" for k in range(self.delay_periods)]

    def _period(self, *, tick: bool) -> None:
        r = self.rows
        error = r["theta"] - r["pll_th"]
        r["pll_w"] = r["pll_w"] + self.drive["pll_ki_per_s2"] * self.ts_s * error
        r["pll_th"] = r["pll_th"] + self.ts_s * (r["pll_w"] + self.drive["pll_kp_per_s"] * error)
        for k in reversed(range(1, len(self.taps))):
            r[f"travel{k}"] = r[f"travel{k - 1}"]
        r["travel0"] = (r["theta"] - r["theta_before"]) / self.ts_s
        r["theta_before"] = r["theta"]
        if tick and self.inline:
            self._speed_loop()
        self._currents()
        if tick and not self.inline:
            self._speed_loop()  # its output waits for the next period
        acting = np.array([r[name] for name in ("id", "iq", "w", "theta", "vd", "vq", "ahead")])
        r["id"], r["iq"], r["w"], r["theta"] = (self.motor @ acting)[:4]
        r["vd"], r["vq"], r["ahead"] = self.next_voltage

    def _speed_loop(self) -> None:
        r, d = self.rows, self.drive
        if self.source == "mt":
            late_s = 0.5 / self.edges_per_s if self.edges_per_s > 0.0 else 0.0  # age of the last edge, in the mean
            edge = r["theta"] - min(late_s, self.ts_s * self.divider) * r["w"]
            seen = (edge - r["edge_before"]) / (self.ts_s * self.divider)
            r["edge_before"] = edge
        elif self.source == "pll":
            seen = r["pll_w"]
        else:
            seen = sum((tap * r[f"travel{k}"] for k, tap in enumerate(self.taps)), np.zeros(self.size + 1))
        self.seen = seen
        error = self.correction - d["speed_error_gain"] * seen
        r["iq_ref"] = r["x"] + d["speed_kp_a_per_unit"] * error
        r["x"] = r["x"] + d["speed_ki_a_per_unit_s"] * self.ts_s * self.divider * error

    def _currents(self) -> None:
        r = self.rows
        ref = r["iq_ref"]
        if self.delay_periods:
            ref = r[f"ref{self.delay_periods - 1}"]
            for k in reversed(range(1, self.delay_periods)):
                r[f"ref{k}"] = r[f"ref{k - 1}"]
            r["ref0"] = r["iq_ref"]
        volt_d, volt_q = self._deadbeat(ref) if self.deadbeat else self._pi(ref)
        advance = self.drive["angle_advance_periods"]
        ahead = r["theta"] + advance * self.ts_s * r["pll_w"]
        # acts from one period after the sample on, when the rotor has turned that far
        lead = (advance - 1.0) * self.ts_s * self.plant["pole_pairs"] * self.speed_rad_s
        cos, sin = math.cos(lead), math.sin(lead)
        self.next_voltage = (cos * volt_d - sin * volt_q, sin * volt_d + cos * volt_q, ahead)

    def _pi(self, ref: Array) -> tuple[Array, Array]:
        r, d = self.rows, self.drive
        volts = []
        for axis, error in (("d", -r["id"]), ("q", ref - r["iq"])):
            volts.append(r[f"x{axis}"] + d["current_kp_v_per_a"] * error)
            r[f"x{axis}"] = r[f"x{axis}"] + d["current_ki_v_per_as"] * self.ts_s * error
        return volts[0], volts[1]

    def _deadbeat(self, ref: Array) -> tuple[Array, Array]:
        """Deadbeat control as in control/motor/deadbeat.h: prediction, correction of what it misses, voltage."""
        r, d = self.rows, self.drive
        we = d["pole_pairs"] * self.speed_rad_s
        ld, lq, psi = d["motor_ld_h"], d["motor_lq_h"], d["motor_psi_wb"]
        iq0 = self.plant["viscous_nms"] * self.speed_rad_s / (1.5 * self.plant["pole_pairs"] * self.plant["psi_wb"])

        def drop(i_d: Array, i_q: Array) -> tuple[Array, Array]:
            turning = d["pole_pairs"] * r["pll_w"]
            in_d = d["motor_resistance_ohm"] * i_d - we * lq * i_q - lq * iq0 * turning
            return in_d, d["motor_resistance_ohm"] * i_q + we * ld * i_d + psi * turning

        i_d, i_q = r["id"], r["iq"]
        for axis, current in (("d", i_d), ("q", i_q)):
            r[f"c{axis}"] = r[f"c{axis}"] + d["deadbeat_correction"] * (current - r[f"guess_{axis}"])
        t_d, t_q = self.ts_s / ld, self.ts_s / lq
        now = drop(i_d, i_q)
        rise_d, rise_q = r["cd"] + t_d * (r["last_d"] - now[0]), r["cq"] + t_q * (r["last_q"] - now[1])
        mid = drop(i_d + 0.5 * rise_d, i_q + 0.5 * rise_q)
        next_d = i_d + t_d * (r["last_d"] - mid[0]) + r["cd"]
        next_q = i_q + t_q * (r["last_q"] - mid[1]) + r["cq"]
        later = drop(0.5 * next_d, 0.5 * (next_q + ref))
        out_d = later[0] + (-next_d - r["cd"]) / t_d
        out_q = later[1] + (ref - next_q - r["cq"]) / t_q
        r["guess_d"], r["guess_q"] = next_d, next_q
        r["last_d"], r["last_q"] = out_d, out_q
        return out_d, out_q
