"""`ssmash window`: run an operating window, draw its report, film an episode of it."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import tyro
from rich.console import Console

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows.config import WindowConfig, load_window
from ssmash_gym.windows.engines import Engine, Threads
from ssmash_gym.windows.rows import read_document, read_rows
from ssmash_gym.windows.sequential import fewest
from ssmash_gym.windows.stages import STAGES
from ssmash_gym.windows.verdicts import cells_of, judged_rows, sentences

if TYPE_CHECKING:
    from ssmash_gym.windows.sweep import Sweep

FILMS: Final = 4  # of a report
Policies = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


def window(
    config: Annotated[str | None, tyro.conf.Positional] = None,
    policy: Policies = (),
    out: Path = Path("runs/window"),
    seeds: int | None = None,
    most: int | None = None,
    episodes: int | None = None,
    engine: Literal["threads", "ray"] = "threads",
    address: str | None = None,
    threads: int | None = None,
    report: Path | None = None,
    limits: str | None = None,
    films: int | None = None,
    film: Path | None = None,
    cell: int | None = None,
    stage: str | None = None,
) -> None:
    """Run an operating window; or draw the report of one that has been run; or film an episode of one of its cells.

    Writes ``rows/*.parquet`` (one row an episode) and ``window.json`` to --out. A window that was stopped is gone on
    with by the same command; finished episodes are never run again.

    Args:
        config: Name of a window (frigate_traverse) or its YAML file.
        policy: At the claw: a scripted policy by name, a trained agent by name or folder (NAME=FOLDER); may be given
            several times. The window's own by default.
        out: Folder for the dataset.
        seeds: Seas of every cell, instead of the window's effort.seeds.
        most: Seas of a cell at most, instead of effort.most.
        episodes: Episodes at most, of all policies of this call, instead of effort.episodes.
        engine: What runs the episodes: threads of this process, or Ray (extra ``distributed``); the rows are the same.
        address: Of a running Ray cluster, or auto; a local one is started without it.
        threads: Workers of the threads, or of a local Ray; one a core by default.
        report: Draw the window in this folder into its folder ``report``, without running anything.
        limits: With --report: judge by the limits and the acceptance of another window's YAML.
        films: With --report: film the worst episodes of so many of the worst cells, 4 by default (extra ``render``).
        film: Film an episode of the window in this folder: the worst one of --cell with --policy.
        cell: Number of the cell to film.
        stage: Stage to film, where the window has several.

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    wanted = {"a window": config, "--report": report, "--film": film}
    chosen = [word for word, given in wanted.items() if given is not None]
    if len(chosen) != 1:
        raise ConfigurationError(
            f"{' and '.join(chosen) or 'nothing to do'}: give a window to run, or --report FOLDER, or --film FOLDER."
        )
    _refuse_besides(
        chosen[0],
        {
            "a window": {
                "--seeds": seeds, "--most": most, "--episodes": episodes, "--threads": threads, "--address": address,
                "--engine": None if engine == "threads" else engine,
            },
            "--report": {"--limits": limits, "--films": films},
            "--film": {"--cell": cell, "--stage": stage},
        },
    )  # fmt: skip
    if films is not None and films < 0:
        raise ConfigurationError(f"--films {films} is refused: 0 or more.")
    if config is not None:
        effort = {"seeds": seeds, "most": most, "episodes": episodes}
        _run(config, policy, out, effort, functools.partial(_engine, engine, address, threads))
    elif report is not None:
        from ssmash_gym.windows.report import write_report

        console = Console()
        page = write_report(
            report, limits=limits, films=FILMS if films is None else films,
            tell=lambda words: console.print(words, markup=False, soft_wrap=True),
        )  # fmt: skip
        console.print(f"report in {page}", soft_wrap=True)
    elif film is not None:
        from ssmash_gym.windows.film import film_cell

        Console().print(f"film in {film_cell(film, cell, policy, stage)}", soft_wrap=True)


def _refuse_besides(done: str, options: dict[str, dict[str, Any]]) -> None:
    """Refuse options that what is done does not read.

    Args:
        done: A key of `options`.
        options: By what reads them.

    Raises:
        ConfigurationError: One is given.
    """
    for what, given in options.items():
        for option, value in given.items():
            if value is not None and what != done:
                where = f"{what} to run" if what == "a window" else what
                raise ConfigurationError(f"{option} {value} is refused without {where}.")


def _engine(name: str, address: str | None, threads: int | None) -> Engine:
    if threads is not None and threads < 1:
        raise ConfigurationError(f"--threads {threads} is refused: at least 1.")
    if name == "threads":
        if address is not None:
            raise ConfigurationError(f"--address {address} is refused without --engine ray.")
        return Threads(threads)
    from ssmash_gym.windows.engine_ray import Ray

    return Ray(address, threads)


def _run(
    config: str, policies: tuple[str, ...], out: Path, effort: dict[str, int | None], engine: Callable[[], Engine]
) -> None:
    from ssmash_gym.windows.sweep import prepared, run_sweep

    console = Console()
    name = Path(config).stem if config.endswith((".yaml", ".yml")) else config
    sweep = prepared(_with_effort(load_window(config), effort), name, policies, source=config)
    for sentence in (*hints(sweep), going_on(out)):
        console.print(sentence, markup=False, soft_wrap=True)
    try:
        run_sweep(sweep, out, engine(), shown=Console(stderr=True).is_terminal)
    except KeyboardInterrupt:
        kept = read_rows(out, ()).height
        console.print(f"{kept:,} episodes are kept in {out}; the same command goes on there", soft_wrap=True)
        raise
    told, rows = read_document(out), read_rows(out)
    for sentence in sentences(cells_of(judged_rows(rows, told), told)):
        console.print(sentence, markup=False, soft_wrap=True)
    console.print(f"dataset in {out}; `ssmash window --report {out}` draws it", soft_wrap=True)


def hints(sweep: Sweep) -> list[str]:
    """What a user might not expect of a window that is about to be run, a sentence each."""
    config, found = sweep.config, []
    seas = fewest(config.acceptance, config.confidence)
    if config.effort.most < seas:
        found.append(
            f"note: with at most {config.effort.most} seas no cell can be shown to be within, even if nothing "
            f"happens in it: that takes {seas} at an acceptance of {100 * config.acceptance:g} % and a confidence of "
            f"{100 * config.confidence:g} %"
        )
    alone = [stage for stage in config.stages if STAGES[stage].policy is not None]
    if alone:
        found.append(f"note: {' and '.join(alone)}: nobody drives; the rows are named {STAGES[alone[0]].policy}")
    return found


def going_on(out: Path) -> str:
    """What lies in a window's folder already."""
    count = read_rows(out, ()).height
    return f"going on in {out}: {count:,} episodes are there" if count else f"running into {out}"


def _with_effort(config: WindowConfig, given: dict[str, int | None]) -> WindowConfig:
    """The window with what the command line says of its effort.

    Raises:
        ConfigurationError: A number is refused.
    """
    changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    for key, value in changes.items():
        if value < 1:
            raise ConfigurationError(f"--{key} {value} is refused: at least 1.")
    if not changes:
        return config
    effort = {**config.effort.model_dump(), **changes}
    if "most" not in changes:
        effort["most"] = max(effort["most"], effort["seeds"])
    return load_window({**config.model_dump(mode="json"), "effort": effort})
