"""Numbers as a person reads them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def amperes(value_a: float) -> str:
    """A current with its unit: 15.6 A, 228.4 mA."""
    return f"{value_a:.3g} A" if abs(value_a) >= 1.0 else f"{1e3 * value_a:.1f} mA"
