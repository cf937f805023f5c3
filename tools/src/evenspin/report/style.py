"""Style of the pictures."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

# A method that does not stand here is drawn under its own name, in one of OTHER_COLOURS.
METHOD_COLOURS = {
    "pi": "#8c8c8c",
    "crc": "#e08e0b",
    "forc": "#1f6fb4",
    "fal-forc": "#0b8f6a",
    "fal-forc-beyond": "#7a4fb4",
    "corrected": "#c2376b",
    "dob": "#b4441f",
    "ro": "#7a4fb4",
    "aro": "#1f6fb4",
    "aro-beyond": "#0b8f6a",
}
METHOD_NAMES = {
    "pi": "PI",
    "crc": "CRC",
    "forc": "FORC",
    "fal-forc": "fal-FORC",
    "fal-forc-beyond": "fal-FORC, beyond",
    "corrected": "corrected at the source",
    "dob": "DOB",
    "ro": "RO",
    "aro": "ARO",
    "aro-beyond": "ARO, beyond",
}
METHOD_WIDTHS = {"crc": 2.2}  # shows behind FORC, whose curve is the same where the period is whole
# What a paper prints, over our curves and bars.
SIMULATION_COLOUR, EXPERIMENT_COLOUR = "#e0218a", "#7a0bc0"
REFERENCE_COLOUR = "#222222"
OTHER_COLOURS = ("#1f6fb4", "#e08e0b", "#0b8f6a", "#b4441f", "#7a4fb4")

RC: dict[Any, Any] = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.labelsize": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "figure.constrained_layout.use": True,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "svg.fonttype": "none",
    "svg.hashsalt": "evenspin",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
}


@contextmanager
def drawing() -> Iterator[None]:
    """Everything is drawn in the style of the house."""
    import matplotlib as mpl

    with mpl.rc_context(RC):
        yield


def subplots(rows: int = 1, columns: int = 1, *, width: float = 10.0, height: float = 3.2, **options: Any) -> Any:
    """A figure and its axes (always a 2-D array), without a window; call it within `drawing`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def to_svg(figure: Any) -> str:
    """The figure as an <svg> element; the same figure always gives the same text.

    By the canvas: `savefig` draws a figure twice, the first time only for its layout.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    out = io.StringIO()
    FigureCanvasSVG(figure).print_svg(out, metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    return text[text.index("<svg") :]
