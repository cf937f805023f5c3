"""An effect hidden in a log: record a machine that has it, then ask why the model does not match.

A script in cells (# %%): editors and Jupyter open it as a notebook.
"""

# %% A machine with cogging, which its model does not have, recorded like any drive is.
from pathlib import Path
from tempfile import TemporaryDirectory

import evenspin as es

speeds_rpm = (120.0, 240.0, 60.0)
events = [{"at_s": 2.0 * k, "speed_rpm": rpm, "load_brake_a": 0.5 + 0.5 * k} for k, rpm in enumerate(speeds_rpm)]
scenario = es.load({"name": "hidden", "model": "guo2024", "duration_s": 6.0, "event": events})
hidden = {"cogging.amplitude_nm": 0.02, "cogging.order": 12}
machine = scenario.change(hidden).simulate()

# %% Held against the model: where is the gap, and what explains it?
with TemporaryDirectory() as folder:
    log = machine.save(Path(folder) / "log") / "hidden.csv"
    gap = es.find_gap(log, model="guo2024")
for sentence in gap.summary:
    print(sentence)

# %% The effect by name, with its parameters.
print(gap.names, {name: dict(numbers) for name, numbers in gap.parameters.items()})

# %% The model with what was found in it does what the machine does: ripple of order 12, rad/s.
found = scenario.change(
    {f"{name}.{key}": value for name, each in gap.parameters.items() for key, value in each.items()}
)
steady = {"model": scenario, "model with what was found": found}
ripple_rad_s = {name: float(each.simulate().between(1.0, 2.0).orders(orders=(12,))[0]) for name, each in steady.items()}
ripple_rad_s["machine"] = float(machine.between(1.0, 2.0).orders(orders=(12,))[0])
print(ripple_rad_s)
