"""What `ssmash evaluate --study` does: run, summarise, report, and tell it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from ssmash_gym.document import listed
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.figure_text import number
from ssmash_gym.evaluation.study import StudyConfig, load_study
from ssmash_gym.evaluation.study_run import planned, run_study
from ssmash_gym.evaluation.study_summary import summarise
from ssmash_gym.evaluation.targets import sentences


def chosen_study(
    study: str, against: str | None, conditions: str | None, episodes: int | None
) -> tuple[StudyConfig, str, StudyConfig]:
    """A study, its name, and the part of it that the command line asks for.

    Args:
        study: Name or YAML file.
        against: Scripted policies to run, with commas; None: all of the study's.
        conditions: Conditions to run, with commas; None: all.
        episodes: Seas at most; None: as in the study.

    Raises:
        ConfigurationError: A name is unknown, or a value is refused.
    """
    found = load_study(study)
    narrowed = found.narrowed(names_in(against), names_in(conditions), episodes)
    return found, Path(study).stem if study.endswith((".yaml", ".yml")) else study, narrowed


def evaluate_study(
    study: StudyConfig,
    name: str,
    agents: Sequence[str],
    out: Path,
    *,
    part: StudyConfig | None = None,
    threads: int | None = None,
    report: Path | None = None,
    film: bool = True,
) -> dict[str, Any]:
    """Run what is missing, work out the figures, write the page, and show the aims.

    Args:
        study: The study.
        name: Of it.
        agents: ``NAME=FOLDER,FOLDER``, folders or names.
        out: Folder of rows and figures.
        part: What of the study is run; None runs all.
        threads: Of the simulation.
        report: Folder for the page; None writes none.
        film: Whether the page has a film of one sea driven by several.

    Returns:
        The contents of ``summary.json``.

    Raises:
        ConfigurationError: Something is refused; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    write_page = None if report is None else page_writer(agents, film)
    console = Console()
    plan = planned(study, name, agents, part)
    bars = Console(stderr=True).is_terminal
    try:
        run_study(plan, out, threads=threads, shown=bars)
    except KeyboardInterrupt:
        console.print(f"what is done is kept in {out}; the same command goes on there")
        raise
    summary = summarise(out, shown=bars)
    shown = Console(width=max(console.width, 160)) if not console.is_terminal else console
    for condition, found in summary["conditions"].items():
        shown.print(table(condition, found["policies"]))
    for sentence in sentences(summary["targets"]):
        shown.print(sentence, markup=False, soft_wrap=True)
    if summary["code_states"] > 1:
        shown.print(f"note: the rows were made by {summary['code_states']} states of the sources", markup=False)
    if write_page is not None and report is not None:
        write_page(out, report)
        console.print(f"report in {report}")
    console.print(f"results in {out}")
    return summary


def page_writer(agents: Sequence[str], film: bool) -> Callable[[Path, Path], Path]:
    """The function that makes a page of a study's folder.

    Args:
        agents: As the study is run with, for the film.
        film: Whether there is one.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
    """
    from ssmash_gym.evaluation.film import require_rendering
    from ssmash_gym.evaluation.page import require_report, write_report

    require_report()
    if film:
        require_rendering()
    return functools.partial(write_report, agents=agents, film=film)


def table(condition: str, policies: Mapping[str, Mapping[str, Any]]) -> Table:
    """Figures of one condition; one row a policy."""
    found = Table(title=condition, caption="[...]: 95 % intervals; a failed episode counts with the ultimate load")
    found.add_column("policy")
    for heading in (
        "seas", "success\n%", "peak probe load\nP95 kN", "mean\nkN", "over limit\n% of time", "over hold\nmean kN",
        "main tires\nP95 kN", "lift-offs\nan episode", "time\nmedian s",
    ):  # fmt: skip
        found.add_column(heading, justify="right")
    for name, figures in policies.items():
        load = figures["peak_probe_kN"]
        found.add_row(
            name,
            str(figures["seas"]),
            _cell(figures["success"], 100.0, digits=0),
            _cell(load["p95"]),
            _cell(load["mean"]),
            _cell(figures["over_limit_share"], 100.0, bare=True),
            _cell(figures["excess_kN"]["mean"], bare=True) if "excess_kN" in figures else "-",
            _cell(figures["peak_main_kN"]["p95"], bare=True),
            _cell(figures["lift_offs"], digits=2, bare=True),
            _cell(figures["time_s"], bare=True),
        )
    return found


def _cell(figure: Mapping[str, Any], factor: float = 1.0, digits: int = 1, bare: bool = False) -> str:
    return number(figure, digits, factor=factor, short=bare).replace("[", "\\[")  # no markup


def names_in(words: str | None) -> tuple[str, ...] | None:
    """Names with commas between them; None stays None.

    Raises:
        ConfigurationError: There is no name.
    """
    if words is None:
        return None
    found = tuple(dict.fromkeys(listed(words)))
    if not found:
        raise ConfigurationError(f"{words!r} is refused: give names with commas between them.")
    return found
