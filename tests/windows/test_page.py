"""The page of a window: whole in one file, numbers those of the tables, the worst episodes first."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows import charts, page_words
from ssmash_gym.windows.chart_layout import layout_of
from ssmash_gym.windows.page import Film, inlined, write_window_page
from ssmash_gym.windows.page_data import MOST_EPISODES, page_data, rounded, worst
from tests.html_reader import HtmlReader
from tests.windows.synthetic import AXES, document, tables

SMALL = {
    "sea_state": AXES["sea_state"] | {"values": [4, 6]},
    "waves_from_deg": AXES["waves_from_deg"] | {"values": [0, 90, 180, 270]},
    "speed_kn": AXES["speed_kn"] | {"values": [0, 10]},
}


class Reader(HtmlReader):
    """Texts without scripts."""

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            super().handle_data(data)

    def of(self, name: str) -> list[str]:
        return [value for _, one, value in self.attributes if one == name]


@pytest.fixture(scope="module")
def told() -> dict[str, Any]:
    return document(SMALL)


@pytest.fixture(scope="module")
def both(told: dict[str, Any]) -> tuple[pl.DataFrame, pl.DataFrame]:
    return tables(told, episodes=30)


@pytest.fixture(scope="module")
def text(
    both: tuple[pl.DataFrame, pl.DataFrame], told: dict[str, Any], tmp_path_factory: pytest.TempPathFactory
) -> str:
    folder = tmp_path_factory.mktemp("page")
    film = folder / "film.mp4"
    film.write_bytes(b"not really a film")
    films = {("secured", "agent", 5): Film(film, "The worst <one>")}
    path = write_window_page(*both, told, folder / "window.html", films, command="ssmash window CONFIG OUT")
    return path.read_text(encoding="utf-8")


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Empty figures, for tests of something else: drawing takes longest."""
    for name in ("placard", "probability", "difference"):
        monkeypatch.setattr(charts, name, lambda *given: '<svg width="1" height="1"></svg>')


def held(text: str) -> dict[str, Any]:
    """The numbers in the page."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return dict(json.loads(found[1]))


def test_the_page_needs_nothing_but_itself(text: str) -> None:
    page = Reader(text)
    for name in ("src", "href", "xlink:href", "poster", "data", "srcset", "action"):
        assert all(link.startswith(("data:", "#")) for link in page.of(name)), name
    assert "@import" not in text and not re.search(r"url\((?!#)", text)
    script = text[text.rindex("<script>") :]
    assert not re.search(r"fetch|XMLHttpRequest|import\(|innerHTML|eval\(", script)
    assert set(re.findall(r"https?://[^\"'<> ]*", script)) == {"http://www.w3.org/2000/svg"}  # a name, no address
    outside = re.sub(r'xmlns(:\w+)?="[^"]*"', "", text[: text.rindex("<script>")])
    assert not re.search(r"https?://", outside)


def test_identifiers_are_unique_and_links_lead_to_them(text: str) -> None:
    page = Reader(text)
    identifiers = page.of("id")
    assert len(identifiers) == len(set(identifiers))
    ends = {link[1:] for name in ("href", "xlink:href") for link in page.of(name) if link.startswith("#")}
    ends |= set(re.findall(r"url\(#([^)]*)\)", text))
    assert ends <= set(identifiers)


def test_every_cell_can_be_chosen_in_one_figure(text: str, both: tuple[pl.DataFrame, pl.DataFrame]) -> None:
    shown = [one for one in Reader(text).of("id") if re.search(r"s\d+p\d+c\d+$", one)]
    numbers = held(text)
    wanted = {f"f{one['s']}-{one['p']}-s{one['s']}p{one['p']}c{one['c']}" for one in numbers["cells"]}
    assert set(shown) == wanted and len(shown) == both[0].height
    places = [(one["s"], one["p"], *one["place"]) for one in numbers["cells"]]
    assert len(set(places)) == len(places)


def test_the_numbers_of_a_cell_are_those_of_the_tables(text: str, both: tuple[pl.DataFrame, pl.DataFrame]) -> None:
    cells, rows = both
    numbers = held(text)
    for one, row in zip(numbers["cells"], cells.iter_rows(named=True), strict=True):
        assert (numbers["stages"][one["s"]], numbers["policies"][one["p"]], one["c"]) == (
            row["stage"], row["policy"], row["cell"],
        )  # fmt: skip
        assert (one["n"], one["over"], one["v"], one["by"]) == (
            row["episodes"], row["exceeded"], row["verdict"], row["limiting"],
        )  # fmt: skip
        assert one["share"] == [rounded(row[name]) for name in ("share", "low", "high")]
        assert one["by_limit"] == [row[f"over_{name}"] for name in numbers["names"]]
        own = rows.filter(pl.col("stage") == row["stage"], pl.col("policy") == row["policy"],
                          pl.col("cell") == row["cell"])  # fmt: skip
        seeds = [episode[0] for episode in one["rows"]]
        assert len(seeds) == len(set(seeds)) == MOST_EPISODES and seeds[0] == str(row["worst_seed"])
        assert set(map(int, seeds)) <= set(own["seed"])
        exceeded = [len(episode[4]) for episode in one["rows"]][1:]
        assert exceeded == sorted(exceeded, reverse=True)


def test_the_worst_episodes_follow_the_use_if_it_is_told(told: dict[str, Any]) -> None:
    head = {"stage": ["s"] * 4, "policy": ["p"] * 4, "cell": [0] * 4, "number": range(4), "seed": range(4)}
    rows = pl.DataFrame(head | {"exceeds": ["", "", "a", None], "worst_use": [0.2, 0.9, 1.1, None]})
    cells = pl.DataFrame({"stage": ["s"], "policy": ["p"], "cell": [0]})
    assert worst(rows, cells)["seed"].to_list() == [2, 1, 0, 3]


def test_words_and_tables_count_the_cells(both: tuple[pl.DataFrame, pl.DataFrame], told: dict[str, Any]) -> None:
    cells = both[0]
    own = cells.filter(pl.col("valid"), pl.col("stage") == "traverse", pl.col("policy") == "agent")
    within = own.filter(pl.col("verdict") == "within").height
    sentence = page_words.headline(cells, told)[0]
    assert f"within the limits in {within} of {own.height} cells" in sentence
    assert f"A further {16 - own.height} cell" in sentence
    for table, stage in zip(page_words.counts(cells, told), told["stages"], strict=True):
        total = sum(int(row.cells[k].text) for row in table.rows for k in (2, 3, 4, -1))
        assert total == cells.filter(pl.col("stage") == stage).height


def test_directions_go_over_the_bow(told: dict[str, Any]) -> None:
    at = list(range(0, 360, 30))
    cells = pl.DataFrame([
        {"stage": "s", "policy": "p", "cell": k, "waves_from_deg": float(d), "speed_kn": v, "episodes": 9, "share": 0.0,
         "low": 0.0, "high": 0.05, "limiting": None, "valid": True,
         "verdict": "within" if d in (300, 330, 0, 30, 180) or v == 0.0 else "beyond"}
        for k, (d, v) in enumerate((d, v) for d in at for v in (0.0, 10.0))
    ])  # fmt: skip
    layout = layout_of(cells, told | {"axes": {name: SMALL[name] | {"values": []} for name in list(SMALL)[1:]}})
    assert page_words.directions(cells, layout) == "180, 300–30"
    assert page_words.fastest(cells, layout) == "0"
    all_within = cells.with_columns(verdict=pl.lit("within"))
    assert page_words.directions(all_within, layout) == "all" and page_words.fastest(all_within, layout) == "10"
    assert page_words.directions(all_within.with_columns(valid=pl.lit(False)), layout) == "none"


def test_films_are_in_the_page_and_others_have_a_command(text: str) -> None:
    page, numbers = Reader(text), held(text)
    film = next(value for tag, name, value in page.attributes if (tag, name) == ("video", "src"))
    assert base64.b64decode(film.removeprefix("data:video/mp4;base64,")) == b"not really a film"
    assert [(one["s"], one["p"], one["c"]) for one in numbers["cells"] if one["film"]] == [(1, 0, 5)]
    assert numbers["commands"][0][1] == "ssmash window --film DIR --policy trapezoid --stage traverse --cell "
    assert "The worst &lt;one&gt;" in text


def test_provenance_is_told(text: str) -> None:
    shown = " ".join(Reader(text).texts)
    for fact in ("0123abcd", "seed 7", "feed1234", "time-uniform confidence sequence", "assumed", "not operational",
                 "ssmash window CONFIG OUT", "made_up_helicopter", f"{MOST_EPISODES} worst episodes"):  # fmt: skip
        assert fact in shown, fact


def test_the_csv_in_the_page_is_the_table(text: str, both: tuple[pl.DataFrame, pl.DataFrame]) -> None:
    link = next(value for value in Reader(text).of("href") if value.startswith("data:text/csv"))
    back = pl.read_csv(base64.b64decode(link.split(",", 1)[1]), schema_overrides=dict(both[0].schema))
    assert back.equals(both[0])


def test_odd_names_are_words_and_not_tags(tmp_path: Path, no_figures: None) -> None:
    odd = document(SMALL, name="</title><b>", policies={"</script><i> $x$": {"kind": "<u>"}}, stages=["it's"])
    odd["limits"] = {"q": {"value": 1.0, "unit": "kN", "label": "</script><s>", "sense": "above", "note": "<em>"}}
    text = write_window_page(*tables(odd, episodes=3), odd, tmp_path).read_text(encoding="utf-8")
    Reader(text)
    for tag in ("<b></", "</script><i>", "</script><s>", "<u>", "<em>"):
        assert tag not in text
    numbers = held(text)
    assert numbers["policies"] == ["</script><i> $x$"] and numbers["limits"][0]["label"] == "</script><s>"
    assert "--policy '</script><i> $x$' --stage 'it'\"'\"'s' --cell " in numbers["commands"][0][0]


@pytest.mark.parametrize("empty", [True, False])
def test_one_policy_one_sea_state_no_episodes_and_unknown_columns(empty: bool, tmp_path: Path) -> None:
    one = document(SMALL | {"sea_state": SMALL["sea_state"] | {"values": [5]}}, policies={"p": {}}, stages=["traverse"])
    cells, rows = tables(one, episodes=3)
    cells = cells.with_columns(further=pl.lit("x"), nested=pl.concat_list("low", "high")).drop("valid", "worst_seed")
    rows = pl.DataFrame() if empty else rows.with_columns(further=pl.lit(1.0), time_s=pl.lit(float("nan")))
    text = write_window_page(cells, rows, one, tmp_path).read_text(encoding="utf-8")
    assert [len(cell["rows"]) for cell in held(text)["cells"]] == [0 if empty else 3] * 8
    assert 'id="differences"' not in text


def test_what_is_missing_is_refused_before_anything_is_written(
    both: tuple[pl.DataFrame, pl.DataFrame], told: dict[str, Any], tmp_path: Path, no_figures: None
) -> None:
    cells, rows = both
    gone = {("traverse", "agent", 0): Film(tmp_path / "gone.mp4")}
    nowhere = {("traverse", "agent", 99): Film(tmp_path / "gone.mp4")}
    for given, films, words in (
        ((cells.drop("share"), rows), {}, "no column share"), ((cells, rows.drop("seed")), {}, "no column seed"),
        ((cells.head(0), rows), {}, "no cells"), ((cells, rows), gone, "film is missing"),
        ((cells, rows), nowhere, "no cell 99"),
    ):  # fmt: skip
        with pytest.raises(ConfigurationError, match=words):
            write_window_page(*given, told, tmp_path / "page.html", films)
    assert not list(tmp_path.iterdir())


def test_the_same_tables_give_the_same_page(
    both: tuple[pl.DataFrame, pl.DataFrame], told: dict[str, Any], tmp_path: Path, no_figures: None
) -> None:
    one, other = (write_window_page(*both, told, tmp_path / name) for name in ("a", "b"))
    assert one == tmp_path / "a" / "index.html" and one.read_bytes() == other.read_bytes()


def test_a_large_window_stays_small() -> None:
    told = document(stages=["traverse"])
    cells, rows = tables(told)
    size = len(json.dumps(page_data(cells, rows, told, {}), separators=(",", ":")))
    assert cells.height == 960 and rows.height > 38_000 and size < 2_500_000
    figure = charts.placard(cells, told, "traverse", ["agent"])
    assert len(inlined(figure, "f-")) < 700_000  # and about twice as much again as maps, in fifteen megabytes
