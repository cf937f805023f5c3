"""The map file of TI's linker is read, and what the drive relies on is checked. sample.map was made by hand."""

from __future__ import annotations

import unittest
from pathlib import Path

import ti_map

SAMPLE = (Path(__file__).parent / "sample.map").read_text()


class Reading(unittest.TestCase):
    def setUp(self) -> None:
        self.map = ti_map.parse(SAMPLE)

    def test_memory_has_origin_length_and_use(self) -> None:
        self.assertEqual(
            [region.name for region in self.map.regions],
            ["BEGIN", "FLASH_A_D", "FLASH_E_N", "RAMM1", "RAM_CODE", "RAM_DRIVE"],
        )
        self.assertEqual(self.map.regions[4], ti_map.Region("RAM_CODE", 0x8000, 0x8000, 0x2000))

    def test_sections_are_read_with_their_name_on_the_same_line_or_on_the_one_before(self) -> None:
        self.assertEqual(self.map.section(".text"), ti_map.Section(".text", 0x80008, 0x1A00, 0x80008))
        self.assertEqual(self.map.section("codestart"), ti_map.Section("codestart", 0x80000, 2, 0x80000))
        self.assertEqual(len(self.map.sections), 6)  # input sections are none

    def test_a_section_that_is_copied_runs_where_it_is_copied_to(self) -> None:
        self.assertEqual(self.map.section(".TI.ramfunc"), ti_map.Section(".TI.ramfunc", 0x88000, 0x2000, 0x8000))

    def test_modules_belong_to_their_library_and_totals_are_none(self) -> None:
        names = ["main_f28379d.c.obj", "codestart.asm.obj", "configure.c.obj", "current_isr.c.obj", "sysctl.obj"]
        self.assertEqual([m.name for m in self.map.modules], names)
        configure = self.map.modules[2]
        self.assertEqual(
            (configure.library, configure.code, configure.initialised, configure.uninitialised),
            ("firmware/libfirmware_float.a", 4352, 12, 0),
        )
        self.assertTrue(self.map.modules[4].library.endswith("driverlib_eabi.lib"))
        # Grand Total of the sample less what the linker made (64) and the stack (1016)
        self.assertEqual(sum(m.code for m in self.map.modules), 7169)
        self.assertEqual(sum(m.initialised for m in self.map.modules), 76 - 64)
        self.assertEqual(sum(m.uninitialised for m in self.map.modules), 15016 - 1016)

    def test_symbols_have_their_address(self) -> None:
        self.assertEqual(self.map.symbols["drive_current_isr"], 0x8010)
        self.assertEqual(self.map.symbols["RamfuncsLoadSize"], 0x2000)
        self.assertEqual(self.map.symbols["__stack"], 0x400)
        self.assertNotIn("name", self.map.symbols)

    def test_the_report_names_every_module_and_the_sum(self) -> None:
        lines = ti_map.report(self.map)
        self.assertTrue(any(line.split() == ["RAM_CODE", "0x8000", "32768", "8192", "25"] for line in lines))
        self.assertTrue(any(line.split() == [".TI.ramfunc", "0x88000", "0x8000", "8192"] for line in lines))
        self.assertTrue(any(line.split() == ["configure.c.obj", "4352", "12", "0"] for line in lines))
        self.assertIn("driverlib_eabi.lib", lines)
        self.assertEqual(lines[-1].split(), ["all", "7169", "12", "14000"])

    def test_a_text_that_is_no_map_gives_nothing(self) -> None:
        self.assertEqual(ti_map.parse("hello\n1 2 3\n"), ti_map.Map())


class Checking(unittest.TestCase):
    def faults(self, old: str = "", new: str = "") -> list[str]:
        self.assertIn(old, SAMPLE)
        return ti_map.faults(ti_map.parse(SAMPLE.replace(old, new)))

    def test_the_sample_has_no_fault(self) -> None:
        self.assertEqual(self.faults(), [])

    def test_an_interrupt_in_flash_is_a_fault(self) -> None:
        (line,) = self.faults("00008010  drive_current_isr", "00080a10  drive_current_isr")
        self.assertIn("drive_current_isr: at 0x080a10, must be in RAM", line)

    def test_the_flash_api_in_flash_is_a_fault(self) -> None:
        for address, count in (("00008908", 0), ("00080908", 1)):
            lines = self.faults("00080908  drive_make_setup", f"{address}  Fapi_issueProgrammingCommand")
            self.assertEqual(len(lines), count, lines)

    def test_a_missing_interrupt_is_a_fault(self) -> None:
        (line,) = self.faults("00008800  hal_sample_read ", "00008800  hal_sample_ride ")
        self.assertIn("hal_sample_read: not in the map", line)

    def test_code_start_elsewhere_is_a_fault(self) -> None:
        (line,) = self.faults("*          0    00080000    00000002", "*          0    00080010    00000002")
        self.assertIn("codestart: at 0x080010, must be at 0x080000", line)

    def test_a_stack_beyond_16_bits_is_a_fault(self) -> None:
        (line,) = self.faults(".stack     0    00000400", ".stack     0    0000fe00")
        self.assertIn(".stack", line)

    def test_a_drive_outside_its_blocks_is_a_fault(self) -> None:
        (line,) = self.faults("*          0    00014000    000036b0", "*          0    00014000    00005001")
        self.assertIn("drive_memory", line)

    def test_single_precision_helpers_are_no_double_arithmetic(self) -> None:
        self.assertEqual(self.faults("00080908  drive_make_setup", "00080908  __c28xabi_divl"), [])

    def test_double_arithmetic_and_division_without_tmu_are_faults(self) -> None:
        for name in ("__c28xabi_divd", "__c28xabi_ftod", "__c28xabi_dtoi", "FD$$ADD"):
            (line,) = self.faults("00080908  drive_make_setup", f"00080908  {name}")
            self.assertIn("64-bit", line)
        for name in ("FS$$DIV", "__c28xabi_divf"):
            (line,) = self.faults("00080908  drive_make_setup", f"00080908  {name}")
            self.assertIn("TMU", line)

    def test_a_ram_build_starts_at_0(self) -> None:
        text = SAMPLE.replace("00088000    00002000     RUN ADDR = 00008000", "00008000    00002000     ")
        text = text.replace(".text      0    00080008", ".text      0    0000a000")
        start = "*          0    00080000    00000002"
        in_ram = text.replace(start, start.replace("00080000", "00000000"))
        elsewhere = text.replace(start, start.replace("00080000", "00000100"))
        self.assertEqual(ti_map.faults(ti_map.parse(in_ram)), [])
        self.assertIn("must be at 0x000000", ti_map.faults(ti_map.parse(elsewhere))[0])


if __name__ == "__main__":
    unittest.main()
