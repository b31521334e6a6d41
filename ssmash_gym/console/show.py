"""What happens at the console, in order: an episode is prepared, started, driven in real time, closed and recorded."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from ssmash_gym.console.commands import Fresh, Newest
from ssmash_gym.console.desk import STANDING, Desk, entrant_of
from ssmash_gym.console.pace import Pace
from ssmash_gym.console.programme import FreeDrive, Programme
from ssmash_gym.console.roles import Roles
from ssmash_gym.console.runs import run_of_trial
from ssmash_gym.console.words import score_words
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.trials.review import rival_run
from ssmash_gym.trials.session import KEPT, Assignment, result_of
from ssmash_gym.trials.stamps import Stamp, waited_ms
from ssmash_gym.trials.trial import PAGE, PRACTICE, Trial

Phase = Literal["preparing", "ready", "countdown", "running", "over", "done"]
AT_REST: Final = ("ready", "over")  # phases in which inputs may change
ABSENT_S: Final = 3.0  # with nobody at the claw, or a silent page, in a session: then the trial is broken off
RECENT: Final = 50  # commands over which the shown latency is taken
Tell = Callable[[dict[str, Any]], None]


@dataclass(frozen=True)
class Rules:
    """How time is kept; the protocol's in a session, these in a free drive. All assumed.

    Attributes:
        countdown_s: Between the start button and the first control step [s].
        late_after_s: A step taken so much after it was due counts as late [s].
        late_share: Share of late steps from which a trial is not valid.
    """

    countdown_s: float = 3.0
    late_after_s: float = 0.02
    late_share: float = 0.02


class Show:
    """Runs the desk in real time.

    Args:
        programme: Which episodes, and where their records go.
        tell: Sends a message to all pages.
        rules: How time is kept.
        policy: At hand for taking the claw, and to compare with; a name, or an agent's folder.
        by_policy: Whether it drives from the beginning.

    Attributes:
        session: Whether it is one by protocol: a person drives, and nobody else.
        roles, newest: Who drives, and the newest command.
        phase: Where the show stands.
        kept: Record of the last episode, and its file.
        begun_s: Server's clock at the present episode's first control step [s].

    Raises:
        ConfigurationError: The condition or the policy is refused.
    """

    def __init__(
        self,
        programme: Programme,
        tell: Tell,
        rules: Rules | None = None,
        *,
        policy: str | None = None,
        by_policy: bool = False,
    ) -> None:
        self.programme = programme
        self.rules = rules or Rules()
        self.roles = Roles("policy" if by_policy else "person")
        self.newest = Newest()
        self.phase: Phase = "preparing"
        self.kept: tuple[Trial, Path] | None = None
        self.last: dict[str, dict[str, Any]] = {}  # newest message of each kind that a page needs when it joins
        self._tell = tell
        self._word = policy
        self.session = not isinstance(programme, FreeDrive)
        self._desk = self._make_desk(programme.condition)
        self._assignment = programme.next()
        self._wish = self._granted = ""
        self._woken = asyncio.Event()
        self._pace = Pace(self.interval_s, self.rules.late_after_s, 0.0)
        self._latencies: list[float] = []
        self.begun_s = 0.0
        self._review: dict[str, Any] | None = None

    # --- what pages wish ----------------------------------------------------------------------------------------

    @property
    def policy(self) -> str | None:
        """Name of the policy at hand."""
        return self._desk.policy

    @property
    def interval_s(self) -> float:
        """Between two commands [s]."""
        return self._desk.interval_s

    def call(self, wish: str) -> str:
        """A wish of the driver: start, again, next or abort; returns why it is not granted, or nothing."""
        allowed = {
            "start": self.phase == "ready",
            "abort": self.phase in ("countdown", "running"),
            "next": self.phase == "over" or (self.phase == "ready" and not self.session),
            "again": self.phase == "over" and not self.session,
        }
        if not allowed[wish]:
            return f"{wish!r} is not possible now: the episode is {self.phase}."
        self._wish = wish
        self._woken.set()
        return ""

    def hand(self, by: Literal["person", "policy"]) -> str:
        """Give the claw to the policy or to a person; returns why not, or nothing."""
        if by == "policy" and self.policy is None:
            return "no policy drives in a session." if self.session else "there is no policy at hand."
        self.roles.by = by
        return ""

    async def configure(self, condition: Condition) -> None:
        """Make another desk, between episodes; takes long where kernels must be compiled.

        Raises:
            ConfigurationError: The condition is refused; nothing has changed.
        """
        before = self.phase
        if before not in AT_REST or not isinstance(self.programme, FreeDrive):
            where = "in a session" if self.session else f"while the episode is {before}"
            raise ConfigurationError(f"inputs cannot be changed {where}.")
        self._enter("preparing")
        try:
            self._desk = await asyncio.to_thread(self._make_desk, condition)
        except BaseException:  # whatever it was: the show must not wait for a desk that never comes
            self._enter(before)
            raise
        self.programme.condition = condition
        self._wish = "again"
        self._woken.set()

    def _make_desk(self, condition: Condition) -> Desk:
        entrant = None if self._word is None or self.session else entrant_of(self._word, condition.task)
        return Desk(condition, entrant)

    # --- the show -----------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Episode after episode, until there is none left."""
        while self._assignment is not None:
            ready = await self._prepare(self._assignment)
            if ready and await self._wished("start", "next", "again") == "start" and await self._count_down():
                self.programme.begin(self._assignment)
                try:
                    await self._drive()
                finally:
                    self._close()
            if self.phase == "over":
                await self._wished("again", "next")
            if isinstance(self.programme, FreeDrive) and self._granted == "next":
                self.programme.on()
            self._assignment = self.programme.next()
        self._enter("done")

    async def _wished(self, *wishes: str) -> str:
        """Wait for one of the wishes."""
        while self._wish not in wishes:
            self._woken.clear()
            await self._woken.wait()
        self._granted, self._wish = self._wish, ""
        return self._granted

    async def _prepare(self, assignment: Assignment) -> bool:
        """Bring the next episode to its start; False where its sea, its ship or its helicopter cannot be started."""
        self._enter("preparing")
        self._wish = self._granted = ""
        desk = self._desk
        about = {
            "allowed_late_share": self.rules.late_share,
            **self.programme.about(assignment),
            "origin": PAGE,
            "started_utc": datetime.now(UTC).isoformat(timespec="seconds"),
        }
        try:
            await asyncio.to_thread(desk.begin, assignment.seed, about)
        except ConfigurationError as refusal:
            self._tell({"type": "refused", "message": str(refusal), "about": "start"})
            self._enter("over")
            return False
        condition = desk.condition
        self.last.pop("result", None)
        self._send(
            "setup", setup=desk.setup(), seed=desk.seed, configuration=condition.configuration,
            session={**about["session"], "participant": self.programme.participant},
            names={
                "scenario": condition.name, "helicopter": condition.helicopter.name, "ship": _ship(condition.scenario),
            },
        )  # fmt: skip
        self._pace = Pace(desk.interval_s, self.rules.late_after_s, 0.0)
        self._latencies = []
        self._frame(None, "none")
        self._enter("ready")
        return True

    async def _count_down(self) -> bool:
        """Count down to the first control step; False when it was broken off."""
        end = time.perf_counter() + self.rules.countdown_s
        while (left := end - time.perf_counter()) > 0.0:
            self._enter("countdown", seconds=round(left, 1))
            await asyncio.sleep(min(left, 0.25))
            if self._wish == "abort":
                self._wish = ""
                return False
        return not (self.session and self.roles.driver is None)

    async def _drive(self) -> None:
        """All control steps of an episode, each at its instant of the wall clock."""
        self._enter("running")
        self.newest.episode()
        self.begun_s = begun = time.perf_counter()
        self._pace = pace = Pace(self.interval_s, self.rules.late_after_s, begun)
        before: Stamp | None = None
        absent_s = 0.0
        while not self._desk.over and self._wish != "abort" and absent_s < ABSENT_S:
            await asyncio.sleep(max(0.0, pace.due_s - time.perf_counter()))
            action = self._desk.wish()
            await asyncio.sleep(0)  # what has arrived meanwhile is read now: the newest input is taken last
            now, due = time.perf_counter(), pace.due_s
            fresh = self.newest.read(now, self.interval_s)
            late = pace.take(now)
            absent_s = absent_s + self.interval_s if self.session and fresh is None else 0.0
            by_policy = self.roles.by == "policy" and action is not None
            stamp = self._stamp(None if by_policy else fresh, by_policy, due - begun, now - begun, begun, late)
            command = STANDING if fresh is None else (fresh.along, fresh.across)
            self._desk.step(action if by_policy else None, command, stamp)
            wait = waited_ms(stamp, before)
            before = stamp
            self._latencies += [] if wait is None else [wait]
            self._frame(fresh, "policy" if by_policy else self._whose(fresh))
        self._wish = ""

    def _whose(self, fresh: Fresh | None) -> str:
        """Whose command a person's step is: expired is a driver whose page has fallen silent."""
        return "person" if fresh is not None else "none" if self.roles.driver is None else "expired"

    def _stamp(
        self, fresh: Fresh | None, by_policy: bool, planned_s: float, taken_s: float, begun: float, late: bool
    ) -> Stamp:
        driver = str(self.policy) if by_policy else "none" if fresh is None else "person"
        known = fresh or Fresh(0.0, 0.0, "", -1, float("nan"), float("nan"))
        return Stamp(
            driver=driver, device=known.device, sequence=known.sequence, input_ms=known.input_ms,
            received_s=known.received_s - begun, planned_s=planned_s, taken_s=taken_s, late=late,
            shown_step=self.newest.shown_step,
        )  # fmt: skip

    def _close(self) -> None:
        """Keep the record and tell how it went; also when the console is stopped in the middle."""
        if self._desk.result is None:
            return
        trial = self._desk.trial()
        path = self.programme.keep(trial)
        self.kept, self._review = (trial, path), None
        timing = trial.about["timing"]
        words = score_words(self._desk.condition.task, self._desk.ending)
        spoilt = self._spoilt(trial)
        words += [f"{spoilt}: the trial does not count."] if spoilt else []
        self._send(
            "result", metrics=trial.about["metrics"], words=words, valid=not spoilt, file=path.name,
            latency_ms=timing["latency_ms"], late_share=timing["late_share"],
            beside=self._word is not None and self._revealing(trial),
        )  # fmt: skip
        self._enter("over")

    def _spoilt(self, trial: Trial) -> str:
        """Why a trial does not count, however it went; empty where it does."""
        if not trial.valid:
            return f"{100.0 * trial.about['timing']['late_share']:.1f} % of the control steps came late"
        if self.session and trial.deserted:
            return (
                f"nobody was at the claw, or its page was silent, in {100.0 * trial.deserted_share:.0f} % of the steps"
            )
        return ""

    # --- messages -----------------------------------------------------------------------------------------------

    def _send(self, kind: str, **content: Any) -> None:
        message = {"type": kind, **content}
        self.last[kind] = message
        self._tell(message)

    def _enter(self, phase: Phase, **more: Any) -> None:
        self.phase = phase
        self._send("phase", phase=phase, **more)

    def _frame(self, fresh: Fresh | None, claw: str) -> None:
        if not self._desk.sound:
            return  # the last sound picture stays
        recent = self._latencies[-RECENT:]
        self._send(
            "frame", frame=self._desk.frame(), late=self._pace.late, steps=self._pace.steps, claw=claw,
            used=-1 if fresh is None else fresh.sequence,
            latency_ms=round(float(np.percentile(recent, 95.0)), 1) if recent else None,
        )  # fmt: skip

    async def review(self) -> dict[str, Any]:
        """The last episode beside the policy's own in the same sea; made when it is first asked for.

        In a session the policy's is left out while that could teach something of a sea that is yet to be driven: of
        scored trials until the session is done, and of trials whose sea comes again.

        Raises:
            ConfigurationError: No episode has been driven.
        """
        if self.kept is None:
            raise ConfigurationError("there is nothing to review: no episode has been driven.")
        if self._review is None:
            self._review = await asyncio.to_thread(self._runs, *self.kept, self._revealing(self.kept[0]))
        return self._review

    def _revealing(self, trial: Trial) -> bool:
        """Whether a policy's run in the same sea may be shown."""
        if not self.session or self.programme.next() is None:
            return True
        return trial.phase == PRACTICE and result_of(trial) == KEPT

    def _runs(self, trial: Trial, path: Path, revealing: bool) -> dict[str, Any]:
        runs = [run_of_trial(trial, path.stem)]
        if self._word is not None and revealing:
            runs.append(run_of_trial(rival_run(trial.condition, trial.seed, self._word), f"{self.policy}"))
        return {"type": "review", "runs": runs}


def _ship(scenario: ScenarioConfig) -> str:
    """Name of the ship, where the deck's motion is a ship's."""
    ship = getattr(scenario.motion, "ship", "")
    return str(ship.get("base", "own ship")) if isinstance(ship, Mapping) else Path(str(ship)).stem
