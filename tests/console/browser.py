"""A headless Chromium and a server beside it, for tests of the page. Everything but this machine is out of reach."""

from __future__ import annotations

import asyncio
import shutil
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

from ssmash_gym.console.web import Content, Place, Site, serving

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    # Otherwise a key press holds back messages of the socket by up to 50 ms while pictures are slow.
    "--disable-features=DeferRendererTasksAfterInput",
    # Whatever is not on this machine is not found: what works so, works offline.
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
)  # fmt: skip


@contextmanager
def chromium(*flags: str) -> Iterator[Browser]:
    """A browser; the test is skipped where there is none, or no playwright to drive it."""
    playwright = pytest.importorskip("playwright.sync_api")
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("no Chromium")
    with playwright.sync_playwright() as session:
        browser = session.chromium.launch(executable_path=path, args=[*FLAGS, *flags])
        try:
            yield browser
        finally:
            browser.close()


def watched(browser: Browser, width: int = 720, height: int = 460) -> tuple[Page, list[str]]:
    """A new page, and a list to which its errors and warnings are added."""
    page = browser.new_page(viewport={"width": width, "height": height})
    troubles: list[str] = []
    # Chromium itself remarks on drawing without a graphics card; that is no fault of the page.
    page.on("console", lambda m: troubles.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.on("requestfailed", lambda request: troubles.append(f"failed: {request.url[:120]}"))
    return page, troubles


@contextmanager
def served(contents: Mapping[str, Content]) -> Iterator[str]:
    """Serve contents and the page's folder from a thread; the address without a path."""
    address: list[str] = []
    ready = threading.Event()
    stop: list[Any] = []

    async def run() -> None:
        done = asyncio.Event()
        place = Place()
        async with serving(Site(contents), place) as (_, port):
            stop.extend([asyncio.get_running_loop(), done])
            address.append(place.url(port, ""))
            ready.set()
            await done.wait()

    thread = threading.Thread(target=asyncio.run, args=(run(),), daemon=True)
    thread.start()
    assert ready.wait(10.0), "the server did not start"
    try:
        yield address[0]
    finally:
        loop, done = stop
        loop.call_soon_threadsafe(done.set)
        thread.join(5.0)
