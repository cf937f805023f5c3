"""The check of the layers finds what it is there for, and nothing in clean code."""

from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import check_layers

CLEAN = """\
/* A double, 1.0, malloc(n) and #include "firmware/app/app.h" in a comment are no fault. */
#include "control/numeric/num.h"
#include <math.h>
// uint8_t in a comment that goes on \\
   with sqrt(2.0) on the next line
static const char *const TEXT = "double \\" 1.5 sin(x)";
static const float K[] = {1.0f, .5F, 2.f, 1e-3f, 0x1E5, 12};
float f(float x) { return (x > K[0]) ? fabsf(x) : my_sqrt(x) + frame.sin_free(x); }
"""


def rules(path: str, source: str) -> list[tuple[int, str]]:
    return list(check_layers.violations(path, source))


class Includes(unittest.TestCase):
    def assert_refused(self, path: str, include: str) -> None:
        found = rules(path, f"\n#include {include}\n")
        self.assertEqual([line for line, _ in found], [2], f"{path} includes {include}")

    def assert_allowed(self, path: str, include: str) -> None:
        self.assertEqual(rules(path, f"#  include {include} /* why */\n"), [])

    def test_control_knows_only_itself(self) -> None:
        self.assert_allowed("control/motor/pi.c", '"control/numeric/num.h"')
        self.assert_allowed("control/motor/pi.c", "<stdint.h>")
        self.assert_refused("control/motor/pi.c", "<stdio.h>")
        self.assert_refused("control/motor/pi.h", '"hal/hal_sample.h"')
        self.assert_refused("control/motor/pi.c", '"firmware/app/app.h"')

    def test_hal_contract_knows_only_itself(self) -> None:
        self.assert_allowed("hal/include/hal/hal_sample.h", '"hal/hal_status.h"')
        self.assert_refused("hal/include/hal/hal_sample.h", '"control/numeric/num.h"')
        self.assert_refused("hal/include/hal/hal_sample.h", '"driverlib.h"')

    def test_port_knows_its_vendor_but_not_the_firmware(self) -> None:
        self.assert_allowed("hal/f28379d/pwm.c", '"driverlib.h"')
        self.assert_allowed("hal/f28379d/pwm.c", '"hal/hal_inverter.h"')
        self.assert_allowed("hal/f28379d/pwm.c", '"device.h"')
        self.assert_allowed("hal/f28379d/pwm.c", '"hal/f28379d/board.h"')
        self.assert_refused("hal/f28379d/pwm.c", '"epwm.h"')
        self.assert_refused("hal/f28379d/pwm.c", '"firmware/app/app.h"')

    def test_only_the_main_of_a_board_knows_its_port(self) -> None:
        self.assert_allowed("firmware/main_f28379d.c", '"hal/f28379d/port.h"')
        self.assert_refused("firmware/main_f28379d.c", '"driverlib.h"')
        self.assert_refused("firmware/app/app.c", '"hal/f28379d/port.h"')

    def test_a_second_board_is_guarded_from_its_first_file_on(self) -> None:
        self.assert_allowed("hal/g474/pwm.c", '"hal/g474/board.h"')
        self.assert_allowed("hal/g474/pwm.c", '"hal/hal_inverter.h"')
        self.assert_allowed("firmware/main_g474.c", '"hal/g474/port.h"')
        self.assert_refused("hal/g474/pwm.c", '"hal/f28379d/board.h"')
        self.assert_refused("hal/g474/pwm.c", '"driverlib.h"')
        self.assert_refused("hal/g474/pwm.c", '"firmware/app/app.h"')
        self.assert_refused("hal/hal_sample.h", '"hal/g474/board.h"')
        self.assert_refused("hal/include/hal/hal_sample.h", '"hal/g474/board.h"')
        for path in (
            "firmware/app/app.c",
            "firmware/services/x.c",
            "firmware/main_f28379d.c",
            "sim_host/board/board.c",
        ):
            self.assert_refused(path, '"hal/g474/port.h"')

    def test_firmware_does_not_know_the_simulator(self) -> None:
        for include in ('"control/motor/pi.h"', '"hal/hal_sample.h"', '"firmware/app/app.h"'):
            self.assert_allowed("firmware/app/app.c", include)
        self.assert_refused("firmware/app/app.c", '"sim_host/plant/plant.h"')

    def test_firmware_may_clear_memory_but_not_print(self) -> None:
        self.assert_allowed("firmware/app/app.c", "<string.h>")
        self.assert_refused("firmware/app/app.c", "<stdio.h>")

    def test_physics_knows_neither_control_nor_firmware(self) -> None:
        for folder in ("plant", "effects"):
            path = f"sim_host/{folder}/x.c"
            self.assert_allowed(path, '"sim_host/plant/plant.h"')
            self.assert_allowed(path, '"sim_host/effects/effect.h"')
            self.assert_allowed(path, "<stdlib.h>")
            self.assert_refused(path, '"sim_host/board/board.h"')
            self.assert_refused(path, '"control/motor/frames.h"')
            self.assert_refused(path, "<unistd.h>")

    def test_only_board_and_capi_join_plant_and_firmware(self) -> None:
        for include in ('"firmware/app/app.h"', '"hal/hal_sample.h"'):
            self.assert_allowed("sim_host/board/board.c", include)
            self.assert_allowed("sim_host/capi/capi.c", include)
            self.assert_refused("sim_host/other/x.c", include)

    def test_the_referee_shares_nothing_with_what_it_judges(self) -> None:
        self.assert_allowed("sim_host/referee/x.c", '"sim_host/referee/machine.h"')
        for include in ('"sim_host/plant/plant.h"', '"control/motor/pi.h"', '"firmware/app/drive.h"'):
            self.assert_refused("sim_host/referee/x.c", include)
        for folder in ("plant", "effects", "board", "capi"):
            self.assert_refused(f"sim_host/{folder}/x.c", '"sim_host/referee/machine.h"')

    def test_services_ask_the_drive_and_do_not_look_inside(self) -> None:
        for code in ("x = d->state;", "f(s->setup.drive->fault);", "if (drive->position.homed) {}"):
            self.assertEqual(len(rules("firmware/services/services.c", f"{code}\n")), 1, code)
            self.assertEqual(rules("firmware/app/memory.c", f"{code}\n"), [])
        self.assertEqual(rules("firmware/services/services.c", "x = drive_state(s->setup.drive); /* d->state */\n"), [])

    def test_headers_are_named_from_the_root(self) -> None:
        self.assert_refused("control/motor/pi.c", '"pi.h"')
        self.assert_refused("control/motor/pi.c", '"control/../firmware/app/app.h"')
        self.assert_refused("control/motor/pi.c", "HEADER")


class Target(unittest.TestCase):
    def assert_poison(self, code: str) -> None:
        for path in (
            "control/motor/pi.c",
            "firmware/app/list.def",
            "hal/include/hal/hal_types.h",
            "hal/f28379d/pwm.c",
            "hal/g474/x.c",
        ):
            self.assertEqual([line for line, _ in rules(path, f"int before;\n{code}\n")], [2], f"{path}: {code}")

    def test_clean_code_passes(self) -> None:
        self.assertEqual(rules("control/motor/pi.c", CLEAN), [])

    def test_types_that_the_chip_lacks(self) -> None:
        for code in ("uint8_t x;", "int8_t x;", "(uint_least8_t)x", "double x;"):
            self.assert_poison(code)

    def test_heap(self) -> None:
        for code in ("p = malloc(4);", "free (p);", "p = calloc(1, 2);"):
            self.assert_poison(code)

    def test_library_mathematics(self) -> None:
        for call in ("sin(x)", "cos (x)", "sqrt(x)", "pow(x, y)", "powf(x, y)", "fabs(x)"):
            self.assert_poison(f"y = {call};")

    def test_double_literals(self) -> None:
        for code in ("y = 1.0;", "y = .5;", "y = 1.;", "y = 1e3;", "y = 2.5e-3L;", "f(-1.0, 2.0f)"):
            self.assert_poison(code)

    def test_simulator_may_calculate_in_double(self) -> None:
        self.assertEqual(rules("sim_host/plant/plant.c", "double x = sin(1.0);\n"), [])

    def test_code_after_a_comment_is_seen(self) -> None:
        self.assert_poison("/* one */ double x; /* two */")
        self.assert_poison('f("/*"); double x; /* */')


class Command(unittest.TestCase):
    def run_on(self, files: dict[str, str]) -> tuple[int, str]:
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                file = Path(folder, name)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            output = io.StringIO()
            with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
                status = check_layers.main([folder])
            return status, output.getvalue()

    def test_clean_tree_passes(self) -> None:
        status, output = self.run_on({"control/motor/pi.c": CLEAN})

        self.assertEqual((status, output), (0, "check_layers: 1 files, 0 violations\n"))

    def test_violation_is_named_with_file_and_line(self) -> None:
        status, output = self.run_on({"control/motor/pi.c": "\nuint8_t x;\n", "control/motor/pi.txt": "double"})

        self.assertEqual(status, 1)
        self.assertIn("control/motor/pi.c:2: uint8_t: the C28x has no type of 8 bits\n", output)

    def test_tree_without_sources_is_an_error(self) -> None:
        self.assertEqual(self.run_on({"README.md": "double"})[0], 2)


if __name__ == "__main__":
    unittest.main()
