"""Figures are SVG that stands on its own, show the numbers they are given, and can be told apart in grey."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import combinations

import numpy as np
import pytest

from ssmash_gym.evaluation import charts
from ssmash_gym.evaluation.page_style import FIRST, MARKS, OTHERS, sample, styles
from ssmash_gym.evaluation.statistics import Estimate

NAMES = ("agent", "law", "book")
LOOKS = styles(NAMES, "agent")
SVG = "{http://www.w3.org/2000/svg}"


def words(svg: str) -> list[str]:
    """Texts of a figure: Matplotlib draws them as outlines and leaves the words in comments."""
    return [text.strip() for text in re.findall(r"<!--(.*?)-->", svg, re.DOTALL)]


def around(value: float) -> Estimate:
    return Estimate(value, value - 1.0, value + 2.0)


@pytest.fixture(scope="module")
def drawn() -> dict[str, str]:
    """One of each kind."""
    rng = np.random.default_rng(0)
    loads = {name: rng.gamma(4.0, scale, 30) for name, scale in zip(NAMES, (2.0, 3.0, 6.0), strict=True)}
    rows = {name: [around(k + 5.0), None, around(k + 8.0)] for k, name in enumerate(NAMES)}
    sectors = {name: np.where(np.arange(12) == 3, np.nan, np.arange(12.0)) for name in NAMES}
    steps = np.linspace(0.0, 1e6, 9)
    return {
        "distribution": charts.distribution(loads, LOOKS, 15.0),
        "points": charts.points(["SS3", "SS4", "SS5"], rows, LOOKS, ("sea state", "kN"), limit=15.0),
        "time": charts.load_against_time(
            {name: (40.0 + k, around(9.0)) for k, name in enumerate(NAMES)},
            [charts.Speed("0.3 m/s", 30.0, 40.0), charts.Speed("0.1 m/s", 80.0, 20.0)], LOOKS, 47.5,
        ),
        "heading": charts.by_heading(np.arange(0.0, 360.0, 30.0), sectors, LOOKS, 15.0),
        "dots": charts.dots(["ss5", "heavy", "wet"], rows, {"law": [around(0.9)] * 3}, LOOKS, 15.0),
        "pairs": charts.pairs(loads["agent"], loads["book"], ("agent", "book"), LOOKS),
        "differences": charts.differences(loads["agent"] - loads["law"], ("agent", "law"), LOOKS),
        "learning": charts.learning({"seed 0": (steps, 20.0 - steps * 1e-5, steps * 1e-6)}),
    }  # fmt: skip


def test_every_figure_is_svg_without_a_link(drawn: dict[str, str]) -> None:
    for name, svg in drawn.items():
        root = ET.fromstring(svg)
        assert root.tag == f"{SVG}svg", name
        links = [value for node in root.iter() for key, value in node.attrib.items() if key.endswith("href")]
        assert all(link.startswith("#") for link in links), name
        assert not list(root.iter(f"{SVG}image")) and not list(root.iter(f"{SVG}script")), name


def test_the_same_numbers_give_the_same_text_and_others_do_not() -> None:
    one, same, other = (charts.differences(np.array([-1.0, low]), ("agent", "law"), LOOKS) for low in (2.0, 2.0, 3.0))
    assert one == same != other


def test_figures_name_their_policies_and_units(drawn: dict[str, str]) -> None:
    for name in ("distribution", "points", "time", "heading", "dots"):
        assert set(NAMES) <= set(words(drawn[name])), name
    assert "peak probe load [kN]" in words(drawn["distribution"])
    assert {"SS3", "SS4", "SS5"} <= set(words(drawn["points"]))
    assert {"0.3 m/s", "0.1 m/s"} <= set(words(drawn["time"]))
    assert {"head", "following"} <= set(words(drawn["heading"]))


def test_what_was_not_run_is_left_out() -> None:
    rows = {"agent": [None, None], "book": [around(9.0), around(12.0)]}
    told = words(charts.points(["0", "100"], rows, LOOKS, ("ms", "kN")))
    assert "book" in told and "agent" not in told


def test_pairs_and_differences_tell_the_numbers() -> None:
    ours, theirs = np.array([4.0, 6.0, 9.0, 5.0]), np.array([8.0, 8.0, 8.0, 8.0])
    assert "agent lower in 75 %" in words(charts.pairs(ours, theirs, ("agent", "law"), LOOKS))
    assert "median −2.5 kN" in words(charts.differences(ours - theirs, ("agent", "law"), LOOKS))


@pytest.mark.parametrize("ground", ["white", "grey"])
def test_styles_can_be_told_apart(ground: str) -> None:
    looks = (FIRST, *OTHERS)
    assert len({look.colour for look in looks}) == len(looks)
    for one, other in combinations(looks, 2):  # without colour: by marker
        assert one.marker != other.marker
    for look in looks:
        red, green, blue = (int(look.colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)]
        luminance = float(np.dot(linear, (0.2126, 0.7152, 0.0722)))
        paper = 1.0 if ground == "white" else 0.9  # the tint of the tables' rows
        assert (paper + 0.05) / (luminance + 0.05) >= 3.0, look  # WCAG 2.1, 1.4.11


def test_the_first_policy_stands_out_wherever_it_stands() -> None:
    looks = styles(["book", "agent", "law"], "agent")
    assert looks["agent"] is FIRST
    assert [looks["book"], looks["law"]] == list(OTHERS[:2])


def test_every_marker_has_an_outline_for_the_tables() -> None:
    for look in (FIRST, *OTHERS):
        root = ET.fromstring(sample(look))
        assert MARKS[look.marker] in {node.get("d") for node in root}
