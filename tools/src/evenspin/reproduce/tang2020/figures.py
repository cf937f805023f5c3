"""All figures of the paper: which command draws each, and what it shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from evenspin.report.figures import Picture
from evenspin.report.style import drawing
from evenspin.reproduce.paper import Figure, Gallery, Statement, printed_reduction
from evenspin.reproduce.tang2020 import figure_pictures as pictures
from evenspin.reproduce.tang2020.figure_pictures import DETUNED, FRICTION, MISALIGNED, ON, SENSORS, pair, transfer
from evenspin.reproduce.tang2020.result import Result, reproduce
from evenspin.sim.many import Progress
from evenspin.tableview import number

BLOCKS, TIMING, RIG = "block diagram", "timing diagram", "photograph"
SPEEDS = ("100 rpm", "123 rpm")
LOAD, SPEED = "load step", "speed step"
PURE = "the misalignment is assumed as a pure line; on a bench a part of the ripple does not repeat with the angle"
NOT_SEEN = "in the 12th order only; most of what is left is encoder noise in the memory, and a J too small learns less"
REDUCED = 50.0  # %, what counts as effectively reduced


def _row(result: Result, condition: str, method: str = ON) -> dict[str, float] | None:
    for row in result.rows:
        if (row["condition"], row["method"]) == (condition, method):
            return dict(row)
    return None


def _reduced(result: Result, condition: str, what: str, theirs: str) -> list[Statement]:
    row = _row(result, condition)
    if row is None:
        return []
    ours = f"{number(row['rms_off_rpm'])} to {number(row['rms_on_rpm'])}, -{row['reduction_pct']:.0f} %"
    return [Statement(what, ours, theirs, row["reduction_pct"] >= REDUCED)]


def sensors(result: Result) -> list[Statement]:
    """Figure 9c, d, e."""
    found = pair(result, SENSORS)
    if found is None:
        return []
    ripple = [float(np.std(pictures.shaft_torque_nm(run)[2])) for run in found]
    ours = f"{number(ripple[0])} to {number(ripple[1])}"
    return [
        Statement(
            "torque on the shaft, rms around its mean [N m]", ours, "smoother with ARO", ripple[1] < 0.5 * ripple[0]
        )
    ]


def sensor_spectrum(result: Result) -> list[Statement]:
    """Figure 9b."""
    found = pair(result, SENSORS)
    if found is None:
        return []
    orders = found[0].seen[0].orders
    highest = sorted(orders, key=lambda order: -orders[order])[:2]
    ours = ", ".join(f"{order}: {number(orders[order])} rpm" for order in sorted(highest))
    return [
        Statement("highest orders without observer", ours, "1st and 2nd electrical (5, 10)", set(highest) == {5, 10}),
        *_reduced(result, SENSORS, "speed ripple, rms [rpm]", "reduced effectively"),
    ]


def misaligned(result: Result) -> list[Statement]:
    row = _row(result, MISALIGNED)
    if row is None:
        return []
    return [printed_reduction("peak to peak, reduction [%]", row["pp_reduction_pct"], 76.0, reason=PURE)]


def two_speeds(result: Result) -> list[Statement]:
    """Figure 10."""
    found = [both for name in SPEEDS if (both := pair(result, name)) is not None]
    if len(found) < len(SPEEDS):
        return []
    said = []
    for name, (off, _) in zip(SPEEDS, found, strict=True):
        largest = sorted(sorted(off.seen[0].orders, key=lambda order: -off.seen[0].orders[order])[:6])
        text = ", ".join(map(str, largest))
        expected = [10, 12, 20, 24, 30, 36]
        said.append(Statement(f"{name}: main orders", text, ", ".join(map(str, expected)), largest == expected))
        said += _reduced(result, name, f"{name}: speed ripple, rms [rpm]", "adapts to the speed")
    return said


def wrong_mechanics(result: Result) -> list[Statement]:
    """Figure 13."""
    said = []
    for letter, names in (("J", DETUNED), ("B", FRICTION)):
        rows = [row for name in names if (row := _row(result, name)) is not None]
        if len(rows) == len(names):
            factors = ", ".join(name.rpartition(" ")[2] if letter in name else "1" for name in names)
            text = ", ".join(f"{row['reduction_pct']:.0f}" for row in rows)
            holds = min(row["reduction_pct"] for row in rows) >= REDUCED
            said.append(
                Statement(f"{letter} x {factors}: reduction of rms [%]", text, "no significant differences", holds)
            )
    runs = [result.run(name, ON) for name in DETUNED]
    twelfth = [run.seen[0].orders[12] for run in runs if run is not None]
    if len(twelfth) == len(DETUNED):
        text = ", ".join(number(value, 2) for value in twelfth)
        holds = twelfth[0] == max(twelfth)
        said.append(Statement("J x 0.5, 1, 1.5, 2: 12th order left [rpm]", text, "most with J x 0.5", holds, NOT_SEEN))
    half, whole = (_row(result, name) for name in DETUNED[:2])
    if half is not None and whole is not None:
        ours = f"{number(half['rms_on_rpm'])} / {number(whole['rms_on_rpm'])}"
        holds = half["rms_on_rpm"] > whole["rms_on_rpm"]
        said.append(Statement("J x 0.5 / J: rms left [rpm]", ours, "more with J x 0.5", holds, NOT_SEEN))
    return said


def seen_torque(_: Result) -> list[Statement]:
    """Figure 14."""
    f_hz = np.array([20.0, 40.0])  # 12th and 24th order at 100 rpm
    db = 20.0 * np.log10(np.abs(transfer(0.5, f_hz)))
    shift = np.degrees(np.angle(transfer(0.5, f_hz) / transfer(1.0, f_hz)))
    said = [
        Statement(f"J x 0.5: {order}th order [dB]", f"{value:.2f}", "-6", abs(value + 6.0) < 0.1)
        for order, value in zip((12, 24), db.tolist(), strict=True)
    ]
    text = ", ".join(f"{value:.1f}" for value in shift)
    return [*said, Statement("phase against J x 1 [deg]", text, "little effect", bool(np.abs(shift).max() < 5.0))]


def _in_style(draw: Callable[[Result], Picture | None]) -> Callable[[Result], Picture | None]:
    def within(result: Result) -> Picture | None:
        with drawing():
            return draw(result)

    return within


def _sensor_spectra(result: Result) -> Picture | None:
    text = "Speed at 100 rpm and full load with both sensor errors; orders 5 and 10 are the first two electrical ones."
    return pictures.spectra(result, (SENSORS,), "figure_9b", "Speed spectrum with sensor errors", text)


def _two_spectra(result: Result) -> Picture | None:
    text = "100 rpm: a turn is 6000 samples. 123 rpm: 4878.05 samples, the fractional case. No load, Rig 2."
    return pictures.spectra(result, SPEEDS, "figure_10", "Speed spectra with a whole and a fractional delay", text)


def _load(result: Result) -> Picture | None:
    text = "4.4 N m at 100 rpm after 50 s of learning; the step itself is learned for some turns."
    return pictures.step(result, LOAD, "figure_11", "Load step", text)


def _speed(result: Result) -> Picture | None:
    text = "123 to 451 rpm after 50 s of learning."
    return pictures.step(result, SPEED, "figure_12", "Speed step", text)


GALLERY: Gallery[Result] = Gallery(
    "tang2020",
    (
        Figure(
            ("9a", "9c", "9d", "9e"),
            "currents, torque and speed with sensor errors, full load",
            _in_style(pictures.currents_and_torque),
            sensors,
            (SENSORS,),
        ),
        Figure(("9b",), "speed spectrum with sensor errors", _in_style(_sensor_spectra), sensor_spectrum, (SENSORS,)),
        Figure(("9f",), "misalignment at 1000 rpm", _in_style(pictures.misalignment), misaligned, (MISALIGNED,)),
        Figure(("10",), "spectra at 100 and 123 rpm", _in_style(_two_spectra), two_speeds, SPEEDS),
        Figure(
            ("11",),
            "load step",
            _in_style(_load),
            lambda result: _reduced(
                result, f"{LOAD}, 1-3 s after", "rms 1 to 3 s after the step [rpm]", "low ripple is kept"
            ),
            (LOAD,),
        ),
        Figure(
            ("12",),
            "speed step",
            _in_style(_speed),
            lambda result: _reduced(
                result, f"{SPEED}, 0.5-2 s after", "rms 0.5 to 2 s after the step [rpm]", '"ripple-free"'
            ),
            (SPEED,),
        ),
        Figure(
            ("13",), "wrong mechanical parameters", _in_style(pictures.detuned), wrong_mechanics, (*DETUNED, *FRICTION)
        ),
        Figure(("14",), "torque seen with a wrong J", _in_style(pictures.bode), seen_torque),
    ),
    {**dict.fromkeys(("1", "2", "3", "4", "5", "7"), BLOCKS), "6": TIMING, "8": RIG},
)


def gather(figures: Sequence[Figure[Result]], numeric: str, progress: Progress) -> Result:
    """The conditions that these figures need, without an observer and with ARO as printed."""
    conditions = list(dict.fromkeys(name for figure in figures for name in figure.needs))
    return reproduce(numeric, (ON,), conditions=conditions, keep_records=True, progress=progress)
