"""The driver's newest command: how long it counts, in which order, and for whom."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.console.commands import EXPIRY_S, ZERO_WITHIN_S, Newest
from ssmash_gym.console.messages import Command, Drive, Inputs, Plain, read
from ssmash_gym.console.pace import Pace
from ssmash_gym.console.roles import Roles

INTERVAL_S = 0.1


def command(sequence: int, along: float = 0.5, across: float = 0.0, sent_s: float = 0.0) -> Command:
    stamp_ms = 1e3 * (sent_s + 1e6)
    return Command(type="command", sequence=sequence, stamp_ms=stamp_ms, along=along, across=across, device="keyboard")


# --- commands --------------------------------------------------------------------------------------------


def test_a_command_counts_while_it_is_renewed_and_no_longer() -> None:
    newest = Newest()
    for k in range(20):
        newest.offer(command(k, sent_s=0.03 * k), 0.03 * k)
    last = 0.03 * 19
    assert newest.read(last + 0.19, INTERVAL_S) is not None
    assert newest.read(last + 0.21, INTERVAL_S) is None


@settings(deadline=None)
@given(age=st.floats(0.0, 1.0), interval=st.floats(0.005, 0.2))
def test_no_command_acts_beyond_its_time_whatever_the_control_interval(age: float, interval: float) -> None:
    newest = Newest()
    newest.offer(command(1), 5.0)
    if newest.read(5.0 + age, interval) is not None:
        assert age <= EXPIRY_S + 1e-6
        assert age + interval <= ZERO_WITHIN_S + 1e-6


def test_commands_out_of_order_are_dropped_and_do_not_renew() -> None:
    newest = Newest()
    assert newest.offer(command(5, along=0.2), 0.0)
    assert not newest.offer(command(5, along=1.0), 0.1)
    assert not newest.offer(command(4, along=1.0), 0.1)
    assert newest.dropped == 2
    found = newest.read(0.15, INTERVAL_S)
    assert found is not None
    assert found.along == 0.2
    assert newest.read(0.21, INTERVAL_S) is None, "a dropped message is no renewal"


def test_what_a_stalled_line_held_back_is_not_driven() -> None:
    newest = Newest()
    assert newest.offer(command(1, along=1.0, sent_s=0.0), 0.002)
    assert not newest.offer(command(2, along=1.0, sent_s=0.03), 2.0), "two seconds on its way"
    assert newest.read(2.0, INTERVAL_S) is None
    assert newest.offer(command(3, along=0.0, sent_s=1.99), 2.0)
    found = newest.read(2.0, INTERVAL_S)
    assert found is not None
    assert found.along == 0.0


def test_clocks_that_drift_apart_do_not_stop_the_claw() -> None:
    newest = Newest()
    for minute in range(600):  # ten hours, the page's clock slower by 0.1 s an hour
        now_s = 60.0 * minute
        assert newest.offer(command(minute, sent_s=now_s * (1.0 - 3e-5)), now_s)


def test_the_stamp_is_that_of_the_message_which_brought_the_command_not_of_its_renewals() -> None:
    newest = Newest()
    newest.offer(command(1, along=0.0, sent_s=1.00), 1.00)
    newest.offer(command(2, along=0.7, sent_s=1.03), 1.03)
    newest.offer(command(3, along=0.7, sent_s=1.06), 1.06)
    found = newest.read(1.10, INTERVAL_S)
    assert found is not None
    assert (found.sequence, found.received_s) == (2, 1.03)


def test_what_a_driver_held_down_is_forgotten_with_the_driver() -> None:
    newest = Newest()
    newest.offer(command(900, along=1.0), 0.0)
    newest.forget()
    assert newest.read(0.0, INTERVAL_S) is None
    assert newest.offer(command(0, along=0.1), 0.01), "another page counts from the beginning"


# --- messages --------------------------------------------------------------------------------------------


def test_every_kind_of_message_is_read() -> None:
    good = {
        "type": "command",
        "sequence": 1,
        "stamp_ms": 2.5,
        "along": -1.0,
        "across": 1,
        "device": "stick",
        "shown": 7,
    }
    assert isinstance(read(json.dumps(good)), Command)
    assert isinstance(read('{"type": "drive", "by": "policy"}'), Drive)
    assert isinstance(read('{"type": "configure", "base": {"scenario": "ss3"}, "changes": {"task": {}}}'), Inputs)
    for kind in ("take", "release", "start", "again", "next", "abort", "review", "schema"):
        assert isinstance(read(json.dumps({"type": kind})), Plain)


BAD = [
    "", "null", "[]", "7", '"take"', "{", "{}", '{"type": "fly"}', '{"type": 3}', '{"type": "take", "more": 1}',
    '{"type": "command"}', '{"type":"command","sequence":1,"stamp_ms":0,"along":NaN,"across":0}',
    '{"type":"command","sequence":1,"stamp_ms":0,"along":Infinity,"across":0}',
    '{"type":"command","sequence":1,"stamp_ms":0,"along":1.5,"across":0}',
    '{"type":"command","sequence":1,"stamp_ms":0,"along":"1","across":0}',
    '{"type":"command","sequence":1,"stamp_ms":0,"along":true,"across":0}',
    '{"type":"command","sequence":-1,"stamp_ms":0,"along":1,"across":0}',
    '{"type":"command","sequence":1.5,"stamp_ms":0,"along":1,"across":0}',
    '{"type":"command","sequence":1e400,"stamp_ms":0,"along":1,"across":0}',
    '{"type":"command","sequence":1,"stamp_ms":0,"along":1,"across":0,"device":"rocket"}',
    '{"type":"drive","by":"nobody"}', '{"type":"configure","changes":[]}', "[" * 60_000, '{"a":' * 10_000,
    b"\xff\xfe\x00", '{"type":"take"}{"type":"take"}', "\x00" * 100,
]  # fmt: skip


@pytest.mark.parametrize("text", BAD, ids=lambda text: repr(text[:40]))
def test_malformed_messages_are_none(text: str | bytes) -> None:
    assert read(text) is None


@settings(deadline=None)
@given(st.binary(max_size=300) | st.text(max_size=300))
def test_no_text_makes_the_reader_fail(text: str | bytes) -> None:
    found = read(text)
    assert found is None or not isinstance(found, Command) or math.isfinite(found.along)


# --- roles -----------------------------------------------------------------------------------------------


def test_one_driver_at_a_time() -> None:
    roles = Roles()
    roles.join(1)
    roles.join(2)
    assert roles.take(1)
    assert not roles.take(2)
    assert roles.driver == 1
    assert not roles.release(2)
    assert roles.release(1)
    assert roles.take(2)
    assert roles.leave(2)
    assert roles.driver is None
    assert not roles.take(2), "a page that is gone holds nothing"
    assert roles.message() == {"type": "roles", "driver": None, "viewers": 1, "by": "none"}


# --- pace ------------------------------------------------------------------------------------------------


def test_a_late_step_is_counted_and_does_not_move_the_next_ones() -> None:
    pace = Pace(0.1, 0.02, 10.0)
    late = [pace.take(now) for now in (10.0, 10.1, 10.23, 10.3)]
    assert late == [False, False, True, False]
    assert pace.due_s == pytest.approx(10.4)
    assert (pace.steps, pace.late) == (4, 1)


def test_time_slips_where_a_whole_interval_was_lost() -> None:
    pace = Pace(0.1, 0.02, 10.0)
    assert pace.take(10.35)
    assert pace.due_s == pytest.approx(10.45), "the steps that were missed are not driven all at once"
    assert (pace.steps, pace.late) == (4, 4), "three intervals were lost: whoever had to wait had time to think"
