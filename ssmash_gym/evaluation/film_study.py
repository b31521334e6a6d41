"""Episodes of a study once more, to look at: `ssmash film`, and the film in a study's report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import tyro

from ssmash_gym.document import listed
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.film import SPEED, film_side_by_side, require_rendering
from ssmash_gym.evaluation.page_data import AGENT, CREDITS, FILM, StudyData, read_json, read_study
from ssmash_gym.evaluation.policies import Policy, make_baseline
from ssmash_gym.evaluation.study import StudyConfig, load_study
from ssmash_gym.evaluation.study_entrants import Entrant, agent_entrants
from ssmash_gym.evaluation.study_rows import STUDY
from ssmash_gym.files import write_text

PANELS: Final = 4  # of the film in a report
PEAK: Final = "scored_peak_kN"
Agents = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


def film(
    sea: int,
    study: str = "standard",
    condition: str | None = None,
    policies: str = "trapezoid,yield",
    agent: Agents = (),
    out: Path = Path("runs/film.mp4"),
    speed: float = SPEED,
) -> None:
    """Film one sea of a study, each policy in a panel of its own: bit for bit the study's episodes.

    Args:
        sea: Episode seed, as in the rows and in the report.
        study: Folder of a study that has been run; or a name in ``configs/evaluation``, or a YAML file.
        condition: One of the study's; that of its main aim by default.
        policies: Scripted policies and planners, with commas; may be empty.
        agent: As of ``evaluate``: NAME=FOLDER, a folder, a run or a shipped agent's name; several times for several.
        out: File to write (MP4), and a picture (JPEG) beside it.
        speed: How much faster than in reality it plays.

    Raises:
        ConfigurationError: A name or number is refused; nothing has been written.
        ImportError: The extra ``render`` is missing.
    """
    if sea < 0:
        raise ConfigurationError(f"--sea {sea} is refused: it must not be negative.")
    if not speed > 0.0:
        raise ConfigurationError(f"--speed {speed:g} is refused: it must be above 0.")
    require_rendering()
    config = _config(study)
    known = config.resolved()
    name = condition or (config.targets.main if config.targets else next(iter(known)))
    if name not in known:
        raise ConfigurationError(f"--condition {name!r} is refused: the study has {', '.join(known)}.")
    chosen = known[name]
    drivers = cast_of(agent_entrants(agent) if agent else [], listed(policies), chosen.task)
    metrics = film_side_by_side(drivers, chosen.scenario, sea, out, helicopter=chosen.helicopter, speed=speed)
    for driver, found in metrics.items():
        print(f"{driver}: {found['reason']} after {found['time_s']:.1f} s, peak {found['peak_probe_kN']:.1f} kN")
    print(f"film in {out.with_suffix('.mp4')}")


def _config(study: str) -> StudyConfig:
    """The study of a folder, a name or a file."""
    record = Path(study) / STUDY
    return load_study(read_json(record).get("resolved", {}) if record.is_file() else study)


def film_of_study(folder: Path, agents: Sequence[str] = (), *, speed: float = SPEED) -> Path | None:
    """Film a typical sea of a study for its report: the agent, the best law, the book and the clairvoyant.

    Writes ``film.mp4``, ``film.jpg`` and ``film.json`` into the folder. The sea is the one in which the agent's peak
    load is nearest its median; without an agent the law's.

    Args:
        folder: The study's folder, with its ``summary.json``.
        agents: As of `agent_entrants`, the words that the study was run with; other agents are left out.
        speed: How much faster than in reality it plays.

    Returns:
        The film; None where no policy of the study can be shown.

    Raises:
        ConfigurationError: The study, an agent or the code is not the one of the rows.
        ImportError: The extra ``render`` is missing.
    """
    require_rendering()
    data = read_study(folder)
    entrants = agent_entrants(agents) if agents else []
    names = _shown(data, {one.name for one in entrants})
    if not names:
        return None
    chosen = data.config.resolved()[data.main]
    scripted = [name for name in names if data.kind(name) != AGENT]
    drivers = {one.name: one for one in cast_of(entrants, scripted, chosen.task)}
    sea, typical = _typical(data, names)
    path = folder / FILM
    metrics = film_side_by_side(
        [drivers[name] for name in names], chosen.scenario, sea, path, helicopter=chosen.helicopter, speed=speed,
        looks=data.looks,
    )  # fmt: skip
    _compare(data, sea, entrants, metrics)
    told = ("reason", "time_s", "peak_probe_kN")
    credits: dict[str, Any] = {
        "sea": sea,
        "condition": data.main,
        "speed": speed,
        "choice": f"The sea in which the peak load of {typical} is nearest its median; not chosen by eye.",
        "policies": {name: {key: one[key] for key in told} for name, one in metrics.items()},
    }
    write_text(folder / CREDITS, json.dumps(credits, indent=1) + "\n")
    return path


def cast_of(entrants: Sequence[Entrant], scripted: Sequence[str], task: TaskConfig) -> list[Policy]:
    """The policies of a film, agents first; of an agent with several training seeds only the first one.

    Args:
        entrants: Agents.
        scripted: Names of scripted policies and planners.
        task: The condition's.

    Raises:
        ConfigurationError: A name is refused.
    """
    agents: dict[str, Entrant] = {}
    for one in entrants:
        agents.setdefault(one.name, one)
    others = [name for name in dict.fromkeys(scripted) if name not in agents]
    return [*(one.make(task) for one in agents.values()), *(make_baseline(name, task) for name in others)]


def _shown(data: StudyData, agents: set[str]) -> list[str]:
    """Who is filmed: the first policy, the best law, the book, the clairvoyant or else holding still."""
    config: StudyConfig = data.config
    wanted = [data.first, data.law, config.roles.book, config.roles.clairvoyant, config.roles.hold]
    known = [
        name
        for name in dict.fromkeys(wanted)
        if name and (data.main, name) in data.rows.frames and (data.kind(name) != AGENT or name in agents)
    ]
    return known[:PANELS]


def _typical(data: StudyData, names: Sequence[str]) -> tuple[int, str]:
    """The sea that all have met in which the first one's peak load is nearest its median."""
    seas, (loads, *_) = data.paired(data.main, names, PEAK)
    if not seas.size:
        raise ConfigurationError(f"{data.folder}: {', '.join(names)} have met no sea of {data.main} in common.")
    return int(seas[int(np.argmin(np.abs(loads - np.median(loads))))]), names[0]


def _compare(data: StudyData, sea: int, entrants: Sequence[Entrant], metrics: Mapping[str, Mapping[str, Any]]) -> None:
    """Refuse a film that does not show the episodes of the rows."""
    seeds: dict[str, int | None] = {}
    for one in entrants:
        seeds.setdefault(one.name, one.training_seed)
    for name, found in metrics.items():
        rows = data.frame(data.main, name).filter(sea=sea)
        if name in seeds:
            rows = rows.filter(training_seed=seeds[name]) if seeds[name] is not None else rows
        told = rows["peak_probe_kN"].to_list()
        if told and told[0] != found["peak_probe_kN"]:
            raise ConfigurationError(
                f"{data.folder}: {name} in sea {sea} has a peak of {found['peak_probe_kN']:.3f} kN now and "
                f"{told[0]:.3f} kN in the rows: policy or code have changed since; run the study again."
            )
