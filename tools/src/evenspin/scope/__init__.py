"""The scope: a page in the browser on the drive that `evenspin.bench` talks to.

From the drive to the page: `feed` (connects, streams, reconnects), `history` (the last minutes of rows), `desk`
(what a page may ask for), `messages` (what is said), `server` (HTTP and websockets), `static/` (the page).
"""

from evenspin.scope.desk import Desk
from evenspin.scope.feed import Feed
from evenspin.scope.history import History
from evenspin.scope.server import make_app

__all__ = ["Desk", "Feed", "History", "make_app"]
