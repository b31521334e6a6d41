"""Many viewers, many hostile messages, for long: memory and control steps hold. Short forms run always."""

from __future__ import annotations

import asyncio
import gc
import resource
import time
import tracemalloc
from contextlib import AsyncExitStack
from pathlib import Path

import pytest

pytest.importorskip("websockets")

from ssmash_gym.console.show import Rules
from tests.console.rig import console, page, short_condition
from tests.console.test_server import hostile

VIEWERS = 8
LATE_AFTER_S = 0.02


async def soak(folder: Path, seconds: float) -> tuple[list[int], int, int]:
    """Episode after episode with a driver and viewers; bytes held after each, late steps, steps."""
    held, late, steps = [], 0, 0
    lead_in = {"duration_s": 8.0, "ramp_s": 8.0}  # a shorter one jerks the deck
    condition = short_condition("ss5", horizon_s=min(20.0, seconds), lead_in=lead_in)
    rules = Rules(countdown_s=0.0, late_after_s=LATE_AFTER_S, late_share=1.0)
    end = time.perf_counter() + seconds
    async with console(folder, condition, rules=rules) as (_, port), AsyncExitStack() as stack:
        viewers = [await stack.enter_async_context(page(port)) for _ in range(VIEWERS)]
        driver = await stack.enter_async_context(page(port))
        while time.perf_counter() < end:
            await driver.begin()
            await driver.drive(0.3, 0.0, seconds)
            result = await driver.until("result")
            last = driver.of("frame")[-1]
            late, steps = late + last["late"], steps + last["steps"]
            assert result["file"]
            for viewer in viewers:
                await viewer.until("result")
                assert len(viewer.of("frame")) >= last["frame"]["k"]  # lost steps have no frame
                viewer.told.clear()
                viewer.at.clear()
            driver.told.clear()
            driver.at.clear()
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])
            await driver.say("next")
    return held, late, steps


def test_viewers_see_every_step(tmp_path: Path) -> None:
    tracemalloc.start()
    try:
        held, _, steps = asyncio.run(soak(tmp_path, 3.0))
    finally:
        tracemalloc.stop()
    assert steps > 40
    assert held


@pytest.mark.slow
def test_eight_viewers_for_ten_minutes(tmp_path: Path) -> None:
    tracemalloc.start()
    try:
        held, late, steps = asyncio.run(soak(tmp_path, 600.0))
    finally:
        tracemalloc.stop()
    print(
        f"{steps} steps, {late} late ({100 * late / steps:.2f} %), {held[2] / 1e6:.1f} to {held[-1] / 1e6:.1f} MB held"
    )
    assert late < 0.01 * steps
    assert held[-1] < 1.05 * held[2] + 1e6


@pytest.mark.slow
def test_ten_thousand_hostile_messages(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (desk, port):
            sent = await hostile(port, 500)
            gc.collect()
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            while sent < 10_000:
                sent += sum(await asyncio.gather(*(hostile(port, 500) for _ in range(3))))
            after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            print(f"{sent} messages; dropped {dict(desk.dropped)}; memory {before / 1e3:.0f} to {after / 1e3:.0f} MB")
            assert after < before + 30_000, "kB"
            async with page(port) as driver:  # and it can still be driven
                await driver.begin()
                await driver.drive(1.0, 0.0, 1.0)
                assert max(f["frame"]["claw"][0] for f in driver.of("frame")) > 0.05

    asyncio.run(go())
