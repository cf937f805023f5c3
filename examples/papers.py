"""What the papers show: repetitive control of a drive with faulty current sensors, an observer over the angle.

A script in cells (# %%): editors and Jupyter open it as a notebook.
"""

# %% Guo et al. 2024: four speeds, a load step at each; offsets and gains of the current sensors are wrong.
import evenspin as es

scenario = es.load("guo2024/first")
runs = {method: scenario.change(method=method).simulate() for method in ("pi", "crc", "forc", "fal-forc")}

# %% First and second electrical order of the speed at 255 r/min, in % of the mean: the offsets and the gains.
ripple = {}
for method, run in runs.items():
    at_255 = next(each for each in run.summary()["segments"] if round(each["speed_ref_rpm"]) == 255)
    ripple[method] = (at_255["n1_pct"], at_255["n2_pct"])
    print(f"{method:9} {ripple[method][0]:6.3f} % {ripple[method][1]:6.3f} %")

# %% The overshoot at the start is what fal-FORC is for.
overshoot_rpm = {method: run.summary()["segments"][0]["overshoot_rpm"] for method, run in runs.items()}
print(overshoot_rpm)

# %% Tang et al. 2020: an observer that learns the torque over the angle of the rotor, at 100 r/min.
rig = es.load("tang2020/rpm100")
rms_rpm = {}
for method in ("pi", "aro"):
    speed = rig.change(method=method).simulate(["true_speed_rad_s"]).between(rig.duration_s - 2.0, rig.duration_s)
    rms_rpm[method] = float(speed["true_speed_rad_s"].std()) * 30.0 / 3.14159265
print(rms_rpm)

# %% A picture of one of them.
figure = runs["fal-forc"].plot("true_speed_rad_s", "true_iq_a")
