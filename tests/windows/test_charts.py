"""Figures of windows: every cell once and in its place, looks that can be told apart in grey, words as given."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from html import unescape
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows import charts
from ssmash_gym.windows.chart_layout import MOST_PANELS, layout_of
from ssmash_gym.windows.chart_looks import INSIDE, LIMITS, OPEN, Paint, limit_looks, verdict_look
from ssmash_gym.windows.chart_panels import middle
from tests.windows.synthetic import AXES, document, tables

SVG = "{http://www.w3.org/2000/svg}"
CELL = re.compile(r"s(\d+)([pd])(\d+)c(\d+)$")


def axes(**values: list[float]) -> dict[str, dict[str, Any]]:
    """Axes of a small sweep."""
    return {name: AXES.get(name, {"label": name, "unit": ""}) | {"values": at} for name, at in values.items()}


SMALL = axes(sea_state=[4.0, 6.0], waves_from_deg=[0.0, 90.0, 180.0, 270.0], speed_kn=[0.0, 10.0])


def drawn_cells(svg: str) -> list[tuple[str, ...]]:
    """Stage, policy and number of the cells in a figure."""
    nodes = [node.get("id", "") for node in ET.fromstring(svg).iter(f"{SVG}g")]
    return [found.groups() for one in nodes if (found := CELL.search(one))]


def words(svg: str) -> str:
    """Texts of a figure, which Matplotlib leaves in comments beside the outlines; fixed spaces as others."""
    found = " ".join(text.strip() for text in re.findall(r"<!--(.*?)-->", svg, re.DOTALL))
    return unescape(found).replace("\N{NO-BREAK SPACE}", " ")


@pytest.fixture(scope="module")
def told() -> dict[str, Any]:
    return document(SMALL)


@pytest.fixture(scope="module")
def cells(told: dict[str, Any]) -> pl.DataFrame:
    return tables(told, episodes=60)[0]


@pytest.fixture(scope="module")
def placard(cells: pl.DataFrame, told: dict[str, Any]) -> str:
    return charts.placard(cells, told, "secured")


def test_every_cell_is_drawn_once(placard: str, cells: pl.DataFrame, told: dict[str, Any]) -> None:
    wanted = {("1", "p", str(p), str(c)) for p in range(2) for c in range(16)}
    shown = drawn_cells(placard)
    assert len(shown) == len(wanted) and set(shown) == wanted
    assert set(drawn_cells(charts.probability(cells, told, "secured"))) == wanted
    assert {one[3] for one in drawn_cells(charts.difference(cells, told, "secured"))} == {str(c) for c in range(16)}


def test_a_cell_stands_where_the_waves_come_from(cells: pl.DataFrame, told: dict[str, Any]) -> None:
    layout = layout_of(cells, told)
    assert layout.polar and [layout.title(k) for k in range(2)] == ["sea state 4", "sea state 6"]
    for i, (x, y) in enumerate([(0, 1), (1, 0), (0, -1), (-1, 0)]):  # ahead at the top, starboard at the right
        for j in range(2):
            at = np.array(middle(layout, i, j))
            np.testing.assert_allclose(at / np.linalg.norm(at), [x, y], atol=1e-12)
    near, far = (np.linalg.norm(middle(layout, 0, j)) for j in range(2))
    assert near < far and layout.radii[1] - layout.radii[0] > 0.3  # the lowest speed has an area


@pytest.mark.parametrize("at", [[0.0, 90.0, 180.0, 270.0], [0.0, 45.0, 90.0, 135.0, 180.0], [10.0, 50.0, 200.0, 300.0]])
def test_sectors_do_not_overlap(at: list[float]) -> None:
    told = document(axes(waves_from_deg=at, speed_kn=[0.0, 5.0]), stages=["traverse"])
    layout = layout_of(tables(told, episodes=5)[0], told)
    first, last = layout.sectors_deg
    assert np.all(first < layout.across.values) and np.all(last > layout.across.values)
    assert np.all(last - np.append(first[1:], first[0] + 360.0) <= 1e-9)
    assert layout.closed == (at[1] != 45.0)


def test_looks_differ_without_colour() -> None:
    def grey(colour: str) -> float:
        return float(np.dot([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)], (0.299, 0.587, 0.114)))

    for one, other in combinations([INSIDE, OPEN, *LIMITS], 2):
        assert one.hatch != other.hatch or abs(grey(one.face) - grey(other.face)) > 0.1, (one, other)
    assert grey(INSIDE.face) > grey(OPEN.face) + 0.1 > max(grey(one.face) for one in LIMITS) + 0.2
    looks = limit_looks(f"limit{k}" for k in range(20))
    assert len(set(looks.values())) == 20
    for one in LIMITS:  # the hatch is seen on its ground
        assert abs(grey(one.face) - grey(one.ink)) > 0.3


def test_a_cell_looks_like_its_verdict_and_limit(cells: pl.DataFrame, told: dict[str, Any], placard: str) -> None:
    looks = limit_looks(told["limits"])
    own = cells.filter(pl.col("stage") == "secured", pl.col("policy") == "agent")
    found = {node.get("id"): node for node in ET.fromstring(placard).iter(f"{SVG}g")}
    patterns = {node.get("id"): node for node in ET.fromstring(placard).iter(f"{SVG}pattern")}
    for row in own.iter_rows(named=True):
        look = verdict_look(row, looks)
        path = next(found[f"s1p0c{row['cell']}"].iter(f"{SVG}path"))
        style = path.get("style", "")
        if look.hatch:
            named = re.search(r"url\(#([^)]*)\)", style)
            assert named is not None
            pattern = patterns[named[1]]
            style = next(pattern.iter(f"{SVG}rect")).get("fill", "") + ET.tostring(pattern, "unicode")
        assert look.face in style
    assert len(set(own["verdict"])) > 1  # or nothing has been compared


def test_the_legend_and_the_footer_tell_all(placard: str, told: dict[str, Any]) -> None:
    text = words(placard)
    for fact in ("probe load in the deck plane > 15 kN", "roll of the deck > 9°", "clearance to the corridor's edge",
                 "10 %", "95 %", "0123abcd", "seed 7", "feed1234", "32 cells, 1,920 episodes", "not operational",
                 "sea state 4", "sea state 6", "agent", "trapezoid", "head 0°", "starboard 90°"):  # fmt: skip
        assert " ".join(fact.split()) in " ".join(text.split()), fact


def test_odd_names_are_words_and_not_formulae() -> None:
    odd = document(SMALL, name="a $x_{$ & <b>", policies={"<i>p</i> $y^$": {}}, stages=["traverse"])
    odd["limits"] = {"q": {"value": -1.5, "unit": "kN", "label": "l $\\frac$ -- <u>", "sense": "below"}}
    svg = charts.placard(tables(odd, episodes=5)[0], odd, "traverse")
    assert "a $x_{$ & <b>" in words(svg) and "−1.5 kN" in words(svg)
    assert len(drawn_cells(svg)) == 16


def test_differences_have_a_sign_and_marks() -> None:
    told = document(axes(waves_from_deg=[0.0, 90.0, 180.0], speed_kn=[0.0]), stages=["traverse"])
    table = tables(told, episodes=5)[0].with_columns(valid=pl.lit(True))
    first = (pl.col("policy") == "agent") & (pl.col("cell") == 0)
    table = table.with_columns(
        share=pl.when(first).then(0.5).otherwise(0.1),
        verdict=pl.when(first).then(pl.lit("beyond")).otherwise(pl.lit("within")),
    )
    worse = charts.difference(table, told, "traverse", ("agent", "trapezoid"))
    better = charts.difference(table, told, "traverse", ("trapezoid", "agent"))
    for svg, hatched in ((worse, True), (better, False)):
        group = next(node for node in ET.fromstring(svg).iter(f"{SVG}g") if CELL.search(node.get("id", "")))
        assert ("fill: url(#" in ET.tostring(group, "unicode")) == hatched
    assert worse.count("within with trapezoid only") == 1


def test_other_axes_give_heat_maps_of_the_two_longest() -> None:
    told = document(axes(hs_m=[1.0, 2.0], friction_factor=[0.3, 0.6, 0.9], sink_rate_m_s=[1.0, 2.0, 3.0, 4.0]))
    table = tables(told, episodes=5)[0]
    layout = layout_of(table, told)
    assert (layout.across.name, layout.along.name, layout.polar) == ("sink_rate_m_s", "friction_factor", False)
    assert layout.panels == ((1.0,), (2.0,))
    assert len(drawn_cells(charts.placard(table, told, "traverse", ["agent"]))) == 24


def test_too_many_panels_are_left_out_and_that_is_told() -> None:
    many = axes(waves_from_deg=[0.0, 120.0, 240.0], speed_kn=[0.0], hs_m=[1.0 * k for k in range(5)],
                mass_factor=[0.5 + 0.1 * k for k in range(6)])  # fmt: skip
    told = document(many, stages=["traverse"], policies={"p": {}})
    svg = charts.placard(tables(told, episodes=3)[0], told, "traverse")
    assert len(drawn_cells(svg)) == 3 * MOST_PANELS
    assert f"The first {MOST_PANELS} of 30 panels" in words(svg)


@pytest.mark.parametrize("names", [["sea_state"], ["waves_from_deg", "speed_kn"], ["speed_kn", "sea_state"]])
def test_few_axes_and_holes_do_not_matter(names: list[str]) -> None:
    told = document({name: SMALL[name] for name in names}, stages=["traverse"], policies={"p": {}})
    table = tables(told, episodes=5)[0]
    for figure in (charts.placard, charts.probability):
        assert len(drawn_cells(figure(table, told, "traverse"))) == table.height
        assert len(drawn_cells(figure(table.head(1), told, "traverse"))) == 1


def test_the_csv_file_is_the_table(cells: pl.DataFrame, tmp_path: Path) -> None:
    path = charts.write_csv(cells, tmp_path / "cells.csv")
    back = pl.read_csv(path, schema_overrides=dict(cells.schema))
    assert back.equals(cells)
    nested = cells.with_columns(more=pl.concat_list("low", "high"))
    text = charts.write_csv(nested, tmp_path / "nested.csv").read_text().splitlines()
    assert len(text) == 1 + cells.height and text[0].endswith(",more")


def test_cells_without_episodes_are_left_blank(cells: pl.DataFrame, told: dict[str, Any]) -> None:
    none = pl.when(pl.col("cell") == 3).then(None).otherwise(pl.col("share"))
    table = cells.with_columns(share=none)
    for figure in (charts.placard, charts.probability, charts.difference):
        numbers = [one[3] for one in drawn_cells(figure(table, told, "traverse"))]
        assert numbers and "3" not in numbers


def test_what_cannot_be_drawn_is_refused_in_words(cells: pl.DataFrame, told: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match="no column verdict"):
        charts.placard(cells.drop("verdict"), told, "secured")
    with pytest.raises(ConfigurationError, match="no cells of stage 'landing'"):
        charts.probability(cells, told, "landing")
    with pytest.raises(ConfigurationError, match="one policy only"):
        charts.difference(cells.filter(pl.col("policy") == "agent"), told, "secured")


def test_the_same_table_gives_the_same_figure(cells: pl.DataFrame, told: dict[str, Any], placard: str) -> None:
    assert charts.placard(cells, told, "secured") == placard
    other = cells.with_columns(verdict=pl.lit("undecided"))
    assert charts.placard(other, told, "secured") != placard
    assert verdict_look({"verdict": "beyond", "limiting": None}, {}) != Paint(INSIDE.face)
