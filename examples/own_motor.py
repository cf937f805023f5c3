"""A motor of one's own: from the name plate to a tuned drive, and which method makes it turn evenly.

A script in cells (# %%): editors and Jupyter open it as a notebook.
"""

# %% What is printed on the plate, in the units that are printed there.
import evenspin as es

motor = es.name_plate(
    pole_pairs=7, kv=270, ohm_ll=0.11, mh_ll=0.06, gcm2=500, lines=2048, supply=24, rated_current=12, rated_torque=0.4
)
print({name: f"{value:.4g}" for name, value in motor["plant"].items()})

# %% A run at 300 r/min with a load step, and gains from the numbers of the machine.
events = [{"at_s": 0.0, "speed_rpm": 300.0, "ramp_s": 0.3}, {"at_s": 1.5, "load_brake_nm": 0.1}]
scenario = es.load({"name": "own", "model": motor, "duration_s": 8.0, "event": events})
tuning = scenario.tune("smooth")
print("good:", tuning.good, *tuning.problems)
tuned = scenario.tuned("smooth")

# %% Cogging of 84 cycles a turn, 2 % of the rated torque, and methods against it.
rough = tuned.change({"cogging.amplitude_nm": 0.008, "cogging.order": 84})
ripple_rad_s = {}
for method in ("pi", "forc", "fal-forc", "aro"):
    run = rough.change(method=method).simulate()
    ripple_rad_s[method] = float(run.between(7.0, 8.0).orders(orders=(84,))[0])
    print(f"{method:9} {run.outcome.word:5} {1e3 * ripple_rad_s[method]:7.3f} mrad/s at order 84")

# %% A frame of the best one.
best = min(ripple_rad_s, key=ripple_rad_s.get)
frame = rough.change(method=best).simulate(["speed_rad_s", "iq_a"]).to_pandas()
print(best, frame.describe(), sep="\n")
