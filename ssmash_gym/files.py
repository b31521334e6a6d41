"""Files are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path`; it replaces `path` when the block ends well and is removed when it does not."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


@contextmanager
def whole_files(targets: Iterable[Path]) -> Iterator[dict[Path, Path]]:
    """Places beside several files; all take their files' places when the block ends well, none when it does not."""
    with ExitStack() as stack:
        folders: dict[Path, Path] = {}
        staged = {}
        for target in targets:
            if target.parent not in folders:
                folder = tempfile.TemporaryDirectory(prefix=".ssmash-", dir=target.parent)
                folders[target.parent] = Path(stack.enter_context(folder))
            staged[target] = folders[target.parent] / target.name
        yield staged
        for target in staged:
            if target.is_dir():
                raise IsADirectoryError(
                    f"{target}: this is a folder, a file was to be written there; nothing was written."
                )
        for target, place in staged.items():
            place.replace(target)
