"""Copies go on exactly where the secured helicopter is, and are judged by the task's limits."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.envs.limits import LIMITS
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.monitor import Monitor
from ssmash_gym.monitor.judging import FAILURE, JUDGED, NONE, judged
from ssmash_gym.monitor.rehearsal import Copies, Scene, Shadow
from ssmash_gym.ship.motion import MotionTable
from tests.monitor.decks import motion, quick


def piece(start_s: float, length_s: float, ramp_s: float = 0.0) -> MotionTable:
    return motion(rough=True).bake(length_s, start_s=start_s, ramp_s=ramp_s)


def test_a_copy_that_holds_still_does_what_the_secured_helicopter_does() -> None:
    scene = Scene.of(quick(policy="hold", limits={"probe_in_plane_kN": 70.0, "lift_off_kN": 0.0}))
    shadow = Shadow(scene)
    shadow.advance(piece(0.0, 12.0, ramp_s=8.0).nodes[np.newaxis], 120)
    copies = Copies(scene, 3, 1)
    ahead = piece(12.0, 6.0).nodes
    here, other = shadow.snapshot(), motion(rough=True, seed=9).bake(6.0).nodes
    found = copies.drive(here, np.zeros(3, np.int64), np.stack([ahead, ahead, other]), 6.0)
    assert np.all(np.isinf(found.first_s)) and found.most is None
    shadow.advance(ahead[np.newaxis], 60)
    batch = copies._core.batch
    np.testing.assert_array_equal(batch.state[:, 0], shadow.batch.state[:, 0])
    np.testing.assert_array_equal(batch.state[:, 1], batch.state[:, 0])
    assert not np.array_equal(batch.state[:, 2], batch.state[:, 0])


def test_the_time_of_the_first_exceedance_and_its_limit_are_kept() -> None:
    scene = Scene.of(quick(limits={"probe_in_plane_kN": 3.0}))
    shadow = Shadow(scene)
    shadow.advance(piece(0.0, 12.0, ramp_s=8.0).nodes[np.newaxis], 120)
    found = Copies(scene, 2, 1).drive(
        shadow.snapshot(), np.zeros(2, np.int64), np.stack([piece(12.0, 20.0).nodes] * 2), 20.0
    )
    assert 1.0 < found.first_s[0] < 20.0
    assert found.first_s[0] == found.first_s[1]
    assert found.most == "probe_in_plane"
    assert found.exceeded(20.0).all() and not found.exceeded(found.first_s[0] - 0.1).any()


def test_copies_do_what_the_task_does() -> None:
    """Without rewards and metrics, and bit for bit the same motion, commands and margins."""
    settings = quick(policy="linear", horizon_s=8.0, limits={"probe_in_plane_kN": 70.0, "lift_off_kN": 0.0})
    scene = Scene.of(settings)
    shadow = Shadow(scene)
    shadow.advance(piece(0.0, 12.0, ramp_s=8.0).nodes[np.newaxis], 120)
    nodes = np.stack([piece(12.0, 8.0).nodes, motion(rough=True, seed=9).bake(8.0).nodes])
    copies = Copies(scene, 2, 1)
    copies.drive(shadow.snapshot(), np.zeros(2, np.int64), nodes, 8.0)
    task = Copies(scene, 2, 1)
    task._handover.hand(shadow.snapshot(), np.zeros(2, np.int64), nodes)
    policy = scene.policy
    seen = task._core.reset(seeds=[0, 0], draws=[scene.draw] * 2).copy()
    policy.reset(2)
    for _ in range(80):
        seen = task._core.step(policy.act(seen)).observation
    np.testing.assert_array_equal(copies._core.batch.state, task._core.batch.state)
    np.testing.assert_array_equal(copies._core.book.peak_probe_N, task._core.book.peak_probe_N)
    assert np.ptp(task._core.batch.telemetry["claw_y"]) > 0.0


def test_judging_tells_the_limit_exceeded_furthest_and_every_failure() -> None:
    margins = {name: np.ones(4) for name in LIMITS}
    margins["probe_in_plane"] = np.array([0.5, -0.1, 0.2, 0.1])
    margins["roll"] = np.array([0.1, -0.3, 0.9, 0.5])
    failed = np.array([False, False, True, False])
    found = judged(margins, failed, np.ones(4, np.bool_))
    assert [JUDGED[k] if k != NONE else None for k in found] == [None, "roll", FAILURE, None]
    within_grace = judged(margins, failed, np.zeros(4, np.bool_))
    assert [JUDGED[k] if k != NONE else None for k in within_grace] == [None, None, FAILURE, None]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"policy": "mppi"}, "planner"),
        ({"policy": "nobody"}, "nobody"),
        ({"helicopter": "nobody"}, "nobody"),
        ({"copies": 1}, "copies = 1 is refused"),
        ({"horizon_s": float("nan")}, "horizon_s"),
        ({"least_past_s": 10.0}, "least_past_s"),
        ({"lateral_m": 5.0}, "lateral"),
        ({"limits": {"roll": 3.0}}, "limits"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        Monitor(quick(**changes))


def test_a_trained_agent_can_drive() -> None:
    assert Scene.of(quick(policy="ppo_traverse")).policy.name == "ppo_traverse"
