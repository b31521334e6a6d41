"""The console without a browser: roles, commands, safety, records, hostile pages."""

from __future__ import annotations

import asyncio
import itertools
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("websockets")

from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from ssmash_gym.console.commands import ZERO_WITHIN_S
from ssmash_gym.trials.files import read_trial
from ssmash_gym.trials.replay import replay
from tests.console.rig import INTERVAL_S, console, page
from tests.console.test_commands import BAD


def claw_speed(frame: dict[str, Any]) -> float:
    return abs(frame["frame"]["claw"][3]) + abs(frame["frame"]["claw"][4])


def test_a_drive_is_shown_recorded_and_replayed_bit_for_bit(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (_, port), page(port) as driver:
            await driver.begin()
            await driver.drive(1.0, 0.2, 1.2)
            await driver.drive(-0.5, 0.0, 10.0)
            result = await driver.until("result")
            frames = driver.of("frame")
            assert max(f["frame"]["claw"][0] for f in frames) > 0.05
            assert [f["frame"]["k"] for f in frames] == sorted(f["frame"]["k"] for f in frames)
            assert any(f["claw"] == "person" for f in frames)
            assert result["latency_ms"]["messages"] >= 2
            assert result["words"]
            trial = read_trial(tmp_path / result["file"])
            assert trial.driver == "person"
            assert trial.complete
            assert trial.metrics == result["metrics"]
            assert set(trial.table["device"]) <= {"", "keyboard"}
            assert replay(trial).agrees

    asyncio.run(go())


def test_one_page_drives_and_the_others_watch(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (desk, port), page(port) as driver, page(port) as viewer:
            await driver.begin()
            await viewer.say("take")
            refused = await viewer.until("refused")
            assert "claw" in refused["message"]
            await viewer.say("abort")
            await viewer.until("refused", lambda m: m["about"] == "abort")
            for _ in range(10):
                await viewer.command(1.0, 1.0)
            await driver.drive(0.0, 0.0, 0.5)
            assert all(f["frame"]["command"] == [0, 0] for f in viewer.of("frame")), "a viewer's commands count nothing"
            assert desk.dropped["not the driver"] == 10
            seen = {f["frame"]["k"] for f in viewer.of("frame")}
            assert len(seen & {f["frame"]["k"] for f in driver.of("frame")}) > 5, "the viewer follows"
            await driver.say("release")
            await viewer.say("take")
            roles = await viewer.until("roles", lambda m: m["driver"] == viewer.of("welcome")[0]["you"])
            assert roles["viewers"] == 1

    asyncio.run(go())


@pytest.mark.parametrize("how", ["silent", "closed", "cut", "released"])
def test_the_claw_stops_when_the_driver_falls_silent(tmp_path: Path, how: str) -> None:
    async def go() -> None:
        async with console(tmp_path) as (_, port), page(port) as viewer, page(port) as driver:
            await driver.begin()
            await driver.drive(1.0, 0.0, 0.6)
            moving = viewer.of("frame")[-1]
            assert moving["frame"]["command"][0] == 1.0
            assert claw_speed(moving) > 0.05
            if how == "closed":
                await driver.socket.close()
            elif how == "cut":
                driver.socket.transport.abort()
            elif how == "released":
                await driver.say("release")
            since = len(viewer.told)
            await viewer.until("frame", lambda m: m["frame"]["command"] == [0, 0], since=since)
            first = next(i for i in range(since, len(viewer.told)) if viewer.told[i]["type"] == "frame"
                         and viewer.told[i]["frame"]["command"] == [0, 0])  # fmt: skip
            step = viewer.told[first]
            assert step["claw"] in (("expired",) if how == "silent" else ("none", "expired"))
            await viewer.until("frame", lambda m: m["frame"]["k"] >= step["frame"]["k"] + 12)
            speeds = [claw_speed(f) for f in viewer.of("frame") if f["frame"]["k"] >= step["frame"]["k"]]
            falls = [a - b for a, b in itertools.pairwise(speeds)]
            assert max(falls) <= 0.3 * INTERVAL_S + 2e-3, "the claw slows at its own limit, 0.3 m/s2"
            assert falls[2] > 0.0

    asyncio.run(go())


def test_in_the_record_no_command_outlives_its_renewal(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (desk, port), page(port) as driver:
            await driver.begin()
            for _ in range(12):
                await driver.command(1.0, 0.0)
                await asyncio.sleep(0.03)
            result = await driver.until("result")
            trial = read_trial(tmp_path / result["file"])
            driven = trial.table.filter(trial.table["driver"] == "person")
            silent = trial.table.filter(trial.table["step"] > driven["step"].max())
            assert silent.height > 10
            assert silent["command_along"].abs().max() == 0.0
            first, last = driven["received_s"].min(), driven["taken_s"].max()
            renewed = desk.show.newest.renewed_s - desk.show.begun_s
            assert first <= renewed
            assert last + INTERVAL_S <= renewed + ZERO_WITHIN_S + 1e-6

    asyncio.run(go())


def test_the_policy_drives_and_a_person_takes_over(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path, policy="trapezoid", by_policy=True) as (_, port), page(port) as driver:
            await driver.begin()
            frame = await driver.until("frame", lambda m: m["claw"] == "policy" and m["frame"]["k"] > 8)
            assert frame["frame"]["command"][0] > 0.0
            await driver.say("drive", by="person")
            await driver.drive(-1.0, 0.0, 0.4)
            await driver.until("frame", lambda m: m["claw"] == "person" and m["frame"]["command"][0] == -1.0)
            await driver.say("drive", by="policy")
            result = await driver.until("result")
            trial = read_trial(tmp_path / result["file"])
            assert trial.driver == "several"
            assert set(trial.table["driver"]) >= {"person", "trapezoid"}
            assert replay(trial).agrees

    asyncio.run(go())


def test_the_same_sea_again_and_the_next_one(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (_, port), page(port) as driver:
            seeds = []
            for wish in ("again", "next", "next"):
                await driver.begin()
                await driver.say("abort")
                await driver.phase("over", since=len(driver.told) - 1)
                seeds.append(driver.of("setup")[-1]["seed"])
                driver.told.clear()
                await driver.say(wish)
            await driver.phase("ready")
            seeds.append(driver.of("setup")[-1]["seed"])
            assert seeds == [1, 1, 2, 3]
            assert all(not read_trial(path).complete for path in tmp_path.glob("*.parquet"))

    asyncio.run(go())


def test_inputs_change_between_episodes_only_and_a_mistake_costs_one_sentence(tmp_path: Path) -> None:
    from ssmash_gym.console.form import Bases

    async def go() -> None:
        async with console(tmp_path, bases=Bases(scenario="calm")) as (desk, port), page(port) as driver:
            await driver.phase("ready")
            await driver.say("take")
            await driver.say("configure", base={}, changes={"task": {"limits": {"roll_deg": -3}}})
            refused = await driver.until("refused")
            assert "roll_deg" in refused["message"]
            await driver.say("configure", base={}, changes={"task": {"horizon_s": 2.0, "lead_in": {"duration_s": 8.0}}})
            setup = await driver.until("setup", lambda m: m["setup"]["horizon_s"] == 2.0)
            assert setup["configuration"] == desk.show.programme.condition.configuration
            since = len(driver.told)
            await driver.phase("ready", since=since - 1)
            await driver.say("yaml", base={}, changes={"task": {"horizon_s": 2.0}})
            files = await driver.until("yaml")
            assert "horizon_s: 2.0" in files["files"]["task.yaml"]
            await driver.say("start")
            await driver.phase("running")
            await driver.say("configure", base={}, changes={"task": {"horizon_s": 4.0}})
            refused = await driver.until("refused", lambda m: "running" in m["message"])

    asyncio.run(go())


def test_a_console_that_is_stopped_keeps_what_has_been_driven(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (_, port), page(port) as driver:
            await driver.begin()
            await driver.drive(0.8, 0.0, 0.6)

    asyncio.run(go())
    (path,) = tmp_path.glob("*.parquet")
    trial = read_trial(path)
    assert not trial.complete
    assert trial.steps > 5
    assert replay(trial).agrees


# --- hostile pages ---------------------------------------------------------------------------------------


def test_only_pages_of_this_server_may_open_its_socket(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (desk, port):
            url = f"ws://127.0.0.1:{port}/socket"
            for origin in (
                None,
                "http://evil.example",
                f"http://127.0.0.1:{port + 1}",
                f"https://127.0.0.1:{port}",
                "null",
            ):
                with pytest.raises(InvalidStatus):
                    async with connect(url, origin=origin):
                        pass
            named = {"Host": f"evil.example:{port}"}
            with pytest.raises(InvalidStatus):
                async with connect(url, origin=f"http://evil.example:{port}", additional_headers=named):
                    pass
            assert desk.site.refusals.origins + desk.site.refusals.hosts == 6
            assert not desk.show.roles.pages

    asyncio.run(go())


async def hostile(port: int, rounds: int) -> int:
    """Malformed, out-of-order and oversized messages; returns how many were sent."""
    sent = 0
    async with page(port) as enemy:
        await enemy.say("take")
        for k in range(rounds):
            await enemy.socket.send(BAD[k % len(BAD)])
            await enemy.say("command", sequence=max(0, 50 - k), stamp_ms=1.0, along=1.0, across=1.0)
            sent += 2
    async with page(port) as enemy:
        await enemy.socket.send("x" * 200_000)
        sent += 1
        await asyncio.wait_for(enemy.socket.wait_closed(), 20.0)
    return sent


def test_hostile_messages_are_counted_and_the_drive_goes_on(tmp_path: Path) -> None:
    async def go() -> None:
        async with console(tmp_path) as (desk, port), page(port) as driver:
            await driver.begin()
            enemies = asyncio.gather(*(hostile(port, 150) for _ in range(2)))
            await driver.drive(0.4, 0.0, 10.0)
            sent = await enemies
            result = await driver.until("result")
            trial = read_trial(tmp_path / result["file"])
            assert set(trial.table["command_across"]) == {0.0}, "nobody else's command was taken"
            assert replay(trial).agrees
            assert sum(desk.dropped.values()) >= sum(sent)
            assert desk.dropped["oversized"] == 2

    asyncio.run(go())
