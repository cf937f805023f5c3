"""What can go wrong between the bench and a drive. Each text says where, what, and what to try next."""

from __future__ import annotations

from evenspin.errors import EvenspinError


class PlacedError(EvenspinError):
    """`place`: the command or option that it is about, in front of the text."""

    def __init__(self, text: str, place: str = "") -> None:
        super().__init__(f"{place}: {text}" if place else text)
        self.text = text

    @property
    def bare(self) -> str:
        return self.text


class NoDeviceError(PlacedError):
    """There is no drive where one was expected, or it does not answer."""

    exit_code = 3


class LinkLostError(NoDeviceError):
    """The connection broke while it was in use."""


class RefusedError(PlacedError):
    """The drive refused the request. `parameter`: the one whose rule was broken, when the drive named one."""

    parameter: str = ""
    busy: bool = False  # an earlier change is in progress: ask again


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
