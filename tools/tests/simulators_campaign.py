"""`make simulators`: one drive by three simulators without noise, and what the gap workflow says of motulator's logs.

    python tools/tests/simulators_campaign.py FOLDER PAGE

FOLDER holds truth.json and verdicts/ of a set made with `gap blind make --simulator motulator`; PAGE is written.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from evenspin.blind import motulator_drive, referee
from evenspin.blind.cases import (
    MOTULATOR,
    VALIDATION,
    gap_between,
    make_case,
    plan_cases,
    run_experiments,
    without_noise,
    write_records,
)
from evenspin.blind.experiments import all_experiments
from evenspin.blind.motors import draw_motor
from evenspin.blind.score import markdown, score_set
from evenspin.blind.truth import read_truth
from evenspin.blind.vocabulary import EFFECTS
from evenspin.gap.outcome import Validation
from evenspin.gap.result import investigate
from evenspin.gap.verdict import verdict_json
from evenspin.log import read_case
from evenspin.log.tolerance import SIGMA, unit_of

SEED, SIZE = 5, 2  # of the motor that is drawn; the large effects
NAMES = ("", *motulator_drive.EFFECTS)
WHY = {
    "": "a count of the encoder that falls into the next period",
    "coulomb_friction": "at standstill: held here, and viscous below 0.05 rad/s in motulator",
    "stribeck_friction": "the same",
    "inductance_saturation": "voltage across the axes of a turning rotor: of the flux linkage in plant and "
    "motulator, of the slope in the referee",
}
HEAD = """# Three simulators

<!-- Made by `make simulators`. Do not edit. -->

The drive of the log format stands around three machines that share no code: the plant (`sim_host/plant`, with the
firmware itself), the referee (`sim_host/referee`, which makes the blind cases), and
[motulator](https://github.com/Aalto-Electric-Drives/motulator) 0.5 (`evenspin[motulator]`).

## How far they are apart

Gap as docs/log-format.md defines it (1 = 1 rad/s, 0.1 A or 1 V in every signal), on the two validation records, without
noise; `opens`: what the effect itself makes. One motor, large effects.

| effect | referee, motulator | plant, motulator | plant, referee | opens | what differs |
|---|---|---|---|---|---|
"""
FRICTION = """## Where dry friction is not dry

motulator's friction is a coefficient that depends on the speed: below a border it is viscous, and does not hold a
shaft. The border is {slow:g} rad/s above. One dry friction with other borders:

| border, rad/s | verdict | confidence | error of the torque | gap before, after, floor |
|---|---|---|---|---|
"""
BORDERS = ((0.5, 21), (2.0, 22))  # rad/s, seed


def main() -> None:
    folder, page = Path(sys.argv[1]), Path(sys.argv[2])
    rng = np.random.default_rng(SEED)
    meta = draw_motor(rng)
    motor = meta["motor"]
    experiments = all_experiments(rng, motor["rated_current_a"], motor["rated_torque_nm"])
    angles_rad = list(rng.uniform(0.0, 2.0 * np.pi, len(experiments)))
    values = {name: EFFECTS[name](rng, meta, SIZE) for name in motulator_drive.EFFECTS}
    quiet = without_noise(referee.parameters_of(meta)) | {"sensor.current_lsb_a": 0.0}
    described = dict(meta) | {"current_noise_a": 0.0, "current_lsb_a": 0.0}
    rows = []
    plain: Mapping[str, Mapping[str, np.ndarray]] = {}
    for name in NAMES:
        effects = {name: values[name]} if name else {}
        p = referee.with_effects(quiet, effects) | (motulator_drive.LEFT_OPEN if name else {})
        made = {
            who: run_experiments(p, experiments, angles_rad, 1, VALIDATION, by)
            for who, by in (("referee", referee.simulate), ("motulator", motulator_drive.simulate))
        }
        plant = {who: _to_plant(described, experiments, records, effects) for who, records in made.items()}
        plain = plain or made["referee"]
        opens = gap_between(made["referee"], plain)
        rows.append(
            (
                name or "none",
                gap_between(made["referee"], made["motulator"]),
                plant["motulator"],
                plant["referee"],
                opens,
            )
        )
        print(*rows[-1])
    lines = [
        f"| {n} | {a:.3f} | {b:.3f} | {c:.3f} | {o:.2f} | {WHY.get(n.replace('none', ''), '')} |"
        for n, a, b, c, o in rows
    ]
    truths = read_truth(folder / "truth.json")
    text = HEAD + "\n".join(lines) + "\n\n" + FRICTION.format(slow=motulator_drive.SLOW_RAD_S)
    text += "".join(_with_border(*each) for each in BORDERS)
    text += "\n## What `evenspin gap` says of motulator's logs\n\n"
    page.write_text(text + markdown(score_set(truths, folder / "verdicts")))


def _with_border(border_rad_s: float, seed: int) -> str:
    """A row of the table: one case with this border, made and solved."""
    motulator_drive.SLOW_RAD_S = border_rad_s
    (plan,) = plan_cases({"single": 1}, seed, ("coulomb_friction",), MOTULATOR)
    with tempfile.TemporaryDirectory() as place:
        truth = make_case(plan, Path(place) / "case")
        said = verdict_json(investigate(read_case(Path(place) / "case")))
    hidden = truth.effects[0]["parameters"]["torque_nm"]
    found = said["parameters"].get("coulomb_friction", {}).get("torque_nm", 0.0)
    sure = said["confidence"].get("coulomb_friction", 0.0)
    gaps = ", ".join(f"{said[key]:.3f}" for key in ("gap_before", "gap_after", "gap_floor"))
    names = ", ".join(said["verdict"]) or "nothing missing"
    return f"| {border_rad_s:g} | {names} | {sure:.2f} | {100.0 * abs(found / hidden - 1.0):.1f} % | {gaps} |\n"


def _to_plant(meta: dict, experiments: list, records: dict, effects: dict) -> float:
    """The gap of the plant to these records, from their references and start angles."""
    with tempfile.TemporaryDirectory() as place:
        case = Path(place) / "case"
        chosen = [e for e in experiments if e.name in VALIDATION]
        write_records(case, meta | {"case": "quiet"}, chosen, records)
        unit = unit_of(effects, np.zeros(len(SIGMA)))
        return Validation(read_case(case)).outcome(unit).gap


if __name__ == "__main__":
    main()
