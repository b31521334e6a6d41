"""A console in a thread of its own, beside a browser that is driven from the test."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ssmash_gym.console.server import Console
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.vehicle import load_helicopter
from tests.console.rig import QUICK, console

STRAIGHT = {"base": "calm", "start": {"yaw_deg": 0.0, "lateral_m": 0.0}}


def straight_condition(way_m: float = 0.8, **changes: Any) -> Condition:
    """A calm sea, landed straight, some way to go: the claw stops by itself where the track ends, at the goal."""
    task = load_task(
        {
            "base": "traverse",
            "horizon_s": 60.0 if way_m > 2.0 else 20.0,
            "lead_in": {"duration_s": 2.0, "ramp_s": 2.0},
            "track": {"goal_x_m": way_m},
            "claw": {"x_max_m": way_m},
            "goal": {"hold_s": 0.5},
            **changes,
        }
    )
    return Condition("straight", "", task, load_scenario(STRAIGHT), load_helicopter("generic_tricycle"))


@dataclass
class Desk:
    """A running console.

    Attributes:
        console: The server; its state may be read.
        port: It listens on.
        folder: Of the records.
    """

    console: Console
    port: int
    folder: Path

    @property
    def url(self) -> str:
        """Of the page, without the picture: what draws on a processor takes seconds a picture."""
        return f"http://127.0.0.1:{self.port}/?quality=off"


@contextmanager
def desk(folder: Path, condition: Condition | None = None, **options: Any) -> Iterator[Desk]:
    """A console that listens while the block lasts."""
    found: list[Desk] = []
    ready, stop = threading.Event(), threading.Event()
    faults: list[BaseException] = []

    async def run() -> None:
        rules = options.pop("rules", QUICK)
        async with console(folder, condition or straight_condition(), rules=rules, **options) as (server, port):
            found.append(Desk(server, port, folder))
            ready.set()
            while not stop.is_set():
                await asyncio.sleep(0.05)

    def body() -> None:
        try:
            asyncio.run(run())
        except BaseException as fault:  # told in the test's own thread
            faults.append(fault)
        finally:
            ready.set()

    thread = threading.Thread(target=body, daemon=True)
    thread.start()
    assert ready.wait(60.0), "the console did not start"
    if faults:
        raise faults[0]
    try:
        yield found[0]
    finally:
        stop.set()
        thread.join(30.0)
    if faults:
        raise faults[0]


class Line:
    """A line to a port of this machine that can be cut: then nothing comes through, and nobody is told.

    Attributes:
        port: Its near end.
        cut: Set it to cut the line.
    """

    def __init__(self, port: int) -> None:
        self.cut = threading.Event()
        self._far = port
        self._near = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._near.getsockname()[1])
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            near, _ = self._near.accept()
            try:
                far = socket.create_connection(("127.0.0.1", self._far))
            except OSError:  # the console is gone: so is the line
                near.close()
                continue
            for ends in ((near, far), (far, near)):
                threading.Thread(target=self._carry, args=ends, daemon=True).start()

    def _carry(self, source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                if self.cut.is_set():
                    return
                sink.sendall(data)
            sink.close()
