"""PI controller, tracking filter, M/T speed, deadbeat current control."""

from __future__ import annotations

from evenspin.blocks.block import Block


class Pi:
    """PI controller: `output` proposes, `commit` passes it what was realised.

    While limited the integrator holds ("hold"), or only if the error pushes further out ("hold-outward").
    """

    def __init__(
        self,
        kp: float,
        ki_ts: float,
        out_min: float,
        out_max: float,
        *,
        anti_windup: str = "hold",
        numeric: str = "float",
    ) -> None:
        self._block = Block(
            "pi", numeric=numeric, kp=kp, ki_ts=ki_ts, out_min=out_min, out_max=out_max, anti_windup=anti_windup
        )

    def output(self, error: float) -> float:
        return self._block.do("output", error)[0]

    def commit(self, realised: float) -> None:
        self._block.do("commit", realised)

    def step(self, error: float) -> float:
        """Propose and realise at once."""
        out = self.output(error)
        self.commit(out)
        return out

    def propose(self, error: float) -> float:
        """Step of the current loop: without limits, for an output that is limited as a vector with another axis."""
        return self._block.do("propose", error)[0]

    def learn(self, error: float) -> None:
        """The error of such a proposal, when the vector was not limited."""
        self._block.do("learn", error)

    @property
    def rejected(self) -> int:
        """Errors that were not finite, since it was made."""
        return int(self._block.do("rejected")[0])

    def reset(self, integrator: float = 0.0) -> None:
        self._block.do("reset", integrator)


class Pll:
    """Tracking filter: angle in, speed out. Gains in 1/s and 1/s^2."""

    def __init__(self, kp: float, ki: float, ts_s: float, *, numeric: str = "float") -> None:
        self._block = Block("pll", numeric=numeric, kp=kp, ki=ki, ts_s=ts_s)

    def step(self, angle_rad: float) -> float:
        """Advance one sample; returns the speed, rad/s."""
        return self._block.do("step", angle_rad)[0]

    def reset(self, angle_rad: float = 0.0) -> None:
        self._block.do("reset", angle_rad)


class MtSpeed:
    """Speed from encoder counts over the time between edges."""

    def __init__(self, counts_per_rev: int, clock_hz: float, ts_s: float, *, numeric: str = "float") -> None:
        self._block = Block("mt", numeric=numeric, counts_per_rev=counts_per_rev, clock_hz=clock_hz, ts_s=ts_s)

    def step(self, edge_count: int, edge_cyc: int, now_cyc: int) -> float:
        """Counter at the last edge, its time and the time now in clock cycles; returns the speed, rad/s."""
        return self._block.do("step", edge_count, edge_cyc % 2**32, now_cyc % 2**32)[0]


class Deadbeat:
    """Deadbeat control of the dq currents: the reference is reached two samples later. SI units.

    Args:
        correction: gain with which what the model does not explain is learned, 0 to 0.5.
    """

    def __init__(
        self,
        r_ohm: float,
        ld_h: float,
        lq_h: float,
        psi_wb: float,
        pole_pairs: int,
        ts_s: float = 1e-4,
        correction: float = 0.1,
        *,
        numeric: str = "float",
    ) -> None:
        self._block = Block(
            "deadbeat",
            numeric=numeric,
            r_ohm=r_ohm,
            ld_h=ld_h,
            lq_h=lq_h,
            psi_wb=psi_wb,
            pole_pairs=pole_pairs,
            ts_s=ts_s,
            correction=correction,
        )

    def step(
        self,
        current_a: tuple[float, float],
        reference_a: tuple[float, float],
        speed_m_rad_s: float,
        last_v: tuple[float, float],
    ) -> tuple[float, float]:
        """dq currents now and wanted, mechanical speed, dq voltage that acts now; returns the voltage for the next."""
        vd_v, vq_v = self._block.do("step", *current_a, *reference_a, speed_m_rad_s, *last_v)
        return vd_v, vq_v
