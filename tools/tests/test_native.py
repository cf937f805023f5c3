"""The compiled library: found, fitting, and complete."""

import numpy as np
import pytest
from evenspin.errors import NativeError
from evenspin.native import NUMERICS, library, load, tables
from evenspin.native.csvrows import csv_rows
from evenspin.native.simulation import Simulation, noise_of

# Names that are spoken outside of this project: the format sheet's vocabulary.
EFFECTS = {
    "current_offset": ["offset_a_a", "offset_b_a"],
    "current_gain": ["gain_a", "gain_b"],
    "dead_time": ["dead_time_s"],
    "cogging": ["amplitude_nm", "phase_rad", "order"],
    "flux_harmonics": ["torque_ripple_rel", "sign"],
    "coulomb_friction": ["torque_nm"],
    "stribeck_friction": ["torque_nm", "speed_rad_s"],
    "viscous_friction": ["factor"],
    "inertia": ["factor"],
    "load_torque": ["torque_nm"],
    "misalignment": ["amplitude_nm", "phase_rad", "second_rel", "phase2_rad"],
    "encoder_eccentricity": ["amplitude_rad", "phase_rad"],
    "encoder_offset": ["angle_el_rad"],
    "torque_constant": ["factor"],
    "winding_resistance": ["factor"],
    "current_loop_delay": ["extra_periods"],
    "inductance_saturation": ["i_sat_a"],
    "two_mass": ["f_res_hz", "load_ratio", "damping_ratio"],
    "backlash": ["gap_rad", "load_ratio", "f_res_hz", "damping_ratio"],
    "current_filter": ["tau_s"],
}


@pytest.mark.parametrize("numeric", NUMERICS)
def test_both_builds_load_and_say_what_they_are(numeric):
    loaded = load(numeric)

    assert loaded.text(loaded.lib.es_numeric()) == numeric


def test_effects_have_the_names_of_the_format_before_any_of_our_own():
    known = tables().effects

    assert {name: list(known[name].params)[: len(params)] for name, params in EFFECTS.items()} == EFFECTS


def test_every_entry_of_a_table_explains_itself():
    fields = [*tables().params.values(), *tables().model.values(), *tables().inputs.values()]
    fields += [field for effect in tables().effects.values() for field in effect.params.values()]

    for field in fields:
        assert field.doc.endswith("."), field.name
        assert field.minimum <= field.default <= field.maximum, field.name
        assert (field.kind == "choice") == bool(field.choices), field.name
    for effect in tables().effects.values():
        assert effect.doc and effect.signature and effect.acts_on
    for fault in tables().faults[1:]:
        assert fault.cause and fault.check


def test_declarations_leave_out_what_is_not_c():
    header = """
    /* a comment
       with #define inside */
    #ifndef X
    #ifdef __cplusplus
    extern "C" {
    #endif
    int f(int a); // why
    #ifdef __cplusplus
    }
    #endif
    #endif
    """

    assert library.declarations(header).split() == ["int", "f(int", "a);"]


def test_a_missing_library_says_what_to_do(monkeypatch, tmp_path):
    monkeypatch.setattr(library, "library_folder", lambda header: tmp_path)

    with pytest.raises(NativeError, match="make setup"):
        library._loaded.__wrapped__("float")


def test_a_library_is_loaded_once_however_it_is_named():
    assert load() is load("float") is load(numeric="float")


def test_null_handles_are_harmless():
    lib, ffi = load().lib, load().ffi

    assert lib.es_sim_run(ffi.NULL, 10, 1, ffi.NULL, 0) == 0
    assert not lib.es_sim_start(ffi.NULL)
    assert lib.es_param_info(-1, ffi.new("es_field_t *")) is False
    lib.es_sim_free(ffi.NULL)
    lib.es_block_free(ffi.NULL)
    assert lib.es_block_new(b"pi", ffi.NULL) != ffi.NULL
    assert not lib.es_block_start(ffi.NULL, ffi.NULL)


@pytest.mark.parametrize("width", [1, 7])
def test_numbers_for_a_csv_file_are_written_as_python_writes_nine_digits(width):
    """Python rounds from all digits of the number, the library from 64 bits where that is enough."""
    random = np.random.default_rng(5)
    bits = random.integers(0, 2**64, 21_000, dtype=np.uint64).view(np.float64)
    common_sizes = random.normal(0.0, 1.0, 21_000) * 10.0 ** random.integers(-6, 10, 21_000)
    near_ties = (random.integers(10**8, 10**9, 21_000) + 0.5) * 10.0 ** random.integers(-14, 2, 21_000)
    single = random.normal(0.0, 50.0, 21_000).astype(np.float32).astype(float)
    special = [0.0, -0.0, np.nan, np.inf, -np.inf, 5e-324, 1.7976931348623157e308, 999999999.5, 0.0001, 9.9999999995e-5]
    values = np.concatenate([bits, common_sizes, near_ties, single, (special * 7)[:70]]).reshape(-1, width)

    written = csv_rows(values).decode()

    expected = "".join(",".join(f"{value + 0.0:.9g}" for value in row) + "\n" for row in values.tolist())
    assert written == expected


def test_a_table_without_rows_has_no_text():
    assert csv_rows(np.empty((0, 3))) == b""


def test_a_seed_is_refused_with_the_noise_of_another_one_in_words():
    with pytest.raises(NativeError, match="seed = 5: must be the seed that the noise was drawn with"):
        Simulation().set_noise(5, noise_of(6, 4))
    Simulation().set_noise(6, noise_of(6, 4))
