"""The page of a safe operating window: one HTML file with figures, tables, every cell and films (extra ``report``)."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym import __version__
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.page import PAGE, data_uri, require_report
from ssmash_gym.files import write_text
from ssmash_gym.windows import charts, page_words
from ssmash_gym.windows.chart_layout import checked, layout_of
from ssmash_gym.windows.page_data import KEYS, Key, as_json, page_data

MOST_COMPARED: Final = 3  # policies of which each pair has a chart of differences
ROWS_NEED: Final = (*KEYS, "number", "seed")


@dataclass(frozen=True)
class Film:
    """A film of one episode of a cell: the MP4's path, and what the page says below it."""

    path: Path
    caption: str = ""


def write_window_page(
    cells: pl.DataFrame,
    rows: pl.DataFrame,
    document: Mapping[str, Any],
    out: Path,
    films: Mapping[Key, Film] | None = None,
    *,
    command: str = "",
) -> Path:
    """Write the page of a window.

    It needs no network and no file beside it; without scripts it shows all figures and tables. Of each cell it holds
    the worst episodes only, and says so. The same input gives the same page, byte for byte.

    Args:
        cells: One row a stage, policy and cell.
        rows: One row an episode; may be empty.
        document: Contents of ``window.json``.
        out: File to write, ``.html``; or a folder, for ``index.html`` in it.
        films: By stage, policy and cell.
        command: The command that made the window, for its provenance.

    Returns:
        The file.

    Raises:
        ConfigurationError: A column or a film is missing; nothing has been written.
        ImportError: A library is missing; the sentence names the extra ``report`` or ``plot``.
    """
    require_report()
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    _checked(cells, rows, document)
    loader = ChoiceLoader([PackageLoader(f"ssmash_gym.{part}", "templates") for part in ("windows", "evaluation")])
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters["inline"] = Markup  # of what this package has drawn itself
    files = {name: Markup(loader.get_source(environment, f"{source}")[0])
             for name, source in (("base", "study.css"), ("css", "window.css"), ("script", "window.js"))}  # fmt: skip
    shown = _films(cells, films or {})
    told = contents(cells, rows, document, shown) | {"command": command}
    text = environment.get_template("window.html.j2").render(**files, **told)
    path = out if out.suffix == ".html" else out / PAGE
    write_text(path, text)
    return path


def _checked(cells: pl.DataFrame, rows: pl.DataFrame, document: Mapping[str, Any]) -> None:
    """Check both tables.

    Raises:
        ConfigurationError: A column is missing, or there are no cells.
    """
    checked(cells, document)
    if not cells.height:
        raise ConfigurationError("The window has no cells: there is no page to write.")
    missing = [name for name in ROWS_NEED if rows.height and name not in rows.columns]
    if missing:
        raise ConfigurationError(f"The table of episodes has no column {', '.join(missing)}: no page was written.")


def contents(
    cells: pl.DataFrame, rows: pl.DataFrame, document: Mapping[str, Any], films: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """Everything that the template shows, by name."""
    identifiers = {one["key"]: one["id"] for one in films}
    csv = io.BytesIO()
    charts.plain(cells).write_csv(csv)
    data = page_data(cells, rows, document, identifiers)
    return {
        "generator": f"ssmash_gym {__version__}",
        "title": f"Operating window “{document.get('name', '')}”, simulated",
        "description": str(document.get("description") or ""),
        "facts": page_words.facts(cells, document),
        "answer": page_words.headline(cells, document),
        "limits_told": page_words.told_limits(document),
        "stages": data["stages"],
        "policies": data["policies"],
        "polar": layout_of(cells, document).polar,
        "placards": _placards(cells, document),
        "maps": _maps(cells, document),
        "differences": _differences(cells, document),
        "counts": page_words.counts(cells, document),
        "films": films,
        "most": data["most"],
        "data": as_json(data),
        "csv": data_uri(csv.getvalue(), "text/csv"),
        "csv_name": f"{re.sub(r'[^A-Za-z0-9_-]+', '_', str(document.get('name') or 'window'))}.csv",
        "method": page_words.method(document),
        "provenance": [page_words.limits(document), page_words.axes(cells, document), page_words.policies(document)],
        "made": page_words.made(document),
    }


def _pairs(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[tuple[int, str, int, str]]:
    """Every stage and policy that has cells, with their numbers."""
    return [
        (s, stage, p, policy)
        for s, stage in enumerate(charts.stages_of(cells, document))
        for p, policy in enumerate(charts.policies_of(cells, document))
        if cells.filter((pl.col("stage") == stage) & (pl.col("policy") == policy)).height
    ]


def _placards(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The placards, one a stage and policy, as elements of the page: a script finds their cells."""
    return [
        {"stage": s, "policy": p, "alt": f"{stage} with {policy}: verdict of every cell",
         "svg": inlined(charts.placard(cells, document, stage, [policy]), f"f{s}-{p}-")}
        for s, stage, p, policy in _pairs(cells, document)
    ]  # fmt: skip


def _maps(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[dict[str, str]]:
    return [
        _picture(charts.probability(cells, document, stage), f"{stage}: share of episodes beyond a limit")
        for stage in charts.stages_of(cells, document)
    ]


def _differences(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[dict[str, str]]:
    """A chart for each stage and each pair of the first policies."""
    found = []
    for stage in charts.stages_of(cells, document):
        here = charts.policies_of(cells.filter(pl.col("stage") == stage), document)[:MOST_COMPARED]
        for k, one in enumerate(here):
            for other in here[k + 1 :]:
                svg = charts.difference(cells, document, stage, (one, other))
                found.append(_picture(svg, f"{stage}: {one} less {other}"))
    return found


def _picture(svg: str, title: str) -> dict[str, str]:
    return {"source": data_uri(svg.encode(), "image/svg+xml"), "title": title}


def inlined(svg: str, prefix: str) -> str:
    """A figure as an element of a page: without a head and without fixed size, its identifiers its own.

    Args:
        svg: A figure's text.
        prefix: Goes before each identifier; figures of one page need different ones.
    """
    text = svg[svg.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)  # the words, which the outlines show
    text = re.sub(r'^<svg([^>]*?) width="[^"]*" height="[^"]*"|^<svg([^>]*?) height="[^"]*" width="[^"]*"',
                  r"<svg\1\2", text)  # fmt: skip
    text = re.sub(r'\bid="([^"]*)"', rf'id="{prefix}\1"', text)
    return re.sub(r'(href="#|url\(#)', rf"\1{prefix}", text)


def _films(cells: pl.DataFrame, films: Mapping[Key, Film]) -> list[dict[str, Any]]:
    """The films, in the order given.

    Raises:
        ConfigurationError: A file is missing, or the window has no such cell.
    """
    known = set(cells.select(KEYS).iter_rows())
    found = []
    for k, ((stage, policy, cell), film) in enumerate(films.items()):
        if (stage, policy, cell) not in known:
            raise ConfigurationError(f"{film.path}: the window has no cell {cell} of {stage} with {policy} to show.")
        if not film.path.is_file():
            raise ConfigurationError(f"{film.path}: this film is missing; no page was written.")
        found.append({
            "key": (stage, policy, cell), "id": f"film{k}", "title": f"{stage}, {policy}, cell {cell}",
            "caption": film.caption, "source": data_uri(film.path.read_bytes(), "video/mp4"),
        })  # fmt: skip
    return found
