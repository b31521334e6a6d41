"""Fixed, sinusoidal and irregular motion, and the configuration sections they come from."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from pydantic import BaseModel, TypeAdapter

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import (
    CHANNELS,
    DOFS,
    DeckRms,
    Fixed,
    Irregular,
    IrregularRotation,
    Motion,
    MotionConfig,
    MotionFile,
    Signal,
    Sinusoid,
    parse_motion,
)
from ssmash_gym.ship.harmonics import Component, Harmonics, spectrum_bins


def rolling(rms_deg: float = 3.0, period_s: float = 10.0, **other: object) -> Irregular:
    return Irregular.model_validate({"roll": {"rms_deg": rms_deg, "period_s": period_s}, **other})


def test_fixed_deck_stands_still_with_and_without_a_ramp() -> None:
    source = Fixed(roll_deg=5.0, pitch_deg=-2.0, yaw_deg=30.0, x_m=1.0, y_m=2.0, z_m=-3.0)
    table = source.bake(10.0, 0.25)
    expected = [1.0, 2.0, -3.0, *np.radians([5.0, -2.0, 30.0])]
    np.testing.assert_allclose(table.at(3.21).position, expected, rtol=1e-15)
    assert np.all(table.nodes[:, 6:] == 0.0)
    assert np.array_equal(source.bake(10.0, 0.25, ramp_s=5.0).nodes, table.nodes)


@pytest.mark.parametrize("dof", DOFS)
def test_sinusoid_has_its_amplitude_period_and_phase_in_one_channel(dof: str) -> None:
    k = DOFS.index(dof)
    size = {"amplitude_m": 1.5} if k < 3 else {"amplitude_deg": 5.0}
    source = Sinusoid(dof=dof, period_s=8.0, phase_deg=30.0, **size)
    amplitude = 1.5 if k < 3 else np.radians(5.0)
    t = np.linspace(0.0, 24.0, 961)
    q, qd, qdd = source.bake(24.0, 0.25).at(t)
    np.testing.assert_allclose(q[:, k], amplitude * np.sin(2 * np.pi * t / 8.0 + np.radians(30.0)), atol=1e-6)
    np.testing.assert_allclose(q[:321, k], q[320:641, k], atol=1e-12)  # one period later it is the same
    assert np.max(np.abs(qd[:, k])) == pytest.approx(amplitude * 2 * np.pi / 8.0, rel=1e-3)
    assert np.max(np.abs(qdd[:, k])) == pytest.approx(amplitude * (2 * np.pi / 8.0) ** 2, rel=1e-3)
    for part in (q, qd, qdd):
        assert np.all(np.delete(part, k, axis=1) == 0.0)


def test_sinusoid_swings_about_its_mean_pose() -> None:
    source = Sinusoid(dof="roll", amplitude_deg=5.0, period_s=8.0, roll_deg=2.0, pitch_deg=1.0, z_m=-1.0)
    position = source.realise().signal(np.linspace(0.0, 8.0, 81)[:-1]).position
    np.testing.assert_allclose(position.mean(axis=0), [0.0, 0.0, -1.0, *np.radians([2.0, 1.0, 0.0])], atol=1e-12)
    ramped = source.bake(20.0, 0.25, ramp_s=5.0)
    np.testing.assert_allclose(ramped.at(0.0).position[3], np.radians(2.0))


def test_spectrum_bins_hold_all_the_energy_and_peak_where_they_should() -> None:
    edges, energy = spectrum_bins(96)
    assert energy.sum() == pytest.approx(1.0, abs=1e-12)
    assert np.all(energy > 0.0)
    assert np.all(np.diff(edges) > 0.0)
    fine_edges, fine = spectrum_bins(400)
    density = fine / np.diff(fine_edges)
    assert fine_edges[np.argmax(density)] == pytest.approx(1.0, abs=0.02)
    x = 0.5 * (fine_edges[1:] + fine_edges[:-1])
    shape = 5.0 * x**-5.0 * np.exp(-1.25 * x**-4.0) / (np.exp(-1.25 / 81.0) - np.exp(-20.0))
    np.testing.assert_allclose(density[5:-5], shape[5:-5], rtol=0.02)


@pytest.mark.parametrize("components", [16, 96, 256])
def test_irregular_long_run_rms_is_the_parameter_whatever_the_seed(components: int) -> None:
    for seed in range(5):
        motion = rolling(components=components).realise(np.random.default_rng(seed))
        np.testing.assert_allclose(motion.rms, [0, 0, 0, np.radians(3.0), 0, 0], rtol=1e-12)


def test_irregular_record_has_its_rms_within_three_percent() -> None:
    source = Irregular.model_validate(
        {
            "heave": {"rms_m": 0.7, "period_s": 7.0},
            "roll": {"rms_deg": 3.0, "period_s": 10.0},
            "pitch": {"rms_deg": 1.0, "period_s": 6.0},
            "roll_deg": 4.0,
        }
    )
    expected = np.array([0.7, np.radians(3.0), np.radians(1.0)])
    t = 0.9 * np.arange(15_000)
    for seed in (1, 2):
        motion = source.realise(np.random.default_rng(seed))
        position = motion.signal(t).position
        found = np.sqrt(np.mean((position - motion.mean) ** 2, axis=0))[[2, 3, 4]]
        np.testing.assert_allclose(found, expected, rtol=0.03)
        assert position[:, 3].mean() == pytest.approx(np.radians(4.0), rel=0.01)


def test_irregular_rms_over_many_short_records_is_unbiased() -> None:
    source, rng = rolling(), np.random.default_rng(0)
    squares = [np.mean(source.realise(rng).bake(120.0, 0.25).nodes[:, 3] ** 2) for _ in range(150)]
    assert np.sqrt(np.mean(squares)) == pytest.approx(np.radians(3.0), rel=0.03)


def test_irregular_rates_do_not_depend_on_luck() -> None:
    """Severity comes from the parameters: the long-run RMS of rate and acceleration scatters by a few per cent."""
    spread = []
    for seed in range(40):
        (roll,) = rolling().realise(np.random.default_rng(seed)).components
        spread.append([np.sqrt(0.5 * np.sum((roll.amplitude * roll.omega**p) ** 2)) for p in (1, 2)])
    scatter = np.std(spread, axis=0) / np.mean(spread, axis=0)
    assert scatter[0] < 0.005
    assert scatter[1] < 0.01
    # Mean period of the cut spectrum: the ratio of position to rate RMS by the closed-form moments.
    edges, energy = spectrum_bins(4000)
    x = 0.5 * (edges[1:] + edges[:-1])
    expected = np.radians(3.0) * 2.0 * np.pi / 10.0 * np.sqrt(np.sum(energy * x**2))
    assert np.mean(spread, axis=0)[0] == pytest.approx(expected, rel=0.01)


FIGURES = [field.name for field in fields(DeckRms)]


def test_severity_of_sines_is_that_of_a_long_record() -> None:
    """Closed form against the sampled motion, heeled, trimmed and turned, in all six degrees of freedom at once."""
    parts = {dof: {"rms_m": 0.3 + 0.1 * k, "period_s": 7.0 + k} for k, dof in enumerate(DOFS[:3])}
    turns = {dof: {"rms_deg": 1.0 - 0.2 * k, "period_s": 8.0 + k} for k, dof in enumerate(DOFS[3:])}
    pose = {"roll_deg": 5.0, "pitch_deg": -3.0, "yaw_deg": 40.0, "x_m": 1.0}
    source = Irregular.model_validate({**parts, **turns, **pose, "components": 16})
    motion = source.realise(np.random.default_rng(2))
    exact, long = motion.deck_rms(), Motion.deck_rms(motion, 10_000.0)
    for name in FIGURES:
        assert getattr(exact, name) == pytest.approx(getattr(long, name), rel=0.01), name
    assert exact.roll_deg == pytest.approx(1.0, rel=1e-12)
    assert exact.heave_m == pytest.approx(0.5, rel=1e-12)
    with pytest.raises(ConfigurationError, match="duration_s is 0"):
        motion.deck_rms(0.0)


def test_sines_of_one_frequency_add_up_with_their_phases() -> None:
    """Sway can take away what roll makes felt: only phases tell, so the channels must not be added as strangers."""
    omega, roll = np.array([0.7]), 0.05
    sway = 9.81 * roll / 0.7**2  # its acceleration is then g times the roll

    def felt(phase: float, yaw: float) -> tuple[float, float]:
        leaning = Component(3, omega, np.array([roll]), np.zeros(1))
        along = [(0, -np.sin(yaw)), (1, np.cos(yaw))]  # to starboard of a ship that points elsewhere
        moving = [Component(k, omega, np.array([sway * part]), np.array([phase])) for k, part in along]
        motion = Harmonics([0.0, 0.0, 0.0, 0.0, 0.0, yaw], (leaning, *moving))
        sampled = Motion.deck_rms(motion, 20.0 * np.pi / 0.7 * 10.0)
        return motion.deck_rms().lateral_specific_force_g, sampled.lateral_specific_force_g

    for yaw in (0.0, 0.6):
        for phase, share in ((0.0, 2.0), (0.5 * np.pi, np.sqrt(2.0)), (np.pi, 0.0)):
            exact, sampled = felt(phase, yaw)
            assert exact == pytest.approx(share * roll / np.sqrt(2.0), abs=1e-12)
            assert exact == pytest.approx(sampled, abs=5e-3 * roll)


def test_same_generator_state_same_bits_and_other_seed_other_motion() -> None:
    first, again, other = (rolling().realise(np.random.default_rng(s)).bake(30.0, 0.25).nodes for s in (5, 5, 6))
    assert np.array_equal(first, again)
    assert np.max(np.abs(first - other)) > 0.01


def test_random_numbers_are_common_to_configurations() -> None:
    alone = rolling().realise(np.random.default_rng(3))
    with_heave = rolling(heave={"rms_m": 1.0, "period_s": 7.0}).realise(np.random.default_rng(3))
    stronger = rolling(rms_deg=6.0).realise(np.random.default_rng(3))
    t = np.linspace(0.0, 50.0, 101)
    roll = alone.signal(t).position[:, 3]
    assert np.array_equal(with_heave.signal(t).position[:, 3], roll)
    np.testing.assert_allclose(stronger.signal(t).position[:, 3], 2.0 * roll, rtol=1e-12)


def test_draws_from_one_generator_differ_and_leave_it_at_the_same_place() -> None:
    a, b = np.random.default_rng(9), np.random.default_rng(9)
    one, two = rolling().realise(a), rolling().realise(a)
    assert not np.array_equal(one.components[0].phase, two.components[0].phase)
    rolling(rms_deg=0.0).realise(b)
    Irregular().realise(b)
    assert a.random() == b.random()


def test_zero_rms_is_exactly_zero() -> None:
    motion = rolling(rms_deg=0.0, pitch={"rms_deg": 0.0, "period_s": 5.0}).realise(np.random.default_rng(0))
    assert np.all(motion.bake(20.0, 0.25).nodes == 0.0)
    assert np.all(Irregular().realise(np.random.default_rng(0)).bake(20.0, 0.25, ramp_s=3.0).nodes == 0.0)


def test_irregular_motion_wants_a_generator() -> None:
    with pytest.raises(ConfigurationError, match=r"realise\(rng\)"):
        rolling().bake(10.0, 0.25)


def test_a_spacing_too_wide_for_the_motion_is_refused() -> None:
    source = Sinusoid(dof="roll", amplitude_deg=1.0, period_s=0.8)
    assert source.bake(4.0, 0.2).duration_s == 4.0
    with pytest.raises(ConfigurationError, match=r"spacing_s is 0.25, allowed is at most 0.2 s"):
        source.bake(4.0, 0.25)


def test_a_new_source_only_gives_its_signal() -> None:
    class Launch(Motion):
        def signal(self, t):
            t = np.asarray(t)[:, None] * np.ones(6)
            return Signal(t**2, 2.0 * t, 2.0 + 0.0 * t)

    table = Launch().bake(4.0, 0.5, start_s=1.0)
    np.testing.assert_allclose(table.at(1.25).position, 2.25**2)
    assert len(CHANNELS) == table.at(0.0).rate.shape[0]
    ramped = Launch().bake(4.0, 0.5, ramp_s=2.0)
    assert np.all(ramped.nodes[0] == 0.0)


@pytest.mark.parametrize(
    ("section", "kind"),
    [
        ({"type": "fixed"}, Fixed),
        ({"type": "fixed", "roll_deg": 5}, Fixed),
        ({"type": "sinusoid", "dof": "heave", "amplitude_m": 1, "period_s": 7}, Sinusoid),
        ({"type": "irregular", "roll": {"rms_deg": 3, "period_s": 10}}, Irregular),
        ({"type": "file", "path": "motion.csv", "rates": "euler", "detrend": True}, MotionFile),
    ],
)
def test_sections_build_their_source_and_come_back(section: dict, kind: type) -> None:
    source = parse_motion(section)
    assert isinstance(source, kind)
    assert parse_motion(source.model_dump(mode="json")) == source


def test_the_union_is_a_field_of_larger_models() -> None:
    class Scenario(BaseModel):
        motion: MotionConfig

    scenario = Scenario.model_validate(
        {"motion": {"type": "file", "path": "seas/one.csv"}}, context={"folder": "/configs"}
    )
    assert scenario.motion.path.as_posix() == "/configs/seas/one.csv"
    assert TypeAdapter(MotionConfig).json_schema()["discriminator"]["propertyName"] == "type"
    assert parse_motion({"type": "file", "path": "/abs.csv"}, folder="/configs").path.as_posix() == "/abs.csv"


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({}, ("motion.type", "fixed, sinusoid, irregular, file")),
        ({"type": "wavy"}, ("motion.type", "'wavy'", "sinusoid")),
        ({"type": "fixed", "rol": 3}, ("motion.rol", "not a key", "roll_deg")),
        ({"type": "fixed", "roll_deg": float("nan")}, ("motion.roll_deg", "nan", "finite")),
        ({"type": "sinusoid", "dof": "roll", "amplitude_m": 1, "period_s": 5}, ("dof roll", "amplitude_deg")),
        ({"type": "sinusoid", "dof": "sway", "amplitude_deg": 1, "period_s": 5}, ("dof sway", "amplitude_m")),
        ({"type": "sinusoid", "dof": "roll", "amplitude_deg": 1}, ("motion.period_s", "missing")),
        ({"type": "sinusoid", "dof": "roll", "amplitude_deg": 1, "period_s": 0}, ("motion.period_s", "0", "greater")),
        ({"type": "sinusoid", "dof": "bank", "amplitude_deg": 1, "period_s": 5}, ("motion.dof", "'bank'", "'roll'")),
        ({"type": "irregular", "roll": {"rms_deg": -1, "period_s": 5}}, ("motion.roll.rms_deg", "-1")),
        ({"type": "irregular", "roll": {"rms_m": 1, "period_s": 5}}, ("motion.roll", "rms_deg, period_s")),
        ({"type": "irregular", "roll": 3}, ("motion.roll", "3", "rms_deg, period_s")),
        ({"type": "irregular", "components": 2}, ("motion.components", "2", "8")),
        ({"type": "file", "path": "x", "euler_order": "zyz"}, ("motion.euler_order", "'zyz'", "'zyx'")),
        (7, ("motion", "7")),
    ],
)
def test_mistakes_cost_one_sentence(section: dict, words: tuple[str, ...]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_motion(section)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message


def test_sources_are_frozen() -> None:
    with pytest.raises(ValueError, match="frozen"):
        Fixed().roll_deg = 1.0
    with pytest.raises(ValueError, match="frozen"):
        IrregularRotation(rms_deg=1.0, period_s=2.0).rms_deg = 3.0
