"""The sockets of the pages: who is connected, what they say, what they are told."""

from __future__ import annotations

import asyncio
import itertools
import json
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from ssmash_gym import __version__
from ssmash_gym.console import messages
from ssmash_gym.console.form import Bases, checked, form_of, yaml_files
from ssmash_gym.console.messages import Command, Drive, Inputs, Plain
from ssmash_gym.console.programme import Programme
from ssmash_gym.console.show import Rules, Show
from ssmash_gym.console.web import PAGE, Place, Site, serving
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from websockets.asyncio.server import ServerConnection

MOST_PAGES: Final = 64
MESSAGES_PER_S: Final = 500.0  # of one page, in the long run; a page that drives sends 30 to 60
BURST: Final = 200.0
MOST_UNSENT: Final = 1_000_000  # bytes that a page may leave unread before it is cut off
ERRANDS: Final = ("review", "schema", "yaml", "configure")
JOINING: Final = ("setup", "phase", "frame", "result")  # what a page is told when it joins, as far as it is known


class Allowance:
    """How much a page may say: more is read later, so that nobody's talk delays the control steps."""

    def __init__(self, now_s: float) -> None:
        self._left, self._then_s = BURST, now_s

    def wait_s(self, now_s: float) -> float:
        """Take one message; returns how long to wait before reading the next one [s]."""
        self._left = min(BURST, self._left + MESSAGES_PER_S * (now_s - self._then_s)) - 1.0
        self._then_s = now_s
        return max(0.0, -self._left / MESSAGES_PER_S)


class Console:
    """The server of a console.

    Args:
        programme: A free drive or a session.
        rules: How time is kept.
        policy: At hand for taking the claw.
        by_policy: Whether it drives from the beginning.
        bases: Names that the form starts from; None: the page has no form.
        protocol: Of a session, for the page.

    Attributes:
        show: What is shown.
        site: GET requests, and how many were refused.
        dropped: Messages that were not taken, by kind.

    Raises:
        ConfigurationError: Something is refused.
    """

    def __init__(
        self,
        programme: Programme,
        rules: Rules | None = None,
        *,
        policy: str | None = None,
        by_policy: bool = False,
        bases: Bases | None = None,
        protocol: Mapping[str, Any] | None = None,
    ) -> None:
        self.show = Show(programme, self._tell_all, rules, policy=policy, by_policy=by_policy)
        index = (PAGE / "index.html").read_bytes()
        self.site = Site({"/": index})
        self.dropped: Counter[str] = Counter()
        self._bases = bases
        self._protocol = protocol
        self._pages: dict[int, ServerConnection] = {}
        self._numbers = itertools.count(1)
        self._errands: dict[int, asyncio.Task[None]] = {}  # what takes longer, one a page: commands do not wait for it
        self._running: asyncio.Task[None] | None = None

    @asynccontextmanager
    async def serving(self, place: Place) -> AsyncIterator[int]:
        """Serve pages and run the show while the block lasts; yields the port."""
        async with serving(self.site, place, self._page) as (_, port):
            self._running = asyncio.create_task(self.show.run())
            try:
                yield port
            finally:
                self._running.cancel()
                with suppress(asyncio.CancelledError):
                    await self._running

    async def finished(self) -> None:
        """Wait until there is no episode left; a fault of the show is raised here."""
        assert self._running is not None
        await self._running

    async def deserted(self) -> None:
        """Wait until no page is open."""
        while self._pages:
            await asyncio.sleep(0.2)

    # --- pages --------------------------------------------------------------------------------------------------

    async def _page(self, connection: ServerConnection) -> None:
        """A page from its first to its last message."""
        from websockets.exceptions import ConnectionClosed

        if len(self._pages) >= MOST_PAGES:
            await connection.close(1013, "too many pages")
            return
        page = next(self._numbers)
        self._pages[page] = connection
        self.show.roles.join(page)
        try:
            await self._welcome(page, connection)
            allowance = Allowance(time.perf_counter())
            async for text in connection:
                await self._hear(page, text)
                if wait_s := allowance.wait_s(time.perf_counter()):
                    await asyncio.sleep(wait_s)
        except ConnectionClosed as closing:
            if closing.sent is not None and closing.sent.code == 1009:
                self.dropped["oversized"] += 1
        finally:
            del self._pages[page]
            if self.show.roles.leave(page):
                self.show.newest.forget()
            self._roles()

    async def _welcome(self, page: int, connection: ServerConnection) -> None:
        show = self.show
        await self._tell(
            page,
            {
                "type": "welcome",
                "you": page,
                "version": __version__,
                "mode": "trial" if show.session else "drive",
                "policies": [] if show.policy is None else [show.policy],
                "policy": show.policy,
                "form": self._bases is not None,
                "protocol": self._protocol,
                "countdown_s": show.rules.countdown_s,
                "interval_s": show.interval_s,
            },
        )
        for kind in JOINING:
            if kind in show.last:
                await self._tell(page, show.last[kind])
        self._roles()

    async def _hear(self, page: int, text: str | bytes) -> None:
        """One message of a page."""
        message = messages.read(text)
        if message is None:
            self.dropped["malformed"] += 1
        elif isinstance(message, Command):
            self._command(page, message)
        elif message.type not in ERRANDS:
            await self._answered(page, message)
        elif page in self._errands:
            self.dropped["impatient"] += 1
        else:
            task = self._errands[page] = asyncio.create_task(self._answered(page, message))
            task.add_done_callback(lambda done: self._errands.pop(page, None))

    async def _answered(self, page: int, message: Plain | Drive | Inputs) -> None:
        """Grant a wish, or say in one sentence why not."""
        from websockets.exceptions import ConnectionClosed

        try:
            await self._wish(page, message)
        except ConfigurationError as refusal:
            self.dropped["refused"] += 1
            with suppress(ConnectionClosed):
                await self._tell(page, {"type": "refused", "message": str(refusal), "about": message.type})
        except ConnectionClosed:
            pass  # the page is gone: nobody waits for the answer

    def _command(self, page: int, message: Command) -> None:
        if page != self.show.roles.driver:
            self.dropped["not the driver"] += 1
        elif not self.show.newest.offer(message, time.perf_counter()):
            self.dropped["out of order"] += 1

    async def _wish(self, page: int, message: Plain | Drive | Inputs) -> None:
        """Everything but a command.

        Raises:
            ConfigurationError: It is not granted; one sentence.
        """
        kind = message.type
        if kind in ("take", "release"):
            self._role(page, kind)
        elif kind == "review":
            await self._tell(page, await self.show.review())
        elif kind == "schema":
            await self._tell(page, {"type": "schema", **await asyncio.to_thread(form_of, self._form())})
        elif isinstance(message, Inputs) and kind == "yaml":
            condition = await asyncio.to_thread(self._filled_in, message)
            await self._tell(page, {"type": "yaml", "files": yaml_files(condition)})
        elif page != self.show.roles.driver:
            raise ConfigurationError(f"{kind!r} is the driver's: take the claw first.")
        elif isinstance(message, Inputs):
            await self.show.configure(await asyncio.to_thread(self._filled_in, message))
        elif isinstance(message, Drive):
            _grant(self.show.hand(message.by))
            self._roles()
        else:
            _grant(self.show.call(kind))

    def _role(self, page: int, kind: str) -> None:
        roles, before = self.show.roles, self.show.roles.driver
        if kind == "take" and not roles.take(page):
            raise ConfigurationError("somebody else holds the claw: wait until it is released.")
        if kind == "release":
            roles.release(page)
        if roles.driver != before:
            self.show.newest.forget()  # what the last driver held down is not the next one's
        self._roles()

    def _form(self) -> Bases:
        if self._bases is None:
            raise ConfigurationError("inputs cannot be changed in a session.")
        return self._bases

    def _filled_in(self, message: Inputs) -> Condition:
        """What a form stands for; a page names no files."""
        return checked(message.base, message.changes, self._form(), files=False)

    # --- telling ------------------------------------------------------------------------------------------------

    def _roles(self) -> None:
        self._tell_all(self.show.roles.message())

    def _tell_all(self, message: Mapping[str, Any]) -> None:
        """Send a message to every page; one that does not read is cut off and waited for by nobody."""
        from websockets.asyncio.server import broadcast

        for connection in self._pages.values():
            if connection.transport.get_write_buffer_size() > MOST_UNSENT:
                connection.transport.abort()
        broadcast(self._pages.values(), _text(message))

    async def _tell(self, page: int, message: Mapping[str, Any]) -> None:
        """Send a message to one page."""
        connection = self._pages.get(page)
        if connection is not None:
            await connection.send(_text(message))


def _grant(why_not: str) -> None:
    if why_not:
        raise ConfigurationError(why_not)


def _text(message: Mapping[str, Any]) -> str:
    return json.dumps(message, allow_nan=False, separators=(",", ":"))
