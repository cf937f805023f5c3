"""The drive of the log format around a machine of motulator: a third simulator, apart from the other two.

The machine and the shaft are motulator's (`SynchronousMachine`, `StiffMechanicalSystem`, `TwoMassMechanicalSystem`,
`ExternalRotorSpeed`), integrated here by fixed steps. Sensors, controller and average-voltage bridge follow
docs/log-format.md and are written apart from the firmware and from the referee. What motulator leaves to its user is
done as its manual suggests: friction is a coefficient that depends on the speed, saturation a current that is a
function of the flux linkages.

It takes the parameters of the referee (`evenspin.blind.referee`) as far as it has them, and refuses the others.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.blind.referee import PWM_HZ, Inputs, defaults
from evenspin.errors import InputError
from evenspin.log.columns import LOG_COLUMNS

TS_S = 1.0 / PWM_HZ
SUBSTEPS = 2  # of a control period; Runge-Kutta of fourth order
# Below this speed the friction of a coefficient that depends on the speed is viscous: it does not hold a shaft.
SLOW_RAD_S = 0.05
EFFECTS = (
    "coulomb_friction",
    "stribeck_friction",
    "viscous_friction",
    "inertia",
    "torque_constant",
    "winding_resistance",
    "inductance_saturation",
    "two_mass",
)
_GROUPS = ("motor", "sensor", "bridge", "drive", "run", *EFFECTS)
# What the vocabulary leaves open: here friction acts on the second mass, and each axis saturates for itself.
LEFT_OPEN = {"motor.load_friction_share": 1.0, "inductance_saturation.per_axis": 1.0}
_LEFT_OUT = ("bridge.edges", "bridge.residual_dead_time_s", "run.mean")  # must be 0
TRUE_SIGNALS = ("true_speed_rad_s",)

Array = NDArray[np.float64]


def simulate(parameters: Mapping[str, float], inputs: Inputs, decimate: int) -> dict[str, Array]:
    """As `evenspin.blind.referee.simulate`, but the columns of the log and the true speed only."""
    p = defaults() | dict(parameters)
    _need_supported(p)
    plant, controller, sensors = _Plant(p), _Controller(p), _Sensors(p)
    controller.angle_rad = sensors.count(plant.angle_rad)
    rows = []
    waiting_v = 0j
    columns = (inputs.speed_ref_rad_s, inputs.id_ref_a, inputs.iq_ref_a, inputs.load_torque_nm, inputs.current_mode)
    for n, (speed, id_ref, iq_ref, load, mode) in enumerate(zip(*(c.tolist() for c in columns), strict=True)):
        ia, ib, angle = sensors.sample(plant)
        asked_v = controller.step(ia, ib, angle, speed, complex(id_ref, iq_ref), mode != 0.0)
        if n % decimate == 0:
            c = controller
            rows.append(
                (n * TS_S, speed, c.speed, angle, c.ref.real, c.ref.imag, c.i.real, c.i.imag, ia, ib)
                + (c.v.real, c.v.imag, p["bridge.dc_link_v"], load, plant.speed)
            )
        plant.step(waiting_v, load)
        waiting_v = asked_v
    table = np.array(rows)
    record = dict(zip((*LOG_COLUMNS, *TRUE_SIGNALS), table.T, strict=True))
    noise = sensors.rng.standard_normal((2, len(table)))
    record["vdc_v"] = record["vdc_v"] + p["sensor.vdc_noise_v"] * noise[0]
    record["load_torque_nm"] = record["load_torque_nm"] + p["sensor.load_noise_nm"] * noise[1]
    return record


def _need_supported(p: Mapping[str, float]) -> None:
    nothing = defaults()
    if p["inductance_saturation.i_sat_a"] and not p["inductance_saturation.per_axis"]:
        raise InputError("motulator", "inductance_saturation.per_axis", 0, "1", "here each axis saturates for itself")
    for name, value in p.items():
        foreign = name.split(".")[0] not in _GROUPS or name in _LEFT_OUT
        if foreign and value != nothing[name]:
            raise InputError("motulator", name, value, f"{nothing[name]:g}", f"it can hide {', '.join(EFFECTS)}")


class _Plant:
    """motulator's machine and shaft."""

    def __init__(self, p: Mapping[str, float]) -> None:
        from motulator.drive import model, utils

        self.ratio = p["motor.pole_pairs"]
        psi = p["motor.psi_wb"]
        par = utils.SynchronousMachinePars(
            n_p=p["motor.pole_pairs"],
            R_s=p["motor.resistance_ohm"],
            L_d=p["motor.ld_h"],
            L_q=p["motor.lq_h"],
            psi_f=psi,
        )
        self.machine: Any = model.SynchronousMachine(par, i_s=_saturated(p))
        self.load_nm = 0.0
        self.shaft: Any = _shaft(p, model, utils, lambda _: self.load_nm)
        start = p["motor.start_angle_rad"]
        self.machine.state = SimpleNamespace(psi_s=complex(psi), exp_j_theta_m=cmath.exp(1j * self.ratio * start))
        self.shaft.state.exp_j_theta_M = cmath.exp(1j * start)

    @property
    def angle_rad(self) -> float:
        return cmath.phase(self.shaft.state.exp_j_theta_M)

    @property
    def speed(self) -> float:
        return float(getattr(self.shaft.state, "w_M", 0.0).real)

    @property
    def current_a(self) -> complex:
        """In the stationary frame."""
        return complex(self.machine.i_s * self.machine.state.exp_j_theta_m)

    def step(self, v: complex, load_nm: float) -> None:
        """A control period under one voltage vector of the stationary frame."""
        self.load_nm = load_nm
        h = TS_S / SUBSTEPS
        for _ in range(SUBSTEPS):
            start = self._states()
            k1 = self._rates(v)
            k2 = self._rates_at(start, k1, 0.5 * h, v)
            k3 = self._rates_at(start, k2, 0.5 * h, v)
            k4 = self._rates_at(start, k3, h, v)
            self._put(
                [x + h / 6.0 * (a + 2.0 * (b + c) + d) for x, a, b, c, d in zip(start, k1, k2, k3, k4, strict=True)]
            )
        state = self.machine.state  # the vectors of the angles stay on the unit circle
        state.exp_j_theta_m /= abs(state.exp_j_theta_m)
        self.shaft.state.exp_j_theta_M /= abs(self.shaft.state.exp_j_theta_M)

    def _states(self) -> list[complex]:
        return [*vars(self.machine.state).values(), *vars(self.shaft.state).values()]

    def _put(self, values: list[complex]) -> None:
        both = (self.machine.state, self.shaft.state)
        keys = [(state, key) for state in both for key in vars(state)]
        for (state, key), value in zip(keys, values, strict=True):
            setattr(state, key, value)

    def _rates_at(self, start: list[complex], rate: list[complex], h: float, v: complex) -> list[complex]:
        self._put([x + h * k for x, k in zip(start, rate, strict=True)])
        return self._rates(v)

    def _rates(self, v: complex) -> list[complex]:
        machine, shaft = self.machine, self.shaft
        machine.set_outputs(0.0)
        shaft.set_outputs(0.0)
        machine.inp.u_ss, machine.inp.w_M = v, shaft.out.w_M
        shaft.inp.tau_M = machine.out.tau_M
        return [*machine.rhs(), *shaft.rhs()]


def _saturated(p: Mapping[str, float]) -> Callable[[complex], complex] | None:
    """Per axis: the differential inductance L / (1 + (i / i_sat)^2) has the flux L i_sat atan(i / i_sat)."""
    i_sat = p["inductance_saturation.i_sat_a"]
    if i_sat == 0.0:
        return None
    ld, lq, psi = p["motor.ld_h"], p["motor.lq_h"], p["motor.psi_wb"]

    def current(flux: complex) -> complex:
        return i_sat * complex(math.tan((flux.real - psi) / (ld * i_sat)), math.tan(flux.imag / (lq * i_sat)))

    return current


def _shaft(p: Mapping[str, float], model: Any, utils: Any, load: Callable[[float], float]) -> Any:
    if p["motor.locked"]:
        return model.ExternalRotorSpeed(lambda _: 0.0)
    dry, low, slow = (
        p["coulomb_friction.torque_nm"],
        p["stribeck_friction.torque_nm"],
        p["stribeck_friction.speed_rad_s"],
    )
    viscous = p["motor.viscous_nms"]

    def coefficient(speed: float) -> float:
        """Of the friction; motulator multiplies it with the speed."""
        torque = dry + low * math.exp(-((speed / slow) ** 2))
        return viscous + torque / max(speed, SLOW_RAD_S)

    friction = coefficient if dry or low else viscous
    inertia, hz = p["motor.inertia_kgm2"], p["two_mass.f_res_hz"]
    if hz == 0.0:
        return model.StiffMechanicalSystem(J=inertia, B_L=friction, tau_L=load)
    ratio = p["two_mass.load_ratio"]
    rotor, behind = (1.0 - ratio) * inertia, ratio * inertia
    reduced, w = rotor * behind / inertia, 2.0 * math.pi * hz
    par = utils.TwoMassMechanicalSystemPars(
        J_M=rotor, J_L=behind, K_S=reduced * w * w, C_S=2.0 * p["two_mass.damping_ratio"] * reduced * w, B_L=friction
    )
    return model.TwoMassMechanicalSystem(par, tau_L=load)


class _Sensors:
    """Encoder counts and two phase currents with noise and steps."""

    def __init__(self, p: Mapping[str, float]) -> None:
        self.count_rad = 2.0 * math.pi / p["sensor.counts_per_rev"]
        self.noise_a, self.lsb_a = p["sensor.current_noise_a"], p["sensor.current_lsb_a"]
        self.gain = (p["sensor.gain_a"], p["sensor.gain_b"])
        self.offset_a = (p["sensor.offset_a_a"], p["sensor.offset_b_a"])
        self.rng = np.random.default_rng(int(p["run.seed"]))
        self.drawn: list[float] = []

    def count(self, angle_rad: float) -> float:
        return math.floor((angle_rad % (2.0 * math.pi)) / self.count_rad) * self.count_rad

    def sample(self, plant: _Plant) -> tuple[float, float, float]:
        i = plant.current_a
        return (
            self._converted(i.real, 0),
            self._converted(-0.5 * i.real + 0.5 * math.sqrt(3.0) * i.imag, 1),
            self.count(plant.angle_rad),
        )

    def _converted(self, amps: float, phase: int) -> float:
        if not self.drawn:
            self.drawn = self.rng.standard_normal(10000).tolist()
        seen = self.gain[phase] * amps + self.offset_a[phase] + self.noise_a * self.drawn.pop()
        return round(seen / self.lsb_a) * self.lsb_a if self.lsb_a > 0.0 else seen


class _Controller:
    """docs/log-format.md, word for word: tracking filter, speed PI every tenth period, current PI per axis."""

    def __init__(self, p: Mapping[str, float]) -> None:
        self.ratio = p["motor.pole_pairs"]
        self.kp, self.ki = p["drive.current_kp_v_per_a"], p["drive.current_ki_v_per_as"]
        self.speed_kp, self.speed_ki = p["drive.speed_kp_a_per_rad_s"], p["drive.speed_ki_a_per_rad"]
        self.every = int(p["drive.speed_periods"])
        self.limit_a, self.limit_v = p["drive.iq_limit_a"], p["bridge.dc_link_v"] / math.sqrt(3.0)
        self.pll_kp, self.pll_ki = p["drive.pll_kp"], p["drive.pll_ki"]
        self.advance_s = p["drive.angle_advance_periods"] * TS_S
        self.speed = self.angle_rad = self.speed_sum = 0.0
        self.sum = self.i = self.v = self.ref = 0j
        self.was_current_mode, self.period = False, 0

    def step(self, ia: float, ib: float, angle: float, speed_ref: float, i_ref: complex, current_mode: bool) -> complex:
        """The voltage of the stationary frame that is to act in the next period."""
        error = math.remainder(angle - self.angle_rad, 2.0 * math.pi)
        self.speed += self.pll_ki * error * TS_S
        self.angle_rad += (self.speed + self.pll_kp * error) * TS_S
        electrical = self.ratio * angle
        self.i = complex(ia, (ia + 2.0 * ib) / math.sqrt(3.0)) * cmath.exp(-1j * electrical)
        if current_mode:
            if not self.was_current_mode:
                self.speed_sum = 0.0
            self.ref = i_ref
        elif self.period % self.every == 0:
            self.ref = complex(i_ref.real, self._speed_loop(speed_ref))
        else:
            self.ref = complex(i_ref.real, self.ref.imag)
        self.was_current_mode = current_mode
        self.period += 1
        miss = self.ref - self.i
        self.v = self.kp * miss + self.sum
        if abs(self.v) > self.limit_v:
            self.v *= self.limit_v / abs(self.v)
        else:
            self.sum += self.ki * TS_S * miss
        return self.v * cmath.exp(1j * (electrical + self.advance_s * self.ratio * self.speed))

    def _speed_loop(self, speed_ref: float) -> float:
        error = speed_ref - self.speed
        wanted = self.speed_kp * error + self.speed_sum
        given = min(max(wanted, -self.limit_a), self.limit_a)
        if given == wanted or error * wanted < 0.0:
            self.speed_sum += self.speed_ki * self.every * TS_S * error
        return given
