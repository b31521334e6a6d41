"""Records in SHIPMO columns: written and read back, conventions, and what is refused."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.ship import Fixed, Irregular, Motion, MotionFile, RecordedMotion, Signal, read_shipmo, write_shipmo
from ssmash_gym.ship.kinematics import angles_from_rotation, rotation

SEA = Irregular.model_validate(
    {
        "surge": {"rms_m": 0.3, "period_s": 9.0},
        "sway": {"rms_m": 0.6, "period_s": 9.0},
        "heave": {"rms_m": 0.7, "period_s": 7.5},
        "roll": {"rms_deg": 5.0, "period_s": 10.0},
        "pitch": {"rms_deg": 2.0, "period_s": 8.0},
        "yaw": {"rms_deg": 2.0, "period_s": 11.0},
        "components": 32,
    }
)


@pytest.fixture(scope="module")
def sea() -> Motion:
    return SEA.realise(np.random.default_rng(4))


def rows(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines()]


def write_rows(path: Path, table: list[list[str]]) -> Path:
    path.write_text("\n".join(" ".join(row) for row in table) + "\n")
    return path


def relative_error(found: Signal, exact: Signal) -> list[float]:
    """Largest error of position (up to a constant), rate and acceleration in standard deviations."""
    shift = found.position - exact.position
    errors = [shift - shift.mean(axis=0), found.rate - exact.rate, found.acceleration - exact.acceleration]
    return [float(np.max(np.abs(e) / np.std(x, axis=0))) for e, x in zip(errors, exact, strict=True)]


@pytest.mark.parametrize("rates", ["body", "euler"])
@pytest.mark.parametrize("name", ["motion.csv", "SHIPMO.INP"])
def test_a_written_record_reads_back_as_the_same_motion(tmp_path: Path, sea: Motion, name: str, rates: str) -> None:
    path = write_shipmo(tmp_path / name, sea, 0.05, 40.0, rates=rates)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion = MotionFile(path=path, rates=rates, detrend=False).realise()
    assert motion.duration_s == pytest.approx(40.0)
    assert motion.consistent
    assert max(d.share for d in motion.discrepancies) < 1e-4
    t = np.linspace(0.5, 39.5, 777)
    position, rate, acceleration = relative_error(motion.signal(t), sea.signal(t))
    assert position < 1e-5
    assert rate < 1e-5
    assert acceleration < 1e-3
    np.testing.assert_allclose(motion.signal([0.0]).position[0, :3], 0.0, atol=1e-15)
    np.testing.assert_allclose(motion.signal(t).position[:, 3:], sea.signal(t).position[:, 3:], atol=1e-7)


def test_the_columns_are_those_of_the_thesis(tmp_path: Path) -> None:
    table = SEA.realise(np.random.default_rng(1)).bake(5.0, 0.25)
    path = write_shipmo(tmp_path / "motion.txt", table, 0.5, 5.0)
    data = np.loadtxt(path)
    assert data.shape == (11, 16)
    at, pose = table.at(data[:, 0]), table.pose(data[:, 0])
    np.testing.assert_allclose(data[:, 0], 0.5 * np.arange(11))
    np.testing.assert_allclose(np.radians(data[:, 1:4]), at.position[:, 3:], atol=1e-12)
    np.testing.assert_allclose(data[:, 4:7], at.rate[:, :3], atol=1e-10)
    np.testing.assert_allclose(np.radians(data[:, 7:10]), pose.w_NS_S, atol=1e-12)
    np.testing.assert_allclose(data[:, 10:13], at.acceleration[:, :3], atol=1e-10)
    np.testing.assert_allclose(np.radians(data[:, 13:16]), pose.wdot_NS_S, atol=1e-12)


def test_the_wrong_convention_is_reported_with_the_right_one(tmp_path: Path, sea: Motion) -> None:
    path = write_shipmo(tmp_path / "motion.csv", sea, 0.05, 40.0, rates="euler")
    with pytest.warns(ConfigurationWarning, match="agree better with rates: euler"):
        motion = MotionFile(path=path).realise()
    yaw = next(d for d in motion.discrepancies if d.name == "yaw rate")
    assert yaw.share > 0.05
    assert yaw.unit == "rad/s"
    assert f"{yaw.rms:.3g}" in motion.report()
    linear = [d.share for d in motion.discrepancies if d.name.startswith("acceleration")]
    assert max(linear) < 1e-3


def test_the_wrong_sequence_is_reported_with_the_right_one(tmp_path: Path, sea: Motion) -> None:
    """Angles of another sequence beside the same body rates: the file itself tells which sequence it is."""
    path = write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.05, 40.0)
    table = np.loadtxt(path)
    table[:, 1:4] = np.degrees(in_sequence(np.radians(table[:, 1:4]), "xyz"))
    np.savetxt(path, table, fmt="%.14g")
    with pytest.warns(ConfigurationWarning, match="agree better with rates: body, euler_order: xyz"):
        MotionFile(path=path).realise()
    with pytest.warns(ConfigurationWarning, match="agree better with rates: body, euler_order: xyz"):
        MotionFile(path=path, rates="euler").realise()


def in_sequence(angles: np.ndarray, order: str) -> np.ndarray:
    """The angles of another sequence that give the attitudes of z-y-x angles, by iteration on R(a) = R."""
    R_NS = rotation(angles)
    for _ in range(50):
        angles = angles + angles_from_rotation(rotation(angles, order).transpose(0, 2, 1) @ R_NS)
    np.testing.assert_allclose(rotation(angles, order), R_NS, atol=1e-12)
    return angles


def test_file_rates_that_disagree_are_reported_and_the_derivative_is_used(tmp_path: Path, sea: Motion) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.05, 40.0)
    table = rows(path)
    for row in table:
        row[7] = repr(1.5 * float(row[7]))
    write_rows(path, table)
    motion = RecordedMotion(read_shipmo(path))
    shares = {d.name: d.share for d in motion.discrepancies}
    assert shares["roll rate"] == pytest.approx(1.0 / 3.0, rel=1e-3)
    assert shares["pitch rate"] < 1e-4
    assert not motion.consistent
    assert "roll rate: RMS difference" in motion.report()
    t = np.linspace(1.0, 39.0, 99)
    np.testing.assert_allclose(motion.signal(t).rate[:, 3], sea.signal(t).rate[:, 3], atol=1e-6)


def test_a_baked_record_keeps_its_own_derivatives(tmp_path: Path, sea: Motion) -> None:
    source = MotionFile(path=write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.1, 30.0), detrend=False)
    table = source.bake(20.0, 0.25, start_s=5.0, ramp_s=4.0)
    t, h = 0.25 * np.arange(80) + 0.11, 1e-3  # within the pieces: the third derivative jumps at nodes
    low, mid, high = table.at(t - h), table.at(t), table.at(t + h)
    for k in (0, 1):
        assert np.max(np.abs((high[k] - low[k]) / (2 * h) - mid[k + 1]) / np.std(mid[k + 1], axis=0)) < 1e-5
    plain = source.bake(20.0, 0.25, start_s=5.0)
    t = np.linspace(0.0, 20.0, 301)
    for found, exact in zip(plain.at(t), sea.signal(5.0 + t), strict=True):
        error = (found - exact)[:, 3:]
        assert np.max(np.abs(error) / np.std(exact[:, 3:], axis=0)) < 5e-3


@pytest.mark.parametrize("order", ["xyz", "yxz"])
def test_angles_in_another_sequence_give_the_same_deck(tmp_path: Path, sea: Motion, order: str) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.05, 20.0)
    table = np.loadtxt(path)
    table[:, 1:4] = np.degrees(in_sequence(np.radians(table[:, 1:4]), order))
    np.savetxt(path, table, fmt="%.14g")
    motion = MotionFile(path=path, euler_order=order, detrend=False).realise()
    assert motion.consistent  # body rates do not depend on the sequence
    t = np.linspace(0.5, 19.5, 99)
    np.testing.assert_allclose(motion.signal(t).position[:, 3:], sea.signal(t).position[:, 3:], atol=1e-7)


class Sailing(Motion):
    """Steady ship speed with a swaying deck on top."""

    def signal(self, t):
        t = np.asarray(t)
        zero, one = np.zeros((len(t), 6)), np.zeros((len(t), 6))
        q, qd, qdd = zero.copy(), zero.copy(), one
        q[:, 0], qd[:, 0] = 9.0 * t, 9.0
        q[:, 1], qd[:, 1], qdd[:, 1] = np.sin(t), np.cos(t), -np.sin(t)
        return Signal(q, qd, qdd)


def test_mean_speed_stays_unless_detrended(tmp_path: Path) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", Sailing(), 0.05, 40.0)
    t = np.linspace(0.0, 40.0, 201)
    kept = MotionFile(path=path, detrend=False).realise().signal(t)
    np.testing.assert_allclose(kept.position[:, 0], 9.0 * t, atol=1e-8)
    np.testing.assert_allclose(kept.position[:, 1], np.sin(t), atol=1e-6)
    clean = MotionFile(path=path).realise()
    np.testing.assert_allclose(clean.signal(t).position[:, 0], 0.0, atol=1e-7)
    np.testing.assert_allclose(clean.signal(t).rate[:, 0], 0.0, atol=1e-8)
    assert abs(clean.signal(t).position[:, 1].mean()) < 0.01
    np.testing.assert_allclose(clean.signal(t).acceleration, kept.acceleration, atol=1e-12)


def test_the_mean_heading_is_taken_off(tmp_path: Path, sea: Motion) -> None:
    """A record on any mean course gives the same deck: only the axes of N turn with it."""
    path = write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.05, 40.0)
    table = np.loadtxt(path)
    turn = np.radians(130.0)
    R = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    table[:, 3] += 130.0
    table[:, 4:7], table[:, 10:13] = table[:, 4:7] @ R.T, table[:, 10:13] @ R.T
    np.savetxt(tmp_path / "turned.inp", table, fmt="%.14g")
    straight, turned = (MotionFile(path=p).realise() for p in (path, tmp_path / "turned.inp"))
    assert turned.consistent and turned.mean[5] == pytest.approx(0.0, abs=1e-12)
    t = np.linspace(0.5, 39.5, 99)
    for one, other in zip(straight.signal(t), turned.signal(t), strict=True):
        np.testing.assert_allclose(other, one, atol=1e-7)


def test_a_ramped_record_starts_at_its_mean_speed(tmp_path: Path) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", Sailing(), 0.05, 40.0)
    table = MotionFile(path=path, detrend=False).bake(30.0, 0.25, ramp_s=5.0, start_s=3.0)
    first = table.at(0.0)
    assert first.rate[0] == pytest.approx(9.0, abs=1e-3)
    np.testing.assert_allclose(first.acceleration, 0.0, atol=1e-9)
    assert np.max(np.abs(table.nodes[:, 12])) < 0.01  # the ramp makes no acceleration of the steady speed


def test_yaw_through_north_is_continuous(tmp_path: Path) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", Fixed(yaw_deg=359.0), 0.1, 10.0)
    table = rows(path)
    for k, row in enumerate(table):
        row[3] = repr((359.0 + 0.1 * k) % 360.0)
        row[9] = "1"
    motion = MotionFile(path=write_rows(path, table)).realise()
    np.testing.assert_allclose(motion.signal(np.linspace(0.0, 10.0, 55)).rate[:, 5], np.radians(1.0), atol=1e-9)


def test_comments_names_separators_and_fortran_numbers_are_read(tmp_path: Path, sea: Motion) -> None:
    plain = read_shipmo(write_shipmo(tmp_path / "a.inp", sea, 0.1, 3.0))
    text = (tmp_path / "a.inp").read_text().splitlines()
    text[3] = " ".join(f"{float(v):.16E}".replace("E", "D") for v in text[3].split())
    text[4] = text[4].replace(" ", ",\t")
    other = tmp_path / "b.csv"
    other.write_text(
        "% a comment\n\nt, " + ", ".join(f"c{k}" for k in range(15)) + "\n" + "\n".join(text) + "\n# end\n"
    )
    again = read_shipmo(other)
    for name in ("angles", "velocity", "rates", "acceleration", "rate_derivatives"):
        np.testing.assert_allclose(getattr(again, name), getattr(plain, name), rtol=1e-14, atol=1e-300)
    assert again.step_s == plain.step_s


def test_rounded_times_are_even(tmp_path: Path, sea: Motion) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", sea, 1.0 / 30.0, 3.0)
    table = [[f"{float(row[0]):.3f}", *row[1:]] for row in rows(path)]
    assert read_shipmo(write_rows(path, table)).step_s == pytest.approx(1.0 / 30.0, rel=1e-3)


def test_a_file_without_numbers_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "names.csv"
    path.write_text("# only words\ntime_s,roll_deg\n")
    with pytest.raises(ConfigurationError, match="without a row of numbers, allowed are 8 or more rows"):
        read_shipmo(path)


def test_a_byte_order_mark_is_passed_over(tmp_path: Path, sea: Motion) -> None:
    path = write_shipmo(tmp_path / "a.inp", sea, 0.1, 3.0)
    plain = read_shipmo(path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    np.testing.assert_array_equal(read_shipmo(path).velocity, plain.velocity)


def spoil(table: list[list[str]], what: str) -> None:
    if what == "word":
        table[11][4] = "abc"
    elif what == "nan":
        table[11][8] = "nan"
    elif what == "short":
        table[11] = table[11][:15]
    elif what == "long":
        table[11].append("1.0")
    elif what == "gap":
        del table[11]
    elif what == "back":
        table[11][0] = table[9][0]
    elif what == "few":
        del table[5:]
    elif what == "empty":
        table.clear()


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ("word", ("line 12, column 5", "velocity x [m/s]", "'abc'")),
        ("nan", ("line 12, column 9", "pitch rate [deg/s]", "'nan'")),
        ("short", ("line 12", "15 columns", "exactly 16")),
        ("long", ("line 12", "17 columns", "exactly 16")),
        ("gap", ("line 12", "1.2 s", "0.2 s after", "even step (here 0.1 s)")),
        ("back", ("line 12", "even step")),
        ("few", ("5 rows", "8 or more")),
        ("empty", ("it is empty", "8 or more rows of 16 columns")),
    ],
)
def test_malformed_records_are_refused_by_line_and_column(
    tmp_path: Path, sea: Motion, what: str, words: tuple[str, ...]
) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.1, 3.0)
    table = rows(path)
    spoil(table, what)
    with pytest.raises(ConfigurationError) as caught:
        MotionFile(path=write_rows(path, table)).bake(1.0, 0.25)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    for word in words:
        assert word in message


def test_times_that_stand_still_are_refused(tmp_path: Path) -> None:
    path = write_shipmo(tmp_path / "SHIPMO.INP", Fixed(), 0.1, 3.0)
    with pytest.raises(ConfigurationError, match="line 2: time 0 s does not follow 0 s"):
        read_shipmo(write_rows(path, [["0", *row[1:]] for row in rows(path)]))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"nowhere\.csv: cannot be read"):
        MotionFile(path=tmp_path / "nowhere.csv").realise()


def test_more_time_than_the_record_holds_is_refused(tmp_path: Path, sea: Motion) -> None:
    source = MotionFile(path=write_shipmo(tmp_path / "SHIPMO.INP", sea, 0.1, 10.0))
    assert source.bake(10.0, 0.25).duration_s == 10.0
    with pytest.raises(ConfigurationError, match="allowed is 0 to 10 s"):
        source.bake(10.0, 0.25, start_s=1.0)
    with pytest.raises(ConfigurationError, match="allowed is 0 to 10 s"):
        source.realise().signal([11.0])


def test_writing_is_all_or_nothing(tmp_path: Path, sea: Motion) -> None:
    path = write_shipmo(tmp_path / "motion.csv", sea, 0.1, 5.0)
    before = path.read_bytes()
    for bad in ({"dt": 0.0}, {"dt": 0.1, "rates": "wrong"}, {"dt": 0.1, "duration": np.nan}):
        with pytest.raises(ConfigurationError):
            write_shipmo(path, sea, **({"duration": 5.0} | bad))
    with pytest.raises(ConfigurationError, match="outside the table"):
        write_shipmo(path, sea.bake(2.0, 0.25), 0.1, 5.0)
    with pytest.raises(ConfigurationError, match="cannot be written"):
        write_shipmo(tmp_path / "no" / "motion.csv", sea, 0.1, 5.0)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["motion.csv"]
    with pytest.raises(ConfigurationError, match="realise"):
        write_shipmo(path, SEA, 0.1, 5.0)


def test_a_long_record_is_written_in_pieces_that_do_not_show(tmp_path: Path, sea: Motion) -> None:
    """5000 rows are three blocks: the figures are those of the motion at every row, and progress rises to 1."""
    shares: list[float] = []
    path = write_shipmo(tmp_path / "motion.csv", sea, 0.05, 250.0, progress=shares.append)
    assert len(shares) == 3 and shares == sorted(set(shares)) and shares[-1] == 1.0
    data = np.loadtxt(path, delimiter=",", skiprows=1)
    assert data.shape == (5001, 16)
    np.testing.assert_allclose(data[:, 0], 0.05 * np.arange(5001), atol=1e-9)
    exact = sea.signal(data[:, 0])
    np.testing.assert_allclose(np.radians(data[:, 1:4]), exact.position[:, 3:], atol=1e-9)
    np.testing.assert_allclose(data[:, 10:13], exact.acceleration[:, :3], atol=1e-9)
    quiet = write_shipmo(tmp_path / "quiet.csv", sea, 0.05, 250.0)
    assert quiet.read_bytes() == path.read_bytes()


def test_a_record_may_have_wide_steps(tmp_path: Path, sea: Motion) -> None:
    """A step at which no table could be interpolated: the record holds the exact values all the same."""
    data = np.loadtxt(write_shipmo(tmp_path / "slow.inp", sea, 2.0, 40.0))
    np.testing.assert_allclose(data[:, 4:7], sea.signal(data[:, 0]).rate[:, :3], atol=1e-9)


def test_a_writing_that_is_broken_off_leaves_nothing(tmp_path: Path, sea: Motion) -> None:
    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_shipmo(tmp_path / "motion.csv", sea, 0.05, 250.0, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_rename_leaves_the_old_record(tmp_path: Path, sea: Motion, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_shipmo(tmp_path / "motion.csv", sea, 0.1, 5.0)
    before = path.read_bytes()

    def refuse(self: Path, target: Path) -> Path:
        raise PermissionError(13, "not now")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(ConfigurationError, match="cannot be written"):
        write_shipmo(path, sea, 0.2, 5.0)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["motion.csv"]
