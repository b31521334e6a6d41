"""The page in a browser: every device drives the claw, one page at a time, and a page that is not looked at stops it.

Short ways in the normal tests; the whole way, the times and the pictures in the long ones.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("websockets")

from ssmash_gym.console.commands import ZERO_WITHIN_S
from ssmash_gym.trials.files import read_trial
from ssmash_gym.trials.replay import replay
from tests.console.browser import chromium, watched
from tests.console.desks import Desk, Line, desk, straight_condition

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

PATIENCE_MS = 60_000
DEVICES = ("keyboard", "gamepad", "stick")
PAD = """
window.pad = {id: "mock", index: 0, connected: true, mapping: "standard", timestamp: 0, axes: [0, 0, 0, 0],
              buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}))};
navigator.getGamepads = () => [window.pad];
"""
LEFT_ALONE = ("hidden", "unfocused", "closed", "hanging", "cut")
HIDE = """() => {
  Object.defineProperty(document, "hidden", {configurable: true, get: () => true});
  document.dispatchEvent(new Event("visibilitychange"));
}"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as found:
        yield found


def opened(browser: Browser, at: Desk, scripts: str = "") -> tuple[Page, list[str]]:
    """A page of the console that has heard from it."""
    page, troubles = watched(browser, 900, 600)
    page.set_default_timeout(PATIENCE_MS)
    if scripts:
        page.add_init_script(scripts)
    page.goto(at.url)
    page.wait_for_function("() => window.ssmash?.frame")
    return page, troubles


def hold(page: Page, device: str) -> None:
    """Move a device fully towards the hangar, and keep it there."""
    if device == "keyboard":
        page.keyboard.down("ArrowUp")
    elif device == "gamepad":
        page.wait_for_timeout(100)  # the pad must have been seen at rest
        page.evaluate("() => { window.pad.axes[1] = -1; }")
    else:
        box = page.locator("#stick").bounding_box()
        assert box is not None
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0], box["y"] + 2, steps=3)


def to_the_goal(browser: Browser, at: Desk, device: str) -> None:
    """Drive by a device until the goal is held, and check the record."""
    page, troubles = opened(browser, at, PAD if device == "gamepad" else "")
    page.wait_for_function("() => window.ssmash.mine")
    hold(page, device)
    page.wait_for_function("() => window.ssmash.phase === 'over'")
    result = page.evaluate("() => window.ssmash.result")
    assert result["metrics"]["reason"] == "goal"
    assert page.locator("#result").is_visible()
    trial = read_trial(at.folder / result["file"])
    assert trial.driver == "person"
    assert set(trial.table["device"]) - {""} == {device}
    assert replay(trial).agrees
    assert not troubles
    page.close()


@pytest.mark.parametrize("device", DEVICES)
def test_each_device_drives_to_the_goal(browser: Browser, tmp_path: Path, device: str) -> None:
    with desk(tmp_path) as at:
        to_the_goal(browser, at, device)


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
def test_each_device_drives_the_whole_way_in_a_calm_sea(browser: Browser, tmp_path: Path, device: str) -> None:
    with desk(tmp_path, straight_condition(8.0, goal={"hold_s": 2.0})) as at:
        to_the_goal(browser, at, device)


def test_the_second_page_watches_until_the_first_lets_go(browser: Browser, tmp_path: Path) -> None:
    with desk(tmp_path, straight_condition(6.0)) as at:
        driver, _ = opened(browser, at)
        driver.wait_for_function("() => window.ssmash.mine")
        viewer, troubles = opened(browser, at)
        viewer.wait_for_function("() => window.ssmash.driver !== null")
        assert not viewer.evaluate("() => window.ssmash.mine")
        assert viewer.locator("#take").is_disabled()
        driver.locator("#start").click()
        driver.wait_for_function("() => window.ssmash.phase === 'running'")
        viewer.keyboard.down("ArrowDown")  # moves nothing
        driver.bring_to_front()
        driver.keyboard.down("ArrowUp")
        viewer.wait_for_function("() => window.ssmash.frame.claw[0] > 0.1")
        driver.keyboard.up("ArrowUp")
        driver.locator("#release").click()
        viewer.bring_to_front()
        viewer.locator("#take").click()
        viewer.wait_for_function("() => window.ssmash.mine")
        assert not troubles
        driver.close()
        viewer.close()


def left_alone(page: Page, line: Line, how: str) -> Callable[[], Any]:
    """What befalls a driver's page, when it is called."""
    if how == "hidden":
        return lambda: page.evaluate(HIDE)
    if how == "unfocused":
        return lambda: page.evaluate("() => window.dispatchEvent(new Event('blur'))")
    if how == "closed":
        return page.close
    if how == "cut":
        return line.cut.set
    session = page.context.new_cdp_session(page)
    session.send("Debugger.enable")
    return lambda: session.send("Debugger.pause")


def stopped_after_s(at: Desk, browser: Browser, how: str) -> float:
    """Seconds from what befell the driver's page to the first control step with a zero command."""
    line = Line(at.port)
    page, _ = opened(browser, replace(at, port=line.port))
    page.wait_for_function("() => window.ssmash.mine")
    page.keyboard.down("ArrowUp")
    page.wait_for_function("() => window.ssmash.phase === 'running' && window.ssmash.frame.command[0] === 1")
    leave = left_alone(page, line, how)
    page.wait_for_timeout(500)
    began = time.perf_counter()
    leave()
    show = at.console.show
    while show.phase == "running" and show.last["frame"]["frame"]["command"] != [0, 0]:
        time.sleep(0.002)
    took = time.perf_counter() - began
    assert show.phase == "running", "the episode must not have ended before"
    if not page.is_closed():
        page.close()
    while show.phase == "running":
        time.sleep(0.05)
    assert show.kept is not None
    table = show.kept[0].table
    after = table.filter(table["step"] > table.filter(table["command_along"] > 0.0)["step"].max())
    assert after.height > 5
    assert after["command_along"].abs().max() == 0.0, "it stays at zero"
    falls = -after["claw_vx"].cast(float).diff().drop_nulls().to_numpy()
    assert falls.max() < 0.3 * show.interval_s + 5e-3, "the claw slows at its own limit"
    return took


@pytest.mark.parametrize("how", LEFT_ALONE)
def test_a_page_that_is_left_alone_stops_the_claw(browser: Browser, tmp_path: Path, how: str) -> None:
    with desk(tmp_path, straight_condition(8.0, horizon_s=6.0)) as at:
        assert stopped_after_s(at, browser, how) < 10.0


@pytest.mark.slow
@pytest.mark.parametrize("how", LEFT_ALONE)
def test_it_stops_within_its_time(browser: Browser, tmp_path: Path, how: str) -> None:
    with desk(tmp_path, straight_condition(8.0, horizon_s=6.0)) as at:
        took = stopped_after_s(at, browser, how)
        print(f"{how}: command zero after {1e3 * took:.0f} ms")
        assert took < ZERO_WITHIN_S


def test_the_picture_follows_the_drive(browser: Browser, tmp_path: Path) -> None:
    with desk(tmp_path, straight_condition(8.0)) as at:
        page, troubles = watched(browser, 560, 360)
        page.set_default_timeout(PATIENCE_MS)
        page.goto(at.url.replace("off", "4"))
        page.wait_for_function("() => window.ssmash?.mine")
        page.keyboard.down("ArrowUp")
        page.wait_for_function("() => window.ssmash.shown_step > 10")
        blank: Any = page.screenshot()
        assert len(blank) > 10_000
        assert not troubles
        page.close()
