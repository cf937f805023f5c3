"""Angle and speed: which columns, which units, mechanical or electrical, and in which direction."""

from __future__ import annotations

import math

import numpy as np

from evenspin.importer import motion
from evenspin.importer.choose import motion_by_data
from evenspin.importer.guess_time import times
from evenspin.importer.motion import Reading
from evenspin.importer.names import words_of
from evenspin.importer.state import State
from evenspin.importer.units import TURN, unit_of

Units = list[tuple[str, float]]

SPEED_UNITS = (("rad/s", 1.0), ("rpm", TURN / 60.0), ("turn/s", TURN), ("deg/s", TURN / 360.0))
ANGLE_UNITS = (("rad", 1.0), ("deg", TURN / 360.0), ("turn", TURN))
OMEGAS = ("w", "wm", "wr", "omega", "omega m", "omega r", "omega mech", "omega ref", "w ref", "omega soll", "w soll")
TURNS = ("n", "rpm", "drehzahl", "n soll", "n ist", "n ref", "n mot", "rpm ref")
SYMBOLS = dict.fromkeys(OMEGAS, "rad/s") | dict.fromkeys(TURNS, "rpm") | {"erpm": "erpm"}
LOOKS_LIKE = {
    60.0 / TURN: "rad/s and r/min exchanged",
    360.0 / TURN: "degrees and rad exchanged",
    TURN: "turns and rad exchanged",
    1e3: "ms and s exchanged",
}


def guess_motion(state: State) -> None:
    _columns(state)
    angle = next((name for name in ("theta_m_rad", "theta_e_rad") if name in state.chosen), None)
    speed = "speed_rad_s" if "speed_rad_s" in state.chosen else None
    angles = _angle_units(state, angle) if angle else []
    speeds = _speed_units(state, speed) if speed else []
    if angle and speed:
        _together(state, angle, speed, angles, speeds)
    _alone(state, angle, angles)
    _alone(state, speed, speeds)
    _reference(state)
    if angle == "theta_e_rad" and "theta_e_rad" in state.chosen and state.pole_pairs is None:
        state.questions.append(
            f"pole_pairs: {state.name('theta_e_rad')!r} is an electrical angle, and nothing tells the pole pairs"
        )
    for quantity in ("speed_rad_s", "speed_ref_rad_s"):
        unit = unit_of(state.units.get(quantity, ""))
        if unit is not None and unit.electrical and state.pole_pairs is None:
            state.questions.append(
                f"pole_pairs: {state.name(quantity)!r} is an electrical speed, and nothing tells the pole pairs"
            )
            return


def _columns(state: State) -> None:
    """By the numbers alone, where names say nothing."""
    t = state.seconds()
    if t is None or {"theta_m_rad", "theta_e_rad", "speed_rad_s"} & set(state.chosen):
        return
    free = [state.table.columns[i] for i in state.free()]
    units = [(column, unit_of(column.unit)) for column in free]
    found = motion_by_data(t, [c for c, unit in units if unit is None or unit.dimension in ("angle", "speed", "share")])
    if found is not None:
        state.chosen["theta_m_rad"], state.chosen["speed_rad_s"] = found


def _angle_units(state: State, quantity: str) -> Units:
    column = state.chosen[quantity].column
    unit = unit_of(column.unit)
    span = motion.wrap_span(column.values)
    turn = motion.turn_of(span, motion.is_whole(column.values)) if span is not None else None
    if unit is not None and unit.dimension == "angle":
        if not unit.counts:
            return [(column.unit, unit.si)]
        if state.counts is None and turn is not None and turn[0] == "counts":
            state.counts = turn[1]
            state.notes.append(f"{column.name!r} starts again after {turn[1]:g} counts: taken for a turn")
        if state.counts is None:
            state.questions.append(
                f"counts_per_turn: {column.name!r} is in counts, and nothing tells how many make a turn"
            )
            return []
        return [(column.unit, TURN / state.counts)]
    if turn is not None and turn[0] == "counts":
        if state.counts is None:
            state.counts = turn[1]
            state.notes.append(f"{column.name!r} starts again after {turn[1]:g}: taken for the counts of a turn")
        return [("counts", TURN / state.counts)]
    if turn is not None:
        return [(turn[0], TURN / turn[1])]
    return [*ANGLE_UNITS, *([("counts", TURN / state.counts)] if state.counts else [])]


def _speed_units(state: State, quantity: str) -> Units:
    column = state.chosen[quantity].column
    printed = column.unit or symbol_of(column.name)
    unit = unit_of(printed) if printed else None
    if unit is None or unit.dimension != "speed":
        return list(SPEED_UNITS)
    if unit.counts:
        if state.counts is None:
            state.questions.append(
                f"counts_per_turn: {column.name!r} is in counts, and nothing tells how many make a turn"
            )
            return []
        return [(printed, TURN / state.counts)]
    return [(printed, unit.si)]


def _together(state: State, angle: str, speed: str, angles: Units, speeds: Units) -> None:
    t = state.seconds()
    if t is None or not angles or not speeds:
        return
    values, rate = state.values(angle), state.values(speed)
    good = np.isfinite(t) & np.isfinite(values) & np.isfinite(rate)
    if np.count_nonzero(good) < 20 or np.ptp(values[good]) == 0.0 or np.ptp(rate[good]) == 0.0:
        return
    span = motion.wrap_span(values)
    turn = min((TURN / si for _, si in angles), key=lambda size: abs(size - span)) if span is not None else None
    if turn is not None and span is not None and motion.turn_of(span, motion.is_whole(values)) is None:
        turn = motion.wrap_period(values, span)  # not of a whole turn: the range of a protocol
    continuous = motion.unwrapped(values[good], turn)
    ratio, like = motion.ratio_of(t[good], continuous, rate[good])
    if not abs(like) > motion.CLEAR and turn is not None and len(speeds) == 1:
        steps = motion.foretold(t[good], rate[good]) * speeds[0][1] * turn / TURN
        pairs = motion.ratio_foretold(values[good], turn, steps, state.pole_pairs)
        if pairs is not None:
            continuous = motion.unwrapped_along(values[good], turn, pairs * steps)
            ratio, like = motion.ratio_of(t[good], continuous, rate[good])
    if not abs(like) > motion.CLEAR:
        state.questions.append(
            f"{angle}, {speed}: {state.name(speed)!r} is not the rate of change of {state.name(angle)!r} "
            f"(correlation {like:.2f}): do they belong to one shaft?"
        )
        return
    electrical_speed = unit_of(speeds[0][0]) is not None and unit_of(speeds[0][0]).electrical  # type: ignore[union-attr]
    if electrical_speed and angle == "theta_e_rad":
        _electrical_pair(state, angle, speed, angles, speeds, ratio)
        return
    pairs = state.pole_pairs
    found = motion.readings(ratio, motion.combinations(times(state), angles, speeds), pairs, angle == "theta_e_rad")
    simple = [reading for reading in found if reading.pole_pairs == 1] if angle == "theta_m_rad" else []
    best = simple or found
    inverse = []
    if not best or electrical_speed:
        back = [(time, s, a) for time, a, s in motion.combinations(times(state), angles, speeds)]
        inverse = motion.readings(1.0 / ratio, [((n, 1.0 / si), s, a) for (n, si), s, a in back], pairs, False)
    if electrical_speed and len(inverse) == 1:
        state.pole_pairs = pairs or inverse[0].pole_pairs
        state.units[angle], state.units[speed] = angles[0][0], speeds[0][0]
        _turn_round(state, angle, speed, inverse[0])
        state.because(speed, f"{inverse[0].pole_pairs} times the rate of {state.name(angle)!r}")
    elif len(best) == 1:
        _take(state, best[0], angle, speed)
    elif best:
        _ask(state, best, angle, speed)
    elif len(inverse) == 1 and inverse[0].pole_pairs > 1:
        _speed_is_electrical(state, inverse[0], angle, speed, angles, speeds)
    else:
        _contradiction(state, ratio, angle, speed, angles, speeds)


def _electrical_pair(state: State, angle: str, speed: str, angles: Units, speeds: Units, ratio: float) -> None:
    """Both electrical: their ratio is 1, and pole pairs have to come from elsewhere."""
    found = motion.readings(ratio, motion.combinations(times(state), angles, speeds), 1, False)
    if len(found) == 1:
        state.units[angle], state.units[speed] = found[0].angle_unit, found[0].speed_unit
        if "t_s" in state.chosen:
            state.units.setdefault("t_s", found[0].time_unit)
        _turn_round(state, angle, speed, found[0])
    else:
        _contradiction(state, ratio, angle, speed, angles, speeds)


def _take(state: State, reading: Reading, angle: str, speed: str) -> None:
    state.units[angle], state.units[speed] = reading.angle_unit, reading.speed_unit
    if "t_s" in state.chosen and "t_s" not in state.units:
        state.units["t_s"] = reading.time_unit
        state.because("t_s", f"with it {state.name(speed)!r} is the rate of {state.name(angle)!r}")
    state.because(angle, f"its rate is {abs(reading.ratio):.4g} times {state.name(speed)!r}")
    _turn_round(state, angle, speed, reading)
    if reading.pole_pairs > 1 or angle == "theta_e_rad":
        if angle == "theta_m_rad":
            state.chosen["theta_e_rad"] = state.chosen.pop("theta_m_rad")
            for table in (state.units, state.scale):
                if "theta_m_rad" in table:
                    table["theta_e_rad"] = table.pop("theta_m_rad")  # type: ignore[assignment]
            state.notes.append(
                f"{state.name('theta_e_rad')!r} turns {reading.pole_pairs} times as fast as the shaft: "
                "it is the electrical angle"
            )
        state.pole_pairs = state.pole_pairs or reading.pole_pairs


def _turn_round(state: State, angle: str, speed: str, reading: Reading) -> None:
    if reading.reversed:
        state.scale[angle] = -1.0
        state.notes.append(
            f"{state.name(angle)!r} falls where {state.name(speed)!r} is positive: the angle is turned round"
        )


def _ask(state: State, best: list[Reading], angle: str, speed: str) -> None:
    shown = "; or ".join(
        f"{r.angle_unit} and {r.speed_unit}"
        + (f" with {r.pole_pairs} pole pairs" if r.pole_pairs > 1 else "")
        + (f" and time in {r.time_unit}" if "t_s" not in state.units else "")
        for r in best[:4]
    )
    state.questions.append(
        f"{angle}, {speed}: {state.name(angle)!r} and {state.name(speed)!r} may be in {shown}: give the units"
    )
    state.units[angle], state.units[speed] = best[0].angle_unit, best[0].speed_unit
    if "t_s" in state.chosen:
        state.units.setdefault("t_s", best[0].time_unit)


def _speed_is_electrical(state: State, reading: Reading, angle: str, speed: str, angles: Units, speeds: Units) -> None:
    """A speed that is a whole multiple of the rate of a mechanical angle."""
    state.pole_pairs = state.pole_pairs or reading.pole_pairs
    state.units[angle], state.units[speed] = angles[0][0], speeds[0][0]
    state.scale[speed] = 1.0 / reading.pole_pairs
    _turn_round(state, angle, speed, reading)
    state.because(speed, f"{reading.pole_pairs} times the rate of {state.name(angle)!r}: electrical")
    state.notes.append(
        f"{state.name(speed)!r} is {reading.pole_pairs} times as fast as the shaft: it is the electrical speed"
    )


def _contradiction(state: State, ratio: float, angle: str, speed: str, angles: Units, speeds: Units) -> None:
    unit = times(state)
    value = ratio * angles[0][1] / (speeds[0][1] * unit[0][1]) if unit else math.nan
    like = next((words for size, words in LOOKS_LIKE.items() if _near(value, size) or _near(value, 1.0 / size)), "")
    said = f" (it looks like {like})" if like else ""
    state.questions.append(
        f"{angle}, {speed}: {state.name(angle)!r} turns {value:.4g} times as fast as {state.name(speed)!r} says: "
        f"which unit is wrong{said}?"
    )
    state.units[angle], state.units[speed] = angles[0][0], speeds[0][0]


def _near(value: float, size: float) -> bool:
    return abs(abs(value) / size - 1.0) < motion.AGREE


def _alone(state: State, quantity: str | None, units: Units) -> None:
    """A column that no other one judges."""
    if quantity is None or quantity not in state.chosen or quantity in state.units or not units:
        return
    if len(units) == 1:
        state.units[quantity] = units[0][0]
        if not state.chosen[quantity].column.unit:
            state.because(quantity, "where it starts again" if quantity.startswith("theta") else "its symbol")
    else:
        names = ", ".join(name for name, _ in units)
        state.questions.append(f"{quantity}: the unit of {state.name(quantity)!r} is not printed ({names}?)")


def _reference(state: State) -> None:
    """The reference of the speed is in the unit of the speed unless it says otherwise."""
    if "speed_ref_rad_s" not in state.chosen:
        return
    column = state.chosen["speed_ref_rad_s"].column
    if column.unit:
        state.units["speed_ref_rad_s"] = column.unit
    elif "speed_rad_s" in state.units:
        state.units["speed_ref_rad_s"] = state.units["speed_rad_s"]
        state.scale["speed_ref_rad_s"] = state.scale.get("speed_rad_s", 1.0)
        state.because("speed_ref_rad_s", "in the unit of the speed")
    else:
        state.questions.append(f"speed_ref_rad_s: the unit of {column.name!r} is not printed")


def symbol_of(name: str) -> str:
    """The unit that a symbol has in this field: omega in rad/s, n in r/min."""
    words = words_of(name).split()
    return next((SYMBOLS[" ".join(words[i:])] for i in range(len(words)) if " ".join(words[i:]) in SYMBOLS), "")
