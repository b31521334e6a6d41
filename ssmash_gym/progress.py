"""One progress bar for all long work."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Advance = Callable[..., None]  # advance(share) or advance(share, words): share done, 0 to 1; what is being done


@contextmanager
def progress_bar(words: str = "", *, shown: bool = True) -> Iterator[Advance]:
    """A bar on the error stream, told the share that is done; nothing of it stays.

    Args:
        words: What is being done.
        shown: Whether there is a bar at all: short work needs none.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not shown) as bar:
        task = bar.add_task(words, total=1.0)

        def advance(share: float, now: str | None = None) -> None:
            bar.update(task, completed=share, description=now)

        yield advance
