"""The scope: a page in the browser on the drive that `evenspin.bench` talks to.

From the drive to the page: `feed` (connects, streams, reconnects), `history` (the last minutes of rows), `session`
(what a page may ask for), `messages` (the messages), `page` (one open page, and whether it is still there), `control`
(which page is in control), `stopping` (the path of a stop), `recording`, `configuring` and `calibrating` (what leaves
files), `access` (who may talk to it), `server` (HTTP and websockets), `static/` (the page).
"""

from evenspin.scope.feed import Feed
from evenspin.scope.history import History
from evenspin.scope.server import make_app
from evenspin.scope.session import Session

__all__ = ["Session", "Feed", "History", "make_app"]
