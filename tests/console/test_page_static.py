"""The page as files: nothing inline (strict CSP), nothing from elsewhere, nothing that is missing."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

import ssmash_gym

PAGE = Path(ssmash_gym.__file__).parent / "console" / "page"
OWN = sorted(path for path in PAGE.rglob("*") if path.is_file() and "vendor" not in path.parts)
PAGES = [path for path in OWN if path.suffix == ".html"]
MODULES = [path for path in OWN if path.suffix == ".js"]
STYLES = [path for path in OWN if path.suffix == ".css"]
NAMES = [str(path.relative_to(PAGE)) for path in OWN]
IMPORT = re.compile(
    r"""(?:^\s*(?:import|export)\b[^;]*?\bfrom\s*|\bimport\s*\(\s*|^\s*import\s+)["']([^"']+)["']""", re.MULTILINE
)
FORBIDDEN = (
    r"innerHTML|outerHTML|insertAdjacentHTML|document\.write\(|\beval\(|new Function|setAttribute\(\s*[\"']style"
)
IDS = set(
    """
    scene phase clock driver viewers banner countdown first go stick knob take release start abort again next hand-over
    take-over open-form form result review review-box review-close latency late traces gauges fps names versions
    """.split()  # noqa: SIM905  (a table of words)
)


class Reader(HTMLParser):
    """Collects elements with their attributes, and the texts of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self._open: dict[str, str | None] | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag == "script":
            self._open = dict(attrs)
            self.scripts.append((self._open, ""))

    def handle_endtag(self, tag: str) -> None:
        if tag == "script":
            self._open = None

    def handle_data(self, data: str) -> None:
        if self._open is not None:
            self.scripts[-1] = (self._open, self.scripts[-1][1] + data)


def _import_map(page: Path) -> dict[str, str]:
    texts = [text for about, text in Reader(page.read_text("utf-8")).scripts if about.get("type") == "importmap"]
    return dict(json.loads(texts[0])["imports"]) if texts else {}


def _served(reference: str) -> Path:
    """The file behind a reference in a page, which is served at / and its files below /page/."""
    place = reference.split("?")[0].removeprefix(".").removeprefix("/")
    assert place.startswith("page/"), f"{reference} is not below /page/"
    return PAGE / place.removeprefix("page/")


def test_the_page_is_there() -> None:
    assert PAGE / "index.html" in PAGES and MODULES and STYLES


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_nothing_in_a_page_is_inline(page: Path) -> None:
    read = Reader(page.read_text("utf-8"))
    for tag, attributes in read.elements:
        assert tag != "style"
        for name in attributes:
            assert name != "style" and not name.startswith("on"), f"<{tag} {name}=...> is blocked by the page's policy"
    for about, text in read.scripts:
        assert about.get("type") in ("importmap", "module")
        assert not text.strip() or about.get("type") == "importmap"


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_what_a_page_refers_to_is_there(page: Path) -> None:
    references = [
        value
        for tag, attributes in Reader(page.read_text("utf-8")).elements
        for name, value in attributes.items()
        if value and (name == "src" or (name == "href" and tag == "link")) and not value.startswith("data:")
    ]
    assert references
    for reference in [*references, *_import_map(page).values()]:
        assert _served(reference).is_file(), reference


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PAGE)))
def test_what_a_module_imports_is_there(module: Path) -> None:
    known = {name: target for page in PAGES for name, target in _import_map(page).items()}
    for name in IMPORT.findall(module.read_text("utf-8")):
        found = module.parent / name if name.startswith(".") else _served(known[name])
        assert found.is_file(), f"{module.name} imports {name}"


def test_all_pages_have_the_same_import_map() -> None:
    """The server's policy allows a page's own map only, and all pages draw with the same library."""
    maps = [_import_map(page) for page in PAGES]
    assert all(found == maps[0] for found in maps) and maps[0]


@pytest.mark.parametrize("path", OWN, ids=NAMES)
def test_nothing_comes_from_elsewhere(path: Path) -> None:
    text = path.read_text("utf-8").replace("http://www.w3.org/2000/svg", "")  # a name, not an address
    assert not re.search(r"https?://|//cdn|@import|url\(\s*[\"']?(?!data:|#)", text)


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PAGE)))
def test_no_module_makes_code_or_markup_of_texts(module: Path) -> None:
    text = module.read_text("utf-8")
    assert not re.search(FORBIDDEN, text)
    assert len(text.splitlines()) <= 400


def test_names_that_tests_and_styles_rely_on_are_there() -> None:
    ids = [about["id"] for _, about in Reader((PAGE / "index.html").read_text("utf-8")).elements if "id" in about]
    assert len(ids) == len(set(ids))
    assert set(ids) >= IDS


def test_every_id_that_the_page_asks_for_exists() -> None:
    ids = set(re.findall(r'\bid="([\w-]+)"', (PAGE / "index.html").read_text("utf-8")))
    for module in MODULES:
        text = module.read_text("utf-8")
        made = set(re.findall(r'button\(\s*"([\w-]+)"|\bid: "([\w-]+)"', text))
        own = {name for pair in made for name in pair}
        for name in re.findall(r'byId\(\s*"([\w-]+)"\s*\)', text):
            assert name in ids | own, f"{module.name}: #{name}"


def test_styles_speak_of_classes_that_are_used() -> None:
    """A rule for a class that nothing has is a leftover."""
    used = "\n".join(path.read_text("utf-8") for path in OWN if path.suffix in (".html", ".js"))
    for style in (PAGE / "console.css", PAGE / "panels.css"):
        for name in set(re.findall(r"\.([a-z][a-z-]+)(?=[\s,:.{>\[])", style.read_text("utf-8"))):
            assert re.search(rf"[\"'\s`]{name}[\"'\s`$]", used), f"{style.name}: .{name}"
