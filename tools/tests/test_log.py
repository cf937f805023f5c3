"""The measured-log format: what is written comes back, and nothing is left half-written."""

import gzip
import json

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.log import LOG_COLUMNS, OutputFolder, meta_of, read_case, read_csv, write_case, write_csv
from evenspin.log.columns import LOG_UNITS
from evenspin.model import builtin_scenario
from evenspin.sim import Record

# Header and keys as in the format sheet, written down here a second time on purpose.
HEADER = (
    "t_s,speed_ref_rad_s,speed_rad_s,theta_m_rad,id_ref_a,iq_ref_a,id_a,iq_a,ia_a,ib_a,vd_v,vq_v,vdc_v,load_torque_nm"
)
META_KEYS = {
    "case": None,
    "motor": "pole_pairs resistance_ohm ld_h lq_h psi_wb inertia_kgm2 viscous_nms rated_current_a rated_torque_nm "
    "slots",
    "dc_link_v": None,
    "pwm_hz": None,
    "encoder": "counts_per_rev",
    "current_loop": "ts_s kp_v_per_a ki_v_per_as computation_delay_periods angle_advance_periods v_limit",
    "speed_loop": "ts_s kp_a_per_rad_s ki_a_per_rad iq_limit_a",
    "speed_filter": "type ts_s kp ki",
    "current_noise_a": None,
    "current_lsb_a": None,
    "experiments": None,
}


@pytest.fixture
def record() -> Record:
    values = np.random.default_rng(5).normal(size=(300, len(LOG_COLUMNS))).astype(np.float32).astype(float)
    values[:, 0] = np.arange(300) * 5e-4
    values[3, 13] = np.nan  # not measured
    return Record(LOG_COLUMNS, LOG_UNITS, values)


@pytest.fixture
def meta() -> dict:
    return meta_of(builtin_scenario("guo2024/first").setup, "here", ["run"])


def test_a_case_comes_back_as_it_was(tmp_path, record, meta):
    write_case(tmp_path, meta, {"run": record})

    case = read_case(tmp_path)

    assert (tmp_path / "run.csv").read_text().splitlines()[0] == HEADER
    assert case.meta == meta
    np.testing.assert_allclose(case.experiments["run"].values, record.values, rtol=1e-8)
    np.testing.assert_array_equal(case.experiments["run"]["ia_a"].astype(np.float32), record["ia_a"].astype(np.float32))


def test_meta_has_the_keys_of_the_format_and_no_others(meta):
    assert list(meta) == list(META_KEYS)
    for key, names in META_KEYS.items():
        if names:
            assert list(meta[key]) == names.split()


def test_meta_gives_the_gains_per_mechanical_speed(meta):
    assert meta["speed_loop"]["kp_a_per_rad_s"] == pytest.approx(0.0368 * 4)
    assert meta["speed_loop"]["ki_a_per_rad"] == pytest.approx(0.92 * 4)
    assert meta["current_loop"]["v_limit"] == "dc_link_v/sqrt(3)"
    assert isinstance(meta["motor"]["pole_pairs"], int)


def test_a_compressed_log_reads_the_same(tmp_path, record):
    write_csv(tmp_path / "a.csv", LOG_COLUMNS, record.values)
    write_csv(tmp_path / "a.csv.gz", LOG_COLUMNS, record.values)

    assert gzip.decompress((tmp_path / "a.csv.gz").read_bytes()) == (tmp_path / "a.csv").read_bytes()
    np.testing.assert_array_equal(
        read_csv(tmp_path / "a.csv.gz", LOG_COLUMNS, LOG_UNITS).values,
        read_csv(tmp_path / "a.csv", LOG_COLUMNS, LOG_UNITS).values,
    )


def test_negative_zero_is_written_as_zero(tmp_path):
    write_csv(tmp_path / "z.csv", ("x",), np.array([[-0.0], [1.5]]))

    assert (tmp_path / "z.csv").read_text() == "x\n0\n1.5\n"


def test_columns_may_come_in_any_order(tmp_path):
    (tmp_path / "o.csv").write_text("b,extra,a\n2,9,1\n4,9,3\n")

    assert read_csv(tmp_path / "o.csv", ("a", "b"), ("", "")).values.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    ("text", "line", "word"),
    [
        ("a\n1\n", 1, "b"),
        ("a,b\n1,2\n1,x\n", 3, "'x'"),
        ("a,b\n1,2\n1,2,3\n", 3, "columns = 3"),
        ("a,b\n", 2, "rows"),
        ("", 1, "a"),
    ],
)
def test_a_bad_csv_is_refused_with_its_line(tmp_path, text, line, word):
    path = tmp_path / "bad.csv"
    path.write_text(text)

    with pytest.raises(InputError) as refusal:
        read_csv(path, ("a", "b"), ("", ""))

    assert str(refusal.value).startswith(f"{path}:{line}: ")
    assert word in str(refusal.value)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"experiments": [1]}', b'{"experiments": ["../x"]}', b"\xff"])
def test_a_bad_meta_is_refused(tmp_path, content):
    (tmp_path / "meta.json").write_bytes(content)

    with pytest.raises(InputError, match="meta.json"):
        read_case(tmp_path)


def test_a_case_without_logs_is_refused(tmp_path, meta):
    (tmp_path / "meta.json").write_text(json.dumps(meta))

    with pytest.raises(InputError, match="experiments"):
        read_case(tmp_path)


def test_a_missing_experiment_is_left_out(tmp_path, record, meta):
    write_case(tmp_path, {**meta, "experiments": ["run", "coast_down"]}, {"run": record})

    assert list(read_case(tmp_path).experiments) == ["run"]


# ---- the output folder -----------------------------------------------------------------------------------------------


def test_an_output_appears_when_it_is_complete(tmp_path):
    out = tmp_path / "deep" / "out"

    with OutputFolder(out, ["evenspin", "x"]) as folder:
        (folder / "a.txt").write_text("a")
        assert not out.exists()

    assert sorted(path.name for path in out.iterdir()) == ["a.txt", "manifest.json"]
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def test_an_error_leaves_nothing_behind(tmp_path):
    with pytest.raises(RuntimeError), OutputFolder(tmp_path / "out", []) as folder:
        (folder / "a.txt").write_text("a")
        raise RuntimeError

    assert list(tmp_path.iterdir()) == []


def test_an_error_leaves_the_earlier_output_as_it_was(tmp_path):
    with OutputFolder(tmp_path / "out", []) as folder:
        (folder / "a.txt").write_text("old")

    with pytest.raises(RuntimeError), OutputFolder(tmp_path / "out", []) as folder:
        (folder / "a.txt").write_text("new")
        raise RuntimeError

    assert (tmp_path / "out" / "a.txt").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_an_earlier_output_is_replaced_as_a_whole(tmp_path):
    with OutputFolder(tmp_path / "out", []) as folder:
        (folder / "old.txt").write_text("old")

    with OutputFolder(tmp_path / "out", []) as folder:
        (folder / "new.txt").write_text("new")

    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["manifest.json", "new.txt"]


def test_somebody_elses_folder_is_left_alone(tmp_path):
    (tmp_path / "thesis.txt").write_text("three years")

    with pytest.raises(InputError, match="thesis.txt"):
        OutputFolder(tmp_path, [])


def test_a_file_added_to_an_output_protects_it(tmp_path):
    with OutputFolder(tmp_path / "out", []) as folder:
        (folder / "a.txt").write_text("a")
    (tmp_path / "out" / "notes.txt").write_text("mine")

    with pytest.raises(InputError, match="notes.txt"):
        OutputFolder(tmp_path / "out", [])


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "out").write_text("")

    for path in (tmp_path / "out", tmp_path / "out" / "below"):
        with pytest.raises(InputError, match="a folder"):
            OutputFolder(path, [])
