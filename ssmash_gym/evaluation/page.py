"""The report of a study: one HTML page that holds everything, figures and film included (extra ``report``)."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from ssmash_gym import __version__
from ssmash_gym.errors import require
from ssmash_gym.evaluation import page_words
from ssmash_gym.evaluation.charts import require_matplotlib
from ssmash_gym.evaluation.page_data import CREDITS, CURVES, FILM, STILL, StudyData, read_json, read_study
from ssmash_gym.evaluation.page_figures import Figure, sections
from ssmash_gym.evaluation.page_tables import condition_differences, condition_tables, failures, number, provenance
from ssmash_gym.files import write_text

PAGE: Final = "index.html"  # in a folder


def require_report() -> None:
    """Check that a page can be made.

    Raises:
        ImportError: A library is missing; the sentence names the extra.
    """
    require("jinja2", 'a report needs Jinja2: pip install "ssmash_gym[report]".')
    require_matplotlib()


def write_page(folder: Path, out: Path, *, curves: Mapping[str, Path] | None = None) -> Path:
    """Write the report of a study.

    The page needs no network, no script and no file beside it. The same folder gives the same page, byte for byte.

    Args:
        folder: The study's folder: ``rows/``, ``study.json``, ``summary.json``; and where they are there, the film
            (``film.mp4``, its still ``film.jpg`` and ``film.json``) and training curves (``curves/NAME.csv``).
        out: File to write, ``.html``; or a folder, for ``index.html`` in it.
        curves: Further training curves (``curve.csv``) by name.

    Returns:
        The file.

    Raises:
        ConfigurationError: A file of the folder is missing or cannot be read; nothing has been written.
        ImportError: A library is missing; the sentence names the extra ``report`` or ``plot``.
    """
    require_report()
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    data = read_study(folder)
    found = {path.stem: path for path in sorted((folder / CURVES).glob("*.csv"))} | dict(curves or {})
    loader = PackageLoader("ssmash_gym.evaluation", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters["inline"] = Markup  # of what this package has drawn itself
    style = loader.get_source(environment, "study.css")[0]
    text = environment.get_template("study.html.j2").render(css=Markup(style), **contents(data, found))
    path = out if out.suffix == ".html" else out / PAGE
    write_text(path, text)
    return path


def write_report(
    folder: Path, out: Path, agents: Sequence[str] = (), *, film: bool = True, curves: Mapping[str, Path] | None = None
) -> Path:
    """Film a typical sea of a study and write its report.

    Args:
        folder: The study's folder.
        out: As of `write_page`.
        agents: The words that the study was run with, as of ``--agent``; others cannot be filmed.
        film: Whether to film; one that is in the folder already is shown in any case.
        curves: As of `write_page`.

    Returns:
        The page.

    Raises:
        ConfigurationError: The folder, an agent or the code is not that of the rows; no page has been written.
        ImportError: A library is missing; the sentence names the extra ``report``, ``plot`` or ``render``.
    """
    from ssmash_gym.evaluation.film_study import film_of_study

    require_report()
    if film:
        film_of_study(folder, agents)
    return write_page(folder, out, curves=curves)


def contents(data: StudyData, curves: Mapping[str, Path]) -> dict[str, Any]:
    """Everything that the template shows, by name."""
    return {
        "generator": f"ssmash_gym {__version__}",
        "title": f"Evaluation study “{data.name}”",
        "description": data.config.description,
        "facts": page_words.facts(data),
        "question": page_words.QUESTION,
        "answer": page_words.answer(data),
        "cards": page_words.cards(data),
        "targets": _targets(data),
        "film": _film(data.folder),
        "sections": [
            {**vars(one), "figures": [_placed(figure) for figure in one.figures]} for one in sections(data, curves)
        ],
        "tables_words": page_words.tables_words(data),
        "tables": [*condition_tables(data), condition_differences(data)],
        "failures": failures(data),
        "says_not": page_words.says_not(data),
        "provenance": provenance(data),
        "made": page_words.made(data),
    }


def data_uri(content: bytes, kind: str) -> str:
    """A file as the text of a link."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _placed(figure: Figure) -> dict[str, Any]:
    return {**vars(figure), "source": data_uri(figure.svg.encode(), "image/svg+xml")}


def _targets(data: StudyData) -> dict[str, Any]:
    """The aims, a row each."""
    checks = data.summary.get("targets") or ()
    several = len({one["policy"] for one in checks}) > 1
    rows = []
    for one in checks:
        who = f"{one['policy']} in {one['condition']}" if several else f"in {one['condition']}"
        rows.append({**one, "who": who, "figure": str(one["figure"]).replace("-", "−")})
    note = "In brackets: 95 % intervals. “No data”: not run in this study."
    return {"rows": rows, "note": note if rows else ""}


def _film(folder: Path) -> dict[str, str] | None:
    """The film of the folder, if there is one.

    Raises:
        ConfigurationError: Its record is missing or cannot be read.
    """
    film, still = folder / FILM, folder / STILL
    if not film.is_file():
        return None
    told = read_json(folder / CREDITS)
    ends = [
        f"{name}: {one['reason'].replace('_', ' ')} after {number(one['time_s'])} s, peak "
        f"{number(one['peak_probe_kN'])} kN"
        for name, one in told["policies"].items()
    ]
    return {
        "source": data_uri(film.read_bytes(), "video/mp4"),
        "poster": data_uri(still.read_bytes(), "image/jpeg") if still.is_file() else "",
        "title": f"Sea {told['sea']} of {told['condition']}, at {told['speed']:g} times the speed",
        "caption": f"{told['choice']} {'; '.join(ends)}.",
    }
