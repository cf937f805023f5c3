"""Motor data that the model file leaves open, from the logs: first values, which the fit of everything then improves.

vd = R id + Ld did/dt - we Lq iq          vq = R iq + Lq diq/dt + we Ld id + we psi
1.5 p (psi iq + (Ld - Lq) id iq) - load = J dw/dt + B w + friction sign(w) + constant load
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError
from evenspin.weakform.signals import Signals
from evenspin.weakform.windows import Bump, Windows

Array = NDArray[np.float64]

ELECTRICAL = ("resistance_ohm", "ld_h", "lq_h", "psi_wb")
MECHANICAL = ("inertia_kgm2", "viscous_nms")
MOTOR = (*ELECTRICAL, *MECHANICAL)
SHAFT_S, WINDING_S = 20e-3, 6e-3
HUBER, ROUNDS = 2.0, 10
KNOWN = 0.3  # standard deviation over value, above which a number counts as not shown
MOVES = 0.15  # of iq, rms, that a d current has to have for an inductance of its own


def first_values(logs: Sequence[Signals], plant: dict[str, float], missing: Sequence[str]) -> dict[str, float]:
    """@p plant with what is missing. What the logs do not show is one error that names it."""
    found = dict(plant)
    electrical = [name for name in ELECTRICAL if name in missing]
    mechanical = [name for name in MECHANICAL if name in missing]
    if electrical:
        found |= _electrical(logs, found, electrical)
    if mechanical:
        found |= _mechanical(logs, found, mechanical)
    return found


def _electrical(logs: Sequence[Signals], plant: dict[str, float], missing: list[str]) -> dict[str, float]:
    p = plant["pole_pairs"]
    rows, right = [], []
    alone = _rms([log.id_a for log in logs]) < MOVES * _rms([log.iq_a for log in logs])
    for log in logs:
        if log.vd_v is None or log.vq_v is None:
            continue
        over = Windows.over(len(log), Bump.of(WINDING_S, log.period_s))
        over = over.where(over.all_of(log.good))
        we = p * log.speed_rad_s
        none = np.zeros(np.count_nonzero(over.used))
        d = (over.value(log.id_a), over.slope(log.id_a), -over.value(we * log.iq_a), none)
        q = (over.value(log.iq_a), over.value(we * log.id_a), over.slope(log.iq_a), over.value(we))
        rows += [np.column_stack(d), np.column_stack(q)]
        right += [over.value(log.vd_v), over.value(log.vq_v)]
    if not rows:
        raise _not_shown(missing, "logs without voltages", "record the commanded voltages, or state it")
    x, y = np.concatenate(rows), np.concatenate(right)
    columns = [x[:, 0], x[:, 1] + x[:, 2], x[:, 3]] if alone else list(x.T)
    names = [("resistance_ohm",), ("ld_h", "lq_h"), ("psi_wb",)] if alone else [(name,) for name in ELECTRICAL]
    return _solved(columns, names, y, plant, missing)


def _mechanical(logs: Sequence[Signals], plant: dict[str, float], missing: list[str]) -> dict[str, float]:
    p = plant["pole_pairs"]
    parts: list[Array] = []
    right: list[Array] = []
    top = max(float(np.percentile(np.abs(log.speed_rad_s), 99.0)) for log in logs)
    for log in logs:
        over = Windows.over(len(log), Bump.of(SHAFT_S, log.period_s))
        over = over.where(over.all_of(log.good & (np.abs(log.speed_rad_s) > 0.02 * top)))
        made = 1.5 * p * (plant["psi_wb"] + (plant["ld_h"] - plant["lq_h"]) * log.id_a) * log.iq_a - log.load_nm
        moved = over.curve(log.theta_m_rad) if log.has_angle else over.slope(log.speed_rad_s)
        speed = over.value(log.speed_rad_s)
        parts.append(np.column_stack((moved, speed, np.sign(speed), np.ones(len(speed)))))
        right.append(over.value(made))
    x = np.concatenate(parts)
    names: list[tuple[str, ...]] = [("inertia_kgm2",), ("viscous_nms",), (), ()]
    return _solved(list(x.T), names, np.concatenate(right), plant, missing)


def _solved(
    columns: Sequence[Array], names: Sequence[tuple[str, ...]], y: Array, plant: dict[str, float], missing: list[str]
) -> dict[str, float]:
    """Robust least squares of what is missing, with the rest as it is stated."""
    free = [k for k, own in enumerate(names) if not own or any(name in missing for name in own)]
    left = y.copy()
    for k, own in enumerate(names):
        if k not in free:
            left -= columns[k] * plant[own[0]]
    x = np.column_stack([columns[k] for k in free])
    scale = np.sqrt(np.mean(x * x, axis=0))
    scale[scale == 0.0] = 1.0
    x = x / scale
    w = np.ones(len(left))
    value, spread = np.zeros(len(free)), np.full(len(free), np.inf)
    for _ in range(ROUNDS):
        normal = x.T @ (w[:, None] * x) + 1e-12 * len(left) * np.eye(len(free))
        value = np.linalg.solve(normal, x.T @ (w * left))
        rest = left - x @ value
        sigma = max(1.4826 * float(np.median(np.abs(rest))), 1e-30)
        w = np.minimum(1.0, HUBER * sigma / np.maximum(np.abs(rest), 1e-30))
        spread = 2.0 * sigma * np.sqrt(np.diag(np.linalg.inv(normal)))
    found: dict[str, float] = {}
    for k, amount, unsure in zip(free, value / scale, spread / scale, strict=True):
        for name in names[k]:
            if name not in missing:
                continue
            if name != "viscous_nms" and not unsure < KNOWN * amount:
                raise _not_shown([name], f"{amount:.3g} +- {2.0 * unsure:.2g}", "state it, or record what shows it")
            found[name] = max(float(amount), 1e-9)
    return found


def _not_shown(names: Sequence[str], value: str, hint: str) -> InputError:
    return InputError("gap", ", ".join(names), value, "in the model, or shown by the log", hint)


def _rms(signals: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(signals) ** 2)))
