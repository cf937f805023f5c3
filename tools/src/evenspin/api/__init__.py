"""evenspin as a library: a scenario, changed by name, simulated, as arrays and frames; a log held against a model.

    import evenspin as es

    scenario = es.load("guo2024/first")                       # one that comes with the package, or a file
    run = scenario.change(method="fal-forc", seed=3).simulate()
    run["speed_rad_s"]                                        # array, shape (rows,), rad/s
    run.to_pandas().describe()
    run.plot("true_speed_rad_s", "true_iq_a").savefig("run.png")

Every name carries its unit. Words stand wherever a TOML file has them (`method="forc"`). What cannot be is an
`evenspin.errors.EvenspinError`, one line with what was given, what is allowed, and what was probably meant.
"""

from evenspin.api.catalogue import list_effects, list_models, list_parameters, list_scenarios, list_signals
from evenspin.api.gaps import Gap, find_gap
from evenspin.api.plate import name_plate
from evenspin.api.recordings import replay_recording
from evenspin.api.run import Run
from evenspin.api.scenario import Scenario, load
from evenspin.errors import EvenspinError
from evenspin.replay import Replayed

__all__ = [
    "EvenspinError",
    "Gap",
    "Replayed",
    "Run",
    "Scenario",
    "list_effects",
    "find_gap",
    "load",
    "list_models",
    "name_plate",
    "replay_recording",
    "list_parameters",
    "list_scenarios",
    "list_signals",
]
