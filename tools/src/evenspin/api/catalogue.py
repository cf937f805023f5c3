"""What there is, by name."""

from __future__ import annotations

from collections.abc import Mapping

from evenspin.model.machine import builtin_models
from evenspin.model.scenario import builtin_scenarios
from evenspin.native import Effect, Field, tables


def list_scenarios() -> list[str]:
    """Names of the scenarios that come with the package, as `load` takes them."""
    return list(builtin_scenarios())


def list_models() -> list[str]:
    """Names of the models that come with the package, as `model` of a scenario takes them."""
    return list(builtin_models())


def list_parameters() -> Mapping[str, Field]:
    """Parameters of the drive by name: `unit`, `kind`, `choices`, `minimum`, `maximum`, `default`, `doc`."""
    return tables().params


def list_effects() -> Mapping[str, Effect]:
    """Non-ideal effects of the machine by name: `doc`, `signature`, and `params` by name."""
    return tables().effects


def list_signals() -> Mapping[str, Field]:
    """Signals that a run records, by name: `unit`, `doc`. What begins with `true_` only the simulation knows."""
    return tables().signals
