"""The study that judges the monitor, small."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from ssmash_gym.errors import ConfigurationError
from tests.monitor.decks import quick
from tools import monitor_study
from tools.monitor_study import Study, chunk_rows, foreseen, picture, run, summary, tables

SMALL = Study(seed=3, records=3, starts=2, every_s=12.0, settings=quick(past_s=60.0, limits={"probe_in_plane_kN": 3.0}))


def test_a_small_study_runs_goes_on_where_it_was_and_tells_its_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(monitor_study, "CHUNK", 2)
    first, _ = run(replace(SMALL, records=2), tmp_path)
    kept = next((tmp_path / "rows").glob("0000-2.parquet")).read_bytes()
    rows, past = run(SMALL, tmp_path)
    assert (tmp_path / "rows" / "0000-2.parquet").read_bytes() == kept
    assert rows.head(first.height).equals(first)
    assert rows.height == 6
    assert past["start_s"].max() == 60.0 + 12.0 - 6.0 - 1.0  # earlier starts whose outcome is known at the last start
    told = summary(SMALL, rows, past)
    json.dumps(told)
    assert [h["horizon_s"] for h in told["horizons"]] == [5.0, 6.0]
    for h in told["horizons"]:
        assert sum(b["count"] for b in h["reliability"]) == told["starts"]
        assert 0.0 <= h["brier_monitor"][0] <= 1.0
    assert told["later"][0]["starts"] == told["starts"]
    assert "| 6 |" in tables(told)
    picture(told, tmp_path / "curve.png")
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ConfigurationError, match="another study"):
        run(replace(SMALL, seed=4), tmp_path)


def test_rows_do_not_depend_on_the_records_beside_them_or_the_threads() -> None:
    scene = monitor_study.Scene.of(SMALL.settings)
    both = chunk_rows(SMALL, [0, 1], scene)
    two = replace(SMALL, settings=replace(SMALL.settings, threads=2))
    alone = chunk_rows(two, [1], monitor_study.Scene.of(two.settings))
    assert both.filter(pl.col("record") == 1).equals(alone)


def test_shorter_horizons_come_from_the_same_copies() -> None:
    rows = pl.DataFrame({"first_s": [[3.0, np.inf], [10.0, 20.0]], "true_s": [np.inf, 7.0]})
    for horizon, said, happened in ((5.0, [0.5, 0.0], [0.0, 0.0]), (10.0, [0.5, 0.5], [0.0, 1.0])):
        found = foreseen(rows, horizon)
        np.testing.assert_array_equal(found[0], said)
        np.testing.assert_array_equal(found[1], happened)
