"""A new effect is one file: a copy of the sources with it builds, and `evenspin gap` names it in a log that has it."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
FAN_NM_S2 = 3e-5  # 0.12 N m at 600 r/min

FAN = """\
#include "sim_host/plant/effect.h"

static double friction_nm(const double *p, double speed_abs_rad_s)
{
    return p[0] * speed_abs_rad_s * speed_abs_rad_s;
}

const sim_effect_t effect_fan = {
    .name = "fan",
    .acts_on = "friction",
    .doc = "Drag that grows with the square of the speed.",
    .signature = "q current with the square of the speed, in both directions.",
    .confused_with = {"viscous_friction", "coulomb_friction"},
    .shown_by = {{"staircase", "at many speeds"}, {"coast_down", ""}},
    .told_apart = "Its share of the friction grows with the speed.",
    .param_count = 1,
    .param = {
        {"torque_nms2", "N m s^2", "Drag over the square of the speed.", 0.0, 0.0, 1.0, SIM_AMPLITUDE, 2e-5},
    },
    .friction_nm = friction_nm,
};
"""

# In a process of its own, with the copied package and its library in place of the installed one.
FIND_IT = """\
import sys
sys.meta_path[:] = [f for f in sys.meta_path if not getattr(type(f), "__module__", "").startswith("_editable")]
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from evenspin.cli import main
from evenspin.gap import investigate as core
from evenspin.gap.plan import meta, perform, plan
from evenspin.log import write_case
from evenspin.model import load_machine

wanted = ("staircase", "coast_down", "validation")
chosen = [e for e in plan(load_machine(Path(sys.argv[2]))) if e.name in wanted]
case = Path(sys.argv[3])
case.mkdir()
write_case(case, meta(chosen, "fan"), {e.name: perform(e) for e in chosen})
if sys.argv[5] == "among its neighbours":  # half of the time goes into the others
    everything = core.hypotheses
    near = ("fan", "viscous_friction", "coulomb_friction", "inertia")
    core.hypotheses = lambda scale: {name: h for name, h in everything(scale).items() if name in near}
main(["gap", str(case), "--out", sys.argv[4]])
"""


def copy_of_the_sources(folder: Path) -> Path:
    for name in ("control", "hal", "firmware", "sim_host", "cmake"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / "CMakeLists.txt", folder)
    shutil.copytree(ROOT / "tools/src/evenspin", folder / "package/evenspin", ignore=shutil.ignore_patterns("_lib"))
    return folder


def configure(sources: Path) -> subprocess.CompletedProcess[str]:
    # -O1: compiling takes more of the time than what the library does here
    options = ("-DEVENSPIN_TESTS=OFF", "-DEVENSPIN_NUMERICS=float", "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1 -DNDEBUG")
    words = ("cmake", "-S", sources, "-B", sources / "build", "-G", "Ninja", *options)
    return subprocess.run(words, text=True, capture_output=True, check=False)


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_of_the_sources(tmp_path_factory.mktemp("sources"))


@pytest.mark.parametrize("library", ["among its neighbours", pytest.param("whole", marks=pytest.mark.search)])
def test_gap_names_an_effect_that_is_one_file(sources: Path, tmp_path: Path, library: str) -> None:
    from test_gap_result import MACHINE

    (sources / "sim_host/effects/fan.c").write_text(FAN)
    assert configure(sources).returncode == 0
    build = ("cmake", "--build", sources / "build", "--target", "evenspin_float", "--parallel", "2")
    built = subprocess.run(build, text=True, capture_output=True, check=False)
    assert built.returncode == 0, built.stdout[-2000:]
    built_into = sources / "package/evenspin/_lib"
    built_into.mkdir(exist_ok=True)
    shutil.copy(sources / "sim_host/capi/evenspin_capi.h", built_into)
    shutil.copy(sources / "build/sim_host/capi/libevenspin_float.so", built_into)
    shutil.copy(
        sources / "build/sim_host/capi/libevenspin_float.so", built_into / "libevenspin_fixed.so"
    )  # not used here
    machine = tmp_path / "machine.toml"
    machine.write_text(MACHINE.partition("[effects.")[0] + f"[effects.fan]\ntorque_nms2 = {FAN_NM_S2}\n")

    places = (sources / "package", machine, tmp_path / "case", tmp_path / "out")
    words = (sys.executable, "-c", FIND_IT, *places, library)
    run = subprocess.run(words, text=True, capture_output=True, check=False)

    assert run.returncode == 0, run.stderr[-2000:]
    verdict = json.loads((tmp_path / "out/verdict.json").read_text())
    assert verdict["verdict"] == ["fan"]
    # 5 %: the friction of the unit is fitted along, within its tolerance
    assert verdict["parameters"]["fan"]["torque_nms2"] == pytest.approx(FAN_NM_S2, rel=0.05)


def test_a_second_effect_with_a_flux_linkage_is_refused_when_it_is_built(sources: Path) -> None:
    other = sources / "sim_host/effects/other_saturation.c"
    original = (ROOT / "sim_host/effects/inductance_saturation.c").read_text()
    other.write_text(original.replace("inductance_saturation", "other_saturation"))

    refused = configure(sources)

    other.unlink()
    said = " ".join(refused.stderr.split())
    assert refused.returncode != 0
    assert "inductance_saturation.c;other_saturation.c: only one effect can have linkage_wb" in said


def test_more_effects_than_the_plant_has_room_for_are_refused_when_it_is_built(sources: Path) -> None:
    folder = sources / "sim_host/effects"
    more = [folder / f"fan_{k}.c" for k in range(33)]
    for file in more:
        file.write_text(FAN.replace("fan", file.stem))

    refused = configure(sources)

    for file in more:
        file.unlink()
    assert refused.returncode != 0
    assert "raise SIM_EFFECTS_MAX" in " ".join(refused.stderr.split())
