"""A console on a free port with a short task, and pages that are programs."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from ssmash_gym.console.programme import FreeDrive
from ssmash_gym.console.server import Console
from ssmash_gym.console.show import Rules
from ssmash_gym.console.web import Place
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.vehicle import load_helicopter

INTERVAL_S = 0.05
SHORT = {
    "control_interval_s": INTERVAL_S,
    "horizon_s": 3.0,
    "lead_in": {"duration_s": 1.0, "ramp_s": 1.0},
    "goal": {"hold_s": 0.5},
}
QUICK = Rules(
    countdown_s=0.0, late_after_s=0.05, late_share=0.5
)  # a busy machine must not fail a test of something else


def short_condition(scenario: str = "calm", **changes: Any) -> Condition:
    """A drive of three seconds."""
    task = load_task({"base": "traverse", **SHORT, **changes})
    return Condition("short", "", task, load_scenario(scenario), load_helicopter("generic_tricycle"))


class Page:
    """What a page does, as a program: it remembers everything that it was told."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.told: list[dict[str, Any]] = []
        self.at: list[float] = []
        self.sequence = 0
        self.interval_s = INTERVAL_S
        self._news = asyncio.Event()
        self._task = asyncio.create_task(self._listen())

    async def _listen(self) -> None:
        with suppress(ConnectionClosed):
            async for text in self.socket:
                message = json.loads(text)
                self.interval_s = message.get("interval_s", self.interval_s)
                self.told.append(message)
                self.at.append(time.perf_counter())
                self._news.set()

    def of(self, kind: str) -> list[dict[str, Any]]:
        """Messages of a kind, oldest first."""
        return [message for message in self.told if message["type"] == kind]

    async def until(self, kind: str, found: Callable[[Mapping[str, Any]], bool] = lambda m: True,
                    within_s: float = 30.0, since: int = 0) -> dict[str, Any]:  # fmt: skip
        """The first message of a kind for which something holds, from number `since` on."""
        async with asyncio.timeout(within_s):
            while True:
                for message in self.told[since:]:
                    if message["type"] == kind and found(message):
                        return message
                self._news.clear()
                await self._news.wait()

    async def phase(self, name: str, within_s: float = 60.0, since: int = 0) -> None:
        """Wait until a phase has been entered."""
        await self.until("phase", lambda m: m["phase"] == name, within_s, since)

    async def say(self, kind: str, **content: Any) -> None:
        """Send a message."""
        await self.socket.send(json.dumps({"type": kind, **content}))

    async def command(self, along: float, across: float = 0.0, device: str = "keyboard") -> None:
        """One command."""
        self.sequence += 1
        await self.say("command", sequence=self.sequence, stamp_ms=1e3 * time.perf_counter(), along=along,
                       across=across, device=device)  # fmt: skip

    async def drive(self, along: float, across: float, seconds: float) -> None:
        """Hold a command, renewed as a page does, for so much simulated time or until the episode is over.

        Control steps are counted and no clock is looked at: a busy machine makes it longer and nothing else.
        """
        last = self._step() + round(seconds / self.interval_s)
        while self._step() < last and self._running():
            await self.command(along, across)
            await asyncio.sleep(0.02)

    def _running(self) -> bool:
        phases = self.of("phase")
        return not phases or phases[-1]["phase"] == "running"

    def _step(self) -> int:
        frames = self.of("frame")
        return int(frames[-1]["frame"]["k"]) if frames else 0

    async def begin(self) -> None:
        """Take the claw and start."""
        await self.phase("ready")
        since = len(self.told)
        await self.say("take")
        await self.say("start")
        await self.phase("running", since=since)

    async def close(self) -> None:
        """Close the page."""
        await self.socket.close()
        await self._task


@asynccontextmanager
async def page(port: int) -> AsyncIterator[Page]:
    """A page of the console at a port."""
    async with connect(f"ws://127.0.0.1:{port}/socket", origin=f"http://127.0.0.1:{port}", compression=None) as socket:
        opened = Page(socket)
        try:
            yield opened
        finally:
            await opened.close()


@asynccontextmanager
async def console(
    folder: Path, condition: Condition | None = None, **options: Any
) -> AsyncIterator[tuple[Console, int]]:
    """A console with a free drive, and its port."""
    programme = FreeDrive(condition or short_condition(), 1, folder)
    desk = Console(programme, options.pop("rules", QUICK), **options)
    async with desk.serving(Place()) as port:
        yield desk, port
