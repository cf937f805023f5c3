"""The repetitive controller of the speed loop."""

from __future__ import annotations

from evenspin.blocks.block import Block
from evenspin.errors import BlockError


class RepetitiveController:
    """Repetitive controller: CRC (order 0), FORC (order 1 to 3), fal-FORC (with `fal`).

    Args:
        gain: learning gain k_rc.
        lead: phase lead m, samples.
        q: side and centre of Q(z) = side2 (z^2 + z^-2) + side (z + z^-1) + centre.
        q_side2: side2 of Q(z); 0: three taps.
        order: Lagrange order of the fractional delay; 0 takes whole samples.
        fal: (alpha, delta), or None.
        fal_at: "input" of the memory (A) or "output" of the controller, as lambda (B).
        truncate: order 0: cut the period to whole samples; False rounds to the nearest.
        capacity: samples that the memory holds (memory="angle": cells per electrical turn).
        memory: on a change of the period "keep" or "clear" the samples, or index them by "angle".
        limit: largest correction, unit of the error.
        freeze_above: learning stops while the error was larger within the last `freeze_samples`; 0: never.
    """

    def __init__(
        self,
        gain: float,
        lead: int,
        q: tuple[float, float] = (0.45, 0.10),
        order: int = 2,
        fal: tuple[float, float] | None = None,
        fal_at: str = "input",
        truncate: bool = True,
        capacity: int = 512,
        *,
        q_side2: float = 0.0,
        memory: str = "keep",
        limit: float = 1000.0,
        freeze_above: float = 0.0,
        freeze_samples: int = 80,
        numeric: str = "float",
    ) -> None:
        side, centre = q
        alpha, delta = (1.0, 1.0) if fal is None else fal
        if fal_at not in ("input", "output"):
            raise BlockError("fal_at", fal_at, "must be input or output")
        self._block = Block(
            "rc",
            numeric=numeric,
            gain=gain,
            lead=lead,
            q_side=side,
            q_centre=centre,
            q_side2=q_side2,
            order=order,
            fal_at="none" if fal is None else fal_at,
            alpha=alpha,
            delta=delta,
            truncate=truncate,
            memory=memory,
            capacity=capacity,
            limit=limit,
            freeze_above=freeze_above,
            freeze_samples=freeze_samples,
        )

    def step(self, error: float, period_samples: float, theta_e_rad: float = 0.0) -> float:
        """Advance one sample; returns the correction to add to the error."""
        return self._block.do("step", error, period_samples, theta_e_rad)[0]

    def reset(self) -> None:
        """Forget what was learned."""
        self._block.do("reset")

    @property
    def rejected(self) -> int:
        """Errors that were not finite, since it was made."""
        return int(self._block.do("rejected")[0])
