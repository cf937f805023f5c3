"""Model files and scenario files: TOML with units in the key names, checked on load."""

from evenspin.model.machine import Machine, builtin_models, load_machine
from evenspin.model.scenario import Scenario, builtin_scenario, load_scenario
from evenspin.model.setup import InputCurve, Setup, Tune

__all__ = [
    "InputCurve",
    "Machine",
    "Scenario",
    "Setup",
    "Tune",
    "builtin_models",
    "builtin_scenario",
    "load_machine",
    "load_scenario",
]
