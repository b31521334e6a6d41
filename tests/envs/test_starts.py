"""How an episode starts: the draw in the parameters, the rest on the deck, the prepared starts."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import Par, State
from ssmash_gym.envs import load_scenario, load_task
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.starts import Starter, relative_wind, varied, vary
from ssmash_gym.envs.vector import TraverseVectorEnv
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed, Motion, parse_motion, write_shipmo
from ssmash_gym.simulation.parameters import parameter_column
from ssmash_gym.vehicle import load_helicopter

SHORT: dict[str, Any] = {"horizon_s": 0.5}


def flat_draw(**changes: Any) -> EpisodeDraw:
    return replace(load_scenario("flat").sample(np.random.default_rng(0)), **changes)


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_rows_are_varied_as_the_description_would_be(name: str) -> None:
    """The quick way through parameter rows gives what the validated description gives."""
    helicopter = load_helicopter(name)
    draw = flat_draw(
        helicopter_mass_factor=1.07, helicopter_cg_x_m=0.04, helicopter_cg_y_m=-0.02, helicopter_cg_z_m=0.03,
        helicopter_friction_factor=0.8, helicopter_pressure_factor=0.93,
    )  # fmt: skip
    column = parameter_column(helicopter)
    plain = column.copy()
    vary(column, draw)
    assert column == pytest.approx(parameter_column(varied(helicopter, draw)), rel=1e-14, abs=1e-15)
    assert np.count_nonzero(column != plain) > 20


def test_relative_wind() -> None:
    """True wind from ahead and the ship's own speed add up; a beam wind from starboard blows to port."""
    ahead = flat_draw(wind_speed_mps=10.0, wind_from_deg=0.0, wind_ship_speed_mps=5.0)
    assert relative_wind(ahead) == pytest.approx([-15.0, 0.0, 0.0])
    starboard = flat_draw(wind_speed_mps=10.0, wind_from_deg=90.0)
    assert relative_wind(starboard) == pytest.approx([0.0, -10.0, 0.0])


def test_claw_and_wind_rows() -> None:
    starter = Starter(load_helicopter("generic_tricycle"), load_task(), load_scenario())
    given = {"claw_delay_s": 0.1513, "claw_ripple_along_m": 0.002, "claw_ripple_across_m": None}
    column = starter.column(flat_draw(**given))
    assert column[Par.CLAW_DELAY] == pytest.approx(0.152)  # whole substeps
    assert column[Par.RIPPLE_X] == 0.002 and column[Par.RIPPLE_Y] == 0.0
    assert column[Par.CLAW_SPEED_X] == 0.3


def test_set_down_is_settled() -> None:
    """After the lead-in the quick start on a level deck is where the full search for equilibrium leads, and at rest."""
    task = load_task(SHORT)
    starter = Starter(load_helicopter("generic_tricycle"), task, load_scenario("flat"))
    draw = flat_draw(
        start_yaw_deg=6.0, start_lateral_m=0.08, helicopter_mass_factor=1.05, helicopter_cg_x_m=0.05,
        helicopter_cg_y_m=0.02, helicopter_pressure_factor=0.95,
    )  # fmt: skip
    quick, exact = starter.batch(1, 1), starter.batch(1, 1)
    column = np.array([0])
    starter.start(quick, column, [draw])
    exact.parameters[:, 0] = starter.column(draw)
    exact.place(0.0, 0.08, np.deg2rad(6.0))
    exact.advance(None, intervals=task.lead_in_steps)
    assert np.max(np.abs(quick.state[: State.Q8])) < 2e-4
    change = np.abs(quick.state - exact.state)[: State.CLAW_X, 0]
    assert np.max(change) < 1e-3
    telemetry = quick.telemetry
    assert telemetry["probe_in_plane"][0] < 150.0
    for station in ("auxiliary", "right", "left"):
        load = telemetry[f"{station}_vertical_load"][0]
        assert load == pytest.approx(exact.telemetry[f"{station}_vertical_load"][0], rel=1e-3)
    assert telemetry["yaw"][0] == pytest.approx(np.deg2rad(6.0), abs=1e-3)
    assert (telemetry["probe_x"][0], telemetry["probe_y"][0]) == pytest.approx((0.0, 0.08), abs=1e-3)
    assert (telemetry["claw_x"][0], telemetry["claw_y"][0]) == (0.0, 0.08)


def test_a_heeled_deck_is_settled_too() -> None:
    env = TraverseBatch(1, task=SHORT, scenario={"base": "flat", "motion": {"type": "fixed", "heel_deg": 3.0}})
    env.reset(seeds=[0])
    telemetry = env.telemetry
    assert np.max(np.abs(env.batch.state[: State.Q8])) < 1e-3
    assert telemetry["right_vertical_load"][0] > telemetry["left_vertical_load"][0] + 5e3
    assert telemetry["deck_roll"][0] == pytest.approx(np.deg2rad(3.0))


@pytest.mark.parametrize(
    ("task", "scenario", "words"),
    [
        ({}, {"start": {"lateral_m": 0.5}}, "start.lateral_m"),
        ({}, {"helicopter": {"cg_z_m": 3.0}}, "cg_offset_m"),
    ],
)
def test_bad_ranges_are_refused_before_the_first_episode(task: Any, scenario: Any, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        Starter(load_helicopter("generic_tricycle"), load_task(task), load_scenario(scenario))


def test_wheels() -> None:
    """Braked mains and a locked castor are options of the task; each reaches the parameters."""
    from ssmash_gym.dynamics.layout import STATION_ROWS, Sta

    def rows(wheels: str) -> tuple[float, float, float]:
        column = Starter(load_helicopter("generic_tricycle"), load_task({"wheels": wheels}), load_scenario())._column
        right = Par.STATION + STATION_ROWS
        return column[Par.LOCK + State.U14], column[right + Sta.ROLL_LOCK], column[right + STATION_ROWS + Sta.ROLL_LOCK]

    assert (rows("rolling"), rows("braked"), rows("locked")) == ((0.0, 0.0, 0.0), (0.0, 1.0, 1.0), (1.0, 0.0, 0.0))


def test_prepared_starts_change_nothing() -> None:
    """Columns that end at different times get their starts from the nursery: the single environment's bits."""
    arguments: dict[str, Any] = {"task": {"horizon_s": 0.4, "lead_in": {"duration_s": 4.0, "ramp_s": 3.0}}}
    large = TraverseVectorEnv(9, autoreset_mode="Disabled", threads=1, **arguments)
    large.reset(seed=40)
    served = large.core._nursery
    prepared = 0
    first: dict[int, list[Any]] = {k: [] for k in range(9)}
    for episode in range(3):
        for k in (4, 0, 8, 3, 5, 1, 7, 2, 6):
            mask = np.arange(9) == k
            observation, _ = large.reset(options={"reset_mask": mask})
            first[k].append(observation[k])
            prepared += len(served._children)
        assert prepared > 0, episode
    for k in (0, 4, 6):
        single = TraverseBatch(1, **arguments)
        single.reset(seeds=[40 + k])
        for observation in first[k]:
            assert np.array_equal(single.reset()[0], observation)


def test_a_new_seed_discards_what_was_prepared() -> None:
    arguments: dict[str, Any] = {"task": {"horizon_s": 0.4, "lead_in": {"duration_s": 4.0, "ramp_s": 3.0}}}
    large = TraverseVectorEnv(9, autoreset_mode="Disabled", threads=1, **arguments)
    large.reset(seed=40)
    large.reset(options={"reset_mask": np.arange(9) == 2})
    assert 7 in large.core._nursery._children
    observation, _ = large.reset(seed=[99] * 9, options={"reset_mask": np.arange(9) == 7})
    assert np.array_equal(observation[7], TraverseBatch(1, **arguments).reset(seeds=[99])[0])


def test_a_gust_goes_with_the_true_wind() -> None:
    """Direction in the parameters; a table of the drawn intensity from the motion's seed, and none without gusts."""
    starter = Starter(load_helicopter("generic_tricycle"), load_task(), load_scenario())
    draw = flat_draw(wind_from_deg=90.0, wind_speed_mps=12.0, wind_gust_intensity=0.15)
    assert starter.column(draw)[Par.GUST : Par.GUST + 3] == pytest.approx([0.0, -1.0, 0.0])
    tables = [starter.decks.gusts(replace(draw, motion_seed=seed)) for seed in range(40)]
    speeds = np.array([table.nodes[:, 0] for table in tables if table is not None])
    assert len(speeds) == 40
    ramp = round(starter.task.lead_in.ramp_s / starter.timing.node_spacing_s)
    assert np.std(speeds[:, ramp:]) == pytest.approx(0.15 * 12.0, rel=0.1)
    assert not speeds[:, 0].any()
    again = starter.decks.gusts(replace(draw, motion_seed=3))
    assert again is not None and np.array_equal(again.nodes[:, 0], speeds[3])
    for calm in ({"wind_gust_intensity": 0.0}, {"wind_speed_mps": 0.0}):
        still = replace(draw, **calm)
        assert starter.decks.gusts(still) is None
        assert not starter.column(still)[Par.GUST : Par.GUST + 3].any()


SEA: dict[str, Any] = {"motion": {"components": 24}}  # of the training scenario
SINE: dict[str, Any] = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 3.0, "period_s": 6.0}


def test_the_same_seed_is_the_same_sea_whatever_the_batch_and_the_threads() -> None:
    """Deck tables, gusts and wind bit for bit, alone, in a crowd, and prepared ahead."""
    deck, gusts, wind = [], [], []
    for n, threads in ((1, 1), (9, 1), (9, 2)):
        env = TraverseBatch(n, task=SHORT, scenario=SEA, threads=threads)
        env.reset(seeds=[70 + k for k in range(n)])
        env.reset([0])  # its next episode: from the nursery in a larger batch
        for found, nodes in ((deck, env.batch.nodes[0]), (gusts, env.batch.gust_nodes[0])):
            moving = nodes[:, nodes.shape[1] // 3 :].any(axis=1)
            found.append(nodes[: np.flatnonzero(moving)[-1] + 1].copy())
        wind.append(env.batch.parameters[Par.WIND : Par.GUST + 3, 0].copy())
    for tables in (deck, gusts, wind):
        assert tables[0].any()
        for other in tables[1:]:
            assert np.array_equal(tables[0], other)


def test_the_severity_of_the_sea_is_among_the_metrics() -> None:
    """Long-run figures of the drawn sea: the same after a copy, a fork and a prepared start."""
    env = TraverseBatch(6, task=SHORT, scenario={"motion": {**SEA["motion"], "hs_m": {"choice": [0.5, 5.0]}}})

    def ends(batch: TraverseBatch) -> list[dict[str, Any]]:
        while not batch.book.over.all():
            result = batch.step(np.zeros((batch.n, 2)))
        return [result.endings[k]["episode_metrics"] for k in range(batch.n)]

    env.reset(seeds=list(range(6)))
    env.step(np.zeros((6, 2)))
    copies, kept = env.fork(2), env.snapshot()
    first = ends(env)
    for k, draw in enumerate(env.draws):
        assert draw is not None
        motion = parse_motion(draw.motion).realise(np.random.default_rng(draw.motion_seed))
        found = {name: value for name, value in first[k].items() if name.startswith("sea_")}
        severity = motion.deck_rms()
        assert found == {
            "sea_lateral_g": severity.lateral_specific_force_g,
            "sea_roll_deg": severity.roll_deg,
            "sea_pitch_deg": severity.pitch_deg,
            "sea_vertical_velocity_m_s": severity.vertical_velocity_m_s,
            **{f"sea_{key}": draw.motion[key] for key in ("hs_m", "heading_deg", "speed_kn")},
        }
        assert first[k]["within_validity"] is (motion.outside_validity is None)
    assert {metrics["sea_hs_m"] for metrics in first} == {0.5, 5.0}
    assert ends(copies) == [metrics for metrics in first for _ in range(2)]
    other = TraverseBatch(6, task=SHORT, scenario=env.scenario)
    other.restore(kept)
    assert ends(other) == first


def test_a_sea_that_rolls_too_much_is_flagged() -> None:
    sea = {"type": "seaway", "hs_m": 5.0, "heading_deg": 90.0, "speed_kn": 0.0, "components": 24}
    found = []
    for damping in (0.5, 2.0):
        motion = {**sea, "roll_damping_factor": damping}
        env = TraverseBatch(1, task=SHORT, scenario={"base": "flat", "motion": motion})
        env.reset(seeds=[0])
        assert env.draws[0] is not None
        found.append(env.starter.decks.figures(env.draws[0]))
    assert found[0].roll_deg > 6.0 > found[1].roll_deg
    assert [figures.within_validity for figures in found] == [False, True]


def test_motions_without_a_sea_have_figures_too() -> None:
    env = TraverseBatch(1, task=SHORT, scenario="irregular")
    env.reset(seeds=[0])
    draw = env.draws[0]
    assert draw is not None
    found = env.starter.decks.figures(draw)
    assert found.roll_deg == pytest.approx(draw.motion["roll"]["rms_deg"], rel=1e-12)  # of the long run
    assert found.hs_m is None and found.within_validity and found.lateral_g > 0.01
    other = env.starter.decks.figures(replace(draw, motion_seed=draw.motion_seed + 1))
    assert other.lateral_g != found.lateral_g
    still = env.starter.decks.figures(flat_draw())
    assert (still.roll_deg, still.lateral_g) == (0.0, 0.0)
    assert [still.metrics()[f"sea_{key}"] for key in ("hs_m", "heading_deg", "speed_kn")] == [None] * 3


def test_what_is_the_same_for_every_seed_is_worked_out_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A record is sampled for its figures once, whatever the seed and the start; a drawn motion never is."""
    sampled: list[Motion] = []
    real = Motion.deck_rms
    monkeypatch.setattr(Motion, "deck_rms", lambda motion, *more: sampled.append(motion) or real(motion, *more))
    path = write_shipmo(tmp_path / "sea.csv", parse_motion(SINE), 0.1, 30.0)
    decks = Starter(load_helicopter("generic_tricycle"), load_task(SHORT), load_scenario("flat")).decks
    record = flat_draw(motion={"type": "file", "path": str(path)})
    found = [
        decks.figures(replace(record, motion_seed=seed, motion={**record.motion, "start_s": float(seed)}))
        for seed in range(3)
    ]
    assert len(sampled) == 1 and found[0] is found[1] is found[2]
    sine = decks.figures(flat_draw(motion=SINE))
    assert sine is decks.figures(flat_draw(motion=SINE, motion_seed=5)) and len(sampled) == 1
    assert found[0].roll_deg == pytest.approx(sine.roll_deg, rel=0.01) == pytest.approx(3.0 / np.sqrt(2.0), rel=0.01)


def test_a_draw_that_its_table_refuses_leaves_everything_as_it_was(tmp_path: Path) -> None:
    """A record that ends too soon is found out when it is baked: generators, draws and physics must not have moved."""
    path = write_shipmo(tmp_path / "short.csv", Fixed(), 0.1, 8.0)
    short = flat_draw(motion={"type": "file", "path": str(path)}, helicopter_mass_factor=1.1, wind_speed_mps=9.0)
    env, other = (TraverseBatch(2, task=SHORT, scenario=SEA, threads=1) for _ in range(2))
    for each in (env, other):
        each.reset(seeds=[0, 1])
        each.step(np.zeros((2, 2)))
    for seeds in (None, [5, 6]):
        with pytest.raises(ConfigurationError, match=r"draw: motion: bake: a table from 0 to .* 0 to 8 s"):
            env.reset(seeds=seeds, draws=[short, None])
    assert env.draws == other.draws
    assert np.array_equal(env.batch.parameters, other.batch.parameters)
    assert np.array_equal(env.batch.nodes, other.batch.nodes)
    a, b = env.step(np.zeros((2, 2))), other.step(np.zeros((2, 2)))
    assert np.array_equal(a.observation, b.observation) and np.array_equal(a.reward, b.reward)
    assert np.array_equal(env.reset(), other.reset())


def test_a_neighbours_refused_draw_stops_nobody_else(monkeypatch: pytest.MonkeyPatch) -> None:
    """Starts are prepared together; one that is refused is told when its own column wants it, and leaves no start."""
    arguments: dict[str, Any] = {"task": {"horizon_s": 0.4, "lead_in": {"duration_s": 4.0, "ramp_s": 3.0}}}
    env, other = (TraverseBatch(9, threads=1, **arguments) for _ in range(2))
    for each in (env, other):
        each.reset(seeds=list(range(9)))
    assert env.generators[7] is not None
    bad = env.scenario.sample(copy.deepcopy(env.generators[7])).motion_seed
    real = env.starter.decks.baked

    def refusing(given: Any, seed: int) -> Any:
        if seed == bad:
            raise ConfigurationError("bake: too fast.")
        return real(given, seed)

    monkeypatch.setattr(env.starter.decks, "baked", refusing)
    assert np.array_equal(env.reset([2]), other.reset([2]))
    for _ in range(2):
        with pytest.raises(ConfigurationError, match="draw: motion: bake: too fast"):
            env.reset([7])
    monkeypatch.undo()
    assert np.array_equal(env.reset([7]), other.reset([7]))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"claw_delay_s": 0.5}, "claw_delay_s = 0.5"),
        ({"claw_delay_s": -0.1}, "delay_s"),
        ({"sensors_delay_s": 0.3}, "sensors_delay_s = 0.3"),
        ({"sensors_noise": 1.0}, "sensors_noise = 1.0"),
        ({"start_lateral_m": 0.5}, "start_lateral_m = 0.5"),
        ({"start_yaw_deg": float("nan")}, "start_yaw_deg = nan"),
        ({"start_yaw_deg": "5"}, "start_yaw_deg = '5'"),
        ({"start_yaw_deg": 120.0}, "yaw_deg"),
        ({"wind_speed_mps": None}, "wind_speed_mps = None"),
        ({"helicopter_mass_factor": 0.0}, "mass_factor"),
        ({"motion": 3}, "motion = 3"),
        ({"motion": {"type": "waves"}}, "type is 'waves'"),
        ({"motion_seed": -1}, "motion_seed = -1"),
        ({"wind_gust_intensity": 2.0}, "gust_intensity"),
        ({"motion": {"type": "seaway", "hs_m": -1.0, "heading_deg": 0.0, "speed_kn": 5.0}}, "hs_m is -1"),
        ({"motion": {"type": "seaway", "hs_m": 1.0, "heading_deg": 0.0, "speed_kn": 5.0}}, "must be the seaway's own"),
    ],
)
def test_a_draw_that_does_not_fit_is_refused_before_anything_starts(changes: dict[str, Any], told: str) -> None:
    env = TraverseBatch(1, task=SHORT, scenario="flat")
    first = env.reset(seeds=[0])
    record = {**flat_draw().to_dict(), **changes}
    for given in (record, flat_draw(**changes)):
        with pytest.raises(ConfigurationError, match=told):
            env.reset(draws=[given])
    with pytest.raises(ConfigurationError, match="draw"):
        env.reset(draws=[5])  # type: ignore[list-item]
    with pytest.raises(ConfigurationError, match="list of 1"):
        env.reset(draws=[])
    assert not env.step([[0.0, 0.0]]).terminated[0]
    assert np.array_equal(env.reset(seeds=[0]), first)


def test_motions_are_tried_at_construction(tmp_path: Path) -> None:
    sine = {"type": "sinusoid", "dof": "roll", "amplitude": 1.0, "period_s": {"uniform": [0.6, 9.0]}}
    with pytest.raises(ConfigurationError, match=r"scenario: motion\.period_s"):
        TraverseBatch(1, task=SHORT, scenario={"base": "flat", "motion": sine})
    sea = {"type": "irregular", "severity": 1.0, "levels": [1.0], "roll": {"rms": [1.0], "period_s": [2.5]}}
    with pytest.raises(ConfigurationError, match=r"scenario: motion\.roll\.period_s"):
        TraverseBatch(1, task=SHORT, scenario={"base": "flat", "motion": sea})
    gone = {"type": "file", "paths": [str(tmp_path / "gone.csv")]}
    with pytest.raises(ConfigurationError, match=r"scenario: motion\.paths"):
        TraverseBatch(1, task=SHORT, scenario={"base": "flat", "motion": gone})
    path = write_shipmo(tmp_path / "short.csv", Fixed(), 0.1, 12.0)
    late = {"type": "file", "paths": [str(path)], "start_s": {"uniform": [0.0, 11.0]}}
    with pytest.raises(ConfigurationError, match=r"scenario: motion\.start_s"):
        TraverseBatch(1, task=SHORT, scenario={"base": "flat", "motion": late})
    way = {"type": "seaway", "ship": "canoe", "hs_m": 1.0, "heading_deg": 0.0, "speed_kn": 5.0}
    for scenario in ({"base": "flat", "motion": way}, {"base": "training", "motion": {"ship": "canoe"}}):
        with pytest.raises(ConfigurationError, match=r"^scenario: motion\.ship .*canoe"):
            TraverseBatch(1, task=SHORT, scenario=scenario)
    with pytest.raises(ConfigurationError, match="euler_order"):
        load_scenario({"base": "flat", "motion": {**gone, "euler_order": "zzz"}})
    with pytest.raises(ConfigurationError, match="count twice"):
        load_scenario({"base": "flat", "motion": {**gone, "detrend": False}, "wind": {"ship_speed_mps": 5.0}})


def test_the_task_may_not_ask_more_of_the_probe_than_it_bears() -> None:
    with pytest.raises(ConfigurationError, match="probe_ultimate_kN = 80"):
        TraverseBatch(1, task={"limits": {"probe_ultimate_kN": 80.0}})


def test_time_left_ends_with_the_steps_and_forks_keep_the_observations() -> None:
    env = TraverseVectorEnv(2, task=SHORT, scenario="training", observation=["time_left", "roll"], max_episode_steps=3)
    first = env.reset(seed=0)[0]
    assert first[:, 0] == pytest.approx([0.3 / 60.0] * 2)
    now = env.step(np.zeros((2, 2)))[0]
    assert now[:, 0] == pytest.approx([0.2 / 60.0] * 2)
    fork = env.fork(2)
    mask = np.array([True, False, False, False])
    assert np.array_equal(fork.reset(options={"reset_mask": mask})[0][1:], np.repeat(now, 2, axis=0)[1:])
