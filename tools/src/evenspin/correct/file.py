"""correction.toml, and what stands beside it to try the correction: experiments.toml and nominal.toml."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import pydantic
import tomlkit

from evenspin.bench.config import shortest
from evenspin.bench.experiments import experiments_toml
from evenspin.correct.changes import HOWS, Change
from evenspin.correct.commands import commanded
from evenspin.correct.predict import Prediction
from evenspin.correct.proposal import Correction, NotCorrected, Proposal
from evenspin.correct.quantities import KINDS, Quantity
from evenspin.errors import did_you_mean
from evenspin.log.case import Case
from evenspin.log.nominal import Nominal
from evenspin.model.document import Document, read_document
from evenspin.model.schema import Real, Strict, check, within
from evenspin.native import tables

CORRECTION, EXPERIMENTS, NOMINAL = "correction.toml", "experiments.toml", "nominal.toml"
HEAD = (
    "Parameters of the drive that counteract what `evenspin gap` has named. `evenspin bench apply` tries them: before,",
    "predicted, after. `change`: set to the value, add it, or take it times. `low` and `high`: 95 %.",
)


def write_correction(folder: Path, proposal: Proposal, case: Case, nominal: Nominal) -> None:
    (folder / CORRECTION).write_text(correction_toml(proposal), encoding="utf-8")
    if not proposal.corrections:
        return
    wanted = dict.fromkeys(name for each in proposal.corrections for name in each.spoils.records)
    experiments = commanded(case, list(wanted))
    (folder / EXPERIMENTS).write_text(experiments_toml(proposal.case, NOMINAL, tuple(experiments)), encoding="utf-8")
    (folder / NOMINAL).write_text(_nominal_toml(case, nominal), encoding="utf-8")


def correction_toml(proposal: Proposal) -> str:
    document = tomlkit.document()
    for line in HEAD:
        document.add(tomlkit.comment(line))
    document["case"] = proposal.case
    document["verdict"] = list(proposal.verdict)
    if proposal.corrections:
        several = tomlkit.aot()
        for correction in proposal.corrections:
            several.append(_correction(correction))
        document["correction"] = several
    if proposal.left:
        none = tomlkit.aot()
        for each in proposal.left:
            table = tomlkit.table()
            table["effect"], table["reason"] = each.effect, each.reason
            none.append(table)
        document["none"] = none
    return tomlkit.dumps(document)


def _correction(correction: Correction) -> Any:
    table = tomlkit.table()
    table["name"] = correction.name
    table["effects"] = list(correction.effects)
    quantity, predicted = correction.spoils, correction.predicted
    spoils = tomlkit.table()
    spoils.comment(f"{quantity.what}, {quantity.unit}")
    spoils["kind"] = quantity.kind
    spoils["records"] = list(quantity.records)
    spoils["orders"] = list(quantity.orders)
    if quantity.hz:
        spoils["hz"] = list(quantity.hz)
    for key in ("log", "healthy", "without", "corrected", "low", "high"):
        value = getattr(predicted, key)
        if math.isfinite(value):
            spoils[key] = float(f"{value:.5g}")
    table["spoils"] = spoils
    parameters = tomlkit.aot()
    for change in correction.changes:
        field = tables().params[change.parameter]
        item = tomlkit.table()
        item["name"], item["change"] = change.parameter, change.how
        if field.kind == "choice":
            item["value"] = field.to_text(change.value)
        elif field.kind == "flag":
            item["value"] = bool(change.value)
        else:
            item["value"] = shortest(change.value)
            if field.unit and change.how != "times":
                item["value"].comment(field.unit)
            if change.high > change.low:
                item["low"], item["high"] = shortest(change.low), shortest(change.high)
        parameters.append(item)
    table["parameter"] = parameters
    return table


# ---- reading


class _Parameter(Strict):
    name: str = pydantic.Field(description="a parameter of the drive, in quotes")
    change: Literal["set", "add", "times"] = pydantic.Field(description=" or ".join(f'"{how}"' for how in HOWS))
    value: float | bool | str = pydantic.Field(description="a number, a word in quotes, true or false")
    low: Real | None = pydantic.Field(None, description="a number")
    high: Real | None = pydantic.Field(None, description="a number")


class _Spoils(Strict):
    kind: str = pydantic.Field(description="what is measured, in quotes")
    records: list[str] = pydantic.Field(description="names of experiments", min_length=1)
    orders: list[Annotated[Real, within(0.0, 1e4)]] = pydantic.Field([], description="cycles per turn of the shaft")
    hz: list[Annotated[Real, within(0.0, 1e4)]] = pydantic.Field([], description="frequencies in Hz")
    log: Real | None = pydantic.Field(None, description="a number")
    healthy: Real | None = pydantic.Field(None, description="a number")
    without: Real | None = pydantic.Field(None, description="a number")
    corrected: Real | None = pydantic.Field(None, description="a number")
    low: Real | None = pydantic.Field(None, description="a number")
    high: Real | None = pydantic.Field(None, description="a number")


class _Correction(Strict):
    name: str = pydantic.Field(description="a name in quotes")
    effects: list[str] = pydantic.Field(description="names of effects", min_length=1)
    spoils: _Spoils = pydantic.Field(description="a table")
    parameter: list[_Parameter] = pydantic.Field(description="tables [[correction.parameter]]", min_length=1)


class _None(Strict):
    effect: str = pydantic.Field(description="the name of an effect")
    reason: str = pydantic.Field(description="why it is not corrected")


class _File(Strict):
    case: str = pydantic.Field(description="a name in quotes")
    verdict: list[str] = pydantic.Field(description="names of effects")
    correction: list[_Correction] = pydantic.Field([], description="tables [[correction]]")
    none: list[_None] = pydantic.Field([], description="tables [[none]]")


def read_correction(folder: Path) -> Proposal:
    """Read and check correction.toml of a folder."""
    document = read_document(folder / CORRECTION)
    found = check(_File, document)
    corrections = []
    for number, entry in enumerate(found.correction):
        keys = ("correction", number)
        if entry.spoils.kind not in KINDS:
            raise document.error((*keys, "spoils", "kind"), "a quantity", did_you_mean(entry.spoils.kind, KINDS))
        changes = tuple(_change(document, (*keys, "parameter", i), p) for i, p in enumerate(entry.parameter))
        s = entry.spoils
        predicted = Prediction(*(_or_nan(value) for value in (s.log, s.healthy, s.without, s.corrected, s.low, s.high)))
        quantity = Quantity(s.kind, tuple(s.records), tuple(s.orders), tuple(s.hz))
        corrections.append(Correction(entry.name, tuple(entry.effects), changes, quantity, predicted))
    names = [correction.name for correction in corrections]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise document.error(("correction", number, "name"), "a name of its own", "rename it")
    left = tuple(NotCorrected(each.effect, each.reason) for each in found.none)
    return Proposal(found.case, tuple(found.verdict), tuple(corrections), left)


def _change(document: Document, keys: tuple[str | int, ...], entry: _Parameter) -> Change:
    params = tables().params
    if entry.name not in params:
        raise document.error((*keys, "name"), "a parameter of the drive", did_you_mean(entry.name, params))
    field = params[entry.name]
    if field.kind == "choice":
        good = entry.value in field.choices
    elif field.kind == "flag":
        good = isinstance(entry.value, bool)
    else:
        good = isinstance(entry.value, float) and not isinstance(entry.value, bool) and math.isfinite(entry.value)
        if good and entry.change == "set":
            good = field.minimum <= float(entry.value) <= field.maximum
    if not good or (field.kind in ("choice", "flag") and entry.change != "set"):
        raise document.error((*keys, "value"), field.allowed(), "see `evenspin parameters`")
    value = field.to_number(entry.value)
    return Change(entry.name, entry.change, value, _else(entry.low, value), _else(entry.high, value))


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _else(value: float | None, other: float) -> float:
    return other if value is None else float(value)


def _nominal_toml(case: Case, nominal: Nominal) -> str:
    """The machine of meta.json as a model file: what the gains of the drive were designed for."""
    document = tomlkit.document()
    document["name"] = f"{case.meta.get('case', case.path.name)}-nominal"
    plant = tomlkit.table()
    motor: Mapping[str, Any] = case.meta["motor"]
    numbers = {
        **motor, **nominal.supply, "counts_per_rev": nominal.counts_per_rev, "current_noise_a": nominal.current_noise_a,
    }  # fmt: skip
    for key, value in numbers.items():
        if key in tables().model:
            plant[key] = int(value) if tables().model[key].kind == "integer" else float(value)
    document["plant"] = plant
    return tomlkit.dumps(document)
