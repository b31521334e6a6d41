"""Every numbered equation of the thesis has an owner: a line of code that bears its mark, or what replaces it.

A mark is ``# (2.122)`` at the end of a line, with lists and ranges, such as ``# (2.238)-(2.241), (2.220)``, and words
after the first number. ``python tests/test_equations.py`` writes the index docs/theory/equations.md anew.
"""

from __future__ import annotations

import re
from collections import defaultdict
from functools import cache
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
INDEX = DOCS / "theory" / "equations.md"
LAST = 246
ORACLE = ("tests/verification/kane_kinematics.py", "tests/verification/kane_literal.py")
TESTED = ("tests/verification/test_kane_literal.py",)
MARK = re.compile(r"\S.*\s# (\(2\.\d+\).*)$")
NUMBERS = re.compile(r"\(2\.(\d+)\)(?:-\(2\.(\d+)\))?")
REPLACED = re.compile(r"^## Replaced\n(.*?)(?=^#|\Z)", re.MULTILINE | re.DOTALL)
HEAD = """# Equations

Every numbered equation of chapter 2 of Léveillé (2013) and the files whose lines bear its mark, `# (2.xxx)`.
Files named `kane_*` are the literal form of sections 2.3 and 2.4, kept as a test. This page is written by
`python tests/test_equations.py`; a test keeps it and the code together.
"""


def numbers(text: str) -> set[int]:
    """Equations named in a text, ranges included."""
    found: set[int] = set()
    for first, last in NUMBERS.findall(text):
        found.update(range(int(first), int(last or first) + 1))
    return found


def marks(text: str) -> set[int]:
    """Equations that the lines of a source file are marked with."""
    return set().union(
        *(numbers(m.group(1)) for line in text.splitlines() if "# (2." in line and (m := MARK.search(line)))
    )


@cache
def load() -> tuple[dict[str, list[int]], dict[int, dict[str, str]]]:
    """Sections, and by equation its title and perhaps what replaces it."""
    data: dict[str, Any] = yaml.safe_load((ROOT / "tests" / "data" / "equations.yaml").read_text(encoding="utf-8"))
    entries = {k: {"title": v} if isinstance(v, str) else v for k, v in data["equations"].items()}
    return data["sections"], entries


@cache
def sources() -> list[Path]:
    """Files whose marks count."""
    return [*sorted((ROOT / "ssmash_gym").rglob("*.py")), *(ROOT / name for name in (*ORACLE, *TESTED))]


@cache
def owners() -> dict[int, list[Path]]:
    """Files by the equation that they implement."""
    found: dict[int, list[Path]] = defaultdict(list)
    for path in sources():
        for k in marks(path.read_text(encoding="utf-8")):
            found[k].append(path)
    return found


def index_page() -> str:
    """The index of equations as a page."""
    sections, entries = load()
    owned = owners()
    lines = [HEAD]
    for name, (first, last) in sections.items():
        lines += [f"## {name}", "", "| equation | what | where |", "| --- | --- | --- |"]
        for k in range(first, last + 1):
            where = [f"[{path.name}](../../{path.relative_to(ROOT).as_posix()})" for path in owned.get(k, [])]
            entry = entries[k]
            if "replaced" in entry:
                page = Path(entry["see"])
                link = page.name if page.parent.name == "theory" else f"../{page.name}"
                where.append(f"replaced: {entry['replaced']}, see [{page.stem}]({link})")
            lines.append(f"| (2.{k}) | {entry['title']} | {'; '.join(where)} |")
        lines.append("")
    return "\n".join(lines)


def test_the_list_holds_every_equation_once_and_in_one_section() -> None:
    sections, entries = load()
    assert list(entries) == list(range(1, LAST + 1))
    assert [k for first, last in sections.values() for k in range(first, last + 1)] == list(entries)
    titles = [entry["title"] for entry in entries.values()]
    assert len(set(titles)) == len(titles)
    assert all(set(entry) in ({"title"}, {"title", "replaced", "see"}) for entry in entries.values())


def test_every_equation_has_an_owner() -> None:
    _, entries = load()
    owned = owners()
    orphans = [f"(2.{k}) {e['title']}" for k, e in entries.items() if k not in owned and "replaced" not in e]
    assert not orphans, "no line is marked with:\n" + "\n".join(orphans)


def test_what_is_replaced_is_told_on_its_page() -> None:
    _, entries = load()
    pages = {e["see"]: (DOCS / e["see"]).read_text(encoding="utf-8") for e in entries.values() if "see" in e}
    silent = [f"(2.{k}) on {e['see']}" for k, e in entries.items() if "see" in e and k not in numbers(pages[e["see"]])]
    assert not silent, "\n".join(silent)


def test_what_a_page_calls_replaced_is_so_in_the_list() -> None:
    _, entries = load()
    listed = 0
    for path in sorted(DOCS.rglob("*.md")):
        for block in REPLACED.findall(path.read_text(encoding="utf-8")):
            told = numbers("\n".join(line for line in block.splitlines() if line.startswith(("- ", "  "))))
            page = path.relative_to(DOCS).as_posix()
            assert {k for k in told if entries.get(k, {}).get("see") != page} == set(), page
            listed += len(told)
    assert listed > 0


def test_no_mark_and_no_page_names_an_equation_that_does_not_exist() -> None:
    named = {path: marks(path.read_text(encoding="utf-8")) for path in sources()}
    named |= {path: numbers(path.read_text(encoding="utf-8")) for path in sorted(DOCS.rglob("*.md"))}
    wrong = [
        f"{path.relative_to(ROOT)}: (2.{k})" for path, found in named.items() for k in found - set(range(1, LAST + 1))
    ]
    assert not wrong, "\n".join(wrong)


def test_the_literal_form_covers_kinematics_and_dynamics() -> None:
    covered = set().union(*(marks((ROOT / name).read_text(encoding="utf-8")) for name in (*ORACLE, *TESTED)))
    assert set(range(36, 113)) <= covered


def test_index_page_is_up_to_date() -> None:
    assert INDEX.read_text(encoding="utf-8") == index_page(), "run: python tests/test_equations.py"


def test_marks_are_read_as_lists_and_ranges_at_line_ends() -> None:
    text = "\n".join(
        [
            "x = 1  # (2.5)",
            "y = 2  # (2.7), (2.9)-(2.11): with words, and (2.20)",
            '    """``a x b``  # (2.2)"""',
            "z = 3  # of (2.30)",
            "# (2.40) alone on its line",
            '"""Text on (2.50)."""',
        ]
    )
    assert marks(text) == {2, 5, 7, 9, 10, 11, 20}


if __name__ == "__main__":
    INDEX.write_text(index_page(), encoding="utf-8")
    print(f"{INDEX.relative_to(ROOT)} written")
