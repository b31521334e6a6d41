"""The parts of a training's time add up, and each is told without those inside it."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks import training_time
from benchmarks.training_time import PARTS, Stopwatch


class Work:
    """A training with a start of an episode in it, whose times are known."""

    def __init__(self, clock: list[float]) -> None:
        self.clock = clock

    def learn(self) -> None:
        self.clock[0] += 1.0
        self.start()
        self.advance(8.0)

    def start(self) -> None:
        self.clock[0] += 2.0
        self.advance(4.0)
        self.clock[0] += 0.5

    def advance(self, duration_s: float) -> None:
        self.clock[0] += duration_s


def test_a_part_does_not_hold_those_inside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(training_time.time, "perf_counter", lambda: clock[0])
    monkeypatch.setattr(training_time.time, "process_time", lambda: 2.0 * clock[0])
    watch = Stopwatch()
    places: list[tuple[Any, str, str]] = [
        (Work, "learn", "rest"), (Work, "start", "seas"), (Work, "advance", "simulation"),
    ]  # fmt: skip
    work = Work(clock)
    with watch.watching(places):
        work.advance(100.0)  # outside of the training
        work.learn()
    expected = dict.fromkeys(PARTS, 0.0) | {"rest": 1.0, "seas": 2.5, "lead-in": 4.0, "simulation": 8.0}
    assert watch.wall_s == expected
    assert watch.cpu_s == {name: 2.0 * value for name, value in expected.items()}
    assert "_watched" not in Work.learn.__qualname__


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_every_part_of_a_training_is_found(algorithm: str) -> None:
    small = [
        f"algorithm={algorithm}", "environment.task.horizon_s=2.0", "ppo.steps_per_update=32",
        "sac={steps_per_update: 32, train_every: 8, learning_starts: 64, batch_size: 16, buffer_size: 256}",
    ]  # fmt: skip
    figures = training_time.measure("smoke", 2, small)
    assert figures["steps"] == 2 * 4 * 32
    assert all(part["wall_share"] > 0.0 for part in figures["parts"].values())
    assert sum(part["wall_share"] for part in figures["parts"].values()) == pytest.approx(1.0, abs=1e-3)
