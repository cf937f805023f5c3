"""Records as frames of other libraries. None of them is a dependency: each is loaded when it is asked for."""

from __future__ import annotations

import importlib
from typing import Any

from evenspin.errors import EvenspinError
from evenspin.sim.record import Record


def need(package: str) -> Any:
    """The package, or what to do about it."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise EvenspinError(f"{package}: is not installed ({error}); pip install {package}") from None


def to_pandas(record: Record) -> Any:
    pandas = need("pandas")
    columns = {name: record[name] for name in record.names if name != "t_s"}
    frame = pandas.DataFrame(columns, index=pandas.Index(record["t_s"], name="t_s"))
    frame.attrs["units"] = dict(zip(record.names, record.units, strict=True))
    return frame


def to_polars(record: Record) -> Any:
    polars = need("polars")
    return polars.DataFrame({name: record[name] for name in record.names})


def to_xarray(record: Record) -> Any:
    xarray = need("xarray")
    units = dict(zip(record.names, record.units, strict=True))
    variables = {
        name: ("t_s", record[name], {"units": units[name]} if units[name] else {})
        for name in record.names
        if name != "t_s"
    }
    time = xarray.Variable("t_s", record["t_s"], {"units": "s"})
    return xarray.Dataset(variables, coords={"t_s": time})
