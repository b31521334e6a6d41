"""How soon the console acts on what a page sends, and how punctual its control steps are.

    python -m benchmarks.console_latency [--seconds 60] [--viewers 0,1,8]

`ssmash console` runs in a process of its own. A driver that is a program sends commands forty times a second and
changes them at random instants; viewers read every picture. Latency is what the trial's own record says: from a
message's arrival to the control step that used it first. It cannot be below the wait for the next step: half a control
interval on average, a whole one at most; what exceeds that is the console's. The machine should be idle;
how idle it is says the share of the driver's own short sleeps that lasted 20 ms too long.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import random
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from typing import Any

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from ssmash_gym.trials.files import read_trial

PERIOD_S = 0.025  # between two commands, as of the page
LATE_AFTER_S = 0.02  # as in the console
HELD_S = (0.15, 0.9)  # a command is held for so long


def measure(seconds: float, viewers: int) -> dict[str, Any]:
    """One episode of so many seconds at most; figures of its record."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-u", "-m", "ssmash_gym", "console", "--port", "0", "--no-browser", "--out", folder]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout is not None
            found = re.search(r":(\d+)/", server.stdout.readline())
            assert found is not None
            sleeps = asyncio.run(_drive(int(found[1]), seconds, viewers))
            server.terminate()
        (path,) = Path(folder).glob("*.parquet")
        timing = read_trial(path).about["timing"]
    tired = sum(slept > PERIOD_S + LATE_AFTER_S for slept in sleeps) / max(len(sleeps), 1)
    return {
        "viewers": viewers,
        "overslept": tired,
        **{key: timing[key] for key in ("steps", "late_steps", "interval_s", "latency_ms")},
    }


async def _drive(port: int, seconds: float, viewers: int) -> list[float]:
    url, origin = f"ws://127.0.0.1:{port}/socket", f"http://127.0.0.1:{port}"
    async with AsyncExitStack() as stack:
        sockets = [await stack.enter_async_context(connect(url, origin=origin)) for _ in range(1 + viewers)]
        readers = [asyncio.create_task(_read(socket)) for socket in sockets[1:]]
        driver = sockets[0]
        phases: asyncio.Queue[str] = asyncio.Queue()
        readers.append(asyncio.create_task(_read(driver, phases)))
        await _until(phases, "ready")
        await driver.send('{"type": "take"}')
        await driver.send('{"type": "start"}')
        await _until(phases, "running")
        sleeps = await _command(driver, phases, seconds)
        await driver.send('{"type": "abort"}')
        await _until(phases, "over")
        for reader in readers:
            reader.cancel()
        return sleeps


async def _command(driver: Any, phases: asyncio.Queue[str], seconds: float) -> list[float]:
    """Gentle commands that change at random, until the time or the episode is over; how long each sleep lasted [s]."""
    sleeps = []
    chance, began, change, sequence = random.Random(1), time.perf_counter(), 0.0, 0
    along = across = 0.0
    while (now := time.perf_counter()) - began < seconds and phases.empty():
        if now >= change:
            along, across = chance.uniform(-0.3, 0.5), chance.uniform(-0.2, 0.2)
            change = now + chance.uniform(*HELD_S)
        sequence += 1
        message = {"type": "command", "sequence": sequence, "stamp_ms": 1e3 * now, "along": along, "across": across}
        await driver.send(json.dumps(message))
        began_s = time.perf_counter()
        await asyncio.sleep(PERIOD_S)
        sleeps.append(time.perf_counter() - began_s)
    return sleeps


async def _read(socket: Any, phases: asyncio.Queue[str] | None = None) -> None:
    with suppress(ConnectionClosed):
        async for text in socket:
            message = json.loads(text)
            if phases is not None and message["type"] == "phase":
                phases.put_nowait(message["phase"])


async def _until(phases: asyncio.Queue[str], wanted: str) -> None:
    while await phases.get() != wanted:
        pass


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--viewers", default="0,1,8")
    chosen = parser.parse_args(arguments)
    for viewers in map(int, chosen.viewers.split(",")):
        found = measure(chosen.seconds, viewers)
        latency = found["latency_ms"]
        bound_ms = 1e3 * found["interval_s"] + 10.0
        print(
            f"{viewers} viewers: {found['steps']} steps, {found['late_steps']} late; latency of {latency['messages']} "
            f"messages: median {latency['p50']:.1f} ms, 95 % within {latency['p95']:.1f} ms, longest "
            f"{latency['max']:.1f} ms (one control step and 10 ms: {bound_ms:.0f} ms); the driver overslept in "
            f"{100.0 * found['overslept']:.1f} % of its sleeps"
        )


if __name__ == "__main__":
    main()
