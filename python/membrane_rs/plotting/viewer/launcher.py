"""What a page's server answers trame's client, which asks for the address of its messages before it guesses one.

The client posts to `LAUNCHER`, where a launcher of ParaView would be. From any other server it gets an error, which the
console of the browser shows, and then takes the address of its page.
"""

from __future__ import annotations

from typing import Any
from urllib.parse import urlsplit

LAUNCHER = "/paraview/"
MESSAGES = "/ws"
SCHEMES = {"http": "ws", "https": "wss"}


def answer_at(server: Any) -> None:
    """Let a server of aiohttp answer there; one of another kind stays as it is."""
    if hasattr(server, "app"):
        server.app.router.add_post(LAUNCHER, _answer)


def messages_of(page: str) -> str | None:
    """The address of the messages of a page, which lies beside it: as the browser sees both, behind a proxy as well.

    None where that is not known: for an address that is none, and one with capitals in its path, since the client
    writes the address it is given in small letters.
    """
    try:
        found = urlsplit(page)
        host = found.hostname and found.netloc
    except ValueError:
        return None
    folder = found.path.rpartition("/")[0]
    if found.scheme not in SCHEMES or not host or folder != folder.lower():
        return None
    return f"{SCHEMES[found.scheme]}://{host}{folder}{MESSAGES}"


async def _answer(request: Any) -> Any:
    from aiohttp import web

    address = messages_of(request.headers.get("Referer", ""))
    if address is None:
        raise web.HTTPNotFound
    return web.json_response({"sessionURL": address})
