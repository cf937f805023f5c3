"""What the shell may offer behind an option or as an argument. Files are completed by the shell itself."""

from __future__ import annotations


def scenario_names(incomplete: str) -> list[str]:
    from evenspin.model.scenario import builtin_scenarios

    return _beginning(incomplete, builtin_scenarios())


def model_names(incomplete: str) -> list[str]:
    from evenspin.model.machine import builtin_models

    return _beginning(incomplete, builtin_models())


def method_names(incomplete: str) -> list[str]:
    from evenspin.model.methods import method_words

    return _beginning(incomplete, method_words())


def change_names(incomplete: str) -> list[str]:
    """Names before the equals sign of --set and --vary."""
    from evenspin.model.changes import known_names

    return [f"{name}=" for name in _beginning(incomplete, known_names())]


def effect_names(incomplete: str) -> list[str]:
    from evenspin.native import tables

    return _beginning(incomplete, tables().effects)


def parameter_names(incomplete: str) -> list[str]:
    from evenspin.native import tables

    return _beginning(incomplete, tables().params)


def fault_names(incomplete: str) -> list[str]:
    from evenspin.native import tables

    return _beginning(incomplete, [fault.name for fault in tables().faults[1:]])


def _beginning(incomplete: str, names: object) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]  # type: ignore[attr-defined]
