"""`ssmash benchmark`: recorded trials beside policies and agents on the same seeds, with matched delays."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import polars as pl
import tyro
from rich.console import Console

from ssmash_gym.benchmark.admission import Entry, only_configuration, read_entries
from ssmash_gym.benchmark.cache import KEYS
from ssmash_gym.benchmark.delays import DELAYS, delays_of
from ssmash_gym.benchmark.figures import POOLS
from ssmash_gym.benchmark.page import write_page
from ssmash_gym.benchmark.page_words import answer, scripted_words, taught
from ssmash_gym.benchmark.run import BOUND, Program, entrants_of, program_rows, trial_rows
from ssmash_gym.benchmark.summary import BENCHMARK, Asked, summarised
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.evaluation.page import PAGE, require_report
from ssmash_gym.evaluation.study_entrants import Entrant, scripted_entrant
from ssmash_gym.evaluation.study_figures import Options
from ssmash_gym.files import whole_file, write_text

BASELINE: Final = "trapezoid"
Folders = Annotated[tuple[Path, ...], tyro.conf.UseAppendAction]
Names = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


def benchmark(
    trials: Folders = (),
    agent: Names = (),
    policy: Names = (),
    delays: str = DELAYS,
    baseline: str = BASELINE,
    bound: bool = False,
    out: Path = Path("runs/benchmark"),
    threads: int | None = None,
) -> None:
    """Compare recorded trials with policies and agents in the same seas.

    Only scored, complete and valid trials of one configuration count; each is simulated once more and must come out
    bit for bit as it was recorded. Writes ``index.html``, ``benchmark.json``, ``rows.parquet`` and ``rows.csv`` to
    --out; what has been simulated is kept there (``rows/``), so that a second call only draws.

    Args:
        trials: Folder of recorded trials, with all folders below it; may be given several times.
        agent: A trained agent by name or folder (NAME=FOLDER); may be given several times.
        policy: A scripted policy or a planner by name; may be given several times.
        delays: Added delays of the programs' commands in ms, with commas; each program drives with each of them.
        baseline: Policy that all programs are compared with, and that is 0 of the score.
        bound: Add the clairvoyant, which is 100 of the score; it plans with the true future, and is slow.
        out: Folder for the report.
        threads: Threads of the simulation; the results do not depend on them.

    Raises:
        ConfigurationError: A name, a file or a number is refused, or a trial does not replay; no report is written.
        ImportError: A library is missing; the sentence names the extra.
    """
    if not trials:
        raise ConfigurationError("--trials is missing: name the folder of the recorded trials.")
    if threads is not None and threads < 1:
        raise ConfigurationError(f"--threads {threads} is refused: at least 1.")
    require_report()
    words = [*_words("--trials", trials), *_words("--agent", agent), *_words("--policy", policy), "--delays", delays,
             "--baseline", baseline, *(["--bound"] if bound else [])]  # fmt: skip
    made = run_benchmark(
        trials, agent, policy, delays, out, baseline=baseline, bound=bound, threads=threads,
        command=shlex.join(["ssmash", "benchmark", *words]),
    )  # fmt: skip
    console = Console()
    if note := scripted_words(made):
        console.print(note, markup=False, soft_wrap=True)
    for sentence in (*answer(made), *taught(made)):
        console.print(sentence, markup=False, soft_wrap=True)
    console.print(f"report in {out / PAGE}", markup=False, soft_wrap=True)


def _words(option: str, values: Sequence[object]) -> list[str]:
    return [word for value in values for word in (option, str(value))]


def run_benchmark(
    trials: Sequence[Path],
    agents: Sequence[str],
    policies: Sequence[str],
    delays: str,
    out: Path,
    *,
    baseline: str = BASELINE,
    bound: bool = False,
    threads: int | None = None,
    options: Options | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run what is missing, work out the figures, and write the report; the arguments are those of `benchmark`.

    Args:
        trials: Folders.
        agents: Trained agents.
        policies: Scripted policies and planners.
        delays: Added delays [ms].
        out: Folder for the report.
        baseline: Policy at the score's 0.
        bound: Whether the clairvoyant drives too.
        threads: Of the simulation.
        options: Of the intervals.
        command: For the page's provenance.

    Returns:
        The contents of ``benchmark.json``.

    Raises:
        ConfigurationError: Something is refused; no report has been written.
    """
    bars = Console(stderr=True).is_terminal
    _refuse_inside(out, trials)
    entries = read_entries(trials)
    only_configuration(entries)
    condition = next(one.trial.condition for one in entries if one.counts)
    delays_ms = delays_of(delays, condition.task.substep_s)
    entrants = entrants_of(agents, [*dict.fromkeys([*policies, baseline])], condition)
    _refuse_namesakes(entries, entrants)
    far, why = _bound(bound, condition)
    programs = _programs(entrants, delays_ms, baseline, baseline in policies)
    programs += [Program(far, 0.0)] if far is not None and BOUND not in {one.label for one in programs} else []
    recorded = trial_rows(entries, out, shown=bars)
    seeds = sorted(recorded.filter(pl.col("counts"))["seed"].unique().to_list())
    driven = program_rows(programs, condition, seeds, out, threads=threads, shown=bars)
    learned = sorted(recorded["seed"].unique().to_list())
    base = next(one for one in programs if one.entrant.name == baseline and not one.delay_ms)
    beside = program_rows([base], condition, learned, out, threads=threads, shown=bars)
    asked = Asked(baseline, "" if far is None else far.name, why, delays_ms, _identities(programs), _lessons(programs))
    document = summarised(entries, recorded, driven, beside, condition, asked, options=options, shown=bars)
    rows = pl.concat([recorded, driven], how="diagonal_relaxed")
    counted = rows.filter(pl.col("counts").fill_null(True))
    page = write_page(document, counted, out / PAGE, command=command)
    with whole_file(out / "rows.parquet") as temporary:
        rows.write_parquet(temporary)
    with whole_file(out / "rows.csv") as temporary:
        rows.select(*KEYS, pl.exclude(KEYS)).write_csv(temporary)
    write_text(page.with_name(BENCHMARK), json.dumps(document, indent=1) + "\n")
    return document


def _refuse_inside(out: Path, trials: Sequence[Path]) -> None:
    """Refuse a report among the trials: the next call would take its rows for trials."""
    for folder in trials:
        if out.resolve().is_relative_to(folder.resolve()):
            raise ConfigurationError(f"--out {out} is refused: it lies in the folder of trials {folder}; take another.")


def _refuse_namesakes(entries: Sequence[Entry], entrants: Sequence[Entrant]) -> None:
    """Refuse a program that is called as a recorded driver is: rows are told apart by names."""
    taken = {one.driver for one in entries} | set(POOLS.values())
    for one in entrants:
        if one.name in taken:
            raise ConfigurationError(
                f"--agent: the name {one.name!r} is a recorded driver's: give another (NAME=FOLDER)."
            )


def _identities(programs: Sequence[Program]) -> dict[str, str]:
    """Hash of each program, of each training seed where it has one."""
    seeds = {one.entrant.name: one.entrant.training_seed for one in programs}
    several = {one.entrant.name for one in programs if one.entrant.training_seed != seeds[one.entrant.name]}
    return {
        one.entrant.name + (f", training seed {one.entrant.training_seed}" if one.entrant.name in several else ""):
        one.entrant.identity for one in programs
    }  # fmt: skip


def _lessons(programs: Sequence[Program]) -> dict[str, list[int]]:
    """Seeds of the recorded episodes that each program has learned from, in any of its trainings."""
    found: dict[str, set[int]] = {}
    for one in programs:
        found.setdefault(one.entrant.name, set()).update(one.entrant.about.get("cloned_from", {}).get("seeds", []))
    return {name: sorted(seeds) for name, seeds in found.items() if seeds}


def _programs(entrants: Sequence[Entrant], delays_ms: Sequence[float], baseline: str, delayed: bool) -> list[Program]:
    """Each program with each delay; the baseline without delay in any case, and with the others if it was named."""
    found = []
    for one in entrants:
        wanted = list(delays_ms)
        if one.name == baseline:
            wanted = sorted({0.0, *delays_ms}) if delayed else [0.0]
        found += [Program(one, delay) for delay in wanted]
    return found


def _bound(wanted: bool, condition: Condition) -> tuple[Entrant | None, str]:
    """The clairvoyant, or why there is none."""
    if not wanted:
        return None, "the clairvoyant was not asked for (--bound)"
    try:
        return scripted_entrant(BOUND, condition.task), ""
    except ConfigurationError as refusal:
        return None, f"there is no clairvoyant for this task ({refusal})"
