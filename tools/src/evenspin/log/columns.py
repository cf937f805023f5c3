"""Columns of a log, in their order."""

from __future__ import annotations

LOG_COLUMNS = (
    "t_s",
    "speed_ref_rad_s",
    "speed_rad_s",
    "theta_m_rad",
    "id_ref_a",
    "iq_ref_a",
    "id_a",
    "iq_a",
    "ia_a",
    "ib_a",
    "vd_v",
    "vq_v",
    "vdc_v",
    "load_torque_nm",
)

LOG_UNITS = ("s", "rad/s", "rad/s", "rad", "A", "A", "A", "A", "A", "A", "V", "V", "V", "N m")
