"""The telemetry table: names, units, values, extremes."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics.channels import OUTPUT_ROWS, StaOut
from ssmash_gym.dynamics.layout import STATION_NAMES, State
from ssmash_gym.ship import Sinusoid
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.telemetry import CHANNELS, channel
from ssmash_gym.vehicle import load_helicopter


@pytest.fixture(scope="module")
def under_way() -> Batch:
    batch = Batch(load_helicopter("generic_tricycle"), 3)
    table = Sinusoid(dof="roll", amplitude_deg=5.0, period_s=7.0, pitch_deg=1.0).bake(3.0, 0.25)
    batch.set_motion([table] * 3)
    batch.place(0.0, [0.0, 0.05, -0.05], [0.0, 0.1, -0.1])
    batch.advance([[1.0, 0.5], [0.5, -1.0], [0.0, 0.0]], intervals=5)
    batch.advance([[1.0, 0.5], [0.5, -1.0], [0.0, 0.0]])
    return batch


def test_every_channel_has_a_name_of_its_own_a_unit_and_a_meaning() -> None:
    names = [c.name for c in CHANNELS.values()]
    assert len(set(names)) == len(names) == OUTPUT_ROWS + sum(not c.has_peaks for c in CHANNELS.values())
    assert names == list(CHANNELS)
    for c in CHANNELS.values():
        assert c.name == c.name.lower() and c.name.isidentifier()
        assert c.unit in {"N", "m", "m/s", "m/s2", "rad", "rad/s", "1"}
        assert c.meaning and (c.frame in {"H", "S", "N", "O", "T"} or c.name.startswith("probe_"))
    assert len({c.meaning for c in CHANNELS.values()}) == len(names)


def test_every_output_row_has_exactly_one_channel() -> None:
    rows = [c.row for c in CHANNELS.values() if c.has_peaks]
    assert sorted(rows) == list(range(OUTPUT_ROWS))
    assert {f"{station}_{row.name.lower()}" for station in STATION_NAMES for row in StaOut} <= set(CHANNELS)


@pytest.mark.parametrize(
    ("wrong", "close"),
    [("probe_inplane", "probe_in_plane"), ("right_vertical", "right_vertical_load"), ("yawrate", "yaw_rate")],
)
def test_an_unknown_name_is_told_what_is_close(under_way: Batch, wrong: str, close: str) -> None:
    for look in (channel, under_way.telemetry.__getitem__, under_way.telemetry.peak_max):
        with pytest.raises(KeyError, match=rf"telemetry has no channel '{wrong}'; close: .*\b{close}\b"):
            look(wrong)
    with pytest.raises(KeyError, match=r"telemetry has no channel 'xyzzy'\W*$"):
        channel("xyzzy")


def test_extremes_bound_the_value_at_the_end(under_way: Batch) -> None:
    telemetry = under_way.telemetry
    for c in CHANNELS.values():
        if not c.has_peaks:
            with pytest.raises(KeyError, match=f"channel '{c.name}' is a state"):
                telemetry.peak_max(c.name)
            continue
        value, high, low = telemetry[c.name], telemetry.peak_max(c.name), telemetry.peak_min(c.name)
        assert np.all(low <= value) and np.all(value <= high), c.name
        assert np.array_equal(telemetry.peak_abs(c.name), np.maximum(np.abs(low), np.abs(high)))
    assert np.any(telemetry.highs > telemetry.outputs) and np.any(telemetry.lows < telemetry.outputs)


def test_what_is_read_is_a_copy(under_way: Batch) -> None:
    telemetry = under_way.telemetry
    for read in (telemetry.__getitem__, telemetry.peak_max, telemetry.peak_min):
        before = read("roll").copy()
        read("roll")[:] = 99.0
        assert np.array_equal(read("roll"), before)
    telemetry["position_x"][:] = 99.0
    assert np.array_equal(telemetry["position_x"], under_way.state[State.Q8])


def test_values_belong_to_their_names(under_way: Batch) -> None:
    """By other ways: rows of the state, angles from Euler parameters, forces from their components, the deck."""
    read, state = under_way.telemetry, under_way.state
    assert np.array_equal(read["velocity_y"], state[State.U8]) and np.array_equal(read["yaw_rate"], state[State.U12])
    assert np.array_equal(read["auxiliary_steer_rate"], state[State.U14])
    e0, e1, e2, e3 = state[State.Q11 : State.Q14 + 1]
    np.testing.assert_allclose(read["pitch"], np.arcsin(2 * (e0 * e2 - e1 * e3)), atol=1e-14)
    np.testing.assert_allclose(read["yaw"], np.arctan2(2 * (e1 * e2 + e0 * e3), 1 - 2 * (e2**2 + e3**2)), atol=1e-14)
    np.testing.assert_allclose(read["roll"], np.arctan2(2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1**2 + e2**2)), atol=1e-14)
    steer = 2.0 * np.arctan2(state[State.Q16 + 3], state[State.Q16])
    np.testing.assert_allclose(read["auxiliary_steer"], steer, atol=1e-14)
    assert np.max(np.abs(steer)) > 1e-3
    np.testing.assert_allclose(read["probe_in_plane"] ** 2, read["probe_fx"] ** 2 + read["probe_fy"] ** 2, rtol=1e-12)
    roll = np.deg2rad(5.0) * np.sin(2.0 * np.pi * under_way.time_s / 7.0)
    np.testing.assert_allclose(read["deck_roll"], roll, rtol=1e-6)
    force = np.hypot(read["deck_fy"][0], read["deck_fz"][0])
    assert read["deck_fx"][0] == pytest.approx(9.81 * np.sin(np.deg2rad(1.0)), rel=1e-3)
    assert force == pytest.approx(9.81 * np.cos(np.deg2rad(1.0)), rel=1e-4)
    assert np.array_equal(read["claw_y"], state[State.CLAW_Y]) and np.array_equal(read["claw_vx"], state[State.CLAW_VX])


def test_signs_of_the_loads(under_way: Batch) -> None:
    """Compressed struts push, deflected tires carry, a claw that runs ahead pulls forward."""
    read = under_way.telemetry
    for station in STATION_NAMES:
        assert np.all(read[f"{station}_vertical_load"] > 1e4)
        assert np.all(read[f"{station}_oleo_force"] > 1e4)
        assert np.all((read[f"{station}_compression"] > 0.05) & (read[f"{station}_compression"] < 0.4))
        assert np.all(read[f"{station}_tire_vertical_deflection"] > 0.01)
        assert np.all((read[f"{station}_friction_use"] >= 0.0) & (read[f"{station}_friction_use"] <= 1.0))
    pulls = (read["probe_fx"] > 0.0) == (read["probe_x"] < read["claw_x"])
    assert pulls[0] and pulls[1]
    assert np.all(read["right_contact_y"] > 1.0) and np.all(read["left_contact_y"] < -1.0)
    assert np.all(read["auxiliary_contact_x"] > read["right_contact_x"] + 5.0)
