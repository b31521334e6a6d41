"""The vectorisations that are compared do the same work."""

from __future__ import annotations

from benchmarks.vectorisation import measure


def test_all_kinds_do_the_same_work() -> None:
    found = measure(2, 4, 1, kinds=("native", "dummy"), scenario="calm", threads=1)
    assert found["same"]
    assert set(found["kinds"]) == {"native", "dummy"}
    assert all(kind["steps_per_s"] > 0.0 for kind in found["kinds"].values())
