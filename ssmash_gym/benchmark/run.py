"""Runs what a benchmark lacks: trials are re-simulated, programs drive the same seas."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import polars as pl

import ssmash_gym
from ssmash_gym.benchmark.admission import Entry
from ssmash_gym.benchmark.cache import keep, kept
from ssmash_gym.benchmark.delays import labelled, later
from ssmash_gym.benchmark.figures import PEOPLE, SCRIPTED
from ssmash_gym.benchmark.measures import ClawWatch
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.step import StepResult
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition, digest
from ssmash_gym.evaluation.episodes import Exceeded, episode_row, numbered, run_episodes, share_of
from ssmash_gym.evaluation.study_entrants import PLANNER, Entrant, agent_entrants, code, scripted_entrant
from ssmash_gym.progress import progress_bar
from ssmash_gym.trials.replay import Replay, replay
from ssmash_gym.trials.trial import Trial

BOUND: Final = "clairvoyant"
CHUNK: Final = 64  # episodes between two files
PLANNER_CHUNK: Final = 8
SAME_PEAK: Final = 0.005  # of the recorded peak load, by which it may differ on another machine; assumed


@dataclass(frozen=True)
class Program:
    """A policy or an agent with a matched delay.

    Attributes:
        entrant: Who.
        delay_ms: Added to each episode's own claw delay [ms].
    """

    entrant: Entrant
    delay_ms: float

    @property
    def label(self) -> str:
        """What tables and figures call it."""
        return labelled(self.entrant.name, self.delay_ms)

    def key(self, condition: Condition) -> str:
        """Hash of all that its rows depend on."""
        return digest(
            self.entrant.identity, condition.configuration, self.delay_ms, code(), _own_code(), ssmash_gym.__version__
        )


def entrants_of(agents: Sequence[str], policies: Sequence[str], condition: Condition) -> list[Entrant]:
    """Programs as the command line names them, agents first.

    Args:
        agents: As of `agent_entrants`.
        policies: Names of scripted policies or planners.
        condition: What they are to drive in.

    Raises:
        ConfigurationError: A name is unknown or named twice, or a policy does not suit the task.
    """
    scripted = [scripted_entrant(name, condition.task) for name in dict.fromkeys(policies)]
    learned = agent_entrants(agents)
    for one in learned:
        if any(other.name == one.name for other in scripted):
            raise ConfigurationError(
                f"--agent: the name {one.name!r} is a scripted policy's: give another (NAME=FOLDER)."
            )
        one.make(condition.task)
    return [*learned, *scripted]


def trial_rows(entries: Sequence[Entry], out: Path, *, shown: bool = True) -> pl.DataFrame:
    """One row a trial that counts or is part of a learning curve, from re-simulation.

    Args:
        entries: All trials.
        out: The benchmark's folder.
        shown: Whether a bar shows the progress.

    Returns:
        Rows as of `run_episodes` with `KEYS` in front, and with ``phase``, ``number``, ``attempt``, ``counts``,
        ``place``, and whether the replay ``agrees`` bit for bit, or how far its peak load is apart (``apart_kN``).

    Raises:
        ConfigurationError: A trial does not replay: no figure is made.
    """
    used = [one for one in entries if one.counts or one.learned]
    rows = []
    with progress_bar("replaying trials", shown=shown) as advance:
        for k, one in enumerate(used):
            advance(k / len(used), f"replaying {one.place}")
            key = digest(hashlib.sha256(one.path.read_bytes()).hexdigest(), code(), _own_code())
            row = kept(out, key)
            if not row.height:
                row = retold(one.trial, one.place)
                keep(out, "trial", key, row, 0)
            rows.append(_named(row, one))
    return pl.concat(rows, how="diagonal_relaxed")


def retold(trial: Trial, place: str) -> pl.DataFrame:
    """The row of a trial, from simulating it once more under the eyes that look at programs.

    Args:
        trial: The trial.
        place: Its file, for messages.

    Raises:
        ConfigurationError: It does not come out bit for bit as it was recorded; or, with other libraries or on
            another processor than then, not nearly so.
    """
    eyes: list[tuple[Exceeded, ClawWatch]] = []

    def note(batch: TraverseBatch, result: StepResult) -> None:
        if not eyes:
            eyes.append((Exceeded(batch.n), ClawWatch(batch)))
        for one in eyes[0]:
            one.note(result)

    found = replay(trial, note)
    apart_kN = _apart_kN(trial, found)
    if apart_kN is None or found.metrics is None:
        raise ConfigurationError(f"{place}: this trial is refused, no figure can be made from it: it {found.words}.")
    exceeded, claw = eyes[0]
    row = episode_row(trial.seed, found.metrics, exceeded.row(0), trial.condition.task) | claw.row(0)
    return numbered([row]).with_columns(agrees=pl.lit(found.agrees), apart_kN=pl.lit(apart_kN))


def _apart_kN(trial: Trial, found: Replay) -> float | None:
    """By how much the replayed peak load differs from the recorded one [kN]; None where the replay is another episode.

    With other libraries or on another processor the last bits may differ. There it is the same episode still if it
    ends alike, with nearly the same load.
    """
    if found.agrees:
        return 0.0
    now, then = found.metrics, trial.metrics
    if not found.elsewhere or now is None or then is None or now["reason"] != then["reason"]:
        return None
    apart_kN = abs(float(now["peak_probe_kN"]) - float(then["peak_probe_kN"]))
    return apart_kN if apart_kN <= SAME_PEAK * float(then["peak_probe_kN"]) else None


def _named(row: pl.DataFrame, entry: Entry) -> pl.DataFrame:
    kind = SCRIPTED if entry.scripted else PEOPLE
    return _keyed(row, entry.driver, kind, 0.0, entry.driver).with_columns(
        phase=pl.lit(entry.phase), number=pl.lit(entry.number), attempt=pl.lit(entry.attempt),
        counts=pl.lit(entry.counts), place=pl.lit(entry.place),
    )  # fmt: skip


def _keyed(rows: pl.DataFrame, driver: str, kind: str, delay_ms: float, member: str) -> pl.DataFrame:
    """Rows with `KEYS` in front."""
    return rows.select(
        pl.lit(driver).alias("driver"), pl.lit(kind).alias("kind"), pl.lit(delay_ms).alias("delay_ms"),
        pl.lit(member).alias("member"), pl.col("seed"), pl.exclude("seed"),
    )  # fmt: skip


def program_rows(
    programs: Sequence[Program],
    condition: Condition,
    seeds: Sequence[int],
    out: Path,
    *,
    threads: int | None = None,
    shown: bool = True,
) -> pl.DataFrame:
    """One row an episode of the programs in the same seas; what is on disk is not run again.

    Args:
        programs: Who drives.
        condition: Of the trials.
        seeds: Episodes.
        out: The benchmark's folder.
        threads: Of the simulation; rows do not depend on them.
        shown: Whether a bar shows the progress.

    Returns:
        Rows as of `run_episodes` with `KEYS` in front; ``member`` tells training seeds of an agent apart.

    Raises:
        ConfigurationError: A delay is beyond what a scenario may have.
        KeyboardInterrupt: The same call goes on where this one was stopped.
    """
    rows = []
    with progress_bar("episodes", shown=shown) as advance:
        for k, program in enumerate(programs):
            first, share = k / len(programs), 1.0 / len(programs)

            def tell(done: float, first: float = first, share: float = share, name: str = program.label) -> None:
                advance(first + share * done, name)

            tell(0.0)
            rows.append(_driven(program, condition, seeds, out, threads, tell))
    return pl.concat(rows, how="diagonal_relaxed")


def _driven(
    program: Program,
    condition: Condition,
    seeds: Sequence[int],
    out: Path,
    threads: int | None,
    tell: Callable[[float], None],
) -> pl.DataFrame:
    """The rows of one program, those that are missing run first."""
    entrant, key, changed = program.entrant, program.key(condition), later(condition, program.delay_ms)
    name = f"{entrant.name}.seed{entrant.training_seed}" if entrant.training_seed is not None else entrant.name
    present = kept(out, key)
    missing = [seed for seed in seeds if seed not in set(present["seed"].to_list())]
    size = PLANNER_CHUNK if entrant.kind == PLANNER else CHUNK
    for first in range(0, len(missing), size):
        chunk = missing[first : first + size]
        rows = run_episodes(
            entrant.make(changed.task), changed.scenario, chunk, helicopter=changed.helicopter, threads=threads,
            tell=share_of(len(missing) * changed.task.horizon_steps, tell), watch=ClawWatch,
        )  # fmt: skip
        keep(out, f"{name}--{program.delay_ms:g}ms", key, rows, present.height)
        present = kept(out, key)
    rows = present.filter(pl.col("seed").is_in(list(seeds))).unique("seed", maintain_order=True)
    return _keyed(rows, program.label, entrant.kind, program.delay_ms, name)


def _own_code() -> str:
    """Hash of what this package measures by."""
    folder = Path(__file__).parent
    names = ("measures.py", "delays.py", "run.py")
    return digest([hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names])
