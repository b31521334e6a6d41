"""Which recorded trials count, and why the others do not: said before anything is compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.trials.files import read_trials
from ssmash_gym.trials.scripted import SCRIPTED_OPERATOR
from ssmash_gym.trials.stamps import PERSON
from ssmash_gym.trials.trial import PRACTICE, SCORED, SEVERAL, Trial


@dataclass(frozen=True)
class Entry:
    """One recorded trial in a benchmark.

    Attributes:
        path: Its file; place: the same below the folder that was named.
        trial: What is in it.
        driver: Who drove, as every table and figure calls it.
        scripted: Whether no person drove.
        reason: Why it does not count; empty: it does.
    """

    path: Path
    place: str
    trial: Trial
    driver: str
    scripted: bool
    reason: str

    @property
    def phase(self) -> str:
        """practice, scored or free."""
        return self.trial.phase

    @property
    def number(self) -> int:
        """Its place in the session, from 1; 0 outside of one."""
        return int(self.trial.about["session"].get("number") or 0)

    @property
    def attempt(self) -> int:
        """Which attempt at its sea it was; above 1 the driver had seen some of the sea before."""
        return int(self.trial.about["session"].get("attempt") or 1)

    @property
    def counts(self) -> bool:
        """Whether its figures are compared."""
        return not self.reason

    @property
    def learned(self) -> bool:
        """Whether it is a point of the learning curve: practice as well as scored, whole and in time."""
        return self.counts or (self.phase == PRACTICE and not unsound(self.trial))


def read_entries(folders: Sequence[Path]) -> list[Entry]:
    """All trials of the folders, each with the reason why it does not count, in the order in which they were driven.

    Args:
        folders: Each is searched with all folders below it.

    Raises:
        ConfigurationError: A folder is missing or holds no trial, a file is damaged, or one participant's session
            lies in two folders.
    """
    found: list[tuple[str, Path, Trial]] = []
    read: set[Path] = set()
    for folder in folders:
        for path, trial in read_trials(folder):
            if path.resolve() not in read:  # a folder may be named twice, or lie in another one
                found.append((path.relative_to(folder).as_posix(), path, trial))
            read.add(path.resolve())
    _refuse_doubles(found)
    found.sort(key=lambda one: (str(one[2].about.get("started_utc") or ""), one[0]))
    return _judged(found)


def _refuse_doubles(found: Sequence[tuple[str, Path, Trial]]) -> None:
    """Refuse one session in two folders: it is a copy, or two people have the same code."""
    homes: dict[tuple[str, str], Path] = {}
    for _, path, trial in found:
        identity, code = str(trial.about["session"]["id"]), str(trial.about["participant"])
        home = homes.setdefault((code, identity), path.parent) if identity else path.parent
        if home != path.parent:
            raise ConfigurationError(
                f"--trials is refused: {home} and {path.parent} hold the same session of participant {code}: name one "
                "of them; two people need two codes."
            )


def _judged(found: Sequence[tuple[str, Path, Trial]]) -> list[Entry]:
    """The trials with their reasons: of two of one driver in the same sea, the first one counts."""
    met: set[tuple[str, int]] = set()
    entries = []
    for place, path, trial in found:
        name, scripted = driver_of(trial)
        reason = unsound(trial) or unscored(trial)
        if not reason and (name, trial.seed) in met:
            reason = "the same driver has met this sea before"
        if not reason:
            met.add((name, trial.seed))
        entries.append(Entry(path, place, trial, name, scripted, reason))
    return entries


def driver_of(trial: Trial) -> tuple[str, bool]:
    """Who drove, and whether that was no person: only the page can have had somebody at the claw."""
    scripted = not trial.by_person
    code = str(trial.about.get("participant") or "without a name")
    if not scripted:
        return f"participant {code}", scripted
    return (code if code.startswith("scripted") else f"scripted {code}"), scripted


def unsound(trial: Trial) -> str:
    """Why a trial tells nothing of its driver; empty where it does."""
    if not trial.complete:
        return "broken off"
    if not trial.valid:
        timing = trial.about["timing"]
        share, allowed = (100.0 * float(timing[key]) for key in ("late_share", "allowed_late_share"))
        return f"late steps: {share:.3g} % of them, allowed {allowed:.3g} %"
    if trial.deserted:
        return f"nobody at the claw in {100.0 * trial.deserted_share:.3g} % of the steps"
    if trial.driver not in (PERSON, SCRIPTED_OPERATOR):
        return "driven by several" if trial.driver == SEVERAL else f"driven by {trial.driver}"
    if not trial.about["draw_of_seed"]:
        return "its sea was given by hand, not drawn from its seed"
    return ""


def unscored(trial: Trial) -> str:
    """Why a sound trial is not scored; empty where it is."""
    return {SCORED: "", PRACTICE: "practice"}.get(trial.phase, "outside of a session")


def only_configuration(entries: Sequence[Entry]) -> str:
    """The configuration that all scored trials, and those of the learning curves, have been driven in.

    Raises:
        ConfigurationError: No trial counts, or there are several configurations.
    """
    if not any(one.counts for one in entries):
        reasons = ", ".join(f"{one.place} ({one.reason})" for one in entries[:3])
        more = f" and {len(entries) - 3} more" if len(entries) > 3 else ""
        raise ConfigurationError(f"--trials is refused: no trial counts: {reasons}{more}.")
    kinds: dict[str, Entry] = {}
    for one in entries:
        if one.counts or one.learned:
            kinds.setdefault(str(one.trial.about["configuration"]), one)
    if len(kinds) > 1:
        told = " and ".join(f"{one.place} ({name})" for name, one in list(kinds.items())[:2])
        raise ConfigurationError(
            f"--trials is refused: its trials were driven in {len(kinds)} configurations, such as {told}; only trials "
            "of one can be compared."
        )
    return next(iter(kinds))
