"""Lines of growing files and of finished ones, the command line, and silence by a clock of the test's own."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from ssmash_gym.cli import main
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.monitor import Monitor
from ssmash_gym.monitor.intake import Intake
from ssmash_gym.monitor.stream import LONGEST_LINE, Lines, batches
from ssmash_gym.monitor.verb import Freshness, answers
from ssmash_gym.monitor.view import picture
from tests.monitor.decks import lines, quick

QUICK = ["--copies", "8", "--horizon", "6", "--past-s", "40", "--least-past-s", "25", "--threads", "1"]


def test_a_growing_file_gives_out_what_is_appended_and_no_half_lines(tmp_path: Path) -> None:
    path = tmp_path / "deck.csv"
    path.write_text("a\nb\n")
    source = batches(str(path), "live", 0.001)
    assert next(source) == ["a", "b"]
    assert next(source) == []
    with path.open("a") as file:
        file.write("c\nhal")
    assert next(source) == ["c"]
    with path.open("a") as file:
        file.write("f\n")
    assert next(source) == ["half"]
    path.write_text("new\n")  # begun anew
    assert next(source) == ["new"]
    path.unlink()
    assert next(source) == []


def test_a_finished_file_comes_line_by_line_with_its_last_line(tmp_path: Path) -> None:
    path = tmp_path / "deck.csv"
    path.write_bytes(b"a\nb\xff\nlast")
    assert list(batches(str(path), "fast")) == [["a"], ["b�"], ["last"]]


def test_bytes_without_an_end_do_not_pile_up() -> None:
    cutter = Lines()
    assert cutter.cut(b"x" * LONGEST_LINE) == []
    assert len(cutter.cut(b"x")[0]) == LONGEST_LINE + 1
    assert cutter.rest() == []


def test_a_pipe_is_read_until_it_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Piped:
        buffer = io.BytesIO(b"a\nb\nc")

    monkeypatch.setattr("sys.stdin", Piped())
    assert [line for found in batches("-", "live", 0.01) for line in found] == ["a", "b", "c"]


def test_no_such_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="no such file"):
        next(batches(str(tmp_path / "none.csv"), "live"))


def ticking(source: Iterator[list[str]], step_s: float) -> tuple[Iterator[list[str]], Callable[[], float]]:
    """A clock that goes on by a step whenever the source is asked."""
    now = [0.0]

    def asked() -> Iterator[list[str]]:
        for found in source:
            now[0] += step_s
            yield found

    return asked(), lambda: now[0]


def test_a_silent_input_is_unknown_after_its_time_and_once_a_second() -> None:
    monitor = Monitor(quick())
    list(monitor.feed(lines()[:150]))
    source, clock = ticking(iter([[]] * 60), 0.1)
    found = list(answers(monitor, source, "live", [], clock))
    assert [a.status for a in found] == ["unknown"] * len(found)
    assert 4 <= len(found) <= 5  # from 2 s on, within 6 s
    assert "no usable sample for 2 s" in (found[0].reason or "")


def test_bad_rows_do_not_end_silence() -> None:
    monitor = Monitor(quick())
    list(monitor.feed(lines()[:150]))
    source, clock = ticking(iter([["rubbish"]] * 60), 0.1)
    found = list(answers(monitor, source, "live", [], clock))
    assert len(found) >= 5
    assert all(a.status == "unknown" for a in found)


def test_samples_that_come_ever_later_are_no_present() -> None:
    """A clock of the deck that goes at half the speed of the wall's: nothing is missing, and all of it is old."""
    monitor = Monitor(quick())
    list(monitor.feed(lines()[:140]))
    source, clock = ticking(iter([[line] for line in lines()[140:]]), 0.4)
    found = list(answers(monitor, source, "live", [], clock))
    assert found[0].status == "ok"
    assert found[-1].status == "unknown"
    assert "later than they did" in (found[-1].reason or "")


def doubts(freshness: Freshness, wall_s: float, deck_s: float, took_s: float = 0.0, rewinds: int = 0) -> str:
    """What is said of an answer about a deck time that was read and answered at given times of the wall."""
    intake = cast("Intake", SimpleNamespace(newest_s=deck_s, rewinds=rewinds))
    return freshness.doubt(wall_s, wall_s + took_s, intake)


def test_clocks_that_drift_are_not_late_and_a_steady_lag_is_forgotten_in_time() -> None:
    freshness = Freshness(2.0)
    freshness.backlog_is_read = True
    assert not any(doubts(freshness, 1000.0 + 1.0005 * t, float(t)) for t in range(36000))
    assert "3.0 s later than they did" in doubts(freshness, 1000.0 + 1.0005 * 36000 + 3.0, 36000.0)
    later = [doubts(freshness, 1003.0 + 1.0005 * t, float(t)) for t in range(36001, 39000)]
    assert later[60] and not later[-1]
    assert not doubts(freshness, 5000.0, 0.0, rewinds=1)  # a clock that has been set anew


def test_a_lag_is_not_forgotten_with_the_past() -> None:
    """Samples 30 s late, then a gap: the fresh past is as late as the old one."""
    freshness = Freshness(2.0)
    freshness.backlog_is_read = True
    assert not doubts(freshness, 100.0, 50.0)
    assert "30.0 s later" in doubts(freshness, 140.0, 60.0)
    assert "29.9 s later" in doubts(freshness, 240.0, 160.0)  # after whatever has been forgotten


def test_a_slow_answer_and_a_record_that_runs_through_a_pipe_are_not_about_now() -> None:
    freshness = Freshness(2.0)
    freshness.backlog_is_read = True
    assert not doubts(freshness, 100.0, 50.0, took_s=0.9)
    assert "the answer took 30.0 s" in doubts(freshness, 101.0, 51.0, took_s=30.0)
    for k in range(1, 5):
        assert "ahead of the wall's" in doubts(freshness, 101.0 + k, 51.0 + 100.0 * k)


def test_what_was_there_before_listening_is_never_a_present(tmp_path: Path) -> None:
    """A file that nobody writes any more looks like a calm one that has just been written: nothing is said of it."""
    path = tmp_path / "old.csv"
    path.write_text("\n".join(lines()[:150]) + "\n")
    source, clock = ticking(islice(batches(str(path), "live", 0.001), 40), 0.1)
    found = list(answers(Monitor(quick()), source, "live", [], clock))
    assert found and all(a.status == "unknown" for a in found)
    assert "no sample has come since the monitor began to listen" in (found[0].reason or "")


def test_a_stuck_channel_is_told_once_a_second() -> None:
    rows = [line.split(",") for line in lines(step_s=0.05)[:700]]
    stuck = [[*row[:1], rows[300][1], *row[2:]] if k >= 300 else row for k, row in enumerate(rows)]
    found = list(Monitor(quick()).feed([",".join(row) for row in stuck]))
    late = [a for a in found if (a.time_s or 0.0) > 20.0]
    assert all(a.status == "unknown" for a in late)
    assert 10 <= len(late) <= 20  # 15 s of rows


def test_a_live_input_is_answered_as_it_grows(tmp_path: Path) -> None:
    path = tmp_path / "deck.csv"
    path.write_text("\n".join(lines()[:150]) + "\n")
    monitor = Monitor(quick())
    source = batches(str(path), "live", 0.001)
    found = answers(monitor, source, "live", [])
    assert next(found).status == "unknown"  # nobody knows how long it has lain there
    with path.open("a") as file:
        file.write("\n".join(lines()[150:156]) + "\n")
    second = next(found)
    assert (second.time_s, second.status) == (30.0, "ok")


def test_the_command_writes_a_header_and_lines_of_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "deck.csv"
    path.write_text("\n".join(lines()[:145]))
    assert main(["monitor", "--follow", str(path), "--pace", "fast", "--view", *QUICK]) == 0
    shown = capsys.readouterr()
    records = [json.loads(line) for line in shown.out.splitlines()]
    assert [r["type"] for r in records] == ["header"] + ["answer"] * 29
    assert records[-1]["status"] == "ok"
    assert "4 answers, median" in shown.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--follow", "none.csv"], "no such file"),
        (["--follow", "-", "--policy", "mppi", "--pace", "fast"], "planner"),
        (["--follow", "-", "--copies", "0"], "copies = 0 is refused"),
    ],
)
def test_a_mistake_costs_one_sentence(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Empty:
        buffer = io.BytesIO(b"")

    monkeypatch.setattr("sys.stdin", Empty())
    assert main(["monitor", *words]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert told in shown.err and len(shown.err.splitlines()) == 1


def test_the_view_shows_what_is_known_and_what_is_not() -> None:
    from rich.console import Console

    screen = io.StringIO()
    console = Console(file=screen, width=100)
    monitor = Monitor(quick())
    for answer in monitor.feed(lines()[:140]):
        console.print(picture(answer, 6.0))
    console.print(picture(monitor.silent(3.0), 6.0))
    shown = screen.getvalue()
    assert "UNKNOWN" in shown and "no usable sample for 3 s" in shown
    assert "0 % exceed a limit" in shown and "next quiet window" in shown
