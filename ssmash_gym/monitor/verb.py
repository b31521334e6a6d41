"""`ssmash monitor`: answers about a deck's motion, one line of JSON a second."""

from __future__ import annotations

import json
import math
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Final, TextIO

import tyro

from ssmash_gym.monitor.intake import Intake
from ssmash_gym.monitor.settings import ANSWER_S, Settings
from ssmash_gym.monitor.stream import Pace, batches
from ssmash_gym.monitor.view import live_view
from ssmash_gym.monitor.watch import OK, Answer, Monitor

DRIFT: Final = 1e-3  # seconds a second by which the clocks of the wall and the deck may go apart


def monitor(
    follow: str,
    pace: Pace = "live",
    policy: str = Settings.policy,
    horizon: Annotated[float, tyro.conf.arg(aliases=("--horizon-s",))] = Settings.horizon_s,
    copies: int = Settings.copies,
    helicopter: str = Settings.helicopter,
    task: str = Settings.task,
    yaw_deg: float = Settings.yaw_deg,
    lateral_m: float = Settings.lateral_m,
    wind_m_s: float = Settings.wind_m_s,
    wind_from_deg: float = Settings.wind_from_deg,
    quiet_share: float = Settings.quiet_share,
    past_s: float = Settings.past_s,
    least_past_s: float = Settings.least_past_s,
    longest_gap_s: float = Settings.longest_gap_s,
    stuck_s: float = Settings.stuck_s,
    silence_s: float = Settings.silence_s,
    seed: int = Settings.seed,
    threads: int = Settings.threads,
    view: bool = False,
) -> None:
    """Watch a deck's motion as it is measured: margin now, next quiet window, risk of a traverse that starts now.

    Answers come as lines of JSON, one a second of the deck's clock, after a header line. Where the input is late,
    missing or absurd the answer is "unknown" with the reason, and no risk is told. All limits are assumed: this is no
    operational aid.

    Args:
        follow: Growing file in SHIPMO columns, or - for standard input.
        pace: live waits for what is appended; real and fast replay a finished record, by its clock or at once.
        policy: Who would drive: a baseline, a trained agent of the package, or an agent's folder.
        horizon: How long each traverse is simulated [s].
        copies: Simulated traverses for each answer.
        helicopter: Name in the catalogue, or a YAML file.
        task: Name in the catalogue, or a YAML file: its limits are the limits.
        yaw_deg: Heading of the secured helicopter relative to the track [deg].
        lateral_m: Claw from the centre line, starboard positive [m].
        wind_m_s: Steady wind over the deck [m/s].
        wind_from_deg: Where it comes from: 0 from the bow, 90 from starboard [deg].
        quiet_share: Share of the futures that must agree on a quiet window.
        past_s: Longest past that a forecast is fitted on [s].
        least_past_s: Past without a gap that is needed for an answer [s].
        longest_gap_s: Longest gap between samples that is bridged [s].
        stuck_s: Time after which a channel that repeats one number counts as stuck [s].
        silence_s: Wall-clock time without a sample after which a live input counts as silent [s].
        seed: Of the futures.
        threads: Workers; answers do not depend on it.
        view: Show the newest answer in the terminal, on the error stream.

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
    """
    settings = Settings(
        helicopter=helicopter, task=task, policy=policy, copies=copies, horizon_s=horizon, seed=seed, yaw_deg=yaw_deg,
        lateral_m=lateral_m, wind_m_s=wind_m_s, wind_from_deg=wind_from_deg, quiet_share=quiet_share, past_s=past_s,
        least_past_s=least_past_s, longest_gap_s=longest_gap_s, stuck_s=stuck_s, silence_s=silence_s, threads=threads,
    )  # fmt: skip
    source = batches(follow, pace)
    first = next(source, [])  # a file that is not there is refused before anything is written
    watching = Monitor(settings)
    watching.warm_up()
    write_line(sys.stdout, watching.header())
    took: list[float] = []
    try:
        with live_view(horizon, shown=view) as show:
            for answer in answers(watching, _again(first, source), pace, took):
                write_line(sys.stdout, answer.record())
                show(answer)
    except BrokenPipeError:  # whoever read the answers has gone: nothing is left to be said, not even at the exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    finally:
        _tell(took)


def answers(
    watching: Monitor,
    source: Iterator[list[str]],
    pace: Pace,
    took: list[float],
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Answer]:
    """The answers to an input as it comes.

    Args:
        watching: The monitor.
        source: Lists of lines, see `stream.batches`; empty ones let silence be noticed.
        pace: Of the input: only a live one can be silent, or so fast that seconds are passed over.
        took: Gets the seconds of the wall's clock that each answer took which is not unknown.
        clock: The clock on the wall [s].
    """
    heard = told = clock()
    freshness = Freshness(watching.settings.silence_s)
    accepted = watching.intake.accepted
    for lines in source:
        began = clock()
        for answer in watching.feed(lines, newest_only=pace == "live"):
            if pace == "live" and answer.status == OK:
                doubt = freshness.doubt(began, clock(), watching.intake)
                answer = watching.doubted(doubt) if doubt else answer
            if answer.status == OK:
                took.append(clock() - began)
            yield answer
            told = began = clock()
        freshness.backlog_is_read = freshness.backlog_is_read or bool(lines)
        now = clock()
        if watching.intake.accepted != accepted:
            accepted, heard = watching.intake.accepted, now
        elif pace == "live" and now - heard >= watching.settings.silence_s and now - told >= ANSWER_S:
            told = now
            yield watching.silent(now - heard)
    last = watching.finish()
    if last is not None:
        yield last


class Freshness:
    """Whether the newest sample of a live input is of now: by the wall's clock and the deck's, which may differ.

    Two clocks may drift apart by `DRIFT`; so a lag that does not grow is forgotten in the course of many minutes.

    Args:
        most_s: Time by which an answer may be behind the deck [s].

    Attributes:
        backlog_is_read: Whether what was there when listening began has been read: nobody knows how old that is.
    """

    def __init__(self, most_s: float) -> None:
        self.backlog_is_read = False
        self._most_s = most_s
        self._rewinds = 0
        self._best_s = math.inf  # wall's time less deck's, of the sample that was least late
        self._before_s = math.inf

    def doubt(self, read_s: float, now_s: float, intake: Intake) -> str:
        """Why an answer about the newest sample is not one about now; empty if it is.

        Args:
            read_s: When the sample was read [s].
            now_s: When the answer is ready [s].
            intake: What has been read.
        """
        if not self.backlog_is_read:
            return "no sample has come since the monitor began to listen"
        if intake.rewinds != self._rewinds:  # another clock, or set anew
            self._rewinds, self._best_s = intake.rewinds, math.inf
        offset_s = read_s - intake.newest_s
        leap_s = self._best_s - offset_s
        drifted_s = DRIFT * max(0.0, read_s - self._before_s)
        self._best_s, self._before_s = min(self._best_s + drifted_s, offset_s), read_s
        if math.isfinite(leap_s) and leap_s > self._most_s:
            return f"the samples' clock has run {leap_s:.1f} s ahead of the wall's: a record, or late before"
        if offset_s - self._best_s > self._most_s:
            return f"samples come {offset_s - self._best_s:.1f} s later than they did"
        if now_s - read_s + offset_s - self._best_s > self._most_s:
            return f"the answer took {now_s - read_s:.1f} s: it is about the past"
        return ""


def write_line(file: TextIO, record: dict[str, Any]) -> None:
    """Write one JSON object as one line, at once."""
    file.write(json.dumps(record, allow_nan=False) + "\n")
    file.flush()


def _again(first: list[str], source: Iterator[list[str]]) -> Iterator[list[str]]:
    yield first
    yield from source


def _tell(took: list[float]) -> None:
    """How long answers took, on the error stream."""
    if took:
        within_s = sorted(took)[math.ceil(0.95 * len(took)) - 1]
        print(
            f"monitor: {len(took)} answers, median {statistics.median(took):.2f} s, 95 % within {within_s:.2f} s, "
            f"longest {max(took):.2f} s each.",
            file=sys.stderr,
        )
