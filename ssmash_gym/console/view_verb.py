"""`ssmash view`: recordings in the 3-D scene, in a browser or as one file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Final

import tyro
from rich.console import Console as Terminal

from ssmash_gym.console.runs import runs_of
from ssmash_gym.console.web import Place, open_browser, page_file, require_websockets, serve_static
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text

PATH: Final = "/view"
MOST_RUNS: Final = 5  # that can be told apart


def view(
    files: Annotated[tuple[Path, ...], tyro.conf.Positional],
    out: Path | None = None,
    port: int = 0,
    address: str = "127.0.0.1",
    browser: bool = True,
) -> None:
    """Show recordings in the 3-D scene with a time slider; several are laid over one another.

    The first one is the solid helicopter, and the deck moves as in it; the others are translucent. Trials are simulated
    once more, bit for bit. Ctrl-C ends it.

    Args:
        files: Trials, and recordings of ``ssmash simulate`` and of cases, at most five.
        out: Write one HTML file that needs no server, instead of serving the page.
        port: Of the server; 0 takes a free one.
        address: Where the server listens. Anything but this machine's own address lets others on the network look.
        browser: Open the page in the browser, where there is a display.

    Raises:
        ConfigurationError: A file cannot be shown, or an option is refused; nothing has been written.
        ImportError: The extra ``web`` is missing.
    """
    if not files:
        raise ConfigurationError("ssmash view needs at least one file: a trial or a recording.")
    if len(files) > MOST_RUNS:
        raise ConfigurationError(f"{len(files)} files are refused: at most {MOST_RUNS} can be told apart in one scene.")
    terminal = Terminal()
    if out is not None:
        _check_out(out)
        from ssmash_gym.console.single_page import single_page

        write_text(out, single_page(runs_of(files)))
        terminal.print(f"{out}: {out.stat().st_size / 1e6:.1f} MB; open it in a browser", markup=False, soft_wrap=True)
        return
    require_websockets()
    place = Place(address, port)
    contents = contents_of(runs_of(files))

    def opened(url: str) -> None:
        terminal.print(f"{url}  (Ctrl-C ends)", markup=False, soft_wrap=True)
        if browser:
            open_browser(url)

    serve_static(contents, place, opened, PATH)


def contents_of(runs: list[dict[str, Any]]) -> dict[str, bytes]:
    """What the server answers with, by path: the page, and the runs."""
    page = page_file("view.html")
    assert page is not None
    return {"/": page, PATH: page, "/runs.json": json.dumps({"runs": runs}, separators=(",", ":")).encode()}


def _check_out(out: Path) -> None:
    """Refuse a file that cannot be written, before anything is simulated.

    Raises:
        ConfigurationError: It is a folder, its own folder is missing, or its name does not say HTML.
    """
    if out.is_dir():
        raise ConfigurationError(f"--out {out} is refused: this is a folder, expected a file.")
    if not out.parent.is_dir():
        raise ConfigurationError(f"--out {out} is refused: there is no folder {out.parent}.")
    if out.suffix.lower() not in (".html", ".htm"):
        raise ConfigurationError(f"--out {out} is refused: the file's name must end in .html.")
