r"""The numbered equations of the thesis: where the code bears their mark and where the manual shows them.

A mark is ``# (2.122)`` at the end of a line of code, with lists and ranges, such as ``# (2.238)-(2.241), (2.220)``, and
words after the first number. In the manual an equation is numbered by ``\tag{2.122}``, ``\tag{2.118, 2.119}`` or
``\tag{2.23–2.28}``. ``python tools/equation_index.py`` writes the index docs/theory/equations.md anew.
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
TAG = re.compile(r"\\tag\{([^}]*)\}")
TAGGED = re.compile(r"2\.(\d+)(?:\s*[-–]\s*2\.(\d+))?")
HEAD = """# Equations

Every numbered equation of chapter 2 of Léveillé (2013): the page of this manual that shows it, and the files whose
lines bear its mark, `# (2.xxx)`. In the built manual the links lead to the equation and to the marked line. Files named
`kane_*` are the literal form of sections 2.3 and 2.4, kept as a test. This page is written by
`python tools/equation_index.py`; a test keeps it, the pages and the code together.
"""


def _spread(pairs: list[tuple[str, str]]) -> set[int]:
    """Numbers of a list of (first, last or nothing)."""
    return {k for first, last in pairs for k in range(int(first), int(last or first) + 1)}


def tags(text: str) -> set[int]:
    """Equations that a page shows, by their tags."""
    return set().union(*(_spread(TAGGED.findall(tag)) for tag in TAG.findall(text)))


def numbers(text: str) -> set[int]:
    """Equations named or shown in a text, ranges included."""
    return _spread(NUMBERS.findall(text)) | tags(text)


def mark_of(line: str) -> set[int]:
    """Equations that a line of code is marked with."""
    found = MARK.search(line) if "# (2." in line else None
    return numbers(found.group(1)) if found else set()


def marks(text: str) -> set[int]:
    """Equations that the lines of a source file are marked with."""
    return set().union(*(mark_of(line) for line in text.splitlines()))


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


def pages() -> list[Path]:
    """Pages of the manual, those that are being written left out."""
    return [
        p for p in sorted(DOCS.rglob("*.md")) if not any(part.startswith(".") for part in p.relative_to(DOCS).parts)
    ]


@cache
def shown() -> dict[int, list[Path]]:
    """Pages of the manual by the equation that they show."""
    found: dict[int, list[Path]] = defaultdict(list)
    for path in pages():
        for k in tags(path.read_text(encoding="utf-8")):
            found[k].append(path)
    return found


def page_link(page: Path) -> str:
    """Markdown link from the index to a page."""
    relative = page.relative_to(DOCS)
    target = relative.name if relative.parent.name == "theory" else f"../{relative.as_posix()}"
    return f"[{page.stem}]({target})"


def index_page() -> str:
    """The index of equations as a page."""
    sections, entries = load()
    owned, shows = owners(), shown()
    lines = [HEAD]
    for name, (first, last) in sections.items():
        lines += [f"## {name}", "", "| equation | what | shown in | implemented in |", "| --- | --- | --- | --- |"]
        for k in range(first, last + 1):
            where = [f"[{path.name}](../../{path.relative_to(ROOT).as_posix()})" for path in owned.get(k, [])]
            entry = entries[k]
            if "replaced" in entry:
                where.append(f"replaced: {entry['replaced']}, see {page_link(DOCS / entry['see'])}")
            page = ", ".join(page_link(path) for path in shows.get(k, []))
            lines.append(f"| (2.{k}) | {entry['title']} | {page} | {'; '.join(where)} |")
        lines.append("")
    return "\n".join(lines)


def main() -> None:
    INDEX.write_text(index_page(), encoding="utf-8")
    print(f"{INDEX.relative_to(ROOT)} written")


if __name__ == "__main__":
    main()
