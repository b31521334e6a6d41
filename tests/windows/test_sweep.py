"""A window on disk: interrupted and gone on with, never mixed, the same rows from threads, processes and machines."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from ssmash_gym import cli
from ssmash_gym.document import write_yaml
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows.chunks import Chunk, Job
from ssmash_gym.windows.config import WindowConfig, load_window
from ssmash_gym.windows.engines import Done, Steps, Threads
from ssmash_gym.windows.rows import KEYS, alone_in, read_document, read_rows
from ssmash_gym.windows.sweep import Sweep, prepared, run_sweep
from ssmash_gym.windows.verdicts import cells_of, judged_rows, sentences

DOCUMENT: dict[str, Any] = {
    "description": "A small one.", "seed": 5, "scenario": "ss5", "stages": ["traverse"],
    "task": {
        "base": "traverse", "horizon_s": 4.0, "grace_s": 0.5, "track": {"goal_x_m": 0.4},
        "lead_in": {"duration_s": 1.0, "ramp_s": 1.0},
    },
    "policies": ["trapezoid", "ppo_traverse"],
    "axes": {"sea_state": [3, 6], "waves_from_deg": [0, 100], "speed_kn": [10]},
    "limits": {"probe_in_plane_kN": 5.0}, "must_arrive": False, "acceptance": 0.3,
    "effort": {"seeds": 6, "step": 4, "most": 14},
}  # fmt: skip


def small(**changes: Any) -> WindowConfig:
    return load_window({**DOCUMENT, **changes})


def sweep_of(config: WindowConfig, *policies: str, size: int = 7) -> Sweep:
    return prepared(config, "small", policies, size=size)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An uninterrupted one."""
    out = tmp_path_factory.mktemp("whole")
    run_sweep(sweep_of(small()), out, Threads(2), shown=False)
    return out


class Clumsy:
    """Runs chunks like the threads, and is stopped after some control intervals."""

    workers = 2

    def __init__(self, after: int) -> None:
        self._left = after

    def run(self, job: Job, chunks: Sequence[Chunk], tell: Steps) -> Done:
        def told(steps: int) -> None:
            self._left -= steps
            if self._left < 0:
                raise KeyboardInterrupt
            tell(steps)

        yield from Threads(self.workers).run(job, chunks, told)


def test_the_plan_is_followed(whole: Path) -> None:
    rows, told = read_rows(whole), read_document(whole)
    assert not rows.select(KEYS).is_duplicated().any()
    cells = cells_of(judged_rows(rows, told), told)
    assert cells.height == 8 and cells["episodes"].min() >= 6 and cells["episodes"].max() == 14
    assert set(cells.filter(pl.col("verdict") == "undecided")["episodes"]) <= {14}
    assert set(cells.filter(pl.col("episodes") < 14)["verdict"]) <= {"within", "beyond"}
    assert told["policies"]["ppo_traverse"]["training_seed"] is not None
    assert len(sentences(cells)) == 2


def test_interrupted_and_continued_is_the_same_row_for_row(whole: Path, tmp_path: Path) -> None:
    chance, kept = random.Random(4), [0]
    while True:
        # The first three cannot end it (2,316 control intervals); how much is done by then is a race of two threads.
        after = chance.randrange(400, 760) if len(kept) < 4 else chance.randrange(20, 3000)
        try:
            run_sweep(sweep_of(small(), size=2), tmp_path, Clumsy(after), shown=False)
            break
        except KeyboardInterrupt:
            kept.append(len(list((tmp_path / "rows").glob("[!.]*"))))
            assert len(kept) < 60
    assert len(kept) > 3 and kept == sorted(kept) and kept[-1] > 0
    assert read_rows(tmp_path).equals(read_rows(whole))
    assert not list((tmp_path / "rows").glob(".*"))  # nothing half written


@pytest.mark.slow
def test_killed_twenty_times_at_random_moments(whole: Path, tmp_path: Path) -> None:
    """The same from the command line: SIGINT or SIGKILL, wherever the process is."""
    file = tmp_path / "small.yaml"
    file.write_text(write_yaml(DOCUMENT))
    chance, stops, out = random.Random(7), 0, tmp_path / "out"
    while True:
        words = [sys.executable, "-m", "ssmash_gym", "window", str(file), "--out", str(out), "--threads", "2"]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if stops < 20:
            time.sleep(chance.uniform(1.0, 5.0))
            process.send_signal(chance.choice([signal.SIGINT, signal.SIGKILL]))
            stops += process.wait() != 0
        else:
            assert process.wait() == 0
            break
    assert read_rows(out).equals(read_rows(whole))


def test_finished_episodes_are_never_run_again(whole: Path, tmp_path: Path) -> None:
    class Idle:
        workers = 1

        def run(self, job: Job, chunks: Sequence[Chunk], tell: Steps) -> Iterator[Any]:
            raise AssertionError("nothing was missing")

    before = sorted((path.name, path.stat().st_mtime_ns) for path in (whole / "rows").iterdir())
    run_sweep(sweep_of(small()), whole, Idle(), shown=False)
    assert sorted((path.name, path.stat().st_mtime_ns) for path in (whole / "rows").iterdir()) == before


def test_chunks_and_threads_leave_no_trace(whole: Path, tmp_path: Path) -> None:
    run_sweep(sweep_of(small(), size=100), tmp_path, Threads(1), shown=False)
    assert read_rows(tmp_path).equals(read_rows(whole))


def test_other_configurations_are_not_mixed_in(whole: Path) -> None:
    before = (whole / "window.json").read_text()
    for changes in ({"seed": 6}, {"limits": {"probe_in_plane_kN": 6.0}}, {"scenario": "ss4"}, {"acceptance": 0.2}):
        with pytest.raises(ConfigurationError, match="must not be mixed"):
            run_sweep(sweep_of(small(**changes)), whole, Threads(1), shown=False)
    with pytest.raises(ConfigurationError, match="ppo_traverse was another one there"):
        other = sweep_of(small())
        entrants = other.job.entrants["traverse"]
        object.__setattr__(entrants["ppo_traverse"], "identity", "other weights")
        run_sweep(other, whole, Threads(1), shown=False)
    assert (whole / "window.json").read_text() == before


def test_rows_tell_themselves_what_they_are_of(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(whole, tmp_path / "copy")
    monkeypatch.setattr("ssmash_gym.windows.sweep.code", lambda: "other sources")
    with pytest.raises(ConfigurationError, match="made by other sources"):
        run_sweep(sweep_of(small()), tmp_path / "copy", Threads(1), shown=False)
    monkeypatch.undo()
    (tmp_path / "copy" / "window.json").unlink()
    with pytest.raises(ConfigurationError, match=r"there are rows but no window\.json"):
        run_sweep(sweep_of(small()), tmp_path / "copy", Threads(1), shown=False)
    monkeypatch.setattr("ssmash_gym.windows.chunks.code", lambda: "of a node with another package")
    with pytest.raises(ConfigurationError, match="a worker runs other sources"):
        run_sweep(sweep_of(small()), tmp_path / "new", Threads(1), shown=False)
    assert not (tmp_path / "new" / "rows").exists()


def test_two_at_once_in_a_folder_are_refused_and_the_same_rows_twice_do_no_harm(whole: Path, tmp_path: Path) -> None:
    with alone_in(tmp_path), pytest.raises(ConfigurationError, match="another process is running"):
        run_sweep(sweep_of(small()), tmp_path, Threads(1), shown=False)
    run_sweep(sweep_of(small(), size=100), tmp_path, Threads(1), shown=False)
    for path in (whole / "rows").iterdir():  # chunked otherwise, so under other names
        shutil.copy(path, tmp_path / "rows")
    assert read_rows(tmp_path).equals(read_rows(whole))


def test_a_policy_joins_later_and_more_seas_too(whole: Path, tmp_path: Path) -> None:
    run_sweep(sweep_of(small(), "trapezoid"), tmp_path, Threads(2), shown=False)
    assert set(read_rows(tmp_path)["policy"]) == {"trapezoid"}
    run_sweep(sweep_of(small(), "ppo_traverse"), tmp_path, Threads(2), shown=False)
    assert read_rows(tmp_path).equals(read_rows(whole))
    more = small(effort={**DOCUMENT["effort"], "most": 18})
    run_sweep(sweep_of(more), tmp_path, Threads(2), shown=False)
    counts = read_rows(tmp_path).group_by("policy", "cell").len()["len"]
    assert counts.max() == 18


def test_a_broken_file_of_rows_is_named(whole: Path, tmp_path: Path) -> None:
    folder = tmp_path / "rows"
    folder.mkdir()
    (folder / "a.parquet").write_bytes(b"nothing")
    with pytest.raises(ConfigurationError, match=r"a\.parquet: this file of rows cannot be read"):
        read_rows(tmp_path)
    kept = pl.read_parquet(next((whole / "rows").glob("*.parquet")))
    for name, factor in (("a", 1.0), ("b", 2.0)):
        kept.with_columns(pl.col("peak_probe_kN") * factor).write_parquet(folder / f"{name}.parquet")
    with pytest.raises(ConfigurationError, match="twice"):
        read_rows(tmp_path)


def test_the_command_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "one.yaml"
    file.write_text(write_yaml({**DOCUMENT, "axes": {"sea_state": [6]}, "policies": ["trapezoid"]}))
    words = ["window", str(file), "--out", str(tmp_path / "out"), "--seeds", "2", "--most", "2"]
    assert cli.main(words) == 0
    told = capfd.readouterr().out
    assert "traverse, trapezoid: 0 of 1 cells within the limits" in told and "--report" in told
    assert "no cell can be shown to be within" in told and "running into" in told
    assert cli.main(words) == 0
    assert "2 episodes are there" in capfd.readouterr().out
    assert json.loads((tmp_path / "out" / "window.json").read_text())["name"] == "one"
    taken = tmp_path / "taken"
    taken.write_text("a file")
    for extra, said in (
        ([str(file), "--most", "0"], "--most 0 is refused"),
        ([str(file), "--threads", "0"], "--threads 0 is refused"),
        ([str(file), "--address", "auto"], "--address auto is refused without --engine ray"),
        ([str(file), "--policy", "wizard"], "wizard"),
        ([str(file), "--films", "2"], "--films 2 is refused without --report"),
        ([str(file), "--cell", "2"], "--cell 2 is refused without --film"),
        (["--report", str(tmp_path), "--seeds", "2"], "--seeds 2 is refused without a window to run"),
        (["--report", str(tmp_path), "--films", "-1"], "--films -1 is refused"),
        ([str(file), "--out", str(taken)], "taken"),
        (["nowhere"], "there is none called 'nowhere'"),
        ([], "give a window to run"),
        (["--report", str(tmp_path / "nothing")], "there is no window in this folder"),
        (["--film", str(tmp_path / "nothing")], "there is no window in this folder"),
    ):
        assert cli.main(["window", *extra]) != 0
        error = capfd.readouterr().err
        assert said in error and error.count("\n") == 1, error


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    assert cli.main(["window", "frigate_traverse", "--out", str(closed / "out")]) == 1
    assert "cannot be read or written" in capfd.readouterr().err
