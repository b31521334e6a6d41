"""The search of gains: the identified model, its replay, and how candidates are written and judged."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ssmash_gym.agents.laws import Trapezoid
from ssmash_gym.agents.laws_gains import FILE, interpolated

from ssmash_gym.assets import asset_path
from ssmash_gym.document import read_file
from tools import lateral_model, law_search
from tools.lateral_model import AT, DECK, INPUTS, STATE, Recording, Replay, identify, record, regressors
from tools.law_search import LAWS, decoded, encoded, entry, flattened, nested, objective, write

GOOD = {"success": 0.95, "peak_p95_kN": 12.0, "peak_top_tenth_kN": 14.0, "median_time_s": 43.0}


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Two excited episodes."""
    return record(0.1, 2)


class Playback(Trapezoid):
    """Gives the commands of a recording again."""

    terms = ("claw_y",)

    def __init__(self, replay: Replay) -> None:
        super().__init__(replay.task)
        self.recording = replay.recording

    def act(self, observations: np.ndarray, starts: np.ndarray | None = None) -> np.ndarray:
        """The recorded commands of the step."""
        k = int(self._steps[0])
        self._steps += 1
        along = self.recording.speed_m_s[k] / self.task.claw.speed_along_m_s
        return np.stack([along, self.recording.command[k]], axis=1)


def test_the_replay_of_the_recorded_commands_is_the_recorded_episode(recording: Recording) -> None:
    replay = Replay(recording, identify(recording), 0.1)
    found = replay.run(Playback(replay), 1)[0]
    goal = replay.task.goal
    on = recording.running[1:]
    load = 1e4 * np.abs(recording.state[1:, :, AT["probe_fy"]]) * on
    load[: replay.task.grace_steps] = 0.0
    inside = (recording.place_m + 0.1 * recording.speed_m_s > 8.0 - goal.x_tolerance_m) & on
    inside &= np.abs(recording.state[1:, :, AT["yaw"]]) * 0.1 < np.deg2rad(goal.yaw_tolerance_deg)
    inside &= np.abs(recording.state[1:, :, AT["claw_y"]]) * 0.1 < goal.y_tolerance_m
    arrived = [np.flatnonzero(np.convolve(column, np.ones(20), "valid") == 20) for column in inside.T.astype(float)]
    ends = [int(first[0]) + 20 if first.size else len(on) for first in arrived]
    peaks = [np.max(load[:end, k]) for k, end in enumerate(ends)]
    assert found["peak_p95_kN"] == pytest.approx(1e-3 * np.percentile(peaks, 95.0), rel=1e-6)
    assert found["success"] == np.mean([first.size > 0 for first in arrived])


def test_copies_of_a_replay_do_not_meet(recording: Recording) -> None:
    replay = Replay(recording, identify(recording), 0.1)
    law = LAWS["yield"]
    soft, firm = {"k_y": 3e-6, "k_c": 0.1, "k_psi": 0.0}, {"k_y": 1e-6, "k_c": 0.3, "k_psi": 0.1}
    both = {name: np.repeat([soft[name], firm[name]], 2) for name in soft}
    together = replay.run(law.make(replay.task, both), 2)
    assert together == [replay.run(law.make(replay.task, gains), 1)[0] for gains in (soft, firm)]
    assert together[0] != together[1]


def test_a_linear_system_is_found_again() -> None:
    rng = np.random.default_rng(2)
    truth = _lawful(rng)
    steps, count = 300, 12
    command = rng.uniform(-1.0, 1.0, (steps, count))
    speed = rng.uniform(0.1, 0.3, (steps, count))
    state = np.zeros((steps + 1, count, len(STATE)))
    state[0] = rng.standard_normal((count, len(STATE)))
    for k in range(steps):
        before = [command[k - lag] if k >= lag else np.zeros(count) for lag in (0, 1, 2)]
        state[k + 1] = regressors(state[k], (before[0], before[1], before[2]), speed[k]) @ truth.T
        state[k + 1, :, [AT[name] for name in DECK]] += rng.standard_normal((len(DECK), count))
    place = np.full((steps, count), 3.0)
    place[:, 0], place[:, 1], speed[:, 2], place[:, 2] = 0.5, 7.0, 0.0, 7.995
    running = np.ones((steps + 1, count), dtype=np.bool_)
    found = identify(Recording(state, command, speed, place, running))
    helicopter = [AT[name] for name in STATE if name not in DECK]
    np.testing.assert_allclose(found.matrices[1][helicopter], truth[helicopter], atol=5e-3)
    assert np.all(found.explained[1][helicopter] > 0.999)


def _lawful(rng: np.random.Generator) -> np.ndarray:
    """A stable system of the kind that is identified."""
    size = len(STATE)
    matrix = np.zeros((size, size + len(INPUTS)))
    matrix[:, :size] = 0.5 * np.eye(size) + 0.03 * rng.standard_normal((size, size))
    matrix[:, size:] = 0.1 * rng.standard_normal((size, len(INPUTS)))
    matrix[:, AT["claw_y"]] = 0.0
    for name in DECK:
        keep = matrix[AT[name], [AT[deck] for deck in DECK]].copy()
        matrix[AT[name]] = 0.0
        matrix[AT[name], [AT[deck] for deck in DECK]] = keep
    claw = AT["claw_vy"]
    matrix[claw] = 0.0
    matrix[claw, [claw, size, size + 1, size + 2]] = 0.3, 0.1, 0.4, 0.2
    matrix[AT["claw_y"]] = 0.05 * matrix[claw]
    matrix[AT["claw_y"], claw] += 0.05
    matrix[AT["claw_y"], AT["claw_y"]] = 1.0
    return matrix


def test_the_deck_does_not_know_of_the_helicopter_nor_anything_of_where_the_claw_is(recording: Recording) -> None:
    model = identify(recording)
    others = [k for k in range(len(STATE) + len(INPUTS)) if k >= len(STATE) or STATE[k] not in DECK]
    for name in DECK:
        assert not np.any(model.matrices[:, AT[name], others])
    assert not np.any(np.delete(model.matrices, AT["claw_y"], axis=1)[:, :, AT["claw_y"]])


def test_the_committed_model_explains_the_load() -> None:
    document = read_file(asset_path("agents", "data", "lateral_model.yaml"))
    assert document["columns"] == [*STATE, *INPUTS]
    assert list(document["models"]) == ["begin", "way", "end", "standing"]
    for model in document["models"].values():
        assert model["explained"]["probe_fy"] > 0.99
        assert model["explained"]["yaw"] > 0.999
        assert [len(row) for row in model["rows"].values()] == [len(STATE) + len(INPUTS)] * len(STATE)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_gains_become_points_and_points_gains(name: str) -> None:
    law = LAWS[name]
    points = np.random.default_rng(1).standard_normal((3, len(law.space)))
    gains = decoded(law, points)
    for i, point in enumerate(points):
        flat = {key: float(values[i]) for key, values in gains.items()}
        np.testing.assert_allclose(encoded(law, flat), point, atol=1e-9)
        assert flattened(nested(flat)) == flat
    for row in read_file(asset_path(*FILE))["laws"][name]:
        assert set(flattened(row["gains"])) == set(law.space)


def test_a_candidate_pays_for_load_failures_and_time() -> None:
    assert objective(GOOD) == 13.0
    assert objective(GOOD | {"peak_p95_kN": 13.0}) == 13.5
    assert objective(GOOD | {"success": 0.85}) == pytest.approx(19.0)
    assert objective(GOOD | {"median_time_s": 48.0}) == pytest.approx(16.0)


def test_the_models_meet_at_their_places() -> None:
    np.testing.assert_array_equal(lateral_model.part_of(np.array([0.0, 0.89, 3.0, 7.0, 8.0])), [0, 0, 1, 2, 3])


GAINS = {"k_y": 1e-6, "k_c": 0.1, "k_psi": 0.01}
ROWS = [{"delay_s": delay_s, "gains": GAINS | {"k_c": 0.1 + delay_s}} for delay_s in (0.0, 0.1, 0.2)]


def judged(
    monkeypatch: pytest.MonkeyPatch, success: float, delay_s: float = 0.1, afresh: bool = False
) -> tuple[dict[str, Any], list[float]]:
    """A row of a search that proposes one finalist, and each k_c that was driven in sea state 5; nothing is driven."""
    tried: list[float] = []

    def driven(law: object, task: object, gains: Mapping[str, float], state: int, options: object) -> dict[str, float]:
        tried.extend([gains["k_c"]] if state == 5 else [])
        return {"episodes": 4, "success": success, "peak_p95_kN": 10.0 + gains["k_c"], "median_time_s": 43.0}

    def searched(law: object, replay: object, begin: np.ndarray, options: object) -> Sequence[Mapping[str, float]]:
        tried.append(float(begin[1]))
        return [GAINS | {"k_c": 0.9}]

    for name in ("record", "identify", "Replay"):
        monkeypatch.setattr(law_search, name, lambda *_: None)
    monkeypatch.setattr(law_search, "searched", searched)
    monkeypatch.setattr(law_search, "driven", driven)
    row = entry("yield", delay_s, ROWS, Namespace(afresh=afresh, episodes=2, threads=1, rounds=3))
    return row, tried


@pytest.mark.parametrize("delay_s", [0.0, 0.1, 0.2])
def test_the_gains_that_the_file_holds_for_the_same_delay_are_a_finalist(
    delay_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    row, (begin, *tried) = judged(monkeypatch, 0.97, delay_s)
    assert begin == pytest.approx(encoded(LAWS["yield"], GAINS | {"k_c": 0.1 + delay_s})[1])
    assert tried == [0.9, 0.1 + delay_s]
    assert row["gains"]["k_c"] == 0.1 + delay_s
    assert row["found"]["fits"] is True


def test_a_search_afresh_and_one_of_another_delay_have_no_such_finalist(monkeypatch: pytest.MonkeyPatch) -> None:
    assert judged(monkeypatch, 0.97, afresh=True)[1] == [0.0, 0.9]
    assert judged(monkeypatch, 0.97, delay_s=0.3)[1][1:] == [0.9]


def test_gains_that_do_not_fit_are_told_and_marked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    row, _ = judged(monkeypatch, 0.9)
    assert row["found"]["fits"] is False
    assert "no finalist reaches 95.5 % within 47.5 s" in capsys.readouterr().out
    write(tmp_path / "gains.yaml", "yield", row)
    document = read_file(tmp_path / "gains.yaml")
    assert document["laws"]["yield"] == [row]
    assert "found.fits is false" in document["provenance"]["objective"]
    assert interpolated(document["laws"]["yield"], 0.1) == row["gains"]  # as the laws read it
