"""The example folder `configs/thesis_case` is what its page says: complete, current, and it runs."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.assets import asset_path
from ssmash_gym.cases import case_from, run_case
from ssmash_gym.document import read_yaml
from ssmash_gym.thesis_files import read_folder, write_case
from ssmash_gym.thesis_files.folder import SIDECAR
from ssmash_gym.thesis_files.run_layout import FILES

EXAMPLE = asset_path("configs", "thesis_case")
PAGE = Path(__file__).parents[2] / "docs" / "guide" / "thesis_files.md"


def test_the_folder_has_all_six_files_and_uses_them() -> None:
    reading = read_folder(EXAMPLE)
    assert {path.name for path in reading.folder.files.values()} == {file.name for file in FILES.values()}
    assert reading.defaults == ()
    # A remark would say that the helicopter is no longer that of the catalogue: make the folder anew (its case.yaml).
    assert reading.remarks == ()
    assert reading.document["helicopter"] == "generic_tricycle"


def test_the_folder_is_the_case_beside_it(tmp_path: Path) -> None:
    text = (EXAMPLE / "case.yaml").read_text(encoding="utf-8")
    case = case_from(read_yaml(text, "case.yaml"), "case.yaml", EXAMPLE)
    write_case(case, tmp_path / "thesis_case")
    for name in ("heli.inp", "solution.inp", "prescribed.inp", "rsd_pos.inp", "shipmo.inp"):
        assert (tmp_path / "thesis_case" / name).read_bytes() == (EXAMPLE / name).read_bytes(), name
    made = read_folder(tmp_path / "thesis_case").case
    assert made.changed({"deck.path": "x", "claw.path": "y"}) == read_folder(EXAMPLE).case.changed(
        {"deck.path": "x", "claw.path": "y"}
    )


def test_the_files_alone_start_as_the_case_does(tmp_path: Path) -> None:
    """The numbers of initials.inp are the settled start: loads within the share that the tires' deflections carry."""
    settled = read_folder(EXAMPLE).case.changed({"solution.end_s": 0.02, "solution.solver": "engine"})
    for name in ("heli.inp", "initials.inp", "solution.inp", "prescribed.inp", "rsd_pos.inp", "shipmo.inp", SIDECAR):
        (tmp_path / name).write_bytes((EXAMPLE / name).read_bytes())
    text = (tmp_path / SIDECAR).read_text(encoding="utf-8")
    bare = re.sub(r"(?ms)^  start:\n(    .*\n)+", "", text)
    assert bare != text
    (tmp_path / SIDECAR).write_text(bare, encoding="utf-8")
    given = read_folder(tmp_path).case.changed({"solution.end_s": 0.02, "solution.solver": "engine"})
    assert (settled.start.type, given.start.type) == ("settled", "state")
    one, other = run_case(settled), run_case(given)
    np.testing.assert_allclose(other.states[:34, 0], one.states[:34, 0], rtol=1e-12, atol=1e-14)
    for station in ("auxiliary", "right", "left"):
        assert other[f"{station}_vertical_load"][0] == pytest.approx(one[f"{station}_vertical_load"][0], rel=1e-6)


def test_the_page_s_own_lines_run(tmp_path: Path) -> None:
    code = re.findall(r"(?ms)^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"))
    assert len(code) == 1
    placed = (
        code[0].replace('"copy"', repr(str(tmp_path / "copy"))).replace('"configs/thesis_case"', repr(str(EXAMPLE)))
    )
    names: dict[str, object] = {}
    exec(placed, names)
    assert names["document"]["name"] == "thesis_case"
    assert names["history"].time_s[-1] == 1.0
