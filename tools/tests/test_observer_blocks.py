"""Angle memory, filters, torque observers and deadbeat control against models in double precision written here."""

import math

import numpy as np
import pytest
from evenspin import blocks
from evenspin.blocks import BlockError
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

NUMERICS = ("float", "fixed")
TURN = 2.0 * math.pi
TS = 1e-4


# ---- angle memory --------------------------------------------------------------------------------------------------


def learned(theta, value, cells, gain, forgetting=1.0, write="one"):
    """m <- q m + g (v - m) at the grid points that the motion reaches or passes, v on the straight line."""
    memory, place = np.zeros(cells), np.asarray(theta) / TURN * cells
    for k in range(1, len(place)):
        old, new = place[k - 1], place[k]
        up = np.arange(math.floor(old) + 1, math.floor(new) + 1)
        down = np.arange(math.ceil(old) - 1, math.ceil(new) - 1, -1)
        passed = up if new > old else down
        for point in passed[-1:] if write == "one" else passed:
            v = value[k - 1] + (value[k] - value[k - 1]) * (point - old) / (new - old)
            cell = int(point) % cells
            memory[cell] = forgetting * memory[cell] + gain * (v - memory[cell])
    return memory


def fed(memory, theta, value):
    for angle, v in zip(theta, value, strict=True):
        memory.write(float(angle), float(v))
    return memory


@pytest.mark.parametrize("numeric", NUMERICS)
@pytest.mark.parametrize("write", ["one", "all"])
@pytest.mark.parametrize("cells", [4, 7, 200, 720])
def test_a_motion_with_reversals_writes_what_the_double_model_writes(cells, write, numeric):
    random = np.random.default_rng(cells)
    theta = 0.37 + np.cumsum(random.uniform(-0.06, 0.09, 6000))
    value = np.sin(3.0 * theta) + 0.1 * random.standard_normal(len(theta))

    memory = fed(blocks.AngleMemory(cells, 0.05, 0.999, write=write, numeric=numeric), theta, value)

    expected = learned(theta, value, cells, 0.05, 0.999, write)
    assert np.abs(expected).max() > 0.1  # there is something to compare
    assert memory.memory == pytest.approx(expected, abs=2e-4)
    assert memory.rejected == 0


@settings(max_examples=40)
@given(
    steps=st.lists(st.floats(-0.4, 0.4), min_size=2, max_size=60),
    start=st.floats(-50.0, 50.0),
    gain=st.floats(0.01, 1.0),
    cells=st.integers(4, 64),
)
def test_any_slow_motion_writes_what_the_double_model_writes(steps, start, gain, cells):
    # A grid point that is hit exactly belongs to one sample or the other: keep away from that by 1e-6 cells.
    theta = start + np.cumsum(steps)
    place = theta / TURN * cells
    if np.abs(place - np.round(place)).min() < 1e-6:
        return
    value = np.cos(theta)

    memory = fed(blocks.AngleMemory(cells, gain, write="all"), theta, value)

    assert memory.memory == pytest.approx(learned(theta, value, cells, gain, write="all"), abs=2e-4)


def test_one_writes_only_the_newest_of_the_points_passed():
    theta, value = [0.1, 0.1 + 3.2 * TURN / 16], [1.0, 1.0]

    one = fed(blocks.AngleMemory(16, 1.0, write="one"), theta, value).memory
    every = fed(blocks.AngleMemory(16, 1.0, write="all"), theta, value).memory

    assert np.flatnonzero(one).tolist() == [3]
    assert np.flatnonzero(every).tolist() == [1, 2, 3]


@pytest.mark.parametrize(("step", "cell"), [(0.3, 1), (-0.3, 15)])
def test_the_point_just_passed_is_written_in_both_directions(step, cell):
    """Upwards the lower border of the new cell, downwards the upper one."""
    start = (0.9 if step > 0 else -0.9) * TURN / 16

    memory = fed(blocks.AngleMemory(16, 1.0), [start, start + step * TURN / 16], [2.0, 2.0]).memory

    assert np.flatnonzero(memory).tolist() == [cell]
    assert memory[cell] == pytest.approx(2.0)


def test_standing_still_writes_nothing():
    memory = fed(blocks.AngleMemory(8, 1.0, write="all"), [1.0] * 50, range(50))

    assert not any(memory.memory)
    assert memory.rejected == 0


@pytest.mark.parametrize("numeric", NUMERICS)
def test_the_hat_averages_the_noise_that_one_sample_writes(numeric):
    """40 samples per cell: the weighted average of 80 has a 40 x 3/2 times smaller variance; one has that of two."""
    random = np.random.default_rng(5)
    theta = np.linspace(0.0, 3.0 * TURN, 3 * 40 * 32, endpoint=False) + 1e-3
    value = np.sin(theta) + random.standard_normal(len(theta))
    exact = np.sin(TURN * np.arange(32) / 32)

    noise = {}
    for write in ("one", "hat"):
        memory = fed(blocks.AngleMemory(32, 1.0, write=write, numeric=numeric), theta, value)
        noise[write] = np.std(np.array(memory.memory) - exact)

    assert 0.6 < noise["one"] < 1.2
    assert 0.05 < noise["hat"] < 0.25


def test_linear_reading_is_the_straight_line_between_two_points():
    memory = fed(blocks.AngleMemory(12, 1.0, write="all"), np.linspace(-0.01, TURN, 500), np.linspace(0.0, 3.0, 500))
    cells = np.array([*memory.memory, memory.memory[0]])

    for theta in (0.3, 2.0, 6.2, 6.2 + TURN, 2.0 - 3 * TURN):
        place = theta % TURN / TURN * 12
        below = int(place)
        expected = cells[below] + (place - below) * (cells[below + 1] - cells[below])
        assert memory.read(theta) == pytest.approx(expected, abs=1e-5)


def test_cubic_reading_is_closer_to_a_sine_than_linear_reading():
    """Error of interpolation: (h^2 / 8) against (9 / 384) h^4 with h = 2 pi order / cells."""
    theta = np.linspace(0.0, 2.0 * TURN, 40_000)
    probe = np.linspace(0.0, TURN, 997)
    error = {}
    for read in ("linear", "cubic"):
        memory = fed(blocks.AngleMemory(64, 1.0, write="all", read=read), theta, np.sin(3.0 * theta))
        error[read] = max(abs(memory.read(angle) - math.sin(3.0 * angle)) for angle in probe)

    h = TURN * 3.0 / 64.0
    assert error["linear"] == pytest.approx(h**2 / 8.0, rel=0.1)
    assert error["cubic"] == pytest.approx(9.0 / 384.0 * h**4, rel=0.25)


@pytest.mark.parametrize("numeric", NUMERICS)
@pytest.mark.parametrize(("theta", "value"), [
    (math.nan, 1.0), (math.inf, 1.0), (0.2, math.nan), (0.2, -math.inf),
])  # fmt: skip
def test_what_is_not_finite_is_counted_and_teaches_nothing(theta, value, numeric):
    memory = fed(blocks.AngleMemory(16, 0.5, write="all", numeric=numeric), np.linspace(0.0, 7.0, 200), np.ones(200))
    before = memory.memory

    memory.write(theta, value)

    assert memory.memory == before
    assert memory.rejected == 1


def test_a_jump_of_more_than_half_a_turn_is_counted_and_teaches_nothing():
    memory = fed(blocks.AngleMemory(16, 0.5, write="all"), np.linspace(0.0, 7.0, 200), np.ones(200))
    before = memory.memory

    memory.write(7.0 + 0.6 * TURN, -5.0)

    assert memory.memory == before
    assert memory.rejected == 1


@pytest.mark.parametrize("turns", [0.8, -0.8, 0.95, 1.2, 3.0])
def test_a_jump_that_looks_short_on_the_circle_is_counted_all_the_same(turns):
    memory = fed(blocks.AngleMemory(16, 0.5, write="all"), np.linspace(0.0, 7.0, 200), np.ones(200))
    before = memory.memory

    memory.write(7.0 + turns * TURN, -5.0)

    assert memory.memory == before
    assert memory.rejected == 1


def test_a_step_below_half_a_turn_writes_every_point_on_the_straight_line():
    memory = fed(blocks.AngleMemory(16, 1.0, write="all"), [0.1, 0.1 + 0.4 * TURN], [1.0, 2.0])

    points = np.arange(1, 7) * TURN / 16
    line = 1.0 + (points - 0.1) / (0.4 * TURN)
    assert memory.memory[1:7] == pytest.approx(line, rel=2e-4)
    assert memory.memory[7:] == [0.0] * 9
    assert memory.rejected == 0


def test_the_contents_stay_within_the_limit():
    memory = fed(blocks.AngleMemory(8, 1.0, write="all", limit=0.5), np.linspace(0.0, 7.0, 100), np.full(100, 9.0))

    assert memory.memory == pytest.approx([0.5] * 8)


@pytest.mark.parametrize(("change", "field"), [
    ({"cells": 0}, "cells"),
    ({"cells": 3}, "cells"),
    ({"cells": 4097}, "cells"),
    ({"cells": 10.5}, "cells"),
    ({"gain": 0.0}, "gain"),
    ({"gain": 1.01}, "gain"),
    ({"gain": math.nan}, "gain"),
    ({"forgetting": -0.1}, "forgetting"),
    ({"forgetting": 1.1}, "forgetting"),
    ({"write": "both"}, "write"),
    ({"read": "quintic"}, "read"),
    ({"limit": 0.0}, "limit"),
])  # fmt: skip
def test_an_angle_memory_refuses_what_it_cannot_be(change, field):
    with pytest.raises(BlockError, match=rf"^{field} = .*must be"):
        blocks.AngleMemory(**({"cells": 16, "gain": 0.5} | change))


# ---- filters -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("numeric", NUMERICS)
@pytest.mark.parametrize(("order", "cutoff"), [(9, 0.1), (10, 0.1), (15, 0.05), (1, 0.3)])
def test_the_taps_are_those_of_a_hamming_low_pass(order, cutoff, numeric):
    expected = signal.firwin(order + 1, 2.0 * cutoff, window="hamming")

    assert blocks.Fir(order, cutoff, numeric=numeric).taps == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize("order", [0, 9, 10])
def test_a_symmetric_filter_delays_every_slow_signal_by_half_its_order(order):
    fir = blocks.Fir(order, 0.2)
    ramp = [fir.step(float(k)) for k in range(60)]

    assert fir.delay_samples == order / 2.0
    assert ramp[-1] == pytest.approx(59.0 - order / 2.0, abs=1e-4)


@pytest.mark.parametrize(("order", "cutoff", "field"), [
    (16, 0.1, "order"), (-1, 0.1, "order"), (9, 0.5, "cutoff"), (9, 0.0, "cutoff"), (9, math.nan, "cutoff"),
])  # fmt: skip
def test_a_filter_refuses_what_it_cannot_be(order, cutoff, field):
    with pytest.raises(BlockError, match=f"^{field}.*must be"):
        blocks.Fir(order, cutoff)


# ---- torque observers ----------------------------------------------------------------------------------------------


J, B = 9e-4, 4e-3


def turn(torque_of, samples, speed=10.0):
    """Angle of a shaft under a torque that depends on its angle; another one makes up for friction at `speed`."""
    theta, w = np.empty(samples), speed
    angle, steps = 0.2, 20
    for k in range(samples):
        theta[k] = angle
        for _ in range(steps):
            w += TS / steps * (torque_of(angle) - B * (w - speed)) / J
            angle += TS / steps * w
    return theta


@pytest.mark.parametrize("kind", ["dob", "ro", "aro"])
def test_the_measured_torque_is_the_one_that_acted_ten_and_a_half_samples_ago(kind):
    """At the true age the measurement fits; two samples beside it, it does not. The reference carries the friction."""
    samples = 6000
    theta = turn(lambda angle: 0.05 * math.sin(12.0 * angle), samples)
    observer = blocks.TorqueObserver(kind, J, B)
    measured = np.empty(samples)
    for k in range(samples):
        observer.step(theta[k], B * 10.0, 10.0)
        measured[k] = observer.torque_nm

    def misfit(age):
        at = np.arange(200.0, samples) - age
        true = 0.05 * np.sin(12.0 * np.interp(at, np.arange(samples), theta))
        return np.std(measured[200:] - true)

    assert observer.age_samples == 10.5
    assert misfit(10.5) < 2e-4  # the filters show 0.9996 of 19 Hz, single precision the rest
    assert misfit(8.5) > 5.0 * misfit(10.5) < misfit(12.5)
    assert observer.speed_rad_s == pytest.approx(10.0, rel=0.3)


@pytest.mark.parametrize(("orders", "age"), [((9, 10), 10.5), ((9, 9), 10.0), ((0, 0), 1.0), ((15, 15), 16.0)])
def test_the_age_follows_from_the_orders_of_the_filters(orders, age):
    observer = blocks.TorqueObserver("aro", J, B, fir1=(orders[0], 1000.0), fir2=(orders[1], 1000.0))

    assert observer.age_samples == age


def test_an_age_may_be_claimed_instead_of_the_true_one():
    assert blocks.TorqueObserver("aro", J, B, age_samples=21.0).age_samples == 21.0


def test_an_angle_observer_predicts_the_torque_of_the_place_that_comes():
    """After many turns the estimate is the torque two samples ahead."""
    samples = 60_000
    theta = turn(lambda angle: 0.05 * math.sin(5.0 * angle), samples, speed=60.0)
    observer = blocks.TorqueObserver("aro", J, B, gain=0.3)
    estimate = np.array([observer.step(angle, B * 60.0) for angle in theta])
    late = slice(samples - 1200, samples - 2)
    expected = 0.05 * np.sin(5.0 * theta[samples - 1198 :])

    assert np.std(estimate[late] - expected) < 0.06 * np.std(expected)
    assert np.std(estimate[:50]) < 1e-3  # it starts knowing nothing


@pytest.mark.parametrize(("change", "field"), [
    ({"kind": "pid"}, "kind"),
    ({"inertia_kgm2": 0.0}, "inertia_kgm2"),
    ({"inertia_kgm2": math.nan}, "inertia_kgm2"),
    ({"gain": 3.0}, "gain"),
    ({"fir1": (16, 1000.0)}, "fir1_order"),
    ({"fir2": (10, 6000.0)}, "fir"),
    ({"age_samples": 32.0}, "age_samples"),
    ({"cells": 0}, "cells"),
    ({"actuation_samples": 0.0}, ".*actuation"),
])  # fmt: skip
def test_a_torque_observer_refuses_what_it_cannot_be(change, field):
    with pytest.raises(BlockError, match=f"^{field}.*must be"):
        blocks.TorqueObserver(**({"kind": "aro", "inertia_kgm2": J, "viscous_nms": B} | change))


# ---- deadbeat ------------------------------------------------------------------------------------------------------


R, LD, LQ, PSI, POLES = 0.5, 0.9e-3, 1.2e-3, 0.0594, 5


def currents(deadbeat, samples, reference, speed=20.0, r=R, ld=LD, lq=LQ, psi=PSI):
    """The machine in fine steps; the voltage of a sample acts in the period after the next sample."""
    i, acting, w, steps = np.zeros(2), np.zeros(2), POLES * speed, 50
    seen = np.empty((samples, 2))
    for k in range(samples):
        seen[k] = i
        wanted = np.array(deadbeat.step(tuple(i), reference(k), speed, tuple(acting)))
        for _ in range(steps):
            slope = ((acting[0] - r * i[0] + w * lq * i[1]) / ld, (acting[1] - r * i[1] - w * (ld * i[0] + psi)) / lq)
            i = i + TS / steps * np.array(slope)
        acting = wanted
    return seen


def test_the_current_reaches_its_reference_two_samples_later():
    seen = currents(blocks.Deadbeat(R, LD, LQ, PSI, POLES), 60, lambda k: (-0.5, 3.0) if k >= 20 else (0.0, 0.0))

    assert seen[20:22, 1] == pytest.approx([0.0, 0.0], abs=5e-3)
    assert seen[22:, 1] == pytest.approx(np.full(38, 3.0), rel=2e-3)
    assert seen[22:, 0] == pytest.approx(np.full(38, -0.5), rel=5e-3)


@pytest.mark.parametrize("factor", [0.7, 1.3])
@pytest.mark.parametrize("name", ["r", "l", "psi"])
def test_errors_of_the_model_of_a_third_leave_a_stable_loop_without_a_lasting_error(name, factor):
    model = {"r": R, "l": (LD, LQ), "psi": PSI}
    model[name] = tuple(factor * x for x in model["l"]) if name == "l" else factor * model[name]
    deadbeat = blocks.Deadbeat(model["r"], *model["l"], model["psi"], POLES)

    seen = currents(deadbeat, 400, lambda k: (0.0, 3.0))

    assert seen[300:, 1] == pytest.approx(np.full(100, 3.0), rel=2e-3)
    assert np.abs(seen[:, 1]).max() < 4.5


def test_without_the_correction_a_wrong_flux_leaves_an_error():
    textbook = blocks.Deadbeat(R, LD, LQ, 0.7 * PSI, POLES, correction=0.0)

    seen = currents(textbook, 400, lambda k: (0.0, 3.0))

    assert 0.05 < 3.0 - seen[-1, 1] < 1.0


@pytest.mark.parametrize(("change", "field"), [
    ({"ld_h": 0.0}, "ld_h"), ({"lq_h": -1.0}, "lq_h"), ({"r_ohm": -0.1}, "r_ohm"), ({"psi_wb": math.nan}, "psi_wb"),
    ({"pole_pairs": 0}, "pole_pairs"), ({"ts_s": 0.0}, "ts_s"), ({"correction": 0.6}, "correction"),
])  # fmt: skip
def test_deadbeat_refuses_what_it_cannot_be(change, field):
    with pytest.raises(BlockError, match=f"^{field} = .*must be"):
        blocks.Deadbeat(**({"r_ohm": R, "ld_h": LD, "lq_h": LQ, "psi_wb": PSI, "pole_pairs": POLES} | change))
