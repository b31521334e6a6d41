"""The monitor itself: lines go in, answers come out; no clock of the wall but for silence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

import ssmash_gym
from ssmash_gym.evaluation.conditions import digest
from ssmash_gym.evaluation.statistics import share
from ssmash_gym.info import LIBRARIES, installed
from ssmash_gym.monitor.futures import DeckModel, future_nodes, samples_ahead, splined_nodes
from ssmash_gym.monitor.intake import CLOSEST_S, Intake
from ssmash_gym.monitor.judging import JUDGED, deck_margins, deck_use
from ssmash_gym.monitor.quiet import next_quiet
from ssmash_gym.monitor.rehearsal import Copies, Rehearsed, Scene, Shadow
from ssmash_gym.monitor.settings import ANSWER_S, SPACING_S, SUBSTEP_S, Settings
from ssmash_gym.ship.forecast import ORDER
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, N_CHANNELS, Signal, smootherstep
from ssmash_gym.ship.quiescence import SHORTEST_S

OK: Final = "ok"
UNKNOWN: Final = "unknown"
RAMP_S: Final = 8.0  # over which the measured motion is brought up on the secured helicopter, from a level deck
_PER_ANSWER: Final = round(ANSWER_S / SPACING_S)
_NODES: Final = round(ANSWER_S / DEFAULT_SPACING_S)


@dataclass(frozen=True)
class Answer:
    """What the monitor says of one second.

    Attributes:
        time_s: Of the deck's clock [s]; None where no time could be read yet.
        status: ``ok`` or ``unknown``.
        reason: Why it is unknown, in a sentence.
        figures: The numbers of an answer that is ok; empty otherwise.
        malformed: Rows that could not be used so far.
    """

    time_s: float | None
    status: str
    reason: str | None
    malformed: int
    figures: dict[str, Any] = field(default_factory=dict)

    def record(self) -> dict[str, Any]:
        """The answer as one JSON object; what is not known is null, never a number."""
        return {
            "type": "answer",
            "time_s": self.time_s,
            "status": self.status,
            "reason": self.reason,
            **{name: self.figures.get(name) for name in FIGURES},
            "malformed": self.malformed,
        }


FIGURES: Final = (
    "margin_now", "margin_now_limit", "next_quiet", "p_exceed", "p_exceed_interval", "p_exceed_limit", "past_s",
)  # fmt: skip


class Monitor:
    """Watches one deck.

    Args:
        settings: What it is told.

    Raises:
        ConfigurationError: A name or a number is refused; one sentence.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.intake = Intake(settings)
        self._scene = Scene.of(settings)
        self._intervals = round(ANSWER_S / self._scene.task.control_interval_s)
        self._shadow = Shadow(self._scene)
        self._copies = Copies(self._scene, settings.copies, settings.threads)
        self._of = np.zeros(settings.copies, np.int64)
        self._begin_s = math.nan  # of the past that is being watched
        self._begun_s = math.nan  # when the secured helicopter stood on a level deck
        self._due_s = math.nan
        self._epoch = 0
        self._told = "", math.nan
        self._now: _Now | None = None

    def header(self) -> dict[str, Any]:
        """What was asked for and by which versions: the first line."""
        task = self._scene.task
        told = {**self.settings.answered_from, "substep_s": SUBSTEP_S, "order": ORDER, "ramp_s": RAMP_S}
        return {
            "type": "header",
            "configuration": digest(told, task.model_dump(mode="json")),
            "settings": told,
            "limits": task.limits.model_dump(mode="json"),
            "deck_limits": dict(self.settings.deck_limits),
            "judged": list(JUDGED),
            "limits_are": "assumed",
            "quiet_shortest_s": SHORTEST_S,
            "versions": {"ssmash_gym": ssmash_gym.__version__, **{name: installed(name) for name in LIBRARIES}},
        }

    def warm_up(self) -> None:
        """Make an answer about a level deck and throw it away: what is loaded for the first one is there then."""
        past = np.zeros((2 * ORDER, N_CHANNELS))
        futures = DeckModel.fit(past).sample(self.settings.copies, samples_ahead(ANSWER_S), np.random.default_rng(0))
        nodes = future_nodes(past, futures[1:], _NODES + 1)
        self._risk(self._copies.drive(self._shadow.snapshot(), self._of, nodes, ANSWER_S))

    # --- samples -------------------------------------------------------------------------------------------

    def feed(self, lines: Iterable[str], *, newest_only: bool = False) -> Iterator[Answer]:
        """Take lines as they have come in, and answer every second that they complete.

        Args:
            lines: Rows of a SHIPMO file, header and comments included; anything else is counted and left out.
            newest_only: Answer no second that is followed by another one in these lines: they have waited.
        """
        held: Answer | float | None = None
        for line in lines:
            self.intake.take(line)
            for event in self._events():
                if newest_only:
                    held = event
                else:
                    yield self._said(event)
        if held is not None:
            yield self._said(held)

    def _said(self, event: Answer | float) -> Answer:
        return event if isinstance(event, Answer) else self._answer(event)

    def silent(self, silence_s: float) -> Answer:
        """The answer while a live input says nothing.

        Args:
            silence_s: For how long there has been no usable sample, by the clock on the wall [s].
        """
        fault = self.intake.latest_fault
        told = f" (last: {fault})" if fault else ""
        hint = "" if self.intake.accepted and fault else "; a finished record is replayed with --pace fast or real"
        return self._unknown(self.intake.clock_s, f"no usable sample for {silence_s:.0f} s{told}{hint}")

    def doubted(self, reason: str) -> Answer:
        """The answer where the newest sample may not be of now.

        Args:
            reason: Why, in a sentence.
        """
        return self._unknown(self.intake.clock_s, reason)

    def finish(self) -> Answer | None:
        """What is left to say at the end of the input: that its last rows could not be used, if so."""
        fault = self.intake.latest_fault
        return self._unknown(self.intake.clock_s, f"the input ends with unusable rows: {fault}") if fault else None

    def _events(self) -> Iterator[Answer | float]:
        """What the last line has brought: answers that say unknown, and seconds for which the present is ready."""
        intake = self.intake
        intake.lapse()
        if intake.epoch != self._epoch:
            self._epoch = intake.epoch
            if not self._just_told(intake.why, intake.clock_s):  # a stuck channel is at fault in every row
                self._due_s = _next_second(intake.clock_s)
                yield self._unknown(intake.clock_s, f"{intake.why}; a fresh past has to grow")
        if intake.begin_s != self._begin_s and not math.isnan(intake.begin_s):
            self._begin_s, self._begun_s = intake.begin_s, math.nan
            self._due_s = ANSWER_S * math.ceil(intake.begin_s / ANSWER_S - 1e-9)
        if math.isnan(self._due_s):
            self._due_s = _next_second(intake.clock_s)
        while self._due_s <= intake.newest_s + CLOSEST_S:
            self._due_s += ANSWER_S
            unknown = self._moved_on(self._due_s - ANSWER_S)
            if unknown is not None and intake.why and self._just_told(intake.why, self._due_s - ANSWER_S):
                continue
            yield self._due_s - ANSWER_S if unknown is None else unknown
        if math.isnan(intake.newest_s) and intake.clock_s >= self._due_s:
            self._due_s = _next_second(intake.clock_s)
            yield self._unknown(intake.clock_s, f"no usable sample (last: {intake.latest_fault})")

    def _just_told(self, why: str, time_s: float) -> bool:
        """Whether the same has been said within the last second of the deck's clock."""
        before_why, before_s = self._told
        if why == before_why and 0.0 <= time_s - before_s < ANSWER_S - CLOSEST_S:
            return True
        self._told = why, time_s
        return False

    # --- the present ------------------------------------------------------------------------------------------

    def _moved_on(self, now_s: float) -> Answer | None:
        """Bring the secured helicopter to a second; the answer if nothing can be said of it."""
        self._now = None
        past = self.intake.samples(now_s)
        if len(past) <= _PER_ANSWER:
            self._begun_s = now_s
            self._shadow.begin()
            return self._unknown(now_s, self._too_short(now_s))
        if math.isnan(self._begun_s):
            self._begun_s = now_s - ANSWER_S
            self._shadow.begin()
        long_enough = self.intake.past_s(now_s) >= self.settings.least_past_s - 1e-6
        futures = self._futures(past, now_s) if long_enough else np.zeros((1, 0, past.shape[1]))
        piece = self._piece(past, futures[0], now_s)
        margins = {name: float(values[0]) for name, values in self._shadow.advance(piece, self._intervals).items()}
        lost = self._shadow.lost()
        if lost:
            self.intake.forget(f"{lost} at {now_s:g} s: the motion is more than it bears")
            self._epoch = self.intake.epoch
            return self._unknown(now_s, f"{self.intake.why}; a fresh past has to grow")
        if not long_enough:
            return self._unknown(now_s, self._too_short(now_s))
        self._now = _Now(past, futures, piece, margins)
        return None

    def _futures(self, past: FloatArray, now_s: float) -> FloatArray:
        settings = self.settings
        rng = np.random.default_rng([settings.seed, round(now_s / ANSWER_S) % 2**63])
        return DeckModel.fit(past).sample(settings.copies, samples_ahead(settings.horizon_s), rng)

    def _piece(self, past: FloatArray, ahead: FloatArray, now_s: float) -> FloatArray:
        """Nodes of the last second, (1, n, 18), brought up from a level deck at the beginning."""
        series = np.concatenate([past[-6 * _PER_ANSWER :], ahead[:_PER_ANSWER]])
        last = min(len(past), 6 * _PER_ANSWER) - 1
        age_s = now_s - self._begun_s
        if age_s < RAMP_S + len(series) * SPACING_S:
            ages_s = age_s + SPACING_S * np.arange(-last, len(series) - last, dtype=np.float64)
            factor, _, _ = smootherstep(ages_s, RAMP_S)
            series = series * factor[:, np.newaxis]
        times = DEFAULT_SPACING_S * np.arange(-_NODES, 1, dtype=np.float64)
        return splined_nodes(series[:, np.newaxis], last, times)

    def _too_short(self, now_s: float) -> str:
        why = f" after: {self.intake.why}" if self.intake.why else ""
        past_s, least_s = self.intake.past_s(now_s), self.settings.least_past_s
        return f"{past_s:.0f} s of past without a gap, {least_s:g} s are needed{why}"

    def _unknown(self, time_s: float, reason: str) -> Answer:
        return Answer(None if math.isnan(time_s) else round(time_s, 6), UNKNOWN, reason, self.intake.malformed)

    # --- the future -------------------------------------------------------------------------------------------

    def _answer(self, now_s: float) -> Answer:
        """The answer at the second that the secured helicopter has just reached."""
        now = self._now
        assert now is not None
        settings = self.settings
        count = math.ceil(settings.horizon_s / DEFAULT_SPACING_S - 1e-9) + 1
        nodes = future_nodes(now.past, now.futures[1:], count)
        if not np.isfinite(nodes).all():
            return self._unknown(now_s, "the forecast of the deck's motion is not finite")
        rehearsed = self._copies.drive(self._shadow.snapshot(), self._of, nodes, settings.horizon_s)
        figures = {
            **now.margin(settings.deck_limits),
            **self._risk(rehearsed),
            "next_quiet": self._quiet(nodes, now_s),
            "past_s": round(min(self.intake.past_s(now_s), settings.past_s), 6),
        }
        return Answer(round(now_s, 6), OK, None, self.intake.malformed, figures)

    def _risk(self, rehearsed: Rehearsed) -> dict[str, Any]:
        found = share(rehearsed.exceeded(self.settings.horizon_s).astype(np.float64))
        return {
            "p_exceed": round(found.value, 6),
            "p_exceed_interval": [round(bound, 6) for bound in found.interval],
            "p_exceed_limit": rehearsed.most,
        }

    def _quiet(self, nodes: FloatArray, now_s: float) -> dict[str, float] | None:
        window = next_quiet(deck_use(nodes, self.settings.deck_limits), self.settings.quiet_share)
        if window is None:
            return None
        return {
            "start_s": round(now_s + window.in_s, 6),
            "in_s": round(window.in_s, 6),
            "length_s": round(window.length_s, 3),
            "share": round(window.share, 6),
        }


def _next_second(time_s: float) -> float:
    """The first answer after a time; nan after none."""
    return math.nan if math.isnan(time_s) else ANSWER_S * (math.floor(time_s / ANSWER_S + 1e-9) + 1)


@dataclass(frozen=True, eq=False)
class _Now:
    """The present: the past samples, the forecast and futures, the last second's nodes, and the loads' margins."""

    past: FloatArray
    futures: FloatArray
    piece: FloatArray
    loads: dict[str, float]

    def margin(self, deck_limits: Any) -> dict[str, Any]:
        """The least margin within the last second, and which limit it is of."""
        nodes = self.piece[0]
        margins = {**deck_margins(Signal(nodes[:, :6], nodes[:, 6:12], nodes[:, 12:]), deck_limits), **self.loads}
        least = min(margins, key=lambda name: margins[name])
        return {"margin_now": round(margins[least], 6), "margin_now_limit": least}
