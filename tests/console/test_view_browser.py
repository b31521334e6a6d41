"""The page of recordings in a headless browser: offline, under its content policy, with its controls."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from ssmash_gym.console.single_page import single_page
from ssmash_gym.console.view_verb import PATH, contents_of
from tests.console.browser import chromium, served, watched
from tests.console.seas import live_run

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

LOADED = "() => globalThis.player !== undefined"
BODY = "() => player.stage.helicopter.body.position.toArray()"
GHOST = "() => player.stage.ghosts[0].helicopter.body.position.toArray()"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def runs() -> list[dict[str, Any]]:
    return [live_run("fast", 1.0), live_run("slow", 0.3)]


@pytest.fixture(scope="module")
def address(runs: list[dict[str, Any]]) -> Iterator[str]:
    with served(contents_of(runs)) as url:
        yield f"{url}{PATH}?quality=5"


@pytest.fixture(scope="module")
def page(browser: Browser, address: str) -> Iterator[Page]:
    """One page for the tests that only move about in it; at its end it must have had no trouble."""
    page, troubles = watched(browser)
    page.goto(address)
    page.wait_for_function(LOADED)
    yield page
    assert not troubles, troubles
    page.close()


def test_page_shows_all_runs(page: Page, runs: list[dict[str, Any]]) -> None:
    assert page.evaluate("() => player.stage.works")
    assert page.evaluate("() => player.stage.ghosts.length") == 1
    assert page.locator(".player-legend tbody").count() == 2
    assert page.locator(".player-moments button").count() == 2
    page.wait_for_function("() => player.stage.renderer.info.render.calls > 20")
    assert page.evaluate("() => player.stage.last_drawn_step") == 0
    assert page.title().startswith("fast, slow")


def test_slider_moves_every_helicopter(page: Page, runs: list[dict[str, Any]]) -> None:
    slider = page.locator("input[type=range]")
    for index in (0, 12):
        slider.evaluate(
            "(s, t) => { s.value = t; s.dispatchEvent(new Event('input')); }", runs[0]["frames"][index]["t"]
        )
        for script, run in ((BODY, runs[0]), (GHOST, runs[1])):
            assert page.evaluate(script) == pytest.approx(run["frames"][index]["body"][:3], abs=1e-9)
    assert page.evaluate(BODY)[0] > page.evaluate(GHOST)[0], "the faster one is ahead"
    assert page.evaluate("() => player.stage.last_drawn_step") == 12


def test_between_two_frames_the_pose_is_between(page: Page, runs: list[dict[str, Any]]) -> None:
    a, b = runs[0]["frames"][10:12]
    page.evaluate("(t) => player.seek(t)", 0.5 * (a["t"] + b["t"]))
    middle = [0.5 * (p + q) for p, q in zip(a["body"][:3], b["body"][:3], strict=True)]
    assert page.evaluate(BODY) == pytest.approx(middle, abs=1e-9)


def test_scene_is_turned_once_from_deck_axes_to_those_of_the_picture(page: Page) -> None:
    turned = page.evaluate(
        "() => { const v = player.stage.cameras.camera.position.clone().set(1, 2, 3); "
        "player.stage.root.updateMatrixWorld(); return player.stage.root.localToWorld(v).toArray(); }"
    )
    assert turned == pytest.approx([1.0, -3.0, 2.0])


def test_keys_and_buttons(page: Page) -> None:
    page.evaluate("() => { player.seek(0); player.root.focus(); }")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("() => player.time") == pytest.approx(1.0)
    page.keyboard.press("Shift+ArrowLeft")
    assert page.evaluate("() => player.time") == pytest.approx(0.9)
    page.keyboard.press("End")
    assert page.evaluate("() => player.time === player.end")
    page.keyboard.press("Home")
    page.keyboard.press("Space")
    assert page.get_by_role("button", name="Pause").is_visible()
    page.wait_for_function("() => player.time > player.start")
    page.keyboard.press("Space")
    stopped = page.evaluate("() => player.time")
    assert not page.evaluate("() => player.playing")
    page.get_by_role("button", name="From above").click()
    assert page.evaluate("() => player.stage.cameras.name") == "top"
    assert page.get_by_role("button", name="From above").get_attribute("aria-pressed") == "true"
    assert page.evaluate("() => player.time") == stopped


def test_moment_leads_to_its_time(page: Page, runs: list[dict[str, Any]]) -> None:
    page.get_by_role("button", name="a peak of slow").click()
    assert page.evaluate("() => player.time") == pytest.approx(runs[1]["moments"][0]["time_s"])


def test_live_frames_are_drawn_one_interval_later(page: Page, runs: list[dict[str, Any]]) -> None:
    told = page.evaluate(
        """async (frames) => {
          const { Timeline, blankPose } = await import("/page/scene/interpolate.js");
          const line = new Timeline();
          const pose = blankPose();
          const drawn = [];
          frames.forEach((frame, i) => {
            const now = 50 + 0.1 * i + 0.01 * (i % 3);  // messages do not come evenly
            line.push(frame, now);
            for (const s of [0, 0.03, 0.06]) { line.pose(now + s, pose); drawn.push([now + s, pose.t]); }
          });
          const again = { ...frames[0] };  // a new episode begins
          line.push(again, 60);
          line.pose(60, pose);
          return { drawn, restart: pose.t };
        }""",
        runs[0]["frames"],
    )
    late = [now - 50.0 - t for now, t in told["drawn"][15:]]
    assert min(late) > 0.07
    assert max(late) < 0.16
    times = [t for _, t in told["drawn"]]
    assert times == sorted(times), "the picture never goes back"
    assert told["restart"] == 0.0


def test_without_webgl_there_is_a_sentence(browser: Browser, address: str) -> None:
    page, troubles = watched(browser)
    page.add_init_script(
        "const real = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
        "  return kind.startsWith('webgl') ? null : real.call(this, kind, ...rest); };"
    )
    page.goto(address)
    page.wait_for_function(LOADED)
    assert "WebGL is missing" in page.locator(".stage-note").inner_text()
    page.evaluate("() => player.seek(1)")
    assert "1.0 s of" in page.locator("output").inner_text()
    assert not [text for text in troubles if "WebGL" not in text]
    page.close()


def test_one_file_needs_no_server(browser: Browser, runs: list[dict[str, Any]], tmp_path: Path) -> None:
    path = tmp_path / "runs.html"
    path.write_text(single_page([{**runs[0], "name": "</script><b>fast"}]), encoding="utf-8")
    page, troubles = watched(browser)
    page.goto(path.as_uri() + "?quality=5")
    page.wait_for_function(LOADED)
    page.evaluate("() => player.seek(1)")
    assert page.evaluate(BODY) == pytest.approx(runs[0]["frames"][10]["body"][:3], abs=1e-9)
    assert "</script><b>fast" in page.locator(".player-legend").inner_text()
    assert not troubles, troubles
    page.close()
