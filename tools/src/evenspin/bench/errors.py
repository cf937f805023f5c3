"""What can go wrong between the bench and a drive. Each text says where, what, and what to try next."""

from __future__ import annotations

from evenspin.errors import EvenspinError


class NoDeviceError(EvenspinError):
    """There is no drive where one was looked for, or it does not answer."""

    exit_code = 3


class LinkLostError(NoDeviceError):
    """The connection broke while it was in use."""


class RefusedError(EvenspinError):
    """The drive understood and said no. `parameter`: the one whose rule was broken, when the drive named one."""

    parameter: str = ""


class ReadOnlyError(RefusedError):
    """The firmware was built from other lists of parameters and signals: it may be read, not written."""


class DriveFaultError(EvenspinError):
    """The drive has switched off by itself."""

    exit_code = 1


class LostSamplesError(EvenspinError):
    """A stream with gaps, where every sample was needed."""

    exit_code = 1


class LeftOutError(EvenspinError):
    """This bench cannot do the experiment; the next one may go on."""
