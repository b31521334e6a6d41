"""Answers: what they hold, that they are repeatable, and that what is not known is never told as safe."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Sequence
from typing import Any

import pytest

from ssmash_gym.monitor import Answer, Monitor
from tests.monitor.decks import changed, lines, quick

ROLL = 1


def run(rows: Sequence[str], **changes: Any) -> list[dict[str, Any]]:
    monitor = Monitor(quick(**changes))
    found = [answer.record() for answer in monitor.feed(rows)]
    last = monitor.finish()
    return found + ([last.record()] if last else [])


@functools.cache
def told(rough: bool, threads: int = 1) -> tuple[dict[str, Any], ...]:
    return tuple(run(lines(rough), threads=threads))


def check_sound(records: Sequence[dict[str, Any]]) -> None:
    """Every answer is JSON, and one that is unknown has a reason and no figure."""
    for record in records:
        json.loads(json.dumps(record, allow_nan=False))
        if record["status"] == "ok":
            low, high = record["p_exceed_interval"]
            assert 0.0 <= low <= record["p_exceed"] <= high <= 1.0
            assert record["reason"] is None
        else:
            assert record["status"] == "unknown"
            assert record["reason"]
            figures = ("p_exceed", "p_exceed_interval", "margin_now", "next_quiet", "p_exceed_limit")
            assert all(record[name] is None for name in figures)


def test_one_answer_a_second_unknown_until_there_is_enough_past() -> None:
    records = told(rough=False)
    check_sound(records)
    assert [r["time_s"] for r in records] == list(range(35))
    assert [r["status"] for r in records] == ["unknown"] * 25 + ["ok"] * 10
    assert "20 s of past without a gap, 25 s are needed" in records[20]["reason"]


def test_a_calm_deck_has_margin_and_no_foreseen_exceedance_yet_no_certainty() -> None:
    for record in told(rough=False)[25:]:
        assert record["p_exceed"] == 0.0
        assert record["p_exceed_interval"][1] > 0.3  # of 8 copies
        assert record["p_exceed_limit"] is None
        assert record["margin_now"] > 0.5
        assert record["next_quiet"]["in_s"] == 0.0


def test_a_rough_deck_is_told_as_such() -> None:
    records = run(lines(rough=True), limits={"probe_in_plane_kN": 3.0}, horizon_s=12.0)
    check_sound(records)
    answered = [r for r in records if r["status"] == "ok"]
    assert sum(r["p_exceed"] for r in answered) / len(answered) > 0.9
    assert answered[0]["p_exceed_limit"] == "probe_in_plane"
    assert min(r["margin_now"] for r in answered) < 0.0


def test_the_same_input_and_seed_give_the_same_answers_whatever_the_threads() -> None:
    assert json.dumps(told(rough=True)) == json.dumps(run(lines(rough=True), threads=2))
    sampled = run(lines(rough=True), seed=5)
    assert sampled[0] == told(rough=True)[0]
    assert sampled[-1]["status"] == told(rough=True)[-1]["status"] == "ok"
    few = {"limits": {"probe_in_plane_kN": 11.0}, "horizon_s": 20.0}
    one, other = (run(lines(rough=True)[:150], seed=seed, **few) for seed in (0, 5))
    assert [r["p_exceed"] for r in one] != [r["p_exceed"] for r in other]


def test_lines_that_have_waited_are_answered_once_and_alike() -> None:
    monitor = Monitor(quick())
    found = list(monitor.feed(lines(rough=True), newest_only=True))
    assert [answer.record() for answer in found] == [told(rough=True)[-1]]


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda rows: [*rows[:150], *rows[165:]], "no usable sample from"),
        (lambda rows: [*rows[:150], *rows[100:]], "time ran backwards"),
        (lambda rows: [*rows[:150], *(changed(r, ROLL, "nan") for r in rows[150:])], "'nan'"),
        (lambda rows: [*rows[:150], *(changed(r, ROLL, "off") for r in rows[150:])], "'off'"),
        (lambda rows: [*rows[:150], *(changed(r, ROLL, "80") for r in rows[150:])], "no ship can have"),
        (lambda rows: [*rows[:150], *(changed(r, ROLL, "1.5") for r in rows[150:])], "stuck|jumps"),
        (lambda rows: [*rows[:150], *("garbage" for _ in rows[150:])], "columns"),
        (lambda rows: [*rows[:150], *(r[:20] for r in rows[150:])], "columns"),
    ],
)
def test_an_input_that_goes_wrong_is_unknown_and_never_safe(spoil: Any, words: str) -> None:
    rows = spoil(list(lines(rough=False)))
    records = run(rows)
    check_sound(records)
    wrong_s = (150 - 2) * 0.2
    first = next((k for k, r in enumerate(records) if r["time_s"] > wrong_s - 1.0), len(records))
    before = records[:first]
    assert before[-1]["status"] == "ok"
    # A stuck channel can be told once it has stuck for its time; all else at once, within the gap that is bridged.
    later = [r for r in records[len(before) :] if r["time_s"] >= wrong_s + 3.5 or r["time_s"] < wrong_s - 1.0]
    after = later or records[-1:]
    assert all(r["status"] == "unknown" for r in after)
    assert any(re.search(words, r["reason"] or "") for r in records[len(before) :])


def test_rows_that_are_a_few_samples_apart_are_bridged() -> None:
    rows = list(lines(rough=False))
    rows[150] = "1 2 3"
    rows[155] = changed(rows[155], ROLL, "-")
    records = run(rows)
    assert [r["status"] for r in records] == [r["status"] for r in told(rough=False)]
    assert records[-1]["malformed"] == 2


def test_after_a_gap_enough_fresh_past_is_needed_again() -> None:
    rows = list(lines(rough=False, duration_s=64.0))
    records = run([*rows[:152], *rows[170:]])
    check_sound(records)
    begin_s = (170 - 2) * 0.2
    status = {r["time_s"]: r["status"] for r in records if r["time_s"] > begin_s}
    assert all(s == ("ok" if t - begin_s >= 25.0 - 1e-6 else "unknown") for t, s in status.items())
    assert "ok" in status.values()


def test_a_motion_that_breaks_the_probe_is_unknown_and_not_calm() -> None:
    fierce = []
    for line in lines(rough=True):
        words = line.split(",")
        if len(words) == 16 and words[0] != "time_s":
            words[1:7] = [f"{3.0 * float(word):.6g}" for word in words[1:7]]
        fierce.append(",".join(words))
    records = run(fierce)
    check_sound(records)
    assert any("secured helicopter" in (r["reason"] or "") for r in records)
    assert not any(r["status"] == "ok" and r["p_exceed"] < 0.9 for r in records)


def test_warming_up_changes_no_answer() -> None:
    monitor = Monitor(quick())
    monitor.warm_up()
    assert [answer.record() for answer in monitor.feed(lines(rough=True))] == list(told(rough=True))


def test_the_header_tells_what_was_asked_for() -> None:
    header = Monitor(quick()).header()
    assert json.loads(json.dumps(header, allow_nan=False)) == header
    assert header["settings"]["copies"] == 8
    assert header["limits_are"] == "assumed"
    assert "threads" not in header["settings"]
    assert header["versions"]["numba"] != "-"
    other = Monitor(quick(threads=2)).header()
    assert other == header
    assert Monitor(quick(limits={"probe_in_plane_kN": 9.0})).header()["configuration"] != header["configuration"]


def test_silence_and_bad_last_rows_are_told() -> None:
    monitor = Monitor(quick())
    assert monitor.silent(3.2).record()["time_s"] is None
    assert list(monitor.feed(lines()[:40])) != []
    assert monitor.finish() is None
    list(monitor.feed(["rubbish"]))
    last = monitor.finish()
    assert isinstance(last, Answer) and last.status == "unknown"
    assert "rubbish" not in (last.reason or "") and "1 columns" in (last.reason or "")
