"""The compiled library: found, fitting, and complete."""

import pytest
from evenspin.errors import NativeError
from evenspin.native import NUMERICS, library, load, tables

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
        library.load.__wrapped__("float")


def test_null_handles_are_harmless():
    lib, ffi = load().lib, load().ffi

    assert lib.es_sim_run(ffi.NULL, 10, 1, ffi.NULL, 0) == 0
    assert not lib.es_sim_start(ffi.NULL)
    assert lib.es_param_info(-1, ffi.new("es_field_t *")) is False
    lib.es_sim_free(ffi.NULL)
    lib.es_block_free(ffi.NULL)
    assert lib.es_block_new(b"pi", ffi.NULL) != ffi.NULL
    assert not lib.es_block_start(ffi.NULL, ffi.NULL)
