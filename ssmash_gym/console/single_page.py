"""One HTML file that shows runs without a server: style, modules and data are inside."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any, Final

from ssmash_gym.console.web import page_file

_LINK: Final = re.compile(r'<link rel="stylesheet" href="/page/([^"]+)">')
_MAP: Final = re.compile(r'<script type="importmap">(.*?)</script>', re.DOTALL)
_MODULE: Final = re.compile(r'<script type="module" src="/page/([^"]+)"></script>')
_IMPORT: Final = re.compile(
    r"""((?:^|[;}\n])\s*(?:import|export)\b[^'"();]*?\bfrom\s*|^\s*import\s*)(['"])([^'"]+)\2""", re.MULTILINE
)
# Nothing from anywhere else; what is inside cannot name its own hash, so inline parts are let in.
_POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:; base-uri 'none'"
)


def single_page(runs: Sequence[Mapping[str, Any]]) -> str:
    """The page of `ssmash view` with these runs in it.

    Args:
        runs: As of `runs.runs_of`.

    Returns:
        HTML. Modules are `data:` addresses under names of an import map, which alone lets them import one another.
    """
    page = _text("view.html")
    given: dict[str, str] = json.loads(_found(_MAP, page))["imports"]
    names = {path.removeprefix("/page/"): name for name, path in given.items()}
    start = _found(_MODULE, page)
    modules: dict[str, str] = {}
    _collect(start, names, modules)
    imports = {_name(path, names): _address(code) for path, code in modules.items()}
    data = json.dumps({"runs": list(runs)}, separators=(",", ":")).replace("<", "\\u003c")
    parts = [
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        f'<script type="importmap">{json.dumps({"imports": imports})}</script>',
        f'<script type="application/json" id="runs">{data}</script>',
        f'<script type="module">import "{_name(start, names)}";</script>',
    ]
    page = _LINK.sub(lambda link: f"<style>\n{_text(link[1])}</style>", page)
    page = _MODULE.sub("", page)
    return _MAP.sub(lambda _: "\n".join(parts), page, count=1)


def _collect(path: str, names: Mapping[str, str], modules: dict[str, str]) -> None:
    """Gather a module and all that it imports, their imports told by name."""
    if path in modules:
        return
    modules[path] = ""  # modules may import one another
    paths = {name: file for file, name in names.items()}

    def by_name(found: re.Match[str]) -> str:
        wanted = found[3]
        file = paths.get(wanted) or _beside(path, wanted)
        _collect(file, names, modules)
        return f"{found[1]}{found[2]}{_name(file, names)}{found[2]}"

    modules[path] = _IMPORT.sub(by_name, _text(path))


def _beside(path: str, wanted: str) -> str:
    """The file that a relative import means."""
    parts: list[str] = list(PurePosixPath(path).parent.parts)
    for part in PurePosixPath(wanted).parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return "/".join(parts)


def _name(path: str, names: Mapping[str, str]) -> str:
    return names.get(path, f"page/{path}")


def _address(code: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(code.encode()).decode()


def _text(name: str) -> str:
    content = page_file(name)
    if content is None:
        raise FileNotFoundError(f"the package lacks its own page/{name}")
    return content.decode("utf-8")


def _found(pattern: re.Pattern[str], page: str) -> str:
    found = pattern.search(page)
    if found is None:
        raise ValueError(f"view.html has no {pattern.pattern}")
    return found[1]
