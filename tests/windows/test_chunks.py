"""Episodes of a window: bit for bit those of the environment, however they are put together; what is read of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.given import observed
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.study_entrants import Entrant
from ssmash_gym.windows.chunks import Chunk, Job, Worker
from ssmash_gym.windows.config import load_window
from ssmash_gym.windows.criteria import CRITERIA, columns_read, judged, names_of
from ssmash_gym.windows.peaks import COLUMNS, PeakBook
from ssmash_gym.windows.sweep import prepared

TASK = {
    "base": "traverse", "horizon_s": 8.0, "grace_s": 0.5, "track": {"goal_x_m": 0.4},
    "lead_in": {"duration_s": 1.0, "ramp_s": 1.0},
}  # fmt: skip
WINDOW: dict[str, Any] = {
    "seed": 5, "scenario": "ss5", "task": TASK, "stages": ["traverse", "secured", "touchdown"],
    "policies": ["trapezoid", "linear", "ppo_traverse"],
    "axes": {"sea_state": [3, 6], "waves_from_deg": [0, 100]}, "limits": {"probe_in_plane_kN": 6.0},
    "effort": {"seeds": 3, "most": 3},
}  # fmt: skip


@pytest.fixture(scope="module")
def job() -> Job:
    return prepared(load_window(WINDOW), "small").job


@pytest.fixture(scope="module")
def worker(job: Job) -> Worker:
    return Worker(job)


def chunk(*places: tuple[int, int], stage: str = "traverse", policies: tuple[str, ...] = ("trapezoid",)) -> Chunk:
    return Chunk(stage, policies, tuple(cell for cell, _ in places), tuple(number for _, number in places))


def pieces(rows: pl.DataFrame) -> Iterator[tuple[tuple[Any, ...], dict[str, Any]]]:
    for row in rows.iter_rows(named=True):
        yield (row["policy"], row["cell"], row["number"]), row


def test_an_episode_is_the_environments_own(job: Job, worker: Worker) -> None:
    """Shared sea, shared start, a policy before it, neighbours: no number differs from the episode run by itself."""
    names = ("trapezoid", "linear", "ppo_traverse")
    rows = worker.run(chunk((1, 0), (2, 0), (3, 2), policies=names))
    setting = job.settings["traverse"]
    for name in names:
        policy = job.entrants["traverse"][name].make(setting.task)
        for cell, number in ((1, 0), (3, 2)):
            scenario = setting.of(job.grid.cell(cell))
            alone = run_episodes(policy, scenario, [job.seeds[number]], helicopter=setting.helicopter)
            here = rows.filter(policy=name, cell=cell, number=number)
            shared = [column for column in alone.columns if column in here.columns]
            assert len(shared) > 20 and here.select(shared).equals(alone.select(shared))


class Made:
    """A policy of made-up commands with a memory, in whatever task."""

    def __init__(self, name: str, task: TaskConfig) -> None:
        self.name, self.task = name, task
        self._memory = np.zeros((0, 2))

    def reset(self, count: int) -> None:
        self._memory = np.zeros((count, 2))

    def act(self, observations: Any, starts: Any = None) -> Any:
        size = observations.shape[1]
        weights = np.sin(np.arange(2 * size)).reshape(2, size)
        seen = np.stack([(observations * row).sum(axis=1) for row in weights], axis=1)
        self._memory = 0.5 * self._memory + np.tanh(seen)
        return np.clip(0.3 * self._memory + [0.3, 0.0], -1.0, 1.0).astype(np.float32)


def entrant(name: str, observation: str, baseline: str | None) -> Entrant:
    def make(task: TaskConfig) -> Made:
        residual = None if baseline is None else {"baseline": baseline, "along": 0.3, "across": 0.5}
        return Made(
            name, load_task(observed(load_task(task.model_dump(mode="json") | {"residual": residual}), observation))
        )

    return Entrant(name, None, "agent", name, make)


def test_policies_that_observe_differently_share_their_seas_and_nothing_else() -> None:
    """Forecasts, the true future, residual actions, weak drives, noise and delays: as alone, whoever drove before."""
    document = {**WINDOW, "stages": ["traverse"], "scenario": "hard", "policies": ["trapezoid"]}
    job = prepared(load_window({**document, "axes": {"friction_factor": [0.5, 1.0]}}), "mixed", size=5).job
    kinds = {"sensors": None, "forecast": None, "oracle": None, "full": "linear"}
    others = {name: entrant(name, name, baseline) for name, baseline in kinds.items()}
    entrants = {**job.entrants["traverse"], **others}
    mixed, setting = replace(job, entrants={"traverse": entrants}), job.settings["traverse"]
    rows = Worker(mixed).run(chunk((0, 0), (1, 1), policies=("trapezoid", *others)))
    for name in others:
        for cell, number in ((0, 0), (1, 1)):
            scenario = setting.of(job.grid.cell(cell))
            policy = entrants[name].make(setting.task)
            alone = run_episodes(policy, scenario, [job.seeds[number]], helicopter=setting.helicopter)
            here = rows.filter(policy=name, cell=cell, number=number)
            shared = [column for column in alone.columns if column in here.columns]
            assert here.select(shared).equals(alone.select(shared)), name


def test_a_planner_gets_helicopters_of_its_own(job: Job) -> None:
    """It looks at the whole of its batch, so it must not see those of a larger chunk; nor does it disturb others."""
    brief = {**WINDOW, "stages": ["traverse"], "policies": ["linear", "mppi"], "task": {**TASK, "horizon_s": 1.5}}
    made = prepared(load_window(brief), "planned").job
    worker = Worker(made)
    whole = dict(pieces(worker.run(chunk((0, 0), (3, 1), (2, 0), policies=("linear", "mppi")))))
    for key, row in pieces(worker.run(chunk((3, 1), policies=("mppi", "linear")))):
        assert row == whole[key]


@pytest.mark.parametrize("stage", ["traverse", "secured", "touchdown"])
def test_rows_do_not_depend_on_how_they_are_chunked(job: Job, worker: Worker, stage: str) -> None:
    policies = ("trapezoid", "ppo_traverse") if stage == "traverse" else ("hold",)
    places = [(cell, number) for cell in range(4) for number in range(3)]
    whole = dict(pieces(worker.run(chunk(*places, stage=stage, policies=policies))))
    apart = Worker(replace(job, size=5))
    for part, who in ((places[7:12], policies), (places[3:4], policies[-1:]), (places[0:3][::-1], policies[::-1])):
        for key, row in pieces(apart.run(chunk(*part, stage=stage, policies=who))):
            assert row == whole[key]


def test_common_random_numbers(worker: Worker) -> None:
    """The same number is the same draw in every cell and for every policy, but for what the cell sets."""
    rows = worker.run(chunk((0, 1), (3, 1), policies=("trapezoid", "linear")))
    assert rows["seed"].n_unique() == 1
    seas = [name for name in rows.columns if name.startswith("sea_")]
    by_policy = [rows.filter(policy=name).select(seas) for name in ("trapezoid", "linear")]
    assert by_policy[0].equals(by_policy[1])
    assert rows.filter(policy="trapezoid")["sea_hs_m"].to_list() == [0.9, 5.0]


def test_peaks_are_the_extremes_over_all_substeps(worker: Worker, job: Job) -> None:
    setting = job.settings["secured"]
    core = TraverseBatch(2, task=setting.task, scenario=setting.of(job.grid.cell(3)), helicopter=setting.helicopter)
    core.reset(seeds=list(job.seeds[:2]))
    book = PeakBook(core, 2)
    tilt, compression = np.zeros(2), np.zeros(2)
    running, stroke = np.arange(2), setting.helicopter.stations.right.end_stop.stroke_m
    while running.size:
        result = core.step(np.zeros((running.size, 2)), running)
        assert core.reading is not None
        book.note(core.reading, running)
        told = core.telemetry
        along, across, down = (told[f"deck_f{axis}"] for axis in "xyz")
        tilt = np.maximum(tilt, np.degrees(np.arctan(np.hypot(along, across) / -down * np.sign(-down))))
        compression = np.maximum(compression, told.peak_max("right_compression"))
        running = running[~(result.terminated | result.truncated)]
    found = book.columns()
    assert set(found) == set(COLUMNS)
    assert found["peak_deck_tilt_deg"] == pytest.approx(tilt, rel=1e-12)
    assert np.all(found["peak_oleo_share"] >= compression / stroke)
    rows = worker.run(chunk((3, 0), (3, 1), stage="secured", policies=("hold",)))
    for name in COLUMNS:
        assert rows[name].to_list() == found[name].tolist()


def test_locked_wheels_on_a_still_deck_do_not_slide_and_a_slippery_steep_one_does() -> None:
    """The distance slid is that of the contact points where friction gives in, and nothing where it does not."""
    still = load_scenario("flat")
    steep = load_scenario(
        {"base": "flat", "motion": {"type": "fixed", "heel_deg": 12.0}, "helicopter": {"friction_factor": 0.12}}
    )
    slid = []
    for scenario in (still, steep):
        core = TraverseBatch(1, task={**TASK, "wheels": "locked"}, scenario=scenario)
        core.reset(seeds=[0])
        book, start = PeakBook(core, 1), core.telemetry["right_contact_y"]
        for _ in range(20):
            result = core.step(np.zeros((1, 2)))
            assert core.reading is not None
            book.note(core.reading, np.arange(1))
            if result.terminated[0]:
                break
        way = float(np.abs(core.telemetry["right_contact_y"] - start)[0])
        slid.append((float(book.columns()["sliding_m"][0]), way))
    assert slid[0][0] == 0.0
    assert slid[1][0] >= 0.9 * slid[1][1] > 0.0


def test_every_limit_reads_a_column_of_the_rows(worker: Worker) -> None:
    rows = worker.run(chunk((0, 0), (3, 0)))
    assert set(columns_read(dict.fromkeys(CRITERIA, 1.0))) <= set(rows.columns)
    for name, one in CRITERIA.items():
        for figure, beyond in ((1e9, one.sense == "below"), (-1e9, one.sense == "above")):
            assert judged(rows, {name: figure}, must_arrive=False)[f"over_{name}"].to_list() == [beyond, beyond]


def test_what_is_no_number_is_beyond_and_the_lost_exceed_in_any_case() -> None:
    rows = pl.DataFrame(
        {
            "peak_probe_kN": [3.0, float("nan"), 3.0, 3.0, 15.0], "least_station_kN": [5.0, 5.0, 5.0, 5.0, 2.0],
            "failed": [False, False, True, False, False], "success": [True, True, False, False, True],
        }
    )  # fmt: skip
    limits = {"probe_in_plane_kN": 15.0, "least_station_kN": 2.0}
    found = judged(rows, limits, must_arrive=True)
    assert found["exceeded"].to_list() == [False, True, True, True, False]  # at the limit is within
    assert judged(rows, limits, must_arrive=False)["exceeded"].to_list() == [False, True, True, False, False]
    assert found["over_goal"].to_list() == [False, False, False, True, False]
    assert found["worst_use"][4] == pytest.approx(1.0)
    assert names_of(limits, must_arrive=True) == [*limits, "lost", "goal"]


def test_a_harder_touchdown_loads_the_gear_more() -> None:
    document = {**WINDOW, "stages": ["touchdown"], "axes": {"sink_rate_m_s": [0.3, 1.0, 2.5]}, "scenario": "calm"}
    job = prepared(load_window(document), "drops").job
    rows = Worker(job).run(chunk((0, 0), (1, 0), (2, 0), stage="touchdown", policies=("hold",)))
    loads = rows["peak_main_kN"].to_list()
    assert loads == sorted(loads) and loads[2] > 1.3 * loads[0]
    assert rows["peak_probe_kN_no_grace"].to_list() == [0.0, 0.0, 0.0]  # the probe is free
    assert rows["reason"].to_list() == ["time"] * 3
