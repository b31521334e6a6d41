"""A participant's session by a protocol: which sea comes next, and what has been driven; survives a stop or a kill."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Literal, Self

from filelock import FileLock, Timeout
from pydantic import Field

from ssmash_gym.document import read_file, write_yaml
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.evaluation.conditions import Condition, Section, digest
from ssmash_gym.files import write_text
from ssmash_gym.sections import validated
from ssmash_gym.trials.files import read_trial, write_trial
from ssmash_gym.trials.protocol import TrialProtocol
from ssmash_gym.trials.trial import PRACTICE, SCORED, Trial

PARTICIPANT: Final = "participant.yaml"
LOCK: Final = ".lock"
KEPT: Final = "kept"
INVALID: Final = "invalid"  # too many late steps, or nobody at the claw
INCOMPLETE: Final = "incomplete"  # broken off
UNKNOWN: Final = "unknown"  # experience that nobody has stated
_CODE: Final = re.compile(r"[A-Za-z0-9_-]{1,32}")
_HEAD: Final = (
    "# A participant's session. It holds no personal data: who the code stands for is written nowhere here.\n"
)


class Entry(Section):
    """One trial in a participant's file; without a file it was killed in the middle."""

    file: str | None = Field(None, pattern=r"^[A-Za-z0-9_]+\.parquet$")
    phase: Literal["practice", "scored"]
    number: int
    seed: int
    result: Literal["kept", "invalid", "incomplete"]


class Participant(Section):
    """A participant's file."""

    participant: str
    experience: str
    protocol: str
    scored_order: list[int]
    trials: list[Entry]
    under_way: Entry | None = None


@dataclass(frozen=True)
class Assignment:
    """The trial to be driven next.

    Attributes:
        seed: Of its sea.
        phase: ``practice`` or ``scored``.
        number: Of the trial in its phase, from 1; of: how many there are, of practice at most.
        attempt: 1, or more where earlier tries of this sea were invalid or broken off.
    """

    seed: int
    phase: str
    number: int
    of: int
    attempt: int


class Session:
    """The trials of one participant by one protocol, in one folder; `open` makes it.

    Attributes:
        protocol: By which it goes.
        participant: Code.
        folder: The participant's.
        condition: What is simulated.
        experience: Code of the participant's experience.
    """

    def __init__(
        self, protocol: TrialProtocol, participant: str, folder: Path, experience: str, lock: FileLock
    ) -> None:
        self.protocol = protocol
        self.participant = participant
        self.folder = folder
        self.condition: Condition = protocol.condition
        self.experience = experience
        self.identity = digest(protocol.identity, participant)
        self._order = protocol.order(participant)
        self._lock = lock
        self._books: list[Entry] = []
        self._under_way: Entry | None = None
        self._practised: list[dict[str, Any]] = []  # metrics of the practice trials that were kept

    @classmethod
    def open(
        cls, protocol: TrialProtocol, participant: str, folder: str | Path, *, experience: str | None = None
    ) -> Session:
        """Begin a session, or go on with one.

        Args:
            protocol: By which it goes.
            participant: Code of 1 to 32 letters, digits, ``_`` or ``-``.
            folder: Holds one folder for each participant.
            experience: Code of the participant's experience with such a task; asked for once.

        Raises:
            ConfigurationError: A code is refused; another process has the session open; it was begun by another
                protocol or with another experience; or its files are not those that were kept. Nothing has been
                changed.
        """
        check_code("participant", participant)
        if experience is not None:
            check_code("experience", experience)
        own = Path(folder) / participant
        own.mkdir(parents=True, exist_ok=True)
        lock = FileLock(own / LOCK, thread_local=False)
        try:
            lock.acquire(timeout=0)
        except Timeout:
            raise ConfigurationError(f"{own}: another process has this participant's session open.") from None
        session = cls(protocol, participant, own, experience or UNKNOWN, lock)
        try:
            session._resume(experience)
        except BaseException:
            lock.release()
            raise
        return session

    def close(self) -> None:
        """Let go of the participant's folder."""
        self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # --- what comes next ---------------------------------------------------------------------------------------

    @property
    def practising(self) -> bool:
        """Whether practice is not over yet."""
        return not self.protocol.practised(self._practised) and not self._done(SCORED)

    def next(self) -> Assignment | None:
        """The trial to be driven next; None when the session is done.

        A practice sea that was invalid or broken off comes again at once, a scored one after the others.
        """
        if self.practising:
            number = len(self._practised) + 1
            seed = self.protocol.practice_seeds[number - 1]
            return Assignment(seed, PRACTICE, number, self.protocol.practice.most, self._tries(PRACTICE, seed) + 1)
        done = {entry.seed for entry in self._done(SCORED)}
        left = [seed for seed in self._order if seed not in done]
        if not left:
            return None
        seed = min(left, key=lambda one: self._tries(SCORED, one))  # the first of those tried least
        number, tries = self._order.index(seed) + 1, self._tries(SCORED, seed)
        return Assignment(seed, SCORED, number, len(self._order), tries + 1)

    def about(self, assignment: Assignment) -> dict[str, Any]:
        """What a `TrialRecorder` is to be told of a trial of this session."""
        return {
            "participant": self.participant,
            "experience": self.experience,
            "protocol": self.protocol.identity,
            "session": {
                "number": assignment.number,
                "of": assignment.of,
                "phase": assignment.phase,
                "id": self.identity,
                "attempt": assignment.attempt,
            },
            "allowed_late_share": self.protocol.late.share,
        }

    # --- what has been driven ----------------------------------------------------------------------------------

    def begin(self, assignment: Assignment) -> None:
        """Book that a trial is about to be driven: whatever ends it, its sea has then been seen.

        Args:
            assignment: The present `next`.
        """
        self._under_way = Entry(
            file=None, phase=assignment.phase, number=assignment.number, seed=assignment.seed, result=INCOMPLETE
        )
        self._write()

    def keep(self, trial: Trial) -> Path:
        """Write a trial's file and book it.

        One that is invalid or was broken off is kept as such, and its sea comes again.

        Args:
            trial: Recorded with `about` of the present `next`.

        Returns:
            The file.

        Raises:
            ConfigurationError: It is not the trial that comes next.
        """
        assignment = self._fits(trial)
        name = f"{len(self._books) + 1:03d}_{trial.phase}_{assignment.number:02d}"
        result = result_of(trial)
        path = self.folder / (f"{name}.parquet" if result == KEPT else f"{name}_{result}.parquet")
        write_trial(path, trial)
        self._book(path, trial, result)
        self._write()
        return path

    def _fits(self, trial: Trial) -> Assignment:
        """The assignment that a trial fulfils."""
        assignment = self.next()
        if assignment is None:
            raise ConfigurationError(f"{self.folder}: the session is done: no further trial is kept.")
        wanted = {**self.about(assignment), "seed": assignment.seed, "configuration": self.condition.configuration}
        wanted.pop("allowed_late_share")
        for key, value in wanted.items():
            if trial.about.get(key) != value:
                raise ConfigurationError(
                    f"{self.folder}: a trial is refused: its {key} is {shown(trial.about.get(key))}, next is "
                    f"{shown(value)}."
                )
        return assignment

    def _book(self, path: Path, trial: Trial, result: str) -> None:
        number = int(trial.about["session"]["number"])
        entry = {"file": path.name, "phase": trial.phase, "number": number, "seed": trial.seed, "result": result}
        self._books.append(Entry.model_validate(entry))
        self._under_way = None
        if result == KEPT and trial.phase == PRACTICE and trial.metrics is not None:
            self._practised.append(trial.metrics)

    def _done(self, phase: str) -> list[Entry]:
        return [entry for entry in self._books if entry.phase == phase and entry.result == KEPT]

    def _tries(self, phase: str, seed: int) -> int:
        return sum(entry.phase == phase and entry.seed == seed for entry in self._books)

    # --- the participant's file --------------------------------------------------------------------------------

    @property
    def record(self) -> Participant:
        """Contents of ``participant.yaml``."""
        return Participant(
            participant=self.participant,
            experience=self.experience,
            protocol=self.protocol.identity,
            scored_order=self._order,
            trials=self._books,
            under_way=self._under_way,
        )

    def _write(self) -> None:
        write_text(
            self.folder / PARTICIPANT, _HEAD + write_yaml(self.record.model_dump(mode="json", exclude_none=True))
        )

    def _resume(self, experience: str | None) -> None:
        """Take up what the folder holds.

        A trial that was written but not booked (a kill in between) is booked, and so is one that was begun but never
        written (a kill in the middle).
        """
        path = self.folder / PARTICIPANT
        found = validated(Participant, read_file(path), str(path)) if path.is_file() else None
        if found is None and list(self.folder.glob("*.parquet")):
            raise ConfigurationError(f"{self.folder}: trials lie here, but {PARTICIPANT} is missing: put it back.")
        if found is not None:
            self._check(path, found)
            if experience not in (None, found.experience):
                raise ConfigurationError(
                    f"experience {experience!r} is refused: {path} says {found.experience!r} of this participant."
                )
            self.experience = found.experience
            for entry in found.trials:
                self._rebook(entry)
            self._under_way = found.under_way
        waiting = self._waiting()
        if waiting is not None:
            self._book(*waiting)
        elif self._under_way is not None:
            self._books.append(self._under_way)
            self._under_way = None
        if found is None or self.record != found:
            self._write()

    def _check(self, path: Path, found: Participant) -> None:
        """Refuse a participant's file that is not this protocol's, or that has been changed by hand."""
        if found.protocol != self.protocol.identity:
            raise ConfigurationError(
                f"{path}: the session was begun by another protocol, or by this one before it, its scenario, its task "
                "or its helicopter was changed: go on with that one, or take another folder."
            )
        for key in ("participant", "scored_order"):
            if getattr(found, key) != getattr(self.record, key):
                raise ConfigurationError(f"{path}: {key} is not what the protocol gives: the file has been changed.")

    def _rebook(self, entry: Entry) -> None:
        """Take up an entry of the participant's file."""
        if entry.file is None:
            self._books.append(entry)
        else:
            path = self.folder / entry.file
            self._book(path, self._read(path, entry), entry.result)

    def _read(self, path: Path, entry: Entry) -> Trial:
        """The trial of an entry.

        Raises:
            ConfigurationError: Its file is missing or damaged, or another one.
        """
        trial = read_trial(path)
        told = trial.seed, trial.phase, trial.about["session"]["number"], trial.about["session"]["id"], result_of(trial)
        if told != (entry.seed, entry.phase, entry.number, self.identity, entry.result):
            raise ConfigurationError(f"{path}: this is not the trial that was kept here.")
        return trial

    def _waiting(self) -> tuple[Path, Trial, str] | None:
        """A trial that was written but not booked; its name tells that it is the one that came next."""
        booked = {entry.file for entry in self._books}
        for path in sorted(self.folder.glob(f"{len(self._books) + 1:03d}_*.parquet")):
            if path.name not in booked:
                trial = read_trial(path)
                self._fits(trial)
                return path, trial, result_of(trial)
        return None


def result_of(trial: Trial) -> str:
    """``kept``; ``incomplete`` if it was broken off; ``invalid`` if too many of its steps were late or nobody's."""
    if not trial.complete:
        return INCOMPLETE
    return KEPT if trial.valid and not trial.deserted else INVALID


def check_code(what: str, code: str) -> None:
    """Refuse what is no code.

    Args:
        what: ``participant`` or ``experience``.
        code: The code.

    Raises:
        ConfigurationError: It is none.
    """
    if not _CODE.fullmatch(code):
        raise ConfigurationError(
            f"{what} {shown(code)} is refused: give a code of 1 to 32 letters, digits, _ or -, such as "
            f"{'p07, that tells nobody who it is' if what == 'participant' else 'none or pilot'}."
        )
