"""Check that every relative link and picture in the project's Markdown pages leads somewhere."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")
MATHS = re.compile(r"\$\$.*?\$\$|(?<!\\)\$[^$\n]*(?<!\\)\$", re.DOTALL)
SKIPPED = {".venv", "build", "runs", "node_modules"}


def anchors(page: Path) -> set[str]:
    """Anchors that a page's headings make."""
    headings = re.findall(r"^#+\s+(.+?)\s*$", FENCE.sub("", page.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(page: Path) -> list[str]:
    """Links of one page that lead nowhere, as ``page: link``."""
    broken = []
    text = MATHS.sub("", CODE.sub("", FENCE.sub("", page.read_text(encoding="utf-8"))))
    for link in LINK.findall(text):
        if re.match(r"[a-z]+:", link):
            continue
        target, _, anchor = link.partition("#")
        path = (page.parent / target) if target else page
        missing = not path.exists() or (anchor and path.suffix == ".md" and anchor not in anchors(path))
        if missing:
            broken.append(f"{page.relative_to(ROOT)}: {link}")
    return broken


def pages() -> list[Path]:
    """Every Markdown page of the project."""
    found = sorted(ROOT.rglob("*.md"))
    return [p for p in found if not any(part in SKIPPED or part.startswith(".") for part in p.relative_to(ROOT).parts)]


def main() -> int:
    """Print the broken links; the exit status says whether there were any."""
    broken = [line for page in pages() for line in broken_links(page)]
    print("\n".join(broken) if broken else f"{len(pages())} pages, every link leads somewhere")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
