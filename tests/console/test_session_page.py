"""A session at the page: practice, scored seas in their order, a driver who leaves."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

pytest.importorskip("websockets")

from ssmash_gym.console.server import Console
from ssmash_gym.console.web import Place
from ssmash_gym.trials.files import read_trial
from ssmash_gym.trials.protocol import load_protocol
from ssmash_gym.trials.replay import replay
from ssmash_gym.trials.session import Session
from tests.console.rig import QUICK, SHORT, page

PROTOCOL = {
    "base": "standard",
    "task": {"base": "traverse", **SHORT, "horizon_s": 4.0},
    "scenario": "calm",
    "practice": {"least": 2, "most": 2, "plateau": {"last": 2}},
    "scored": {"seas": 2},
    "late": {"after_s": 0.05, "share": 0.5},
    "countdown_s": 0.0,
}


def test_a_page_that_falls_silent_breaks_the_trial_off(tmp_path: Path) -> None:
    """A hidden tab renews nothing: with nobody at the claw the rest would be nobody's driving."""
    protocol = load_protocol({**PROTOCOL, "task": {**PROTOCOL["task"], "horizon_s": 20.0}})

    async def go(session: Session) -> None:
        async with Console(session, QUICK).serving(Place()) as port, page(port) as driver:
            await driver.begin()
            await driver.drive(0.5, 0.0, 0.5)
            assert not (await driver.until("result"))["metrics"]

    with Session.open(protocol, "P02", tmp_path) as session:
        asyncio.run(go(session))
        again = session.next()
        assert again is not None and again.attempt == 2
    trial = read_trial(tmp_path / "P02" / "001_practice_01_incomplete.parquet")
    assert trial.table["driver"].to_list()[-1] == "none" and trial.steps < 120


def test_a_rival_shows_nothing_of_seas_that_are_yet_to_be_driven(tmp_path: Path) -> None:
    protocol = load_protocol(PROTOCOL)

    async def go(session: Session) -> list[tuple[bool, int]]:
        seen = []
        async with Console(session, QUICK, policy="trapezoid").serving(Place()) as port, page(port) as driver:
            for k in range(5):
                driver.told.clear()
                await driver.begin()
                await driver.drive(0.5, 0.0, 0.3 if k == 0 else 10.0)
                if k == 0:
                    await driver.say("abort")
                told = await driver.until("result")
                await driver.say("review")
                seen.append((told["beside"], len((await driver.until("review"))["runs"])))
                await driver.say("next")
        return seen

    with Session.open(protocol, "P03", tmp_path) as session:  # broken off, practice twice, scored, the last one
        seen = asyncio.run(go(session))
    assert seen == [(False, 1), (True, 2), (True, 2), (False, 1), (True, 2)]


def test_a_session_goes_on_where_a_driver_has_left(tmp_path: Path) -> None:
    protocol = load_protocol(PROTOCOL)
    order = protocol.order("P01")

    async def go(session: Session) -> list[int]:
        seeds = []
        desk = Console(session, QUICK, policy="trapezoid")
        async with desk.serving(Place()) as port:
            async with page(port) as driver:
                await driver.begin()  # practice
                assert driver.of("welcome")[0]["mode"] == "trial"
                assert driver.of("setup")[-1]["session"]["participant"] == "P01"
                await driver.say("drive", by="policy")
                await driver.until("refused", lambda m: "session" in m["message"])
                for _ in range(2):
                    await driver.drive(0.5, 0.0, 10.0)
                    await driver.until("result")
                    driver.told.clear()
                    await driver.say("next")
                    await driver.begin()
                seeds.append(driver.of("setup")[-1]["seed"])
                await driver.drive(0.5, 0.0, 0.5)
            async with page(port) as driver:  # the page was closed in the middle, and is opened again
                await driver.phase("over")
                assert not driver.of("result")[-1]["metrics"]
                for _ in range(2):
                    await driver.say("take")
                    driver.told.clear()
                    await driver.say("next")
                    await driver.begin()
                    seeds.append(driver.of("setup")[-1]["seed"])
                    await driver.drive(0.5, 0.0, 10.0)
                    await driver.until("result")
                await driver.say("next")
                await driver.phase("done")
            await desk.finished()
        return seeds

    with Session.open(protocol, "P01", tmp_path) as session:
        assert asyncio.run(go(session)) == [order[0], order[1], order[0]]
        assert session.next() is None
    trials = [read_trial(path) for path in sorted((tmp_path / "P01").glob("*.parquet"))]
    assert [trial.complete for trial in trials] == [True, True, False, True, True]
    assert [trial.scored for trial in trials] == [False, False, False, True, True]
    assert all(replay(trial).agrees for trial in trials)
    assert {trial.driver for trial in trials} == {"person"}
