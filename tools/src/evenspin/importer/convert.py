"""Apply a map to a table: columns of the log format in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable
from collections.abc import Mapping as MappingType
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError
from evenspin.importer import frames
from evenspin.importer.mapping import HINT, ColumnMap, Mapping
from evenspin.importer.motion import (
    FAR,
    FORETOLD,
    foretold,
    is_whole,
    likeness,
    turn_of,
    unwrapped,
    unwrapped_along,
    wrap_period,
    wrap_span,
)
from evenspin.importer.names import QUANTITIES
from evenspin.importer.table import Array, RawColumn, RawTable
from evenspin.importer.units import split_unit, unit_of
from evenspin.plausible.finding import rms
from evenspin.plausible.torque import acceleration_factor, work_share
from evenspin.plausible.windings import LEAST_BLOCKS, blocks_of

INVARIANT = math.sqrt(2.0 / 3.0)
SHOWS = 0.3  # correlation of current and acceleration from which its sign decides
SURE = 0.9  # of 1: how clearly phase currents have to be dq currents turned by an angle
DQ = ("iq_a", "id_a", "iq_ref_a", "id_ref_a", "vq_v", "vd_v")


@dataclass(frozen=True, slots=True)
class Imported:
    """Columns of the log format, a number per row of the file. `notes`: what was done and what was assumed."""

    columns: MappingType[str, Array]
    pole_pairs: int | None
    electrical_zero_rad: float | None
    notes: tuple[str, ...]


def import_table(table: RawTable, mapping: Mapping) -> Imported:
    """Every quantity of the map in SI units; phase quantities are turned into dq where the map has an angle."""
    notes = [*table.notes, *mapping.notes]
    si = {name: _converted(table, mapping, name, column) for name, column in mapping.columns.items()}
    if "t_s" not in si:
        if mapping.rate_hz is None:
            raise InputError(table.path, "t_s", "(missing)", "a column of time, or rate_hz", HINT)
        si["t_s"] = np.arange(len(table)) / mapping.rate_hz
    else:
        si["t_s"] = si["t_s"] - si["t_s"][0]
    _far_apart(table, mapping, si, notes)
    pairs, zero = mapping.pole_pairs, mapping.electrical_zero_rad
    if "theta_m_rad" not in si and "theta_e_rad" in si:
        if pairs is None:
            raise InputError(table.path, "pole_pairs", "(missing)", "given with an electrical angle", HINT)
        si["theta_m_rad"] = si["theta_e_rad"] / pairs
        notes.append(f"mechanical angle from the electrical one and {pairs} pole pairs: its zero is one of {pairs}")
    if mapping.power_invariant:
        si |= {name: si[name] * INVARIANT for name in DQ if name in si}
        notes.append("dq quantities are power-invariant in the file: brought to amplitude-invariant")
    if "iq_a" not in si:
        pairs, zero = _rotor_frame(table, si, pairs, zero, notes)
    else:
        pairs = _beside(table, si, pairs, notes)
    if zero is not None and pairs is not None and "theta_m_rad" in si:
        si["theta_m_rad"] = si["theta_m_rad"] + zero / pairs  # so that the format's electrical angle, p theta, is right
    _voltages(si, pairs)
    columns = {name: values for name, values in si.items() if name in QUANTITIES}
    return Imported(columns, pairs, zero, tuple(notes))


def _converted(table: RawTable, mapping: Mapping, quantity: str, column: ColumnMap) -> Array:
    raw = _source(table, column.source)
    if raw is None:
        names = ", ".join(table.names[:30])
        raise InputError(table.path, f"columns.{quantity}.from", column.source, f"one of {names}", HINT)
    values = raw.values
    if QUANTITIES[quantity] == "angle":
        values = unwrapped(values, _period_of(values))
    return np.asarray((values + column.offset) * _si_per_unit(table, mapping, quantity))


def _si_per_unit(table: RawTable, mapping: Mapping, quantity: str) -> float:
    """SI units of a quantity for each unit of its column, the scale of the map included."""
    column = mapping.columns[quantity]
    unit = unit_of(column.unit)
    factor = 1.0 if unit is None else unit.si
    if unit is not None and unit.counts:
        if mapping.counts_per_turn is None:
            raise InputError(
                table.path, "counts_per_turn", "(missing)", f"given, because {quantity} is in counts", HINT
            )
        factor = unit.si / mapping.counts_per_turn
    if unit is not None and unit.electrical and quantity != "theta_e_rad":
        if mapping.pole_pairs is None:
            raise InputError(table.path, "pole_pairs", "(missing)", f"given, because {quantity} is electrical", HINT)
        factor /= mapping.pole_pairs
    return column.scale * factor


def _period_of(values: Array) -> float | None:
    """After how much an angle starts again."""
    span = wrap_span(values)
    turn = turn_of(span, is_whole(values)) if span is not None else None
    return turn[1] if turn is not None else None if span is None else wrap_period(values, span)


def _far_apart(table: RawTable, mapping: Mapping, si: dict[str, Array], notes: list[str]) -> None:
    """An angle that goes round more than once from row to row is followed by the speed."""
    for name, pairs in (("theta_m_rad", 1), ("theta_e_rad", mapping.pole_pairs)):
        if name not in si or "speed_rad_s" not in si or pairs is None:
            continue
        raw = _source(table, mapping.columns[name].source)
        period = _period_of(raw.values) if raw is not None else None
        if raw is None or period is None:
            continue
        turn_rad = abs(period * _si_per_unit(table, mapping, name))
        steps = pairs * foretold(si["t_s"], si["speed_rad_s"])
        if np.max(np.abs(steps)) > FAR * turn_rad and likeness(si[name], turn_rad, steps) > FORETOLD:
            si[name] = unwrapped_along(si[name], turn_rad, steps)
            notes.append(
                f"{raw.name!r} turns by up to {float(np.max(np.abs(steps))) / turn_rad:.2f} turns from row to row: "
                "how often it went round is taken from the speed"
            )


def _source(table: RawTable, name: str) -> RawColumn | None:
    found = table.column(name) or table.column(split_unit(name)[0])  # as it stands in the header, too
    if found is None and name.isdigit() and 1 <= int(name) <= len(table.columns):
        found = table.columns[int(name) - 1]
    return found


def _rotor_frame(
    table: RawTable, si: dict[str, Array], pairs: int | None, zero: float | None, notes: list[str]
) -> tuple[int | None, float | None]:
    """iq and id from phase or stationary-frame currents."""
    if not ({"ialpha_a", "ibeta_a"} <= set(si) or {"ia_a", "ib_a"} <= set(si)):
        raise InputError(table.path, "iq_a", "(missing)", "a column, or two phase currents and an angle", HINT)
    alpha, beta = _stationary_currents(si)
    if "theta_e_rad" in si and zero is None:
        theta_e = si["theta_e_rad"]
        notes.append("iq_a and id_a from the phase currents and the electrical angle of the file")
    elif "theta_m_rad" in si:
        theta_m = si["theta_m_rad"]
        good = np.isfinite(alpha) & np.isfinite(beta) & np.isfinite(theta_m)
        found, direction, clear = frames.pole_pairs_of(alpha[good], beta[good], theta_m[good])
        if pairs is None:
            if clear < frames.CLEAR:
                raise InputError(table.path, "pole_pairs", "(not to be seen in the currents)", "given", HINT)
            pairs = found
            notes.append(f"{pairs} pole pairs: with them the current vector turns with the shaft ({clear:.2f} of 1)")
        elif clear > frames.CLEAR and found != pairs:
            raise InputError(
                table.path, "pole_pairs", pairs, f"{found}, as often as the currents turn per revolution", HINT
            )
        if direction < 0 and clear > frames.CLEAR:
            raise InputError(
                table.path,
                "ia_a, ib_a",
                "turning against the angle",
                "in the order of the phases",
                "exchange two phases, or turn the angle round (scale = -1)",
            )
        theta_e = pairs * theta_m
        if zero is None:
            zero, clear = frames.zero_of(alpha[good], beta[good], theta_e[good], _drives(si, good))
            if clear < frames.CLEAR:
                raise InputError(table.path, "electrical_zero_rad", "(not to be seen in the currents)", "given", HINT)
            if _magnets_point_back(si, good, theta_e + zero):
                zero = math.remainder(zero + math.pi, 2.0 * math.pi)
            notes.append(
                f"electrical zero {zero:.4f} rad, for a drive that keeps id at 0 ({clear:.2f} of 1); "
                "with MTPA it is off by the angle of the current"
            )
        theta_e = theta_e + zero
    else:
        raise InputError(table.path, "theta_m_rad", "(missing)", "a column: phase currents need an angle", HINT)
    si["id_a"], si["iq_a"] = frames.park(alpha, beta, theta_e)
    si["theta_e_rad"] = theta_e
    return pairs, zero


def _beside(table: RawTable, si: dict[str, Array], pairs: int | None, notes: list[str]) -> int | None:
    """Phase currents beside dq ones tell the electrical zero, and contradict wrong pole pairs."""
    if not {"id_a", "ia_a", "ib_a", "theta_m_rad"} <= set(si):
        return pairs
    alpha, beta = frames.clarke(si["ia_a"], si["ib_a"], si.get("ic_a"))
    names = ("id_a", "iq_a", "theta_m_rad")
    good = np.isfinite(alpha) & np.isfinite(beta) & np.all([np.isfinite(si[name]) for name in names], axis=0)
    d, q, theta = (si[name][good] for name in names)
    found, zero, clear = frames.zero_between(alpha[good], beta[good], d, q, theta, None)
    if clear < SURE:
        for name in ("ia_a", "ib_a"):
            del si[name]
        notes.append(f"phase currents left out: no angle makes them the dq currents ({clear:.2f} of 1)")
        return pairs
    if pairs is not None and found != pairs:
        hint = "correct it, or the unit of the angle"
        raise InputError(table.path, "pole_pairs", pairs, f"{found}, with which phase and dq currents agree", hint)
    si["theta_m_rad"] = si["theta_m_rad"] + zero / found
    notes.append(
        f"{found} pole pairs and electrical zero {zero:.3f} rad, from phase and dq currents: the angle is shifted by it"
    )
    return found


def _speed(si: dict[str, Array]) -> Array:
    speed = si["speed_rad_s"] if "speed_rad_s" in si else np.gradient(np.unwrap(si["theta_m_rad"]), si["t_s"])
    return np.nan_to_num(speed)


def _magnets_point_back(si: dict[str, Array], good: NDArray[np.bool_], theta_e: Array) -> bool:
    """Whether the voltages show that this angle is half a turn off, since the back-EMF is ahead of the magnets.

    They are asked where the acceleration does not show the sign of torque: where a load drives, the current brakes.
    """
    volts = _stationary_voltages(si)
    if volts is None:
        return False
    alpha, beta = (np.asarray(each) for each in volts)
    good = good & np.isfinite(alpha) & np.isfinite(beta)
    _, vq = frames.park(alpha[good], beta[good], theta_e[good])
    i_alpha, i_beta = _stationary_currents(si)
    _, iq = frames.park(i_alpha[good], i_beta[good], theta_e[good])
    t_s, speed = si["t_s"][good], _speed(si)[good]
    blocks = blocks_of({"t_s": t_s, "vq_v": vq, "iq_a": iq, "speed_rad_s": speed})
    if len(blocks["t_s"]) < LEAST_BLOCKS or abs(acceleration_factor(t_s, speed, iq)[1]) > SHOWS:
        return False
    terms = np.column_stack([blocks["iq_a"], blocks["speed_rad_s"]])
    (_, flux_vs), *_ = np.linalg.lstsq(terms, blocks["vq_v"], rcond=None)
    return bool(flux_vs < 0.0 and rms(flux_vs * blocks["speed_rad_s"]) > SHOWS * rms(blocks["vq_v"]))


def _drives(si: dict[str, Array], good: NDArray[np.bool_]) -> Callable[[Array], bool]:
    """Whether a q current speeds the shaft up, or where that does not show, works against friction."""
    t = si["t_s"][good]
    speed = _speed(si)[good]

    def fits(iq: Array) -> bool:
        _, like = acceleration_factor(t, speed, iq)
        return like > 0.0 if abs(like) > SHOWS else work_share(speed, iq) > 0.0

    return fits


def _voltages(si: dict[str, Array], pairs: int | None) -> None:
    """vd and vq from phase voltages, stationary-frame ones, or duties and dc link, with the electrical angle."""
    theta_e = si.get("theta_e_rad")
    if theta_e is None and pairs is not None and "theta_m_rad" in si:
        theta_e = pairs * si["theta_m_rad"]
    volts = _stationary_voltages(si)
    if "vq_v" in si or theta_e is None or volts is None:
        return
    si["vd_v"], si["vq_v"] = frames.park(*volts, theta_e)


def _stationary_currents(si: dict[str, Array]) -> tuple[Array, Array]:
    if {"ialpha_a", "ibeta_a"} <= set(si):
        return si["ialpha_a"], si["ibeta_a"]
    return frames.clarke(si["ia_a"], si["ib_a"], si.get("ic_a"))


def _stationary_voltages(si: dict[str, Array]) -> tuple[Array, Array] | None:
    if {"valpha_v", "vbeta_v"} <= set(si):
        return si["valpha_v"], si["vbeta_v"]
    if {"va_v", "vb_v", "vc_v"} <= set(si):
        return frames.clarke(si["va_v"], si["vb_v"], si["vc_v"])
    if {"duty_a", "duty_b", "duty_c", "vdc_v"} <= set(si):
        a, b, c = (si[name] * si["vdc_v"] for name in ("duty_a", "duty_b", "duty_c"))
        return frames.clarke(a, b, c)
    return None
