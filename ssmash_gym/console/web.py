"""The small web server of the console and of `ssmash view`: files of the page, a socket, and who may speak to them.

It answers on the loopback address unless another one is asked for. A request whose Host is neither an IP address nor a
name of this machine is refused, so that a foreign page cannot reach the server under a name of its own (DNS
rebinding); a socket is opened only to a page that this very server has sent (Origin).
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import errno
import hashlib
import ipaddress
import os
import re
import socket
import sys
import webbrowser
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import unquote, urlsplit

from ssmash_gym.errors import ConfigurationError, require

if TYPE_CHECKING:
    from websockets.asyncio.server import Server, ServerConnection
    from websockets.http11 import Request, Response

PAGE: Final = Path(__file__).resolve().parent / "page"  # everything below it is served under /page/
SOCKET: Final = "/socket"
LARGEST_MESSAGE: Final = 64 * 1024  # bytes, from a page
LOOPBACK_NAME: Final = "localhost"
_TYPES: Final = {
    ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
    ".json": "application/json", ".svg": "image/svg+xml", ".png": "image/png", ".ico": "image/x-icon",
    ".txt": "text/plain; charset=utf-8", ".md": "text/plain; charset=utf-8",
}  # fmt: skip
_IMPORT_MAP: Final = re.compile(rb'<script type="importmap">(.*?)</script>', re.DOTALL)
_HEADERS: Final = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",  # a page that frames this one could have the claw driven by clicks meant for itself
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-cache",
}

Content = bytes | Callable[[], bytes]
Handler = Callable[["ServerConnection"], Awaitable[None]]


def require_websockets() -> None:
    """Check that the server can be run.

    Raises:
        ImportError: The library is missing; the sentence names the extra.
    """
    require("websockets", 'the page needs websockets: pip install "ssmash_gym[web]".')


@dataclass(frozen=True)
class Place:
    """Where the server listens.

    Attributes:
        address: IP address, or a name of this machine.
        port: TCP port; 0 takes a free one.

    Raises:
        ConfigurationError: The port is none.
    """

    address: str = "127.0.0.1"
    port: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.port <= 65535:
            raise ConfigurationError(f"--port {self.port} is refused: it must be a port, 1 to 65535, or 0 for any.")

    @property
    def loopback(self) -> bool:
        """Whether only this machine can reach it."""
        if self.address == LOOPBACK_NAME:
            return True
        try:
            return ipaddress.ip_address(self.address).is_loopback
        except ValueError:
            return False

    def url(self, port: int, path: str = "/") -> str:
        """What a browser on this machine opens."""
        host = self.address
        with contextlib.suppress(ValueError):
            ip = ipaddress.ip_address(host)
            host = LOOPBACK_NAME if ip.is_unspecified else f"[{host}]" if ip.version == 6 else host
        return f"http://{host}:{port}{path}"


@dataclass
class Refusals:
    """What was not let in, counted."""

    hosts: int = 0
    origins: int = 0
    paths: int = 0


@dataclass
class Site:
    """What a server answers GET requests with.

    Attributes:
        contents: Bytes, or a function that makes them, by path; files of the page's folder need no entry.
        refusals: What was not let in.
    """

    contents: Mapping[str, Content]
    refusals: Refusals = field(default_factory=Refusals)

    def answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The response to a request; None lets the socket open."""
        hosts = request.headers.get_all("Host")
        host = hosts[0] if len(hosts) == 1 else ""
        if not is_own_host(host):
            self.refusals.hosts += 1
            return _response(HTTPStatus.FORBIDDEN, b"this host name is not served\n")
        path = unquote(urlsplit(request.path).path)
        if path == SOCKET:
            return self._socket(request, host)
        content = self._content(path)
        if content is None:
            self.refusals.paths += 1
            return _response(HTTPStatus.NOT_FOUND, b"there is no such page\n")
        return _response(HTTPStatus.OK, content, _TYPES.get(Path(path).suffix, _TYPES[".html"]))

    def _socket(self, request: Request, host: str) -> Response | None:
        """Let a socket open to a page of this server only."""
        if request.headers.get("Upgrade", "").lower() != "websocket":
            return _response(HTTPStatus.UPGRADE_REQUIRED, b"this path is for the page's socket\n")
        if request.headers.get_all("Origin") != [f"http://{host}"]:
            self.refusals.origins += 1
            return _response(HTTPStatus.FORBIDDEN, b"only a page of this server may open its socket\n")
        return None

    def _content(self, path: str) -> bytes | None:
        given = self.contents.get(path)
        if given is not None:
            return given if isinstance(given, bytes) else given()
        return page_file(path.removeprefix("/page/")) if path.startswith("/page/") else None


def page_file(name: str) -> bytes | None:
    """A file below the page's folder; None where there is none."""
    path = (PAGE / name).resolve()
    return path.read_bytes() if path.is_relative_to(PAGE) and path.is_file() else None


def is_own_host(host: str) -> bool:
    """Whether a Host header names an IP address or this machine: a foreign name that leads here is no such host."""
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return False
    if name in (LOOPBACK_NAME, socket.gethostname().lower()):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _response(status: HTTPStatus, body: bytes, kind: str = _TYPES[".txt"]) -> Response:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    headers = Headers({**_HEADERS, "Content-Type": kind, "Content-Length": str(len(body)), "Connection": "close"})
    if kind == _TYPES[".html"]:
        headers["Content-Security-Policy"] = content_policy(body)
    return Response(status.value, status.phrase, headers, body)


def content_policy(page: bytes) -> str:
    """Content-Security-Policy of a page: nothing from elsewhere, nothing inline but its own import map, no eval."""
    maps = (base64.b64encode(hashlib.sha256(found).digest()).decode() for found in _IMPORT_MAP.findall(page))
    scripts = " ".join(["'self'", *(f"'sha256-{digest}'" for digest in maps)])
    return (
        f"default-src 'none'; script-src {scripts}; style-src 'self'; img-src 'self' data:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


@asynccontextmanager
async def serving(site: Site, place: Place, handler: Handler | None = None) -> AsyncIterator[tuple[Server, int]]:
    """Run the server while the block lasts.

    Args:
        site: What GET requests are answered with.
        place: Where it listens.
        handler: Called with each socket that a page opens; without one none can be opened.

    Yields:
        The server, and the port that it listens on.

    Raises:
        ConfigurationError: The address is none of this machine's, or the port is taken.
    """
    from websockets.asyncio.server import serve

    async def nobody(connection: ServerConnection) -> None:
        await connection.close()

    try:
        server = await serve(
            handler or nobody, place.address, place.port, process_request=site.answer, max_size=LARGEST_MESSAGE,
            max_queue=16, compression=None, ping_interval=5.0, ping_timeout=10.0, close_timeout=1.0, server_header=None,
        )  # fmt: skip
    except OSError as refusal:
        raise _refusal(place, refusal) from None
    async with server:
        yield server, int(next(iter(server.sockets)).getsockname()[1])


def _refusal(place: Place, refusal: OSError) -> ConfigurationError:
    if refusal.errno == errno.EADDRINUSE:
        return ConfigurationError(f"--port {place.port} is refused: another program listens there; 0 takes a free one.")
    if refusal.errno in (errno.EACCES, errno.EPERM):
        return ConfigurationError(f"--port {place.port} is refused: ports below 1024 need the administrator's rights.")
    return ConfigurationError(f"--address {place.address} is refused: it is no address of this machine.")


def serve_static(contents: Mapping[str, Content], place: Place, opened: Callable[[str], Any], path: str = "/") -> None:
    """Serve pages until Ctrl-C.

    Args:
        contents: Bytes, or functions that make them, by path; files of the page's folder are served under ``/page/``.
        place: Where.
        opened: Called with the address of the page once it can be opened, e.g. `open_browser`.
        path: Of that page.

    Raises:
        ConfigurationError: The address or the port is refused.
        ImportError: The extra ``web`` is missing.
    """
    require_websockets()

    async def run() -> None:
        async with serving(Site(contents), place) as (_, port):
            opened(place.url(port, path))
            await asyncio.Event().wait()

    asyncio.run(run())


def open_browser(url: str) -> bool:
    """Open a page in the user's browser, where there is one and a display to see it on; whether it was opened."""
    try:
        return has_display() and webbrowser.open(url)
    except webbrowser.Error:
        return False


def has_display() -> bool:
    """Whether a browser that is opened can be seen: elsewhere than on Linux it always can."""
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
