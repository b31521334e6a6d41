"""`ssmash manoeuvre`: the validation manoeuvres of the thesis, their figures and what it states about them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import tyro

from ssmash_gym.document import listed
from ssmash_gym.errors import ConfigurationError, require
from ssmash_gym.progress import progress_bar

if TYPE_CHECKING:
    from ssmash_gym.analysis.validation.study import Asked, Study

Friction = Literal["limit_surface", "friction_circle", "independent"]
Solver = Literal["engine", "adams", "gear", "automatic", "dop853", "rk45", "radau"]
EVERY: Final = "all"


def manoeuvre(
    name: Annotated[str, tyro.conf.Positional],
    out: Path,
    friction: Friction = "limit_surface",
    solver: Solver = "engine",
    systems: str = "",
    suspects: bool = False,
) -> None:
    """Replay validation manoeuvres of Léveillé (2013), section 3.2, and hold them against what the thesis states.

    Writes the thesis' figures with its axes (PNG), a summary of what it states and what is simulated (Markdown and
    JSON), the recording (Parquet) and the configuration (YAML), all when everything has been run, or nothing.

    Args:
        name: 1A to 1D, 2A to 2C, or all.
        out: Folder for the output; with all, one folder in it for each manoeuvre.
        friction: Another friction law of the tires, run and drawn beside the default; independent is the thesis' own.
        solver: Another integrator, run beside the engine and compared.
        systems: Other systems of the thesis through which the manoeuvre is run too: names, separated by commas, or all.
        suspects: Also run what the thesis suspects behind its misfits (2A-2C).

    Raises:
        ConfigurationError: A name or the folder is refused, or a run failed; nothing has been written.
        ImportError: Matplotlib is missing.
    """
    from ssmash_gym.analysis.validation.manoeuvres import manoeuvre_named, manoeuvres
    from ssmash_gym.analysis.validation.picture import NEEDS_MATPLOTLIB
    from ssmash_gym.analysis.validation.study import Asked

    chosen = list(manoeuvres().values()) if name.lower() == EVERY else [manoeuvre_named(name)]
    asked = Asked(
        friction="" if friction == "limit_surface" else friction,
        solvers=() if solver == "engine" else (solver,),
        systems=system_list(systems),
        suspects=suspects,
    )
    check_folder(out)
    require("matplotlib", NEEDS_MATPLOTLIB)
    studies = run_studies([one.name for one in chosen], lambda _: asked)
    several = name.lower() == EVERY
    places = {study.manoeuvre.name: out / study.manoeuvre.name if several else out for study in studies}
    command = " ".join(
        ["ssmash manoeuvre", name if several else name.upper(), *_options(friction, solver, systems, suspects)]
    )
    write(studies, places, f"{command} --out {out}", out if several else None)
    show(studies)
    print(f"{out}: {', '.join(places)}" if several else f"{out}: figures, summary, recording and configuration")


def _options(friction: str, solver: str, systems: str, suspects: bool) -> list[str]:
    """Options of a command line that are not the defaults."""
    options = [f"--friction {friction}"] if friction != "limit_surface" else []
    options += [f"--solver {solver}"] if solver != "engine" else []
    options += [f"--systems {systems}"] if systems else []
    return options + (["--suspects"] if suspects else [])


def system_list(words: str) -> tuple[str, ...]:
    """Names of systems from the words of the option.

    Raises:
        ConfigurationError: One of them is unknown.
    """
    if not words:
        return ()
    from ssmash_gym.systems import load_system, system_names

    names = system_names() if words.lower() == EVERY else listed(words)
    return tuple(load_system(one).name for one in names)


def check_folder(out: Path) -> None:
    """Refuse a folder that cannot be one.

    Raises:
        ConfigurationError: A file stands in its way.
    """
    for path in (out, *out.parents):
        if path.exists() and not path.is_dir():
            raise ConfigurationError(f"--out {out} is refused: {path} is a file, expected a folder.")


# --- running ----------------------------------------------------------------------------------------------------


def run_studies(names: Sequence[str], asked: Callable[[str], Asked]) -> list[Study]:
    """Run manoeuvres one after the other, with a bar; `asked` says what is asked for of each."""
    from ssmash_gym.analysis.validation.manoeuvres import manoeuvre_named
    from ssmash_gym.analysis.validation.study import study

    studies = []
    with progress_bar() as advance:
        for k, name in enumerate(names):

            def told(share: float, words: str, k: int = k) -> None:
                advance((k + share) / len(names), words)

            studies.append(study(manoeuvre_named(name), asked(name), told))
    return studies


# --- writing ----------------------------------------------------------------------------------------------------


def write(studies: Sequence[Study], places: Mapping[str, Path], command: str, index: Path | None) -> None:
    """Write everything of the studies, whole or not at all.

    Args:
        studies: The studies.
        places: Folder of each by the manoeuvre's name.
        command: The command line, for the pages.
        index: Folder for the table of all studies; None for a single one.
    """
    from ssmash_gym.analysis.validation.report import as_json, overview
    from ssmash_gym.files import whole_files

    content: dict[Path, Callable[[Path], None]] = {}
    for study in studies:
        content |= files_of(study, places[study.manoeuvre.name], command)
    if index is not None:
        lines = ["# Validation manoeuvres", "", *overview(studies, lambda name: f"{name}/summary.md")]
        content[index / "summary.md"] = text_writer("\n".join(lines))
        everything = json.dumps([as_json(study) for study in studies], indent=1, ensure_ascii=False)
        content[index / "summary.json"] = text_writer(everything + "\n")
    for path in content:
        path.parent.mkdir(parents=True, exist_ok=True)
    with whole_files(content) as staged:
        for path, put in content.items():
            put(staged[path])


def files_of(study: Study, folder: Path, command: str) -> dict[Path, Callable[[Path], None]]:
    """What is written for a study: each file and the function that writes it."""
    from ssmash_gym.analysis.validation.report import as_json, summary
    from ssmash_gym.document import write_yaml

    name = study.manoeuvre.name
    drawn = pictures(study)
    content: dict[Path, Callable[[Path], None]] = {folder / file_name(name, kind): put for kind, put in drawn.items()}
    content |= {
        folder / f"{name}_figure_{figure.number}.png": _draw(study, (figure,), {"ssmash_gym": study.runs.default})
        for figure in study.manoeuvre.figures
    }
    page = summary(study, lambda kind: file_name(name, kind) if kind in drawn else None, f"{name}.yaml", command)
    told = json.dumps(as_json(study), indent=1, ensure_ascii=False) + "\n"
    content |= {
        folder / "summary.md": text_writer(page),
        folder / "summary.json": text_writer(told),
        folder / f"{name}.yaml": text_writer(write_yaml(resolved(study))),
        folder / f"{name}.parquet": study.runs.default.write,
    }
    return content | {folder / f"{name}_{key}.parquet": run.write for key, run in study.runs.variants.items()}


def file_name(name: str, kind: str) -> str:
    """Name of a picture of a manoeuvre: of its figures, of a variant, of the systems."""
    return f"{name}_{kind}.png" if kind else f"{name}.png"


def pictures(study: Study) -> dict[str, Callable[[Path], None]]:
    """What draws each picture of a study, by kind: ``""`` its figures, a variant's name, ``systems``."""
    own = {"ssmash_gym": study.runs.default}
    drawn = {"": _draw(study, study.manoeuvre.figures, own)}
    for key, variant in study.variants.items():
        shown = [
            figure for figure in study.manoeuvre.figures if not variant.figures or figure.number in variant.figures
        ]
        drawn[key] = _draw(study, shown, {**own, variant.label: study.runs.variants[key]})
    if study.systems:
        drawn["systems"] = _draw(study, study.manoeuvre.figures, study.systems)
    return drawn


def _draw(study: Study, figures: Sequence[Any], runs: Mapping[str, Any]) -> Callable[[Path], None]:
    """What draws a sheet."""
    from ssmash_gym.analysis.validation.picture import draw_sheet
    from ssmash_gym.analysis.validation.report import foot, metadata, title

    return lambda path: draw_sheet(path, figures, runs, (title(study), foot(study)), metadata(study))


def text_writer(text: str) -> Callable[[Path], None]:
    """What writes a text."""

    def put(path: Path) -> None:
        path.write_text(text, encoding="utf-8", newline="\n")

    return put


def resolved(study: Study) -> dict[str, Any]:
    """The document of a study's case with its helicopter in it, so that it needs no other file."""
    from ssmash_gym.cases import case_document
    from ssmash_gym.vehicle import document_of

    return {**case_document(study.case), "helicopter": document_of(study.case.vehicle), "changes": {}}


# --- printing ---------------------------------------------------------------------------------------------------


def show(studies: Sequence[Study]) -> None:
    """Print the statements of each study with what is simulated."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    console = Console()
    for study in studies:
        head = (
            f"{study.manoeuvre.name} {study.manoeuvre.title}: {study.holding} of {len(study.findings)} statements hold"
        )
        table = Table(title=head, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for column in ("thesis", "simulated", "holds"):
            table.add_column(column)
        for finding in study.findings:
            table.add_row(finding.statement.thesis, finding.simulated, "yes" if finding.holds else "no")
        console.print(table, markup=False)
        for one in study.agreements:
            apart = f"{100 * one.loads_apart:.3f} %, final positions {1e3 * one.apart_m:.3f} mm apart"
            asked_for = "as asked for" if one.holds else "more than asked for"
            console.print(f"{one.solver}: peak loads within {apart}, {asked_for}", highlight=False)
        for remark in study.remarks:
            console.print(remark, style="bold yellow", soft_wrap=True, markup=False, highlight=False)
