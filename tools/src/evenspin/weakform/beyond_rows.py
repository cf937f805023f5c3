"""Terms of the empirical library as columns of the equations of a log."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Scale
from evenspin.empirical.library import Family, Shape
from evenspin.empirical.rows import Column, Rows
from evenspin.weakform.equations import Equations
from evenspin.weakform.search import SHAFT_PARTS
from evenspin.weakform.terms import Kind, Term
from evenspin.weakform.windows import Windows

Array = NDArray[np.float64]

TORQUE_SHARE = 0.004  # of the rated torque, rms: the least that a term counts for
VOLTS_SHARE = 0.04  # of the voltage over the resistance at the rated current
LOW = {"N m": -np.inf, "V": -np.inf, "ohm": -14.0, "1": -25.0}  # least sizes: -70 % of a resistance, -50 % of a share
HIGH = {"N m": np.inf, "V": np.inf, "ohm": 60.0, "1": 50.0}
FREE = 60.0  # times its least size that a term may be
FREE_START = 1.0  # the same, of what a change with time starts from


def rows_of(e: Equations, scale: Scale, top_rad_s: float, zero_rad: float = 0.0) -> Rows:
    """`zero_rad`: error of the electrical zero, by which currents and voltages are turned into the rotor frame."""
    s, p = e.signals, e.plant["pole_pairs"]
    d_a, q_a = turned(s.id_a, s.iq_a, zero_rad)
    vd_v, vq_v = (None, None) if s.vd_v is None or s.vq_v is None else turned(s.vd_v, s.vq_v, zero_rad)
    flux = e.plant["psi_wb"] + (e.plant["ld_h"] - e.plant["lq_h"]) * d_a
    return Rows(
        s.t_s,
        s.theta_m_rad,
        s.speed_rad_s,
        d_a,
        q_a,
        1.5 * p * flux * q_a,
        vd_v,
        vq_v,
        s.vdc_v,
        p,
        e.plant["psi_wb"],
        top_rad_s,
        4.0 * e.soft_rad_s,
        scale.rated_torque_nm,
        scale.rated_current_a,
        e.plant["dc_link_v"],
        s.shows_orders,
        s.one_travel,
    )


def turned(d: Array, q: Array, angle_rad: float) -> tuple[Array, Array]:
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.asarray(d * cos - q * sin), np.asarray(d * sin + q * cos)


def columns_of(e: Equations, columns: Sequence[Column]) -> list[Array | None]:
    """Per equation, what one unit of each coefficient takes from what is left."""
    parts: list[Array | None] = [_stack(w, [(c.torque, None) for c in columns]) for w in (e.shaft, e.fine)]
    if e.winding is not None:
        parts += [
            _stack(e.winding, [(c.d, c.d_linkage) for c in columns]),
            _stack(e.winding, [(c.q, c.q_linkage) for c in columns]),
        ]
    return parts


def _stack(over: Windows, pairs: Sequence[tuple[Array | None, Array | None]]) -> Array | None:
    if all(value is None and linkage is None for value, linkage in pairs):
        return None
    made = []
    for value, linkage in pairs:
        column = np.zeros(int(np.count_nonzero(over.used)))
        if value is not None:
            column = column - over.value(value)
        if linkage is not None:
            column = column - over.slope(linkage)
        made.append(column)
    return np.column_stack(made)


def edges_of(columns: Sequence[Sequence[Array | None]], sizes: dict[str, float], family: Family) -> Array:
    """Least coefficients: of a torque by what it changes in the windows, rms; else by `sizes`."""
    if family.unit != "N m":
        count = next(c.shape[1] for parts in columns for c in parts if c is not None)
        return np.full(count, family.least * sizes[family.unit])
    rms = []
    for k in range(SHAFT_PARTS):
        shown = [parts[k] for parts in columns]
        rms.append(np.sqrt(np.mean(np.concatenate([x for x in shown if x is not None]) ** 2, axis=0)))
    return np.asarray(sizes["N m"] / np.maximum(np.max(rms, axis=0), 1e-6))


def _label(family: Family, shape: Shape) -> str:
    said = [f"{name} {value:.7g}" for name, value in zip(family.shape, shape, strict=True)]
    return f"{family.name} ({', '.join(said)})" if said else family.name


def group_of(family: Family, shape: Shape) -> str:
    """Terms of a group are one cause: one of them acts."""
    if family.name == "angle_line":
        return f"{family.name} {shape[0]:.1f}"
    if family.name in ("torque_frequency", "supply_frequency"):
        return f"{family.name} {shape[0]:.0f}"
    if family.name in ("time_load", "time_friction", "time_viscous"):
        return "a torque that changes with time"
    return family.name


def term_of(
    family: Family,
    shape: Shape,
    sizes: dict[str, float],
    rows: Callable[[Equations], Rows],
    logs: Sequence[Equations],
    log: int | None,
) -> Term:
    """The library's term at a shape, for the search. `sizes`: least size of a coefficient by its unit."""

    def made(e: Equations) -> Sequence[Array | None]:
        return columns_of(e, family.columns(rows(e), shape))

    edges = edges_of([made(e) for e in logs], sizes, family)
    count = len(edges)
    least = sizes[family.unit]
    details = np.arange(count) >= (family.main or count)
    return Term(
        f"foreign: {_label(family, shape)}{'' if log is None else f' in log {log + 1}'}",
        Kind.FOREIGN,
        np.zeros(count),
        np.ones(count),
        edges * 1e-6,
        edges * np.where(details, FREE_START, FREE),
        np.full(count, LOW[family.unit] * least),
        np.full(count, HIGH[family.unit] * least),
        details,
        lambda z: float(np.linalg.norm((z / edges)[~details])),
        columns=made,
        effect=f"foreign: {group_of(family, shape)}",
        log=log,
        shaft_only=not family.electrical,
        over_angle=family.depends_on == "phase",
    )


def least_sizes(scale: Scale, plant: dict[str, float]) -> dict[str, float]:
    """By unit, the least coefficient that counts."""
    drop_v = VOLTS_SHARE * plant["resistance_ohm"] * scale.rated_current_a
    return {
        "N m": TORQUE_SHARE * scale.rated_torque_nm,
        "V": drop_v,
        "ohm": 0.05 * plant["resistance_ohm"],
        "1": 0.02,
    }
