"""Rows of the table: steps, interrupts, what a method costs more than PI, the whole occupation; and their budgets."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from evenspin.cycles.costs import COSTS
from evenspin.cycles.worst import ANY, EVERYTHING, KINDS, Program
from evenspin.native import tables

CPU_MHZ = 200.0
CPU_CYCLES_PER_PERIOD = 20000  # 200 MHz / 10 kHz
SPEED_DIVIDER = 10
PLAIN_CONTROLLER = "pi"  # current control that the names of variants do not mention
GROWTH = 1.03
BUDGETS = Path("tests/budget/budgets.toml")
CALL = round(10.0 * COSTS["frame"])  # a step includes its call, in tenths of a cycle as the driver counts
ISR_FRAME = round(10.0 * COSTS["isr"])

# What the port and the services add to the drive's interrupts, with the link streaming.
BESIDE_CURRENT = ("port_current_begin", "services_sample black box, stream of 8", "port_current_end busy link")
BESIDE_SPEED = ("port_speed_begin", "port_speed_end")

# Microseconds that the papers state for their own hardware, by the row that does the same work here.
PUBLISHED_US = {
    "extra fal-forc": 11.68,  # Guo et al. 2024
    "extra fal-forc angle": 11.68,
    "extra fal-forc angle dob": 11.68,  # with a disturbance observer besides, which is not in the published figure
    "extra aro": 10.0,  # Tang et al. 2020: below
    "isr current_isr aro deadbeat": 18.2,  # Tang et al. 2020: everything
}


@dataclass(frozen=True, slots=True)
class Row:
    """One thing that costs cycles."""

    name: str
    kind: str  # step, isr, extra, worst case
    cycles_est: int  # mean over the inputs
    cycles_worst: int
    m4_instructions: int | None  # in the worst call, without the HAL
    budget: int | None
    source: str
    low: float = 1.0  # model over real, 10th percentile

    @property
    def key(self) -> str:
        return f"{self.kind} {self.name}"

    @property
    def cycles_held(self) -> int:
        """The worst call plus its band: what nine of ten functions of this kind do not exceed on the chip."""
        return math.ceil(self.cycles_worst / self.low)

    @property
    def published_us(self) -> float | None:
        return PUBLISHED_US.get(self.key)

    @property
    def published_cycles(self) -> int | None:
        return None if self.published_us is None else int(self.published_us * CPU_MHZ)

    def document(self) -> dict[str, object]:
        return {
            **asdict(self),
            "cycles_held": self.cycles_held,
            "us_worst": self.cycles_worst / CPU_MHZ,
            "us_held": self.cycles_held / CPU_MHZ,
            "published_cycles": self.published_cycles,
            "published_us": self.published_us,
        }


def whole(tenths: int) -> int:
    return (tenths + 5) // 10


def base_of(variant: str) -> str:
    """What a variant costs more than: the drive without ripple suppression, under the same current controller."""
    if variant.startswith("position "):
        return "position ppi"
    other = [word for word in tables().params["current_controller"].choices if variant.endswith(f" {word}")]
    return f"pi {other[0]}" if other else "pi"


def make_rows(
    measured: Mapping[str, tuple[int, int]],
    budgets: Mapping[str, int],
    m4: Mapping[str, int] | None = None,
    low: Callable[[int], float] = lambda cycles: 1.0,  # noqa: ARG005
) -> list[Row]:
    """All rows from mean and largest cost, tenths of a cycle; `m4`: instructions of the Cortex-M4F by name; `low`: the
    band's lower end for so many cycles."""
    source = "model"
    rows: list[Row] = []

    def add(name: str, kind: str, est: int, worst: int, instructions: int | None) -> None:
        rows.append(Row(name, kind, est, worst, instructions, budgets.get(f"{kind} {name}"), source, low(worst)))

    def counted(*names: str) -> list[int] | None:
        return [m4[name] for name in names] if m4 is not None and all(name in m4 for name in names) else None

    isr: dict[str, tuple[int, int]] = {}
    for name, (mean, worst) in measured.items():
        if "_isr " in name:
            isr[name] = (whole(mean + ISR_FRAME), whole(worst + ISR_FRAME))
            add(name, "isr", *isr[name], (m4 or {}).get(name))
        else:
            add(name, "step", whole(mean + CALL), whole(worst + CALL), (m4 or {}).get(name))

    methods = [name.removeprefix("current_isr ") for name in isr if name.startswith("current_isr ")]
    for method in methods:
        current, speed = isr[f"current_isr {method}"], isr[f"speed_isr {method}"]
        both = [current[i] + watched(measured, method, i) - (-speed[i] // SPEED_DIVIDER) for i in (0, 1)]
        each = counted(f"current_isr {method}", f"speed_isr {method}")
        add(f"both {method}", "isr", both[0], both[1], each[0] - (-each[1] // SPEED_DIVIDER) if each else None)
    if all(name in measured for name in (*BESIDE_CURRENT, *BESIDE_SPEED)):
        for method in methods:
            period = [occupation(measured, isr, method, i) for i in (0, 1)]
            add(f"occupation {method}", "isr", period[0], period[1], None)
    for method in methods:
        base = base_of(method)
        if method in (base, "align"):  # the latter is no method, but a part of a start
            continue
        extra = [
            sum(isr[f"{which}_isr {method}"][i] - isr[f"{which}_isr {base}"][i] for which in ("current", "speed"))
            for i in (0, 1)
        ]
        each = counted(*(f"{which}_isr {name}" for name in (method, base) for which in ("current", "speed")))
        add(method, "extra", extra[0], extra[1], each[0] + each[1] - each[2] - each[3] if each else None)
    return rows


# All that the interrupts of a PWM period run, each in a call: as in firmware/main_f28379d.c.
CURRENT_INTERRUPT = (
    "port_current_begin",
    "drive_current_isr",
    "drive_watch_isr",
    "services_sample",
    "port_current_end",
)
SPEED_INTERRUPT = ("port_speed_begin", "drive_speed_isr", "port_speed_end")


def worst_rows(
    program: Program,
    budgets: Mapping[str, int],
    low: Callable[[int], float] = lambda cycles: 1.0,  # noqa: ARG005
) -> list[Row]:
    """Rows of the worst case, for each set-up: both interrupts of the drive, and all that runs in a period."""
    rows = []
    for setup in (EVERYTHING, *program.limits.setups):
        of_kind: dict[str, dict[str, int]] = {}
        for kind in KINDS:
            part = {name: program.worst(name, kind, setup).tenths for name in (*CURRENT_INTERRUPT, *SPEED_INTERRUPT)}
            current, speed = (
                whole(ISR_FRAME + sum(part[name] + CALL for name in names))
                for names in (CURRENT_INTERRUPT, SPEED_INTERRUPT)
            )
            of_kind[kind] = {
                "current_isr": whole(part["drive_current_isr"] + ISR_FRAME),
                "speed_isr": whole(part["drive_speed_isr"] + ISR_FRAME),
                "occupation": current - (-speed // SPEED_DIVIDER),
            }
        for kind, found in of_kind.items():
            for which, cycles in found.items():
                name = f"{which} {setup.name}{'' if kind == ANY else f', {kind}'}"
                if kind == ANY or cycles != of_kind[ANY][which]:
                    rows.append(
                        Row(
                            name,
                            "worst case",
                            cycles,
                            cycles,
                            None,
                            budgets.get(f"worst case {name}"),
                            "path",
                            low(cycles),
                        )
                    )
    return rows


def watched(measured: Mapping[str, tuple[int, int]], method: str, which: int) -> int:
    """What is judged beside the control, with its call; 0 where it is not measured."""
    name = f"watch {'align' if method == 'align' else 'run'}"
    return whole(measured[name][which] + CALL) if name in measured else 0


def occupation(
    measured: Mapping[str, tuple[int, int]], isr: Mapping[str, tuple[int, int]], method: str, which: int
) -> int:
    """All that the interrupts of a PWM period take: the current interrupt, and a tenth of the speed interrupt."""

    def called(names: Sequence[str]) -> int:
        return sum(whole(measured[name][which] + CALL) for name in names) + whole(CALL)  # and the call of the drive

    speed = isr[f"speed_isr {method}"][which] + called(BESIDE_SPEED)
    current = isr[f"current_isr {method}"][which] + watched(measured, method, which) + called(BESIDE_CURRENT)
    return current - (-speed // SPEED_DIVIDER)


def read_budgets(path: Path) -> tuple[dict[str, int], dict[str, int], list[str]]:
    """Budgets and recorded figures by `<kind> <name>`, and the names that are known to be over."""
    with path.open("rb") as file:
        document = tomllib.load(file)
    return document["budget"], document["recorded"], document["open"]


def violations(
    rows: Sequence[Row], budgets: dict[str, int], recorded: dict[str, int], open_: Sequence[str] = ()
) -> list[str]:
    """What is over its budget with its band, grew, or is not measured any more: name and both numbers.

    What `open_` names is known to be over its budget: it may not grow, and must leave the list when it gets below.
    """
    row_of = {row.key: row for row in rows}
    found = []
    for name, limit in budgets.items():
        row = row_of.get(name)
        held = f"{name}: {row.cycles_held if row else 0} cycles with the band"
        if row is None:
            found.append(f"{name}: has a budget of {limit} cycles and is not measured")
        elif name in open_:
            if row.cycles_held <= limit:
                found.append(f"{held}, budget {limit}: met, so take it out of `open`")
            elif name not in recorded:
                found.append(f"{held}, budget {limit}: open, and not recorded")
        elif row.cycles_held > limit:
            found.append(f"{held} ({row.cycles_worst} estimated), budget {limit}")
    for name, before in recorded.items():
        row = row_of.get(name)
        if row is not None and row.cycles_worst > max(before * GROWTH, before + 1):
            found.append(f"{name}: {row.cycles_worst} cycles, recorded {before}: grew by more than 3 %")
    return found


def write_recorded(path: Path, rows: Sequence[Row]) -> None:
    """Replace the recorded figures; budgets and comments stay."""
    kept = path.read_text().split("\n[recorded]\n")[0]
    lines = (f'"{row.key}" = {row.cycles_worst}\n' for row in rows)
    path.write_text(f"{kept}\n[recorded]\n{''.join(lines)}")
