"""How evenly it turns: orders of the electrical turn, current distortion, overshoot and dip."""

from evenspin.analysis.distortion import distortion_pct, space_vector
from evenspin.analysis.orders import order_amplitudes, order_spectrum, strongest_orders, whole_turns
from evenspin.analysis.segments import Segment, measure_segment, segments
from evenspin.analysis.transients import dip, overshoot, settling_time_s

__all__ = [
    "Segment",
    "dip",
    "distortion_pct",
    "measure_segment",
    "order_amplitudes",
    "order_spectrum",
    "overshoot",
    "segments",
    "settling_time_s",
    "space_vector",
    "strongest_orders",
    "whole_turns",
]
