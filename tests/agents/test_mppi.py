"""The two planners: they drive, they depend on no neighbour, and only the clairvoyant one knows the future."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ssmash_gym.agents.clairvoyant import Clairvoyant, ClairvoyantSettings
from ssmash_gym.agents.mppi import Mppi, MppiSettings
from ssmash_gym.agents.planning import PLANNERS
from ssmash_gym.agents.planning_law import Law
from ssmash_gym.agents.planning_linear import LinearSearch
from ssmash_gym.agents.planning_policy import Planner

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError

# A short way, so that a whole episode is quickly rehearsed; too short to straighten a helicopter that landed crooked.
STRAIGHT = load_scenario({"base": "ss5", "start": {"yaw_deg": 0.0, "lateral_m": 0.0}})
SHORT = load_task({"track": {"goal_x_m": 1.2}, "claw": {"x_max_m": 1.2}, "horizon_s": 14.0})
QUICK = ClairvoyantSettings(law=Law(arrival_s=9.0), search=LinearSearch(samples=20), iterations=2)
NOTHING = replace(QUICK, iterations=0)
FEW = MppiSettings(law=Law(arrival_s=9.0), samples=8, horizon_s=2.0)


def commands(planner: Planner, seeds: list[int], steps: int, task: TaskConfig = SHORT) -> np.ndarray:
    """Commands of a planner in the simulation, (steps, n, 2)."""
    core = TraverseBatch(len(seeds), task=task, scenario=STRAIGHT)
    planner.attach(core)
    seen = core.reset(seeds=seeds)
    planner.reset(len(seeds))
    given = []
    for _ in range(steps):
        given.append(planner.act(seen))
        seen = core.step(given[-1]).observation
    return np.array(given)


def ends(planner: Planner, seeds: list[int]) -> list[dict[str, object]]:
    """How episodes end."""
    core = TraverseBatch(len(seeds), task=SHORT, scenario=STRAIGHT)
    planner.attach(core)
    seen = core.reset(seeds=seeds)
    planner.reset(len(seeds))
    found: dict[int, dict[str, object]] = {}
    while (running := np.flatnonzero(~core.book.over)).size:
        result = core.step(planner.act(seen)[running], running)
        seen[running] = result.observation
        found |= {k: ending["episode_metrics"] for k, ending in result.endings.items()}
    return [found[k] for k in range(len(seeds))]


def test_planners_are_found_by_name_and_refuse_to_act_alone() -> None:
    task = load_task("traverse")
    for name, make in PLANNERS.items():
        planner = make(task)
        assert (planner.name, planner.task) == (name, task)
        planner.reset(1)
        with pytest.raises(ConfigurationError, match="attach"):
            planner.act(np.zeros((1, 43), np.float32))


def test_a_planner_refuses_a_batch_of_another_control_interval() -> None:
    with pytest.raises(ConfigurationError, match="control_interval_s"):
        Mppi(SHORT).attach(TraverseBatch(1, task={"control_interval_s": 0.2}, scenario="flat"))


@pytest.mark.parametrize("make", [lambda: Mppi(SHORT, FEW), lambda: Clairvoyant(SHORT, QUICK)])
def test_commands_depend_neither_on_neighbours_nor_on_the_batch(make: object) -> None:
    assert callable(make)
    together = commands(make(), [7, 8, 9], 12)
    np.testing.assert_array_equal(commands(make(), [8], 12)[:, 0], together[:, 1])
    assert np.any(together[:, 0] != together[:, 1])


def test_a_row_that_starts_anew_is_planned_anew() -> None:
    core = TraverseBatch(2, task=SHORT, scenario=STRAIGHT)
    planner = Mppi(SHORT, FEW)
    planner.attach(core)
    seen = core.reset(seeds=[7, 8])
    planner.reset(2)
    first = []
    for _ in range(8):
        first.append(planner.act(seen)[1])
        seen = core.step(np.array([planner.act(seen)[0], first[-1]]) * 0.0).observation
    seen[1] = core.reset([1], seeds=[8])
    again = planner.act(seen, np.array([False, True]))[1]
    np.testing.assert_array_equal(again, first[0])


def test_only_the_clairvoyant_planner_knows_the_future() -> None:
    def first(planner: Planner, spoil: bool) -> np.ndarray:
        core = TraverseBatch(1, task=SHORT, scenario=STRAIGHT)
        planner.attach(core)
        seen = core.reset(seeds=[11])
        planner.reset(1)
        if spoil:
            core.batch.nodes[:, 33:, 12:14] += 0.5
            core.batch.gust_nodes[:, 33:] = 0.0
        return planner.act(seen)

    np.testing.assert_array_equal(first(Mppi(SHORT, FEW), False), first(Mppi(SHORT, FEW), True))
    quick = replace(QUICK, iterations=1)
    assert np.any(first(Clairvoyant(SHORT, quick), False) != first(Clairvoyant(SHORT, quick), True))


def test_the_clairvoyant_plan_lowers_the_peaks_and_arrives() -> None:
    seeds = [21, 22, 23]
    plain, planned = ends(Clairvoyant(SHORT, NOTHING), seeds), ends(Clairvoyant(SHORT, QUICK), seeds)
    peaks = np.array([[e["peak_probe_kN"] for e in some] for some in (plain, planned)], dtype=np.float64)
    assert np.all(peaks[1] < peaks[0])
    assert np.mean(peaks[1]) < 0.8 * np.mean(peaks[0])
    assert all(abs(float(str(e["final_to_go_m"]))) < 0.05 for e in planned)


def test_sampled_plans_lower_the_peaks() -> None:
    seeds = [21, 22, 23]
    settings = replace(FEW, samples=24, horizon_s=4.0)
    plain, planned = ends(Clairvoyant(SHORT, NOTHING), seeds), ends(Mppi(SHORT, settings), seeds)
    peaks = [np.mean([float(str(e["peak_probe_kN"])) for e in some]) for some in (plain, planned)]
    assert peaks[1] < 0.85 * peaks[0]


def test_plans_are_made_in_a_calm_sea_without_gusts() -> None:
    planner = Mppi(SHORT, FEW)
    core = TraverseBatch(1, task=SHORT, scenario=load_scenario("calm"))
    planner.attach(core)
    seen = core.reset(seeds=[1])
    planner.reset(1)
    for _ in range(3):
        command = planner.act(seen)
        assert np.isfinite(command).all()
        seen = core.step(command).observation
