"""The examples of docs/guide/own_data.md run as they stand, in order, and print what the page says."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.ship import Motion, MotionTable
from ssmash_gym.ship.response_file import AMPLITUDES, GRID, PHASES
from ssmash_gym.ship.response_table import ResponseFile

PAGE = (Path(__file__).parents[2] / "docs" / "guide" / "own_data.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"(?:`(?P<name>[\w.]+)`:\n\n)?```(?P<kind>\w+)\n(?P<text>.*?)```\n", re.DOTALL)


@pytest.mark.filterwarnings("error")
def test_the_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    printed, compared = "", 0
    for block in BLOCK.finditer(PAGE):
        kind, text = block["kind"], block["text"]
        if kind in ("csv", "yaml"):
            assert block["name"], f"no file name above {text[:40]!r}"
            Path(block["name"]).write_text(text, encoding="utf-8")
        elif kind == "python":
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                exec(compile(text, "own_data.md", "exec"), names)
            printed = output.getvalue()
        else:
            assert kind == "text" and printed.startswith(text), (printed, text)
            compared += 1
    assert compared == 4
    assert [line.split()[0] for line in printed.splitlines()] == ["file", "seaway", "seaway"]  # in the environment
    assert "'kg_m': 6.0" in printed
    assert {"my_ship.csv", "my_ship.yaml", "my_record.yaml", "logger.csv", "frigate.csv"} <= {
        p.name for p in tmp_path.iterdir()
    }
    record, table = names["record"], names["table"]
    assert isinstance(record, Motion) and record.consistent  # type: ignore[attr-defined]
    assert isinstance(table, MotionTable) and np.degrees(np.std(table.nodes[:, 3])) == pytest.approx(
        3.0 / 2**0.5, rel=0.1
    )


def test_the_page_names_every_column_and_every_choice() -> None:
    for name in (*GRID, *(n for n in AMPLITUDES if not n.endswith("rad_per_m"))):
        assert f"`{name}`" in PAGE
    assert f"`{next(iter(PHASES))}` ... `{list(PHASES)[-1]}`" in PAGE
    for key, field in ResponseFile.model_fields.items():
        if key == "table":
            continue
        choices = getattr(field.annotation, "__args__", ("false", "true"))
        for choice in choices:
            default = " (default)" if choice in (field.default, str(field.default).lower()) else ""
            assert re.search(rf"\|( `{key}`)? \| `{choice}`{re.escape(default)} \|", PAGE), (key, choice)
