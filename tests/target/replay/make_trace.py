"""A short recording of the simulated drive as a C file, for a machine without files.

    make_trace.py OUT.c float|fixed

The drive runs up with repetitive control, gets another gain, a load step and another speed, and at the end a dead
current sensor: PI, memory, hand-over of parameters and a trip are all in it.
"""

from __future__ import annotations

import io
import sys
from dataclasses import replace
from pathlib import Path

from evenspin.model.scenario import builtin_scenario
from evenspin.model.setup import InputCurve, Tune
from evenspin.native import tables
from evenspin.recording import Recorder, RecordingFile
from evenspin.sim import complete, prepare

SECONDS = 0.4


def main() -> int:
    target, numeric = Path(sys.argv[1]), sys.argv[2]
    setup = builtin_scenario("guo2024/first").setup
    gain = "speed_kp_a_per_unit"
    method = float(tables().params["method"].choices.index("fal-forc"))
    setup = replace(
        setup,
        drive={**setup.drive, "method": method},
        inputs={
            "speed_ref_rad_s": InputCurve((0.0, 0.25), (15.0, 25.0), False),
            "load_brake_nm": InputCurve((0.0, 0.2), (0.02, 0.06), False),
            "current_a_gain": InputCurve((0.0, 0.38), (1.0, 0.0), False),
        },
        tunes=(Tune(0.15, gain, 0.8 * setup.drive[gain]),),
        duration_s=SECONDS,
        log_rate_hz=setup.pwm_hz,
    )
    place = target.with_suffix(".replay")
    with place.open("wb") as file:
        recorder = Recorder(file, numeric=numeric, what="short run", seed=setup.seed, pwm_hz=setup.pwm_hz)
        log = complete(prepare(setup, ("fault",), numeric, None, recorder), setup, ("fault",), None, recorder)
        recorder.close()
    (part,) = RecordingFile(place).parts()
    tripped = int((log["fault"] > 0.0).argmax())
    assert log["fault"][tripped] > 0.0, "the recording has no fault at its end"
    text = io.StringIO()
    text.write(f"/* {SECONDS:g} s of a simulated drive, {numeric}, made by make_trace.py. */\n")
    text.write("#include <stddef.h>\n#include <stdint.h>\n\n")
    for index, stream in enumerate(part.streams):
        rows = [",".join(map(str, stream[at : at + 40])) for at in range(0, len(stream), 40)] or ["0"]
        text.write(f"static const uint8_t STREAM_{index}[] = {{\n" + ",\n".join(rows) + "};\n")
    names = ", ".join(f"STREAM_{index}" for index in range(len(part.streams)))
    counts = ", ".join(str(len(stream)) for stream in part.streams)
    text.write(f"const uint8_t *const trace_streams[] = {{{names}}};\nconst size_t trace_counts[] = {{{counts}}};\n")
    text.write(f"const uint32_t trace_periods = {part.periods}U, trace_fault_period = {tripped}U;\n")
    text.write(f"const int trace_fault = {int(log['fault'][tripped])};\n")
    target.write_text(text.getvalue())
    return 0


if __name__ == "__main__":
    sys.exit(main())
