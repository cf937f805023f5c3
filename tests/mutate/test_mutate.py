"""What mutates and what does not, and how it is counted; compiling and running are tried by `make mutate` itself."""

from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from mutants import mutants
from mutate import ends_well
from report import Outcome, met, said

SOURCE = """#include <a.h>
/* if (a < b) */
#define LIMIT 7U
static const char *const TEXT = "a + b";
static uint16_t next(const state_t *s, uint16_t by)
{
    const uint16_t sum = (uint16_t)(s->at + by);
    if ((sum >= 12U) && !s->held) {
        reset(s);
    }
    return sum;
}
"""


class Mutants(unittest.TestCase):
    def test_every_operator_acts_where_it_can_and_nowhere_else(self) -> None:
        found = {(m.line, m.operator, m.old, m.new) for m in mutants(SOURCE)}
        self.assertEqual(
            found,
            {
                (7, "arithmetic", "+", "-"),
                (8, "comparison", ">=", ">"),
                (8, "constant", "12U", "13U"),
                (8, "logic", "&&", "||"),
                (8, "logic", "!", ""),
                (9, "statement", "reset(s);", ";"),
            },
        )

    def test_a_mutant_differs_from_the_source_in_its_place_alone(self) -> None:
        for mutant in mutants(SOURCE):
            changed = mutant.applied(SOURCE)
            self.assertEqual(changed[: mutant.at] + mutant.old + changed[mutant.at + len(mutant.new) :], SOURCE)

    def test_keys_outlive_lines_that_move_and_are_all_different(self) -> None:
        keys = [m.key for m in mutants(SOURCE)]
        self.assertEqual(keys, [m.key for m in mutants("\n\n" + SOURCE)])
        self.assertEqual(len(keys), len(set(keys)))

    def test_a_pointer_is_not_multiplied_and_an_arrow_not_compared(self) -> None:
        self.assertEqual(mutants("void f(s_t *s) {\n    s_t *const t = s->next;\n}\n"), [])


class Running(unittest.TestCase):
    def ends(self, text: str) -> bool:
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "program"
            program.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
            program.chmod(0o755)
            return ends_well(program, Path(folder), 1)

    def test_a_program_that_waits_for_a_busy_machine_ends_well_and_one_without_an_end_does_not(self) -> None:
        self.assertTrue(self.ends("sleep 1.5"))
        self.assertFalse(self.ends("while :; do :; done"))
        self.assertFalse(self.ends("exit 3"))


class Report(unittest.TestCase):
    def outcomes(self, file: str, killed: int, alive: int) -> list[Outcome]:
        mutant = mutants(SOURCE)[0]
        return [Outcome(file, mutant, "killed")] * killed + [Outcome(file, mutant, "alive")] * alive

    def test_goals_are_all_of_protection_and_97_percent_of_control(self) -> None:
        self.assertTrue(met(self.outcomes("firmware/app/protection.c", 10, 0)))
        self.assertFalse(met(self.outcomes("firmware/app/protection.c", 999, 1)))
        self.assertTrue(met(self.outcomes("control/motor/pi.c", 97, 3)))
        self.assertFalse(met(self.outcomes("control/motor/pi.c", 96, 4)))

    def test_what_is_the_same_or_does_not_compile_counts_nowhere(self) -> None:
        rest = [Outcome("control/a.c", mutants(SOURCE)[0], fate) for fate in ("same", "refused")]
        lines, good = said([*self.outcomes("control/a.c", 1, 0), *rest])
        self.assertEqual(lines[1], "| `control/a.c` | 1 | 1 | 0 | 0 | 100.0 % |")
        self.assertTrue(good)


if __name__ == "__main__":
    unittest.main()
