r"""A Sphinx extension of the manual: source files as pages, equations with the thesis' numbers as places to link to.

- A link from a page to a file of the repository outside docs/ leads to a page of the manual that shows the file,
  highlighted; a line that bears an equation's mark is a place of that page.
- Display mathematics is handed to MathJax as written, and its ``\tag`` makes it a place of its page.
- In the index of equations the links of a row lead to the equation of that row.
"""

from __future__ import annotations

import html
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from equation_index import INDEX, ROOT, mark_of, shown, tags
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, get_lexer_for_filename
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

DOCS = ROOT / "docs"
FOLDER = "source"  # of the pages that show files
INCLUDED = {"benchmarks/README": "benchmark"}  # pages of the repository that a page of the manual includes
INDEX_PAGE = INDEX.relative_to(DOCS).with_suffix("").as_posix()


def anchor(number: int) -> str:
    """Name of the place of an equation, on a page and in a source file alike."""
    return f"eq-2-{number}"


class SourceLinks(SphinxTransform):
    """Links to files of the repository lead to pages that show them."""

    default_priority = 999

    def apply(self, **kwargs: Any) -> None:
        here = Path(self.env.doc2path(self.env.docname)).parent
        up = "../" * self.env.docname.count("/")
        for node in list(self.document.findall(addnodes.download_reference)):
            path = Path(os.path.normpath(here / node["reftarget"]))
            if path.is_relative_to(DOCS) or not path.is_relative_to(ROOT):
                continue
            name = path.relative_to(ROOT).as_posix()
            self.env.manual_sources.add(name)
            reference = nodes.reference("", "", *node.children, refuri=f"{up}{FOLDER}/{name}.html", internal=True)
            node.replace_self(reference)


class IncludedPages(SphinxTransform):
    """Links to a page of the repository that the manual includes lead to the including page."""

    default_priority = 999

    def apply(self, **kwargs: Any) -> None:
        for node in self.document.findall(addnodes.pending_xref):
            path = Path(node["reftarget"])
            if path.is_absolute() and path.is_relative_to(ROOT):
                name = path.relative_to(ROOT).as_posix()
                node["reftarget"] = INCLUDED.get(name, node["reftarget"])


class Equations(SphinxTransform):
    """Display mathematics as written, with the thesis' numbers as places to link to."""

    default_priority = 999

    def apply(self, **kwargs: Any) -> None:
        for node in self.document.findall(nodes.math_block):
            text = node.astext()
            node["ids"] += [anchor(k) for k in sorted(tags(text))]
            node["no-wrap"] = node["nowrap"] = True
            node.children = [nodes.Text(rf"\[{text}\]")]


def lead_to_rows(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """In the index of equations every link of a row leads to the equation of that row."""
    for row in doctree.findall(nodes.row) if docname == INDEX_PAGE else ():
        number = next(row.findall(nodes.Text)).astext().strip("()").removeprefix("2.")
        if not number.isdigit():
            continue
        pages = {path.stem for path in shown().get(int(number), [])}
        for link in row.findall(nodes.reference):
            if f"{FOLDER}/" in link["refuri"] or Path(link["refuri"]).stem in pages:
                link["refuri"] += f"#{anchor(int(number))}"


def start(app: Sphinx) -> None:
    """A fresh list of source files to show."""
    app.env.manual_sources = set()


def source_pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """A page for every source file that a page links to."""
    for name in sorted(app.env.manual_sources):
        title = html.escape(name)
        yield (
            f"{FOLDER}/{name}",
            {"title": title, "body": f"<h1>{title}</h1>{body(ROOT / name)}", "parents": []},
            "page.html",
        )


def body(path: Path) -> str:
    """A source file as highlighted HTML; marked lines carry the names of their equations."""
    text = path.read_text(encoding="utf-8")
    try:
        lexer = get_lexer_for_filename(path.name, stripnl=False)
    except ClassNotFound:
        lexer = TextLexer(stripnl=False)
    coloured = highlight(text, lexer, HtmlFormatter(nowrap=True)).splitlines()
    lines, seen = [], set[int]()
    for number, (source, line) in enumerate(zip(text.splitlines(), coloured, strict=False), 1):
        new = sorted(mark_of(source) - seen)
        seen.update(new)
        places = "".join(f'<span class="place" id="{anchor(k)}"></span>' for k in new)
        lines.append(f'{places}<span class="linenos" id="L{number}">{number:4d}</span>{line}')
    return '<div class="highlight file"><pre>' + "\n".join(lines) + "</pre></div>"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    for transform in (SourceLinks, IncludedPages, Equations):
        app.add_transform(transform)
    app.add_lexer("csv", TextLexer)
    app.connect("builder-inited", start)
    app.connect("doctree-resolved", lead_to_rows)
    app.connect("html-collect-pages", source_pages)
    return {"version": "1", "parallel_read_safe": False}
