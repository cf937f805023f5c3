"""The control blocks of the firmware, called one by one. Nothing is computed here: every number comes from the C code.

    >>> from evenspin import blocks
    >>> rc = blocks.RepetitiveController(gain=0.6, lead=5, q=(0.45, 0.10), order=2, fal=(0.6, 0.4))
    >>> correction = rc.step(error, period_samples=58.82)

Every function and class takes `numeric="float"` (default) or `"fixed"`. `Block` is any block by its name, with the
parameters and actions of its list; the other classes are the same blocks with a Python signature.
"""

from evenspin.blocks.block import Block
from evenspin.blocks.functions import (
    clarke,
    fal,
    inverse_clarke,
    inverse_park,
    lagrange,
    lambda_,
    park,
    power,
    rdc_robust_term,
    sincos,
    spatial_lowpass,
    stribeck,
    svm,
    vector_limit,
)
from evenspin.blocks.loops import Deadbeat, MtSpeed, Pi, Pll
from evenspin.blocks.observers import AngleMemory, Fir, TorqueObserver
from evenspin.blocks.position import MotionProfile, Setpoint
from evenspin.blocks.repetitive import RepetitiveController
from evenspin.errors import BlockError

__all__ = [
    "AngleMemory",
    "Block",
    "BlockError",
    "Deadbeat",
    "Fir",
    "MotionProfile",
    "MtSpeed",
    "Pi",
    "Pll",
    "RepetitiveController",
    "Setpoint",
    "TorqueObserver",
    "clarke",
    "fal",
    "inverse_clarke",
    "inverse_park",
    "lagrange",
    "lambda_",
    "park",
    "power",
    "rdc_robust_term",
    "sincos",
    "spatial_lowpass",
    "stribeck",
    "svm",
    "vector_limit",
]
