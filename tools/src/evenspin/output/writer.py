"""What a folder and a file as output have in common: the claim, the staging folder, the place at the end."""

from __future__ import annotations

import sys
import weakref
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType

from evenspin.errors import EvenspinError, InputError, reason
from evenspin.output import staging
from evenspin.output.claim import BusyError, Claim
from evenspin.output.origin import Origin, absolute

Say = Callable[[str], None]


def to_stderr(text: str) -> None:
    print(f"evenspin: {text}", file=sys.stderr)


class Writer:
    """`with writer as place:` write there; it becomes the output when the block ends well, and else is gone."""

    what = "output"

    def __init__(
        self, path: Path, origin: Origin | Sequence[str], *, option: str, recording: bool, force: bool, say: Say
    ) -> None:
        self.path = absolute(path)
        self.origin = origin if isinstance(origin, Origin) else Origin(" ".join(origin))
        self.option = option
        self.recording = recording
        self.force = force
        self.say = say
        self.staging: Path | None = None
        self._claim: Claim | None = None
        self.check()

    # ---- for those who fill it in

    def check(self) -> None:
        """Refuse what must not be replaced, before any work is done."""
        raise NotImplementedError

    def begin(self, new: Path) -> None:
        """What has to be there before it is written."""

    def finish(self, new: Path) -> None:
        """The last touch, before it takes its place."""

    def done(self) -> None:
        """It stands where it belongs."""

    # ---- the steps of every output

    def claim(self) -> None:
        """From here on others that want to write it are refused."""
        if self._claim is not None:
            return
        claim = Claim(self.path)
        try:
            claim.take()
        except BusyError as error:
            must = "one that nobody else writes"
            raise self.refusal(must, f"{error} writes it now: wait for it, or choose another name") from None
        except OSError as error:
            raise self.unwritable(error) from None
        self._claim = claim
        weakref.finalize(self, claim.release)
        self.check()  # the one that had it before may have changed it
        for left in staging.leftovers(self.path.parent, self.path, own=True):
            self.say(f"{left}; `evenspin clean {self.path.parent}` removes what is half-written")

    def release(self) -> None:
        if self._claim is not None:
            self._claim.release()
            self._claim = None

    def __enter__(self) -> Path:
        self.claim()
        try:
            self.staging = staging.make_staging(self.path)
            new = self.staging / staging.NEW
            self.begin(new)
        except OSError as error:
            self._leave()
            raise self.unwritable(error) from None
        return new

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            if kind is None:
                self._put()
            elif isinstance(error, OSError) and not isinstance(error, EvenspinError):
                raise self.unwritable(error) from None
        except OSError as problem:
            raise self.unwritable(problem) from None
        finally:
            self._leave()

    def _put(self) -> None:
        assert self.staging is not None
        new = self.staging / staging.NEW
        self.finish(new)
        self.check()
        if self.recording:
            staging.sync(new)
        staging.put_in_place(self.staging, self.path)
        if self.recording:
            staging.sync_names(self.path.parent)
        self.done()

    def _leave(self) -> None:
        if self.staging is not None:
            staging.remove(self.staging)
            self.staging = None
        self.release()

    # ---- refusals

    def refusal(self, must: str, hint: str) -> InputError:
        return InputError(self.option, self.what, self.path, must, hint)

    def unwritable(self, error: OSError) -> InputError:
        return self.refusal("writable", reason(error))
