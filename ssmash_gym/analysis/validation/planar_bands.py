"""How much 2A to 2C depend on where the helicopter points at the start.

A vehicle that is moved by a claw behind its main wheels turns ever faster, so that a small difference at the start
grows. ``python -m ssmash_gym.analysis.validation.planar_bands`` prints the table of the page.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from ssmash_gym.dynamics.layout import State

if TYPE_CHECKING:
    from ssmash_gym.cases import Case, History

BY_DEG: Final = 0.1
LOAD: Final = "probe_in_plane"


@dataclass(frozen=True)
class Band:
    """A manoeuvre with the yaw at the start changed to either side.

    Attributes:
        name: Of the manoeuvre.
        by_deg: Change of the yaw at the start.
        yaw_deg: Yaw at the end: from the lower start, from the case's own, from the higher.
        steer_deg: Steer angle at the end, likewise.
        peak_kN: Peak in-plane load of the probe, likewise.
        apart_m: Distance of the final position of the body's c.g. from that of the case's own start: lower, higher.
    """

    name: str
    by_deg: float
    yaw_deg: tuple[float, float, float]
    steer_deg: tuple[float, float, float]
    peak_kN: tuple[float, float, float]
    apart_m: tuple[float, float]

    @property
    def growth(self) -> float:
        """Difference of yaw at the end over that at the start."""
        return (self.yaw_deg[2] - self.yaw_deg[0]) / (2.0 * self.by_deg)


def band(case: Case, by_deg: float = BY_DEG) -> Band:
    """Run a case with its own yaw at the start, with less and with more.

    Args:
        case: A case that starts settled.
        by_deg: Change of the yaw at the start [deg].

    Raises:
        ConfigurationError: The case has no yaw at its start, or a run cannot be made.
    """
    from ssmash_gym.cases import quantity, run_case
    from ssmash_gym.cases.start import Settled
    from ssmash_gym.errors import ConfigurationError

    if not isinstance(case.start, Settled):
        raise ConfigurationError(f"case {case.name}: start.type must be settled for a band of the yaw at the start.")
    own = case.start.yaw_deg
    runs = [run_case(case.changed({"start.yaw_deg": own + by})) for by in (-by_deg, 0.0, by_deg)]

    def ends(name: str) -> tuple[float, float, float]:
        low, middle, high = (float(quantity(name).of(history)[-1]) for history in runs)
        return low, middle, high

    low, middle, high = (1e-3 * history.largest(LOAD) for history in runs)
    return Band(
        name=case.name,
        by_deg=by_deg,
        yaw_deg=ends("yaw_deg"),
        steer_deg=ends("steer_deg"),
        peak_kN=(low, middle, high),
        apart_m=(_apart(runs[0], runs[1]), _apart(runs[2], runs[1])),
    )


def _apart(one: History, other: History) -> float:
    """Distance between the final positions of the body's c.g. [m]."""
    rows = slice(State.Q8, State.Q10 + 1)
    return float(np.linalg.norm(one.states[rows, -1] - other.states[rows, -1]))


def table(bands: Sequence[Band]) -> list[str]:
    """Bands as a table in Markdown."""
    lines = [
        "| manoeuvre | yaw at the end [deg] | grown by | steer at the end [deg] | peak probe load [kN] | "
        "final position moves by [mm] |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for one in bands:
        yaw, steer, peak = (
            " / ".join(f"{v:.2f}" for v in values) for values in (one.yaw_deg, one.steer_deg, one.peak_kN)
        )
        moved = " / ".join(f"{1e3 * v:.1f}" for v in one.apart_m)
        lines.append(f"| {one.name} | {yaw} | {one.growth:.2f} | {steer} | {peak} | {moved} |")
    return lines


def main(names: Sequence[str]) -> None:
    """Print the table of the named manoeuvres."""
    from ssmash_gym.cases import load_case

    print("\n".join(table([band(load_case(name)) for name in names])))


if __name__ == "__main__":
    main(sys.argv[1:] or ("2A", "2B", "2C"))
