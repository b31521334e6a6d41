"""The small web server: what it serves, to whom, and under which policy."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import http.client
import socket

import pytest

pytest.importorskip("websockets")

from ssmash_gym.console.web import PAGE, Place, Site, content_policy, is_own_host, serving
from ssmash_gym.errors import ConfigurationError

INDEX = b'<html><script type="importmap">{"imports": {}}</script></html>'


def get(port: int, path: str, host: str | None = None, method: str = "GET") -> tuple[int, bytes, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request(method, path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    return answer.status, answer.read(), dict(answer.getheaders())


def fetch(*requests: tuple[str, str | None]) -> list[tuple[int, bytes, dict[str, str]]]:
    async def go() -> list[tuple[int, bytes, dict[str, str]]]:
        async with serving(Site({"/": INDEX, "/live": lambda: b"now"}), Place()) as (_, port):
            return [await asyncio.to_thread(get, port, path, host) for path, host in requests]

    return asyncio.run(go())


def test_pages_come_with_a_policy_that_lets_nothing_in_from_elsewhere() -> None:
    status, body, headers = fetch(("/", None))[0]
    assert (status, body) == (200, INDEX)
    policy = dict(part.split(" ", 1) for part in headers["Content-Security-Policy"].split("; "))
    digest = base64.b64encode(hashlib.sha256(b'{"imports": {}}').digest()).decode()
    assert policy["script-src"] == f"'self' 'sha256-{digest}'"
    assert policy["default-src"] == policy["frame-ancestors"] == "'none'"
    assert not {"'unsafe-inline'", "'unsafe-eval'", "*"} & set(headers["Content-Security-Policy"].split())
    assert headers["X-Frame-Options"] == "DENY"


def test_nothing_outside_the_pages_folder_is_served() -> None:
    paths = [
        "/page/../web.py",
        "/page/%2e%2e/web.py",
        "/page/..%2fweb.py",
        "/page//etc/passwd",
        "/page/",
        "/web.py",
        "/page",
    ]
    for status, body, _ in fetch(*((path, None) for path in paths)):
        assert status == 404
        assert b"import" not in body
    assert (PAGE.parent / "web.py").is_file(), "which is what was asked for"


def test_files_of_the_page_have_their_types() -> None:
    scripts = [path.relative_to(PAGE).as_posix() for path in PAGE.rglob("*.js")]
    assert scripts
    for (status, body, headers), name in zip(fetch(*((f"/page/{n}", None) for n in scripts)), scripts, strict=True):
        assert status == 200
        assert headers["Content-Type"].startswith("text/javascript")
        assert body == (PAGE / name).read_bytes()


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.1:80", "localhost:8765", "[::1]:8765", "192.168.0.7:8765"])
def test_own_hosts(host: str) -> None:
    assert is_own_host(host)


@pytest.mark.parametrize(
    "host", ["", "evil.example", "evil.example:8765", "127.0.0.1.evil.example", "localhost.", "[::1"]
)
def test_foreign_hosts(host: str) -> None:
    assert not is_own_host(host)


def test_a_foreign_name_that_leads_here_is_refused() -> None:
    ((status, body, _),) = fetch(("/", "evil.example"))
    assert status == 403
    assert INDEX not in body


def test_a_request_without_a_host_or_with_two_is_refused() -> None:
    async def go(head: bytes) -> bytes:
        async with serving(Site({"/": INDEX}), Place()) as (_, port):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(b"GET / HTTP/1.1\r\n" + head + b"\r\n")
            answer = await reader.read()
            writer.close()
            return answer

    for head in (b"", b"Host: localhost\r\nHost: evil.example\r\n"):
        assert asyncio.run(go(head)).startswith(b"HTTP/1.1 403")


def test_contents_may_be_made_when_asked_for() -> None:
    assert fetch(("/live?x=1", None))[0][1] == b"now"


def test_a_page_without_an_import_map_allows_no_inline_script() -> None:
    assert "sha256" not in content_policy(b"<html></html>")


def test_a_taken_port_and_a_foreign_address_cost_one_sentence() -> None:
    async def go(place: Place) -> None:
        async with serving(Site({}), place):
            pass

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(ConfigurationError, match="another program listens"):
            asyncio.run(go(Place("127.0.0.1", taken.getsockname()[1])))
    with pytest.raises(ConfigurationError, match="no address of this machine"):
        asyncio.run(go(Place("203.0.113.9")))
    with pytest.raises(ConfigurationError, match="--port 70000"):
        Place("127.0.0.1", 70_000)


LOOPBACK = {"127.0.0.1": True, "::1": True, "localhost": True, "0.0.0.0": False, "ship": False}


@pytest.mark.parametrize(("address", "loopback"), LOOPBACK.items())
def test_loopback_is_told_from_the_network(address: str, loopback: bool) -> None:
    assert Place(address).loopback is loopback


def test_the_page_opens_at_an_address_that_a_browser_can_reach() -> None:
    assert Place("0.0.0.0").url(80) == "http://localhost:80/"
    assert Place("::1").url(80, "/view") == "http://[::1]:80/view"
