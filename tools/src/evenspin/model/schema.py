"""From tables of the library to pydantic schemas, and from pydantic's findings to one line for the user."""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from typing import Annotated, Any, Literal

import pydantic
from pydantic import BaseModel, BeforeValidator, ConfigDict

from evenspin.errors import MISSING, InputError, did_you_mean
from evenspin.model.document import Document
from evenspin.native import Field

_Model = typing.TypeVar("_Model", bound=BaseModel)


class Strict(BaseModel):
    """No unknown keys, no conversions."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


def table_schema(name: str, fields: Mapping[str, Field]) -> type[Strict]:
    """A TOML table in which every field of a library table may be given."""
    members: dict[str, Any] = {
        field.name: (_type_of(field) | None, pydantic.Field(None, description=field.allowed()))
        for field in fields.values()
    }
    return pydantic.create_model(name, __base__=Strict, **members)


def group_schema(name: str, members: Mapping[str, type[BaseModel]], description: str) -> type[Strict]:
    """A TOML table of tables."""
    fields: dict[str, Any] = {
        key: (schema | None, pydantic.Field(None, description=description)) for key, schema in members.items()
    }
    return pydantic.create_model(name, __base__=Strict, **fields)


def given_numbers(table: BaseModel | None, fields: Mapping[str, Field]) -> dict[str, float]:
    """What the user gave, as the library takes it."""
    if table is None:
        return {}
    return {name: fields[name].to_number(value) for name, value in table.model_dump(exclude_none=True).items()}


def check(schema: type[_Model], document: Document) -> _Model:
    """The document as a value of this schema, or an InputError about its first wrong line."""
    try:
        return schema.model_validate(document.data)
    except pydantic.ValidationError as error:
        findings = [_finding(schema, document, details) for details in error.errors(include_url=False)]
        # A misspelt key is missing under its right name, too: what is there comes before what is not.
        raise min(findings, key=lambda finding: (finding.value is MISSING, finding.line or 0)) from None


def _finding(schema: type[BaseModel], document: Document, details: Any) -> InputError:
    keys = details["loc"]
    around, info = _look_up(schema, keys)
    name = str(keys[-1]) if keys else ""
    if details["type"] == "extra_forbidden":
        hint = did_you_mean(name, around.model_fields)
        return document.error(keys, "a known key with its unit in the name", hint)
    must = info.description if info is not None and info.description else details["msg"]
    hint = "give it" if document.value_of(keys) is MISSING else "correct the value"
    return document.error(keys, must, hint)


def _look_up(schema: type[BaseModel], keys: tuple[str | int, ...]) -> tuple[type[BaseModel], Any]:
    """The schema around a key, and what it says about the key."""
    around, info = schema, None
    inner: type[BaseModel] | None = schema
    for key in keys:
        if isinstance(key, str):
            if inner is None:
                break
            around = inner
            info = around.model_fields.get(key)
            inner = _model_in(info.annotation) if info is not None else None
    return around, info


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_model_in(argument) for argument in typing.get_args(annotation))
    return next((model for model in found if model is not None), None)


def _real(value: object) -> object:
    """A whole number is a real one, unless it is astronomically large."""
    if isinstance(value, int) and not isinstance(value, bool):
        return float(value) if abs(value) < 10**300 else float("inf")
    return value


Real = Annotated[float, BeforeValidator(_real)]


def real(low: float = -math.inf, high: float = math.inf) -> Any:
    """A finite number; whole numbers will do."""
    return Annotated[Real, within(low, high)]


def within(low: float = -math.inf, high: float = math.inf) -> Any:
    """The limits of a `Real`, for annotations, where a call of `real` cannot stand."""
    return pydantic.Field(ge=low, le=high, allow_inf_nan=False)


def _type_of(field: Field) -> Any:
    if field.kind == "choice":
        return Literal[field.choices]
    if field.kind == "flag":
        return Annotated[bool, BeforeValidator(_flag)]
    if field.kind == "integer":
        return Annotated[int, pydantic.Field(ge=math.ceil(field.minimum), le=math.floor(field.maximum))]
    return real(field.minimum, field.maximum)


def _flag(value: object) -> object:
    """0 and 1 are switches, too: the tables write them so."""
    return bool(value) if isinstance(value, int) and value in (0, 1) else value
