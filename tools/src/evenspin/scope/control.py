"""Which page is in control. A page that leaves may come back, as one that is loaded again does; until then the place is
kept for it, and if it does not come, the motor is stopped and the place is free for anybody."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from evenspin.scope.page import Page

RETURN_S = 0.6


class Control:
    """`changed` is called when something changed that pages show, `abandoned` when the motor has to be stopped."""

    def __init__(self, changed: Callable[[], None], abandoned: Callable[[], None]) -> None:
        self.pages: list[Page] = []
        self.holder: Page | None = None
        self._changed, self._abandoned = changed, abandoned
        self._kept_for: str | None = None
        self._timer: asyncio.TimerHandle | None = None

    def enter(self, page: Page) -> None:
        self.pages.append(page)
        if self.holder is None and self._kept_for in (None, page.token):
            self._give(page)
        self._changed()

    def take(self, page: Page) -> None:
        self._give(page)
        self._changed()

    def leave(self, page: Page, *, may_return: bool = True) -> None:
        if page not in self.pages:
            return
        self.pages.remove(page)
        if page is self.holder:
            self.holder = None
            self._kept_for = page.token
            if may_return:
                self._timer = asyncio.get_running_loop().call_later(RETURN_S, self._give_up)
            else:
                self._give_up()
        self._changed()

    def role_of(self, page: Page) -> dict[str, object]:
        free = self.holder is None and self._kept_for is None
        role = "control" if page is self.holder else "watch"
        return {"type": "role", "role": role, "pages": len(self.pages), "free": free}

    def _give(self, page: Page) -> None:
        self.holder = page
        self._forget()

    def _give_up(self) -> None:
        self._forget()
        self._abandoned()
        self._changed()

    def _forget(self) -> None:
        self._kept_for = None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
