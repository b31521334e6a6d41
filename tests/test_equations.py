"""Every numbered equation of the thesis has an owner: a line of code that bears its mark, or what replaces it.

How marks are written and read: `tools/equation_index.py`, which also writes the index docs/theory/equations.md.
"""

from __future__ import annotations

import re

from tools.equation_index import (
    DOCS,
    INDEX,
    LAST,
    ORACLE,
    ROOT,
    TESTED,
    index_page,
    load,
    marks,
    numbers,
    owners,
    pages,
    sources,
    tags,
)

REPLACED = re.compile(r"^## Replaced\n(.*?)(?=^#|\Z)", re.MULTILINE | re.DOTALL)


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
    texts = {e["see"]: (DOCS / e["see"]).read_text(encoding="utf-8") for e in entries.values() if "see" in e}
    silent = [f"(2.{k}) on {e['see']}" for k, e in entries.items() if "see" in e and k not in numbers(texts[e["see"]])]
    assert not silent, "\n".join(silent)


def test_what_a_page_calls_replaced_is_so_in_the_list() -> None:
    _, entries = load()
    listed = 0
    for path in pages():
        for block in REPLACED.findall(path.read_text(encoding="utf-8")):
            told = numbers("\n".join(line for line in block.splitlines() if line.startswith(("- ", "  "))))
            page = path.relative_to(DOCS).as_posix()
            assert {k for k in told if entries.get(k, {}).get("see") != page} == set(), page
            listed += len(told)
    assert listed > 0


def test_no_mark_and_no_page_names_an_equation_that_does_not_exist() -> None:
    named = {path: marks(path.read_text(encoding="utf-8")) for path in sources()}
    named |= {path: numbers(path.read_text(encoding="utf-8")) for path in pages()}
    wrong = [
        f"{path.relative_to(ROOT)}: (2.{k})" for path, found in named.items() for k in found - set(range(1, LAST + 1))
    ]
    assert not wrong, "\n".join(wrong)


def test_the_literal_form_covers_kinematics_and_dynamics() -> None:
    covered = set().union(*(marks((ROOT / name).read_text(encoding="utf-8")) for name in (*ORACLE, *TESTED)))
    assert set(range(36, 113)) <= covered


def test_index_page_is_up_to_date() -> None:
    assert INDEX.read_text(encoding="utf-8") == index_page(), "run: python tools/equation_index.py"


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


def test_tags_of_the_manual_are_read_as_lists_and_ranges() -> None:
    text = r"$$ a = b \tag{2.5} $$ and $$ c \tag{2.7, 2.9–2.11} $$, (2.20) and \tag{2.30-2.31}"
    assert tags(text) == {5, 7, 9, 10, 11, 30, 31}
    assert numbers(text) == tags(text) | {20}
