"""A found term in words: what it depends on, how, which causes look like that, and what would separate them."""

from __future__ import annotations

import math

from evenspin.empirical.term import EmpiricalTerm

CLOSE = 60.0  # cost: a look-alike that is no farther behind is named
SENSOR_RATED = 0.5  # of the rated torque: no torque over the angle of a machine that works swings by more
WHOLE = 3.0  # half widths within which an order is a whole number


def depends_on(term: EmpiricalTerm) -> list[str]:
    """The quantities, the main one first."""
    name = term.family.name
    if name == "angle_line":
        return ["angle", *(["speed"] if term.shape[1] > 0.0 else []), *(["direction"] if term.shape[2] else [])]
    more = {
        "time_friction": ["time", "direction"],
        "time_viscous": ["time", "speed"],
        "time_magnet": ["time", "current"],
        "time_resistance": ["time", "current"],
        "supply_frequency": ["frequency", "voltage"],
        "supply_link": ["supply", "voltage"],
        "supply_power": ["power", "voltage"],
        "current_friction": ["current", "direction"],
        "reversal": ["reversal", "angle"],
        "speed_voltage": ["speed", "voltage"],
        "phase_resistance": ["phase", "current"],
        "voltage_offset": ["phase", "voltage"],
    }
    return more.get(name, [term.family.depends_on])


def form(term: EmpiricalTerm) -> str:
    """One sentence without a cause."""
    size, shape = term.size, term.shape
    low, high = term.speeds_rad_s
    where = f"from {low:.3g} to {high:.3g} rad/s"
    against = "against the motion" if size > 0.0 else "with the motion"
    top = term.facts.get("top_rad_s", high)
    name = term.family.name
    if name == "speed_odd":
        return (
            f"depends on speed only, {against}, grows with {_power(term)} {where}: "
            f"{abs(size):.3g} N m at {top:.3g} rad/s"
        )
    if name == "speed_even":
        side = "against positive rotation" if size > 0.0 else "with positive rotation"
        return (
            f"depends on speed only, {side} in both directions, grows with {_power(term)} {where}: "
            f"{abs(size):.3g} N m at {top:.3g} rad/s"
        )
    if name == "angle_line":
        law = {0.0: "amplitude constant over speed", 1.0: "amplitude grows with the speed"}.get(
            shape[1], "amplitude grows with the square of the speed"
        )
        tied = "phase tied to the shaft" if whole_order(term) else "phase not tied to the shaft"
        over = ", turns over with the direction" if shape[2] else ""
        return f"order {shape[0]:.4g} per turn, {law}{_at_top(term)}{over}, {tied}: {abs(size):.3g} N m"
    if name == "position_bump":
        return (
            f"depends on the position in the travel: {size:+.3g} N m around {shape[0]:.4g} rad, "
            f"gone about {1.5 * shape[1]:.3g} rad away, the same in both directions"
        )
    if name == "position_spring":
        return (
            f"grows evenly with the position: {size:+.3g} N m over the travel of "
            f"{term.facts.get('travel_rad', 0.0):.3g} rad"
        )
    if name.startswith("time_"):
        return _over_time(term)
    if name == "torque_frequency":
        return f"torque of {shape[0]:.4g} Hz whatever the speed and the angle: {abs(size):.3g} N m"
    if name == "supply_frequency":
        return f"the voltage swings at {shape[0]:.4g} Hz by {100.0 * abs(size):.3g} %, whatever the speed"
    if name == "supply_link":
        return (
            f"the voltage follows the measured dc link by {100.0 * abs(size):.3g} % of its swing: "
            "it is not corrected for it"
        )
    if name == "supply_power":
        return f"the voltage is smaller by {100.0 * size:.3g} % at the rated power, and larger when it is fed back"
    if name == "current_friction":
        return f"friction of {100.0 * size:.3g} % of the torque of the motor, {against}"
    if name == "cross_saturation":
        return f"the d flux falls by {50.0 * size:.3g} % of that of the magnets at the rated q current"
    if name == "reversal":
        return f"friction of {size:.3g} N m that builds up over {shape[0]:.3g} rad after each reversal"
    if name == "speed_history":
        return (
            f"follows changes of the speed and dies away, time constant {shape[0]:.3g} s: {size:.3g} N m at a full step"
        )
    if name == "speed_voltage":
        return f"q voltage with the square of the speed {where}: {size:.3g} V at {top:.3g} rad/s"
    if name == "voltage_offset":
        return f"a constant voltage of {abs(size):.3g} V in the stationary frame, seen at the electrical order"
    a, b = (float(x) for x in term.coefficients[:2])
    return f"phase a has {a:+.3g} ohm and phase b {b:+.3g} ohm beside the mean"


def like(term: EmpiricalTerm) -> str:
    """Causes that engineers know it by."""
    name = term.family.name
    if name == "speed_odd":
        n = term.shape[0]
        if abs(n - 2.0) < 0.35:
            return "a fan, windage, a centrifugal pump"
        return (
            "churning oil, or windage beside another loss"
            if n > 1.35
            else "grease that thins with the speed, a rubbing seal"
        )
    if name == "angle_line":
        return _line_like(term)
    return {
        "speed_even": (
            "a loss of the load that does not turn over with the direction: an impeller with bias, a sensor gain"
        ),
        "position_bump": "a tight place in the travel, a guide out of line, a cable or hose that is bent there",
        "position_spring": "a spring, a hanging cable, a counterweight",
        "time_load": "a load that builds up, or drift of a current sensor that acts as torque",
        "time_friction": "grease or a seal that warms up (or cools down)",
        "time_viscous": "oil that warms up",
        "time_magnet": "magnets that warm up, or a current sensor whose gain drifts",
        "time_resistance": "a winding that warms up",
        "torque_frequency": "another machine on the same frame, or a pump that runs by itself",
        "supply_frequency": "mains ripple on the dc link",
        "supply_link": "a drive that does not correct its duties for the dc link",
        "supply_power": "a dc supply that sags with load (a long cable, a small capacitor, a battery)",
        "current_friction": "a gear or screw with an efficiency below 1",
        "cross_saturation": "cross saturation of the iron",
        "reversal": "presliding: seals, preloaded bearings or a belt that give way before they slide",
        "speed_history": "a fluid coupling, eddy currents, or an inertia behind a slipping joint",
        "speed_voltage": "iron losses, or a voltage that comes late by more than the timing that was fitted",
        "phase_resistance": "a bad contact or terminal in one phase",
        "voltage_offset": "an offset of the duties or of the measured phase voltage",
    }[name]


def experiment(term: EmpiricalTerm) -> str:
    """The one that would separate this cause from what looks most alike, sized for this machine."""
    name, facts = term.family.name, term.facts
    top, rated = facts.get("top_rad_s", 0.0), facts.get("rated_nm", 0.0)
    first = term.look_alikes[0].family if term.look_alikes else ""
    if name in ("speed_odd", "speed_even", "speed_voltage"):
        if first.startswith("time_"):
            return (
                "run the same staircase of speeds twice, once up and once down: what depends on time "
                f"differs, {_speeds(top)}"
            )
        if name == "speed_voltage":
            return (
                f"hold {top:.3g} rad/s with the phase currents at zero (coast down): iron losses "
                "stay, a late voltage does not"
            )
        return (
            f"hold {_speeds(top)} in both directions for 3 s each, with the fan or pump coupled and uncoupled: "
            f"{abs(term.size):.2g} N m at the top should come and go"
        )
    if name == "angle_line":
        turns = 20.0 / max(term.shape[0], 0.05)
        if whole_order(term) and sensor_error_rad(term) is not None:
            return (
                f"uncouple the load and repeat {max(turns, 5.0):.0f} turns at {0.5 * top:.3g} and {top:.3g} rad/s: "
                "pulses of the load are gone, an error of the angle sensor stays, with the same angle at both speeds"
            )
        if whole_order(term):
            return (
                "turn the shaft by a known angle against the coupling and repeat "
                f"{max(turns, 5.0):.0f} turns at {0.2 * top:.3g} "
                "rad/s: a line of the motor keeps its phase, one of the load moves with the coupling"
            )
        return (
            f"uncouple belt or gear and turn {max(turns, 10.0):.0f} turns at {0.2 * top:.3g} "
            f"rad/s: order {term.shape[0]:.4g} "
            "should be gone; a mark on the second shaft should return with it"
        )
    if name.startswith("position_"):
        return (
            f"travel slowly (about {0.1 * top:.2g} rad/s) end to end three times in both "
            "directions: what depends on the "
            "position repeats, what depends on time does not"
        )
    if name in ("time_resistance", "time_magnet"):
        amps = 0.7 * facts.get("rated_a", 0.0)
        tau = term.shape[0]
        return (
            f"start cold, hold {amps:.2g} A at {0.3 * top:.3g} rad/s for "
            f"{max(3.0 * tau, 30.0):.0f} s, wait as long at rest "
            "and repeat: warming comes back, drift of a sensor does not; measure the winding "
            "with an ohmmeter before and after"
        )
    if name.startswith("time_"):
        return (
            f"hold {0.3 * top:.3g} rad/s for {max(3.0 * term.shape[0], 30.0):.0f} s after an hour "
            "of rest, then again at once: "
            "what warms up is small the second time"
        )
    if name in ("torque_frequency", "supply_frequency"):
        return (
            f"hold {0.25 * top:.3g} and {0.6 * top:.3g} rad/s for 10 s each: {term.shape[0]:.4g} "
            "Hz stays, an order moves with the speed"
        )
    if name in ("supply_link", "supply_power"):
        return (
            f"log the dc link beside steps of {0.5 * rated:.2g} N m at {0.6 * top:.3g} rad/s: it has to sag with them"
        )
    if name == "current_friction":
        return (
            f"hold {0.2 * top:.3g} rad/s in both directions with 0, {0.25 * rated:.2g} and "
            f"{0.5 * rated:.2g} N m of measured load"
        )
    if name == "cross_saturation":
        return (
            "hold the rotor and step iq to the rated current while id is watched, then both "
            f"together, {0.5 * rated:.2g} N m"
        )
    if name == "reversal":
        return (
            f"go back and forth by {0.5 * term.shape[0]:.2g}, {term.shape[0]:.2g} and "
            f"{4.0 * term.shape[0]:.2g} rad around rest: the loop closes within the length"
        )
    if name == "speed_history":
        return f"step between {0.3 * top:.3g} and {0.6 * top:.3g} rad/s and hold each for {5.0 * term.shape[0]:.2g} s"
    return (
        f"exchange two phases at the motor and log {0.2 * top:.3g} rad/s for 10 s: what "
        "belongs to the drive stays in its phase"
    )


def sentence(term: EmpiricalTerm) -> str:
    """Form and cause, as in the report."""
    text = f"{form(term)}: like {like(term)}"
    close = [each.family for each in term.look_alikes if each.behind < CLOSE]
    if close:
        text += f"; {', '.join(NAMES.get(name, name) for name in close)} would look nearly the same"
    return text


NAMES = {
    "speed_odd": "a drag with a power of the speed",
    "speed_even": "a torque with an even power of the speed",
    "angle_line": "another line over the angle",
    "position_bump": "a load at a position",
    "position_spring": "a spring",
    "time_load": "a load that changes with time",
    "time_friction": "friction that changes with time",
    "time_viscous": "viscous friction that changes with time",
    "time_magnet": "a flux that changes with time",
    "time_resistance": "a resistance that changes with time",
    "torque_frequency": "a torque of fixed frequency",
    "supply_frequency": "a voltage of fixed frequency",
    "supply_link": "a voltage that follows the dc link",
    "supply_power": "a voltage that falls with the power",
    "current_friction": "friction that goes with the torque",
    "cross_saturation": "cross saturation",
    "reversal": "friction that builds up after a reversal",
    "speed_history": "a torque that follows changes of the speed",
    "speed_voltage": "a voltage with the square of the speed",
    "phase_resistance": "phases of different resistance",
    "voltage_offset": "a constant voltage in one phase",
}


def whole_order(term: EmpiricalTerm) -> bool:
    """Whether the order is a whole number, as far as the log says."""
    order = term.shape[0]
    half = max(term.shape_half[0] if term.shape_half else 0.0, 0.002)
    return abs(order - round(order)) < WHOLE * half and round(order) > 0


def _line_like(term: EmpiricalTerm) -> str:
    order, power = term.shape[0], term.shape[1]
    if term.shape[2] and power == 0.0 and whole_order(term):
        return "friction that changes over the turn: a bent shaft in its seals, a coupling that rubs"
    if power >= 2.0 and whole_order(term):
        pulses = "pulses of a pump or compressor with as many pistons or vanes, or unbalance of a coupling"
        error_rad = sensor_error_rad(term)
        if error_rad is None:
            return pulses
        sensor = f"an error of the angle sensor by {1e3 * error_rad:.3g} mrad (a code wheel, a resolver)"
        rated = term.size / term.facts["rated_nm"]
        if rated > SENSOR_RATED:
            return f"{sensor}; a torque would be {rated:.2g} times the rated one"
        return f"{pulses}; or {sensor}"
    if whole_order(term):
        if round(order) == 1:
            return "a rotor out of balance under gravity, a bent shaft, an eccentric coupling"
        return "teeth of a gear on this shaft, pistons, a coupling with as many elements"
    if 0.33 < order < 0.48:
        return "the cage of a ball bearing (.38 to .42 per turn is common), or a belt longer than the pulley"
    if order < 1.0:
        return "a belt, a gear or a second shaft that turns slower"
    if order > 6.0:
        return "teeth of a gear behind a ratio, balls of a bearing"
    return "a belt or a second shaft that turns faster, balls of a bearing"


def sensor_error_rad(term: EmpiricalTerm) -> float | None:
    """Amplitude of an angle error that would look like this line: its acceleration times the inertia is the torque.

    None: the line does not grow with the square of the speed, or turns over with it, or the inertia is not known.
    """
    order, power, turns_over = term.shape
    inertia, top = term.facts.get("inertia_kgm2", 0.0), term.facts.get("top_rad_s", 0.0)
    if power < 2.0 or turns_over or not inertia > 0.0 or not top > 0.0 or not term.facts.get("rated_nm", 0.0) > 0.0:
        return None
    return abs(term.size) / (inertia * (order * top) ** 2)


def _power(term: EmpiricalTerm) -> str:
    n = term.shape[0]
    half = term.shape_half[0] if term.shape_half else 0.0
    if abs(n - 2.0) < max(0.15, half):
        return "its square"
    if abs(n - 3.0) < max(0.15, half):
        return "its cube"
    return f"its power {n:.2f}"


def _at_top(term: EmpiricalTerm) -> str:
    return "" if term.shape[1] == 0.0 else f" (at {term.facts.get('top_rad_s', math.nan):.3g} rad/s)"


def _over_time(term: EmpiricalTerm) -> str:
    tau, size, span = term.shape[0], term.size, term.facts.get("span_s", 0.0)
    what = {
        "time_load": f"a load {_grows(size)} by {abs(size):.3g} N m",
        "time_friction": f"friction {_grows(size)} by {abs(size):.3g} N m",
        "time_viscous": (
            f"viscous friction {_grows(size)} by {abs(size):.3g} N m at {term.facts.get('top_rad_s', 0.0):.3g} rad/s"
        ),
        "time_magnet": f"the flux of the magnets {_grows(-size)} by {100.0 * abs(size):.3g} %",
        "time_resistance": f"the resistance {_grows(size)} by {abs(size):.3g} ohm",
    }[term.family.name]
    rate = f"time constant {tau:.3g} s" if tau < 1.2 * span else "evenly"
    return f"{what} over {span:.3g} s, {rate}"


def _grows(size: float) -> str:
    return "grows" if size > 0.0 else "falls"


def _speeds(top: float) -> str:
    return ", ".join(f"{share * top:.3g}" for share in (0.25, 0.5, 0.75, 1.0)) + " rad/s"
