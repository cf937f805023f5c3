"""Blind machines through the whole circle: experiments, cause, correction, before and after; scored as docs/circle.md.

    circle_campaign.py OUT COUNT SEED [PAGE]

Motors, units within their tolerances and hidden effects are drawn as for `make blind`; here the machine is that of the
virtual drive, whose firmware is corrected. The tool gets the nominal model and the log. Each machine leaves
OUT/case_NNNN.json; one that is there already is not run again.
"""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import tomlkit
from circle_page import page_of
from evenspin.bench import Drive
from evenspin.bench.operator import operator_for
from evenspin.blind.cases import TOLERANCE, plan_cases
from evenspin.blind.motors import draw_motor
from evenspin.blind.vocabulary import EFFECTS, SIZES
from evenspin.correct.circle import run_circle
from evenspin.correct.outcome import trial_json
from evenspin.errors import EvenspinError

PAIRS = 0.2  # of the machines have two effects
OFFSET_A, GAIN = 0.010, 0.002  # of a healthy unit's current sensors


def model_toml(meta: Mapping[str, Any], angle_rad: float) -> str:
    """A model file of this drive, as its user would have it: nominal, nothing hidden."""
    motor, speed = meta["motor"], meta["speed_loop"]
    plant = {
        **motor, "dc_link_v": meta["dc_link_v"], "counts_per_rev": meta["encoder"]["counts_per_rev"],
        "current_noise_a": meta["current_noise_a"], "current_lsb_a": meta["current_lsb_a"],
        "initial_angle_rad": angle_rad, "board_dc_link_v": 1000.0, "board_current_a": 1000.0,
    }  # fmt: skip
    drive = {
        "current_kp_v_per_a": meta["current_loop"]["kp_v_per_a"],
        "current_ki_v_per_as": meta["current_loop"]["ki_v_per_as"],
        "speed_error_gain": 1.0,
        "speed_kp_a_per_unit": speed["kp_a_per_rad_s"],
        "speed_ki_a_per_unit_s": speed["ki_a_per_rad"],
        "iq_limit_a": speed["iq_limit_a"],
        "id_limit_a": speed["iq_limit_a"],
        "align_current_a": 0.5 * speed["iq_limit_a"],
        "over_current_a": 4.0 * speed["iq_limit_a"],
        "over_voltage_v": min(1.5 * meta["dc_link_v"], 1000.0),
        "under_voltage_v": 0.5 * meta["dc_link_v"],
        "pll_kp_per_s": meta["speed_filter"]["kp"],
        "pll_ki_per_s2": meta["speed_filter"]["ki"],
        "offset_calibration_periods": 0,
        "align_periods": 0,
        "plausibility_share": 0.0,  # it would trip at the larger effects, which are to be found
    }
    document = tomlkit.document()
    document["name"] = "blind"
    document["plant"], document["drive"] = plant, drive
    return tomlkit.dumps(document)


def hidden_in(rng: np.random.Generator, meta: Mapping[str, Any], effects: Mapping[str, Any]) -> dict[str, float]:
    """The port's query: what this unit is off its data sheet, and the effects."""
    names = {"resistance_ohm": ("resistance_ohm",), "inductance": ("ld_h", "lq_h"), "psi_wb": ("psi_wb",),
             "inertia_kgm2": ("inertia_kgm2",), "viscous_nms": ("viscous_nms",)}  # fmt: skip
    query: dict[str, float] = {}
    for key, bound in TOLERANCE.items():
        factor = 1.0 + rng.uniform(-bound, bound)
        for name in names[key.removeprefix("motor.")]:
            query[f"plant.{name}"] = meta["motor"][name] * factor
    sensors = {f"current_offset.offset_{x}_a": rng.uniform(-OFFSET_A, OFFSET_A) for x in "ab"}
    sensors |= {f"current_gain.gain_{x}": 1.0 + rng.uniform(-GAIN, GAIN) for x in "ab"}
    given = {f"{effect}.{name}": value for effect, params in effects.items() for name, value in params.items()}
    for key, value in sensors.items():
        given[key] = given[key] + value - (1.0 if "gain" in key else 0.0) if key in given else value
    return {key: float(value) for key, value in {**query, **given, "seed": float(rng.integers(1, 2**31))}.items()}


def run_one(plan: Any, attempts: int = 20) -> dict[str, Any]:
    """One machine. A motor whose drive cannot do the experiments even so is drawn again, as for `make blind`."""
    rng = np.random.default_rng(plan.seed)
    refused: list[str] = []
    for _ in range(attempts):
        meta = draw_motor(rng)
        effects = {name: EFFECTS[name](rng, meta, plan.size) for name in plan.names}
        text = model_toml(meta, rng.uniform(0.0, 2.0 * math.pi))
        query = hidden_in(rng, meta, effects)
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            (folder / "blind.toml").write_text(text)
            out = folder / "out"
            out.mkdir()
            try:
                with Drive.connect(f"sim:{folder / 'blind.toml'}?{urlencode(query)}") as drive:
                    transport = drive.link.transport
                    operator = operator_for(transport, lambda request: True)
                    machine = transport.drive.machine
                    done = run_circle(drive, operator, machine, out, "campaign", _silent, _silent, 1)
            except EvenspinError as error:
                refused.append(str(error))
                continue
        return {
            "case": plan.case,
            "size": SIZES[plan.size],
            "hidden": effects,
            "verdict": list(done.result.verdict),
            "left": [{"effect": each.effect, "reason": each.reason} for each in done.proposal.left],
            "applied": trial_json(done.trial, False) if done.trial is not None else None,
            "seconds": done.result.seconds,
            "refused": refused,
        }
    return {"case": plan.case, "hidden": {name: {} for name in plan.names}, "error": refused[-1], "refused": refused}


def _silent(*said: object) -> None:
    pass


def _line(case: Mapping[str, Any]) -> str:
    rows = case["applied"]["corrections"] if case.get("applied") else []
    tried = [f"{r['name']} {r['before']:.3g} -> {r['predicted']:.3g} / {r['after']:.3g} {r['unit']}" for r in rows]
    said = ", ".join(tried) or case.get("error") or "; ".join(left["reason"] for left in case["left"])
    return f"{case['case']}: {', '.join(case['hidden'])}: {', '.join(case.get('verdict', ())) or 'nothing'}: {said}"


def main(words: list[str]) -> int:
    out, count, seed = Path(words[0]), int(words[1]), int(words[2])
    page = Path(words[3]) if len(words) > 3 else None
    most = int(os.environ.get("CIRCLE_FIRST", count))  # a sample of the set: only so many of its machines
    out.mkdir(parents=True, exist_ok=True)
    pairs = round(PAIRS * count)
    cases = []
    for plan in plan_cases({"single": count - pairs, "pair": pairs}, seed)[:most]:
        place = out / f"{plan.case}.json"
        if not place.exists():
            found = run_one(plan)
            place.write_text(json.dumps(found, indent=1) + "\n")
        cases.append(json.loads(place.read_text()))
        print(_line(cases[-1]), flush=True)
    text = page_of(cases, seed, count)
    if page is not None:
        page.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
