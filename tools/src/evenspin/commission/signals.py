"""Excitation and recording through the link."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.bench.client import Drive
from evenspin.bench.errors import DriveFaultError
from evenspin.bench.numbers import Mode, State, Trigger
from evenspin.bench.stream import Stream

Array = NDArray[np.float64]

MOVES_S = 120.0  # the longest that a part of the motion may take


def rows(stream: Stream, seconds: float) -> Array:
    """What arrives in this time."""
    clock = stream._drive.link.transport.clock
    until_s, parts = clock() + seconds, []
    while True:
        left_s = until_s - clock()
        block = stream.read(max(left_s, 0.0))
        if block is not None:
            parts.append(block.values.astype(float))
        elif left_s <= 0.0:
            break
    return np.concatenate(parts) if parts else np.empty((0, len(stream.names)))


def currents(drive: Drive, *, id_a: float = 0.0, iq_a: float = 0.0) -> None:
    drive.setpoint(Mode.CURRENT, id_a=id_a, iq_a=iq_a)


def run_currents(drive: Drive) -> None:
    """Running, without current."""
    currents(drive)
    if drive.state().state != State.RUN:
        drive.start()


def step_capture(
    drive: Drive,
    signals: Sequence[str],
    axis: str,
    from_a: float,
    to_a: float,
    rows_after: int,
    pre: int,
    hold_s: float,
    decimation: int = 1,
) -> Array:
    """Rows at the PWM rate around a step of the current of one axis; the step is back at once when they are taken."""

    def hold(value: float) -> None:
        currents(drive, id_a=value if axis == "d" else 0.0, iq_a=value if axis == "q" else 0.0)

    hold(from_a)
    drive.sleep(hold_s)
    trigger = Trigger.RISING if to_a > from_a else Trigger.FALLING
    drive.arm_capture(signals, rows=pre + rows_after, pre=pre, trigger=trigger, signal_name=f"i{axis}_ref_a",
                      level=0.5 * (from_a + to_a), decimation=decimation)  # fmt: skip
    hold(to_a)
    drive.sleep(rows_after * decimation / drive.info.pwm_hz)
    hold(0.0 if axis == "d" else from_a)
    taken = drive.read_capture()
    drive.need_no_fault()
    return taken.values.astype(float)


def switched(drive: Drive, axis: str, current_a: float, half_wave_s: float, half_waves: int) -> Array:
    """Current, voltage, angle of the shaft and reference of the current at the PWM rate, while a current is
    switched from plus to minus and back: it ends where it began, and so does the speed."""
    count = round(half_waves * half_wave_s * drive.info.pwm_hz)
    drive.arm_capture(
        (f"i{axis}_a", f"v{axis}_v", "theta_m_rad", f"i{axis}_ref_a"), rows=min(count, drive.capture_rows(4))
    )
    for number in range(half_waves + 1):
        way = 1.0 if number % 2 == 0 else -1.0
        part = 0.5 if number in (0, half_waves) else 1.0  # a half, then wholes: the mean of the speed stays at zero
        value = way * current_a
        currents(drive, id_a=value if axis == "d" else 0.0, iq_a=value if axis == "q" else 0.0)
        drive.sleep(part * half_wave_s)
    currents(drive)
    taken = drive.read_capture()
    drive.need_no_fault()
    values = taken.values.astype(float)
    values[:, 2] = np.unwrap(values[:, 2])
    return values


def until(
    drive: Drive,
    stream: Stream,
    parts: list[Array],
    done: Callable[[Array], bool],
    most_s: float = MOVES_S,
    span: int = 20,
) -> bool:
    """Collect rows until `done` says so of the last ones; False: it took too long."""
    clock = drive.link.transport.clock
    until_s = clock() + most_s
    recent = np.empty((0, len(stream.names)))
    while clock() < until_s:
        block = stream.read(0.1)
        if block is None:
            drive.need_no_fault()
            continue
        values = block.values.astype(float)
        parts.append(values)
        recent = np.concatenate((recent, values))[-span:]
        if drive.events and drive.events[-1].state == State.FAULT:
            drive.need_no_fault()
        if len(recent) == span and done(recent):
            return True
    return False


def need_rest(drive: Drive, still_rad_s: float = 0.3, most_s: float = 60.0) -> None:
    """Bridge off, and wait until the shaft has run out."""
    drive.stop()
    for _ in range(round(most_s / 0.1)):
        before = drive.read(("theta_m_rad",))["theta_m_rad"]
        drive.sleep(0.1)
        after = drive.read(("theta_m_rad",))["theta_m_rad"]
        if abs(np.angle(np.exp(1j * (after - before)))) < 0.1 * still_rad_s:
            return
    raise DriveFaultError(
        f"the shaft still turns {most_s:g} s after the bridge was switched off; does something drive it?"
    )
