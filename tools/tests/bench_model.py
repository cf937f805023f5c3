"""The motor of the foreign logs (tests/data/foreign_drive), as a model file: its noise, and nothing hidden."""

MODEL = """\
name = "clean"

[plant]
pole_pairs = 3
resistance_ohm = 0.9
ld_h = 0.0024
lq_h = 0.0024
psi_wb = 0.1
inertia_kgm2 = 0.0008
viscous_nms = 0.002
rated_current_a = 5.0
rated_torque_nm = 2.2
slots = 18
dc_link_v = 150.0
counts_per_rev = 4000
current_noise_a = 0.015
current_lsb_a = 0.009765625
initial_angle_rad = 1.3

[drive]
current_kp_v_per_a = 6.03
current_ki_v_per_as = 2262.0
speed_error_gain = 1.0
speed_kp_a_per_unit = 0.134
speed_ki_a_per_unit_s = 2.02
iq_limit_a = 8.0
over_voltage_v = 250.0
offset_calibration_periods = 0
align_periods = 0
"""
