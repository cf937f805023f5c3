"""Pole placement of the angle observer against polynomials and matrices written here."""

import json
import math

import numpy as np
import pytest
from evenspin.design.aro import Chain, Mechanics, Memory, convergence, gain_of, place_speed_poles, polynomial_17
from evenspin.design.aro_separation import off_product, separation_error, whole_loop
from evenspin.errors import InputError

TS = 1e-4
RIG2 = Mechanics(9e-4, 4e-3, TS)
PAPER = Chain(9, 1000.0, 10, 1000.0, 2.0, TS)


def test_the_coefficients_are_those_of_the_plant():
    assert RIG2.a23 == pytest.approx(1e-4 / 9e-4)
    assert RIG2.a22 == pytest.approx(1.0 - 4e-3 * 1e-4 / 9e-4)


def test_the_memory_poles_are_the_eigenvalues_of_the_matrix_of_the_paper():
    """Equation 16: det(lambda I - (a33 - L a23 C)) with N = 12, L = [0 .. 0, L_N], forgetting 0.98."""
    cells, gain, forgetting = 12, 0.3, 0.98
    a33 = np.diag(np.ones(cells - 1), 1)
    a33[-1, 0] = forgetting
    a33[-1, 0] -= gain

    expected = np.abs(np.linalg.eigvals(a33))

    memory = Memory(cells, gain, forgetting, RIG2.a23)
    assert np.full(cells, memory.pole) == pytest.approx(expected, rel=1e-9)


def test_equation_17_is_the_polynomial_of_its_matrix():
    kp, ki = 0.17, 9e-4
    matrix = np.array([[1.0, 0.0, -1.0], [ki, 0.0, -kp], [0.0, RIG2.a23, RIG2.a22]])

    assert polynomial_17(RIG2, kp, ki) == pytest.approx(np.poly(matrix), abs=1e-12)


def test_the_gains_place_a_double_pole_when_the_torque_has_no_delay():
    speed = place_speed_poles(RIG2, PAPER, 16.0)

    p = math.exp(-2.0 * math.pi * 16.0 * TS)
    without_delay = np.poly([[1.0, -1.0], [RIG2.a23 * speed.ki_nms, RIG2.a22 - RIG2.a23 * speed.kp_nms]])
    assert without_delay == pytest.approx([1.0, -2.0 * p, p * p], abs=1e-12)
    # close to the continuous ones, 2 w J - B and J w^2 T_s
    w = 2.0 * math.pi * 16.0
    assert speed.kp_nms == pytest.approx(2.0 * w * 9e-4 - 4e-3, rel=0.01)
    assert speed.ki_nms == pytest.approx(9e-4 * w**2 * TS, rel=0.02)


def test_with_every_delay_the_roots_are_those_of_a_simulation():
    """Impulse response of the loop, sample by sample: its decay is the largest root."""
    speed = place_speed_poles(RIG2, PAPER, 40.0)
    taps = PAPER.taps(1)
    w, seen, torque, x = [0.0] * 12, [0.0] * 12, [0.0] * 12, 0.0
    out = []
    w[-1] = 1.0
    for _ in range(3000):
        seen.append(0.5 * (w[-1] + w[-2]))
        filtered = float(np.dot(taps, seen[-1 : -len(taps) - 1 : -1]))
        reference = ki_state(speed.ki_nms, x) - speed.kp_nms * filtered
        x -= filtered
        torque.append(reference)
        acting = 0.5 * (torque[-2] + torque[-3])
        w.append(RIG2.a22 * w[-1] + RIG2.a23 * acting)
        out.append(w[-1])
    late = np.abs(out[400:1200])

    decay = math.exp(np.polyfit(np.arange(len(late)), np.log(late + 1e-300), 1)[0])

    assert np.abs(speed.real_roots).max() == pytest.approx(decay, abs=2e-3)
    assert speed.stable


def ki_state(ki, x):
    return ki * x


def test_the_printed_gain_forgets_an_error_in_twenty_turns():
    memory = Memory(200, 0.05, 1.0, RIG2.a23)

    assert memory.turns_to(math.exp(-1.0)) == pytest.approx(-1.0 / math.log(0.95))
    assert memory.turns_to(0.1) == pytest.approx(44.9, abs=0.05)
    assert memory.observer_gain == pytest.approx(0.45)
    assert memory.bound == pytest.approx(2.0 / RIG2.a23)


@pytest.mark.parametrize(("pole", "turns"), [(0.99974, None), (None, 20.0)])
def test_a_pole_or_a_number_of_turns_gives_the_gain(pole, turns):
    gain = gain_of(cells=200, forgetting=1.0, pole=pole, turns=turns)

    expected = 1.0 - 0.99974**200 if pole else 1.0 - math.exp(-1.0 / 20.0)
    assert gain == pytest.approx(expected)
    assert 0.04 < gain < 0.06


@pytest.mark.parametrize("forgetting", [1.0, 0.98])
def test_the_block_converges_as_the_poles_say(forgetting):
    memory = Memory(60, 0.2, forgetting, RIG2.a23)

    turns, error = convergence(memory, 12)

    expected = (forgetting - 0.2) ** turns
    assert error == pytest.approx(expected, rel=0.02)


def test_ages_are_half_orders_and_the_printed_label_counts_whole_ones():
    assert PAPER.age_samples == 10.5
    assert PAPER.printed_label == 21


@pytest.mark.parametrize(("f_hz", "seen"), [(0.0, 1.0), (180.0, 0.97), (400.0, 0.86), (600.0, 0.71)])
def test_the_filters_show_what_an_independent_calculation_says(f_hz, seen):
    assert float(PAPER.gain(np.array([f_hz]))[0]) == pytest.approx(seen, abs=0.012)


# ---- the command ---------------------------------------------------------------------------------------------------


def test_the_command_tells_poles_bound_age_and_what_to_set(evenspin, tmp_path):
    said = evenspin("design", "aro", "--json", tmp_path / "d.json", "--plot", tmp_path / "d.svg")

    assert said.status == 0
    for text in ("0 < L_N < 18.00: stable", "10.5 samples old", "k-21", "observer_gain"):
        assert text in said.out
    found = json.loads((tmp_path / "d.json").read_text())
    assert found["memory"]["pole"] == pytest.approx(0.95 ** (1.0 / 200.0))
    assert len(found["speed"]["roots_17"]) == 3
    assert all(math.hypot(*root) < 1.0 for root in found["speed"]["roots_17"])
    assert "<svg" in (tmp_path / "d.svg").read_text()


@pytest.mark.parametrize("gain", [2.01, -0.05, 0.0])
def test_a_gain_outside_its_bounds_fails_the_check(evenspin, gain):
    said = evenspin("design", "aro", "--gain", gain)

    assert said.status == 1
    assert "NOT stable" in said.out
    assert said.err.startswith("L_N = ") and "2 / a23" in said.err


def test_just_below_the_bound_is_stable(evenspin):
    assert evenspin("design", "aro", "--gain", 1.99).status == 0


def test_a_speed_loop_that_its_delays_make_unstable_fails_the_check(evenspin):
    said = evenspin("design", "aro", "--pi-hz", 300)

    assert said.status == 1
    assert "--pi-hz" in said.err


@pytest.mark.parametrize(("words", "reported"), [
    (("--cells", "0"), "--cells"),
    (("--cells", "5000"), "--cells"),
    (("--pole", "1.0"), "--pole"),
    (("--pole", "nan"), "--pole"),
    (("--turns", "0"), "--turns"),
    (("--turns", "20", "--pole", "0.99"), "--turns"),
    (("--gain", "nan"), "--gain"),
    (("--forgetting", "0"), "--forgetting"),
    (("--pi-hz", "0"), "--pi-hz"),
    (("--pi-hz", "0.1"), "--pi-hz"),
    (("--inertia-kgm2", "0"), "inertia_kgm2"),
    (("--viscous-nms", "-1"), "viscous_nms"),
    (("--viscous-nms", "1e6"), "viscous_nms"),
    (("--model", "tang"), "--model"),
    (("--plot", "picture.gif"), "--plot"),
])  # fmt: skip
def test_bad_input_is_one_line_that_names_the_culprit(evenspin, words, reported):
    said = evenspin("design", "aro", *words)

    assert said.status == 2
    assert said.err.count("\n") == 1
    assert reported in said.err


def test_mechanics_that_are_not_numbers_are_refused():
    with pytest.raises(InputError, match="inertia_kgm2"):
        Mechanics(math.nan, 0.0, TS)


# ---- separation principle ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gain", "forgetting"), [(0.05, 1.0), (0.3, 0.95), (1.9, 1.0)])
def test_memory_and_speed_loop_keep_their_poles_beside_each_other(gain, forgetting):
    """Equation 15 for 2 N + 3 = 203 states; rounding of a determinant of that size is some 1e-10."""
    memory, speed = Memory(200, gain, forgetting, RIG2.a23), place_speed_poles(RIG2, PAPER, 16.0)

    assert separation_error(RIG2, memory, speed) < 1e-8


def test_the_poles_of_the_whole_loop_are_those_of_its_parts():
    """By eigenvalues, with few cells: N on the unit circle, N of the memory, three of the speed loop."""
    cells = 6
    memory, speed = Memory(cells, 0.4, 0.9, RIG2.a23), place_speed_poles(RIG2, PAPER, 40.0)

    poles = np.linalg.eigvals(whole_loop(RIG2, memory, speed, cells))

    circle = np.exp(2j * np.pi * np.arange(cells) / cells)
    parts = np.concatenate([circle, 0.5 ** (1.0 / cells) * circle, speed.roots])  # 0.9 - 0.4 is left after a turn
    apart = np.abs(poles[:, None] - parts[None, :])
    assert apart.min(axis=0).max() < 1e-6  # a double root errs by the root of the rounding


def test_a_loop_in_which_the_observer_saw_the_speed_controller_would_not_separate():
    cells = 20
    memory, speed = Memory(cells, 0.05, 1.0, RIG2.a23), place_speed_poles(RIG2, PAPER, 16.0)
    phi = whole_loop(RIG2, memory, speed, cells)
    phi[-1, 1] = memory.observer_gain * RIG2.a23  # T_ref is not subtracted from what it measures

    assert off_product(phi, RIG2, memory, speed, cells) > 1e-3
