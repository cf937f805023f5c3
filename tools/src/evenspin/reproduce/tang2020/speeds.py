"""The page of all speeds: what aro-beyond leaves from 50 to 2500 rpm, and how much of it is the encoder's rounding."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from evenspin.analysis.orders import order_spectrum
from evenspin.analysis.segments import RAD_S
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg
from evenspin.reproduce.tang2020.conditions import OFF, at_speed
from evenspin.reproduce.tang2020.measure import evenness
from evenspin.reproduce.tang2020.sweep import SIGNALS, SPEEDS_RPM, WINDOW_S, learning_s
from evenspin.sim import Record, complete, prepare
from evenspin.sim.many import Progress, run_all

MARK = "<!-- Made by `evenspin reproduce tang2020 --sweep --page` (`make speeds`). Do not edit. -->"
FINE_COUNTS = 2.0**24  # an encoder without steps, as far as the speed shows them
FINE = {"encoder_counts": FINE_COUNTS, "aro_sync_hz": 0.0, "aro_drift_counts": 0.0}
WORST = 8
MOST_ORDER = 200.0
LARGEST = 3  # orders shown


@dataclass(frozen=True, slots=True)
class AtSpeed:
    """One speed. Reductions of the rms of the speed against the drive without an observer, %."""

    speed_rpm: float
    off_rpm: float
    float_pct: float
    fixed_pct: float
    fine_pct: float  # float, with an encoder of FINE_COUNTS
    left: Sequence[tuple[float, float]]  # float: largest orders, and their amplitude in rpm

    @property
    def lost_pct(self) -> float:
        """What the rounding of the encoder costs, the worse of both builds."""
        return self.fine_pct - min(self.float_pct, self.fixed_pct)


def measured(rpm: float) -> AtSpeed:
    """Four runs: without an observer, with it in both builds, and with a fine encoder."""
    off = evenness(_run(rpm, OFF, "float"), *_window(rpm)).rms_rpm
    on = _run(rpm, "aro-beyond", "float")

    def reduction(record: Record) -> float:
        return 100.0 * (1.0 - evenness(record, *_window(rpm)).rms_rpm / off)

    fixed, fine = _run(rpm, "aro-beyond", "fixed"), _run(rpm, "aro-beyond", "float", fine=True)
    return AtSpeed(rpm, off, reduction(on), reduction(fixed), reduction(fine), _orders(on.between(*_window(rpm))))


def _window(rpm: float) -> tuple[float, float]:
    end_s = learning_s(rpm)
    return end_s - WINDOW_S, end_s


def _run(rpm: float, method: str, numeric: str, *, fine: bool = False) -> Record:
    setup = at_speed(rpm, method, learning_s(rpm))
    if fine:
        plant, drive = {**setup.plant, "counts_per_rev": FINE_COUNTS}, {**setup.drive, **FINE}
        setup = replace(setup, plant=plant, drive=drive)
    return complete(prepare(setup, SIGNALS, numeric), setup, SIGNALS)


def _orders(record: Record) -> list[tuple[float, float]]:
    """The largest lines of the spectrum that are not neighbours of a larger one."""
    order, amplitude = order_spectrum(record["true_speed_rad_s"] / RAD_S, record["true_theta_m_rad"], MOST_ORDER)
    found: list[tuple[float, float]] = []
    for k in np.argsort(amplitude)[::-1]:
        if all(abs(order[k] - other) > 0.2 for other, _ in found):
            found.append((float(order[k]), float(amplitude[k])))
        if len(found) == LARGEST:
            break
    return found


def speeds_page(path: Path, progress: Progress | None = None, speeds: Sequence[float] = SPEEDS_RPM) -> None:
    """Measure, and write PATH with its picture in a folder of the same name beside it."""
    jobs: list[Callable[[], AtSpeed]] = [_later(rpm) for rpm in speeds]
    points = run_all(jobs, progress)
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    (folder / "reduction.svg").write_text(_picture(points), encoding="utf-8")
    path.write_text(_markdown(points, folder.name), encoding="utf-8")


def _later(rpm: float) -> Callable[[], AtSpeed]:
    return lambda: measured(rpm)


def _picture(points: Sequence[AtSpeed]) -> str:
    rpm = [point.speed_rpm for point in points]
    with drawing():
        figure, axes = subplots(height=3.6)
        panel = axes[0, 0]
        panel.plot(
            rpm, [p.fine_pct for p in points], color=REFERENCE_COLOUR, label="encoder of 2^24 counts", linewidth=2.0
        )
        panel.plot(rpm, [p.float_pct for p in points], ".-", color=OTHER_COLOURS[0], label="float", linewidth=0.8)
        panel.plot(rpm, [p.fixed_pct for p in points], ".-", color=OTHER_COLOURS[1], label="fixed point", linewidth=0.8)
        panel.set(
            xlabel="speed [rpm]", ylabel="reduction of the rms [%]", xlim=(0.0, max(rpm) * 1.02), ylim=(0.0, 101.0)
        )
        panel.legend()
        return to_svg(figure)


def _markdown(points: Sequence[AtSpeed], folder: str) -> str:
    worst = min(points, key=lambda point: min(point.float_pct, point.fixed_pct))
    lost = sorted(points, key=lambda point: point.lost_pct, reverse=True)
    median = float(np.median([point.lost_pct for point in points]))
    lines = [
        "# Tang et al. 2020: ARO at every speed",
        "",
        MARK,
        "",
        "Speed ripple of Rig 2 without load, rms of the true speed, with `tang2020/beyond` against the drive without "
        f"an observer, in the last {WINDOW_S:g} s of 55 s (from 300 rpm on of 30 s). The grey line is the same drive "
        "with an encoder of 2^24 counts, whose rounding does not show: what falls with the speed there is the torque "
        "that the filters do not let through. The rest is what the rounding of the 2^17 counts costs. More in "
        "[tang2020.md](tang2020.md).",
        "",
        f"![Reduction of the speed ripple over the speed]({folder}/reduction.svg)",
        "",
        f"Least reduction: {min(worst.float_pct, worst.fixed_pct):.0f} % at {worst.speed_rpm:.4g} rpm. The rounding "
        f"costs {median:.1f} points in the median, {lost[0].lost_pct:.1f} at most (the worse of both builds).",
        "",
        "## Where the rounding costs most",
        "",
        "| rpm | float, % | fixed point, % | 2^24 counts, % | largest orders left, float: order (rpm) |",
        "|---|---|---|---|---|",
    ]
    for point in lost[:WORST]:
        left = ", ".join(f"{order:.2f} ({amplitude:.3f})" for order, amplitude in point.left)
        lines.append(f"{_cells(point)} {left} |")
    lines += [
        "",
        "## All speeds",
        "",
        "| rpm | float, % | fixed point, % | 2^24 counts, % | off, rpm |",
        "|---|---|---|---|---|",
    ]
    lines += [f"{_cells(point)} {point.off_rpm:.3f} |" for point in points]
    return "\n".join([*lines, ""])


def _cells(point: AtSpeed) -> str:
    values = (point.float_pct, point.fixed_pct, point.fine_pct)
    return f"| {point.speed_rpm:.6g} | " + " | ".join(f"{value:.1f}" for value in values) + " |"
