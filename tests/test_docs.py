"""The manual holds together: every page is reached, every equation of chapter 2 is shown, the mathematics is closed.

Only the last test needs Sphinx and is skipped without it; `make docs` writes the pages.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from tools.check_links import broken_links
from tools.equation_index import DOCS, INDEX, LAST, pages, tags

TOCTREE = re.compile(r"^```\{toctree\}\n(?::[^\n]*\n)*(.*?)^```", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]+`")
DISPLAY = re.compile(r"\$\$(.*?)\$\$", re.DOTALL)
INLINE = re.compile(r"(?<![\\$])\$([^$]+)\$")
ENVIRONMENT = re.compile(r"\\(begin|end)\{(\w+\*?)\}")
PAGES = pages()


@cache
def text(page: Path) -> str:
    """A page without its code."""
    return CODE.sub("`code`", FENCE.sub("", page.read_text(encoding="utf-8")))


def entries(page: Path) -> list[Path]:
    """Pages that the tables of contents of a page name."""
    found = []
    for block in TOCTREE.findall(page.read_text(encoding="utf-8")):
        for entry in block.split():
            found += sorted(page.parent.glob(f"{entry}.md")) or [page.parent / f"{entry}.md"]
    return found


def name(page: Path) -> str:
    return page.relative_to(DOCS).as_posix()


def test_every_page_is_in_exactly_one_table_of_contents() -> None:
    listed = Counter(entry for page in PAGES for entry in entries(page))
    assert sorted(listed) == [page for page in PAGES if page != DOCS / "index.md"]
    assert [name(page) for page, times in listed.items() if times != 1] == []


def test_every_equation_of_chapter_2_is_shown_in_the_theory() -> None:
    shown = set().union(*(tags(text(page)) for page in PAGES if page != INDEX))
    missing = sorted(set(range(1, LAST + 1)) - shown)
    assert not missing, "no page shows " + ", ".join(f"(2.{k})" for k in missing)


def test_an_equation_is_shown_once() -> None:
    """A second place would be a second thing to keep right; other pages name the number and link."""
    where = {k: [] for k in range(1, LAST + 1)}
    for page in PAGES:
        for k in tags(text(page)):
            where[k].append(name(page))
    assert {f"(2.{k})": found for k, found in where.items() if len(found) > 1} == {}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_mathematics_is_closed(page: Path) -> None:
    """Unbalanced dollars, environments, braces or delimiters show as raw text on the built page."""
    content = text(page)
    assert content.count("$$") % 2 == 0
    displays = DISPLAY.findall(content)
    for formula in [*displays, *INLINE.findall(DISPLAY.sub("", content))]:
        assert "\n\n" not in formula, formula
        assert formula.count("{") - formula.count(r"\{") == formula.count("}") - formula.count(r"\}"), formula
        assert len(re.findall(r"\\left\b", formula)) == len(re.findall(r"\\right\b", formula)), formula
        open_: list[str] = []
        for kind, environment in ENVIRONMENT.findall(formula):
            if kind == "begin":
                open_.append(environment)
            else:
                assert open_ and open_.pop() == environment, formula
        assert not open_, formula


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_an_environment_of_numbered_lines_has_no_tag_outside(page: Path) -> None:
    """MathJax refuses two tags in one line, and a tag in an environment that has one line."""
    for formula in DISPLAY.findall(text(page)):
        lines = formula.split(r"\\") if r"\begin{align}" in formula else [formula]
        assert all(line.count(r"\tag{") <= 1 for line in lines), formula


def test_links_lead_somewhere() -> None:
    assert [line for page in PAGES for line in broken_links(page)] == []


def test_the_manual_builds_without_warnings(tmp_path: Path) -> None:
    """Everything but the writing of pages: references, tables of contents, headings, included files."""
    pytest.importorskip("sphinx")
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-b",
        "dummy",
        "-W",
        "--keep-going",
        "-q",
        "-E",
        str(DOCS),
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
