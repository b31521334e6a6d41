"""The live view in the terminal, on the error stream beside the answers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from ssmash_gym.monitor.watch import OK, Answer

if TYPE_CHECKING:
    from rich.table import Table

_UNKNOWN: Final = "[bold reverse] UNKNOWN [/]"


def picture(answer: Answer, horizon_s: float) -> Table:
    """One answer as a table."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(title="deck monitor (assumed limits; not for operational use)", show_header=False, min_width=60)
    table.add_row("deck clock", "-" if answer.time_s is None else f"{answer.time_s:.0f} s")
    if answer.status != OK:
        table.add_row("status", _UNKNOWN)
        table.add_row("reason", escape(answer.reason or ""))
    else:
        f = answer.figures
        low, high = f["p_exceed_interval"]
        colour = "red" if f["margin_now"] < 0.0 else "yellow" if f["margin_now"] < 0.2 else "green"
        window = f["next_quiet"]
        told = "none foreseen" if window is None else f"in {window['in_s']:.0f} s for {window['length_s']:.0f} s"
        table.add_row("status", "ok")
        table.add_row("margin now", f"[{colour}]{100 * f['margin_now']:.0f} %[/] of {f['margin_now_limit']}")
        table.add_row("next quiet window", told)
        limit = "" if f["p_exceed_limit"] is None else f", most by {f['p_exceed_limit']}"
        table.add_row(
            f"starting now, {horizon_s:g} s",
            f"{100 * f['p_exceed']:.0f} % exceed a limit ({100 * low:.0f} to {100 * high:.0f} %){limit}",
        )
    table.add_row("unusable rows", str(answer.malformed))
    return table


@contextmanager
def live_view(horizon_s: float, *, shown: bool) -> Iterator[Callable[[Answer], None]]:
    """A place in the terminal that shows the newest answer.

    Args:
        horizon_s: Of the answers [s].
        shown: Whether there is a view at all.
    """
    if not shown:
        yield lambda answer: None
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(stderr=True), auto_refresh=False) as live:
        yield lambda answer: live.update(picture(answer, horizon_s), refresh=True)
