"""Lines of a growing file, of standard input, or of a finished record at a chosen pace."""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final, Literal

from ssmash_gym.columns import number_in
from ssmash_gym.errors import ConfigurationError

Pace = Literal["live", "real", "fast"]
STANDARD_INPUT: Final = "-"
WAIT_S: Final = 0.1  # between looks at a file that has not grown
LONGEST_LINE: Final = 65536  # bytes; what is longer is no row and is given out in pieces
_CHUNK: Final = 1 << 16


def batches(source: str, pace: Pace, wait_s: float = WAIT_S) -> Iterator[list[str]]:
    """Lines as they come: a list of those that are there, an empty one where nothing has come for `wait_s`.

    Args:
        source: A file, or ``-`` for standard input.
        pace: ``live`` waits for what is appended and never ends for a file; ``fast`` gives out a finished record line
            by line and ends; ``real`` does so by the record's own clock.
        wait_s: Longest time without giving out anything [s].

    Raises:
        ConfigurationError: The file cannot be read.
    """
    if source != STANDARD_INPUT and not Path(source).is_file():
        what = "this is a folder, no file" if Path(source).is_dir() else "there is no such file"
        raise ConfigurationError(f"monitor: --follow {source}: {what}.")
    if pace != "live":
        lines = _finished(sys.stdin.buffer) if source == STANDARD_INPUT else _of_file(Path(source))
        yield from _timed(lines) if pace == "real" else ([line] for line in lines)
    elif source == STANDARD_INPUT:
        yield from _piped(sys.stdin.buffer, wait_s)
    else:
        yield from _grown(Path(source), wait_s)


class Lines:
    """Cuts bytes into lines; the last one, while it has no end, waits for more."""

    def __init__(self) -> None:
        self._rest = b""

    def cut(self, chunk: bytes) -> list[str]:
        """The lines that a chunk completes."""
        *whole, self._rest = (self._rest + chunk).split(b"\n")
        if len(self._rest) > LONGEST_LINE:
            whole.append(self._rest)
            self._rest = b""
        return [line.decode("utf-8", errors="replace") for line in whole]

    def rest(self) -> list[str]:
        """What is left without an end."""
        left, self._rest = self._rest, b""
        return [left.decode("utf-8", errors="replace")] if left else []


def _of_file(path: Path) -> Iterator[str]:
    with path.open("rb") as file:
        yield from _finished(file)


def _finished(file: BinaryIO) -> Iterator[str]:
    lines = Lines()
    while chunk := file.read(_CHUNK):
        yield from lines.cut(chunk)
    yield from lines.rest()


def _timed(lines: Iterator[str]) -> Iterator[list[str]]:
    """Each line when its time has come, counted from the first one."""
    began: tuple[float, float] | None = None
    for line in lines:
        words = line.replace(",", " ").replace(";", " ").split()
        told = number_in(words[0]) if words else None
        if told is not None:
            if began is None:
                began = time.monotonic(), told
            ahead_s = told - began[1] - (time.monotonic() - began[0])
            if 0.0 < ahead_s < 60.0:  # a time that is wrong must not stop everything
                time.sleep(ahead_s)
        yield [line]


def _grown(path: Path, wait_s: float) -> Iterator[list[str]]:
    """What is in a file and what is appended to it; a file that has become shorter is read from its begin."""
    place, lines = 0, Lines()
    while True:
        try:
            with path.open("rb") as file:
                if path.stat().st_size < place:
                    place, lines = 0, Lines()
                file.seek(place)
                chunk = file.read()
        except OSError:  # moved away for a moment, or for good: then the input is silent
            chunk = b""
        place += len(chunk)
        found = lines.cut(chunk) if chunk else []
        if not found:
            time.sleep(wait_s)
        yield found


def _piped(file: BinaryIO, wait_s: float) -> Iterator[list[str]]:
    """What comes through a pipe, until it is closed; a thread waits for it, so that silence can be told."""
    come: queue.Queue[bytes | None] = queue.Queue()

    def read() -> None:
        for line in iter(lambda: file.readline(LONGEST_LINE), b""):
            come.put(line)
        come.put(None)

    threading.Thread(target=read, daemon=True).start()
    lines, closed = Lines(), False
    while not closed:
        chunks: list[bytes | None] = []
        try:
            chunks.append(come.get(timeout=wait_s))
            while True:
                chunks.append(come.get_nowait())
        except queue.Empty:
            pass
        closed = bool(chunks) and chunks[-1] is None
        yield lines.cut(b"".join(chunk for chunk in chunks if chunk))
    yield lines.rest()
