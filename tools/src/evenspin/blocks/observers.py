"""Angle memory, filters and observers of the disturbance torque."""

from __future__ import annotations

from evenspin.blocks.block import Block
from evenspin.errors import BlockError

LIMIT = 100.0  # inside what the fixed-point numeric holds


class AngleMemory:
    """Learns a waveform over the angle: every grid point that the motion passes moves towards what was seen there.

    Args:
        cells: grid points per turn, 4 to 4096.
        gain: learning gain g of m <- q m + g (v - m), in (0, 1].
        forgetting: q, 0 to 1; 1 forgets nothing.
        write: of the points passed since the last sample "one" (the newest), "all", or "hat" (all, each with the
            average of the samples around it).
        read: "linear" between two points or "cubic" through four.
        limit: largest size of a stored value.
    """

    def __init__(
        self,
        cells: int,
        gain: float,
        forgetting: float = 1.0,
        write: str = "one",
        read: str = "linear",
        *,
        limit: float = LIMIT,
        numeric: str = "float",
    ) -> None:
        self._block = Block(
            "angle_memory",
            numeric=numeric,
            cells=cells,
            gain=gain,
            forgetting=forgetting,
            write=write,
            read=read,
            limit=limit,
        )

    def write(self, theta: float, value: float) -> None:
        """One sample: `value` seen at the angle `theta`, rad; it may run on beyond a turn."""
        self._block.do("write", theta, value)

    def read(self, theta: float) -> float:
        """What was learned for the angle `theta`, rad."""
        return self._block.do("read", theta)[0]

    @property
    def memory(self) -> list[float]:
        """The grid points; number i stands for the angle 2 pi i / cells."""
        return self._block.table

    @property
    def rejected(self) -> int:
        """Samples that were not finite, and jumps of the angle, since it was made."""
        return int(self._block.do("rejected")[0])


class Fir:
    """Symmetric low-pass (Hamming window): linear phase, so its delay is the same at every frequency.

    Args:
        order: 0 to 15; it has order + 1 taps.
        cutoff_over_rate: corner over sampling rate, above 0 and below 0.5.
    """

    def __init__(self, order: int, cutoff_over_rate: float, *, numeric: str = "float") -> None:
        self._block = Block("fir", numeric=numeric, order=order, cutoff_over_rate=cutoff_over_rate)
        self.taps = self._block.table

    def step(self, x: float) -> float:
        """Advance one sample; returns the filtered value."""
        return self._block.do("step", x)[0]

    @property
    def delay_samples(self) -> float:
        """Half the order; it need not be a whole number."""
        return self._block.do("delay")[0]


class TorqueObserver:
    """Measures the disturbance torque from the encoder and predicts it for the moment when a reference of now acts.

    Args:
        kind: "dob" (one state), "ro" (memory over time) or "aro" (memory over the angle).
        inertia_kgm2, viscous_nms: what it assumes of the mechanics.
        ts_s: sampling time.
        fir1, fir2: order and corner in Hz of the filters of speed and torque.
        actuation_samples: from a torque reference to the middle of its action.
        age_samples: age that it takes the measured torque to have; 0: the true one, from its filters.
        gain: learning gain a23 L_N, in (0, 1].
        forgetting: Q, 0 to 1.
        cells, write, read: as in AngleMemory.
    """

    def __init__(
        self,
        kind: str,
        inertia_kgm2: float,
        viscous_nms: float = 0.0,
        *,
        ts_s: float = 1e-4,
        fir1: tuple[int, float] = (9, 1000.0),
        fir2: tuple[int, float] = (10, 1000.0),
        actuation_samples: float = 2.0,
        age_samples: float = 0.0,
        gain: float = 0.05,
        forgetting: float = 1.0,
        cells: int = 200,
        write: str = "one",
        read: str = "linear",
        numeric: str = "float",
    ) -> None:
        self._block = Block(
            "observer",
            numeric=numeric,
            kind=kind,
            inertia_kgm2=inertia_kgm2,
            viscous_nms=viscous_nms,
            ts_s=ts_s,
            fir1_order=fir1[0],
            fir1_hz=fir1[1],
            fir2_order=fir2[0],
            fir2_hz=fir2[1],
            actuation_samples=actuation_samples,
            age_samples=age_samples,
            gain=gain,
            forgetting=forgetting,
            cells=cells,
            write=write,
            read=read,
        )
        self._seen = [0.0, 0.0]
        self._period = kind == "ro"
        self._target_rad_s = 0.0

    def step(self, theta_m_rad: float, ref_last_nm: float = 0.0, target_speed_rad_s: float | None = None) -> float:
        """Angle now and torque reference of the last sample; returns the expected disturbance torque, N m.

        "ro" needs the speed at which the motor is meant to turn, because a turn at it is the period of its memory.
        """
        if target_speed_rad_s is None and self._period:
            raise BlockError("target_speed_rad_s", "none", "must be given for ro: a turn at this speed is its period")
        if target_speed_rad_s is not None and target_speed_rad_s != self._target_rad_s:
            self._block.do("target", target_speed_rad_s)
            self._target_rad_s = target_speed_rad_s
        expected_nm, *self._seen = self._block.do("step", theta_m_rad, ref_last_nm)
        return expected_nm

    @property
    def speed_rad_s(self) -> float:
        """Filtered speed of the last step."""
        return self._seen[0]

    @property
    def torque_nm(self) -> float:
        """Disturbance torque measured in the last step; it acted `age_samples` ago. Positive drives forward."""
        return self._seen[1]

    @property
    def age_samples(self) -> float:
        """Age of the measured torque as the observer counts it."""
        return self._block.do("age")[0]
