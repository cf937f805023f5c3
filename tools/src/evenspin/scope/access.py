"""Who may talk to the scope: pages that it served, under its own names, with the token of this run.

A browser sends requests on behalf of any page that it shows, so Host and Origin are checked: a page of another origin
must not move a motor, and another host name that resolves to this machine must not read from it. Other accounts of this
machine reach 127.0.0.1, too; they do not have the token, which is only in the address that the command prints.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import secrets
import socket
import weakref
from urllib.parse import urlsplit

from aiohttp import web

TOKEN_OCTETS = 16
STRANGERS = 64  # connections at a time that have not shown the token; a page opens six while it loads
WRONG_TOKEN = "token: must be that of this run; open the address that `evenspin scope` printed\n"
FOREIGN_PAGE = "this page was not served by this scope\n"


class Access:
    """What is refused is refused with one line, before anything is done."""

    def __init__(self, host: str, token: str | None = None) -> None:
        self.token = token or secrets.token_urlsafe(TOKEN_OCTETS)
        self._names = allowed_names(host)
        self._known: weakref.WeakSet[asyncio.BaseTransport] = weakref.WeakSet()

    def need_name(self, request: web.Request) -> None:
        if not self.answers_to(request.host):
            raise web.HTTPForbidden(text=f"the scope does not answer to the name {request.host!r}\n")

    def need_token(self, request: web.Request) -> None:
        shown = request.query.get("token", "")
        if not hmac.compare_digest(shown.encode(errors="replace"), self.token.encode()):
            raise web.HTTPForbidden(text=WRONG_TOKEN)
        if request.transport is not None:
            self._known.add(request.transport)

    def need_own_page(self, request: web.Request) -> None:
        origin = urlsplit(request.headers.get("Origin", ""))
        if origin.scheme != "http" or origin.netloc != request.host:
            raise web.HTTPForbidden(text=FOREIGN_PAGE)
        self.need_token(request)

    def answers_to(self, host: str) -> bool:
        """Addresses cannot be rebound to this machine by somebody else's name server; names can."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in self._names:
            return True
        with contextlib.suppress(ValueError):
            return ipaddress.ip_address(name).is_loopback or "*" in self._names
        return False

    def hang_up_on_strangers(self, server: web.Server) -> None:
        """The oldest beyond STRANGERS: whoever opens connections and says nothing must not use up those for pages."""
        transports = [connection.transport for connection in server.connections]
        strangers = [each for each in transports if each is not None and each not in self._known]
        for transport in strangers[:-STRANGERS]:
            transport.abort()


def allowed_names(host: str) -> frozenset[str]:
    """Names that the scope answers to; "*": any address in figures."""
    names = {"localhost", host.lower()}
    try:
        local = host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = False
    return frozenset(names if local else names | {"*", socket.gethostname().lower()})
