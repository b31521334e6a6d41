"""The time grid of a batch: substeps, control intervals, nodes of what is prescribed (deck, gusts, claw)."""

from __future__ import annotations

from dataclasses import dataclass

from ssmash_gym.errors import ConfigurationError

LONGEST_SUBSTEP_S = 0.005
NODE_SPACING_S = 0.25  # C2 quintic pieces: below 2e-5 of the acceleration's deviation in a seaway


@dataclass(frozen=True)
class Timing:
    """Substep, control interval and node spacing [s]; the latter two are whole numbers of substeps.

    Args:
        substep_s: step of the integration.
        control_interval_s: time between two commands, a whole number of substeps.
        longest_node_s: time between two nodes of the prescribed tables, rounded to whole substeps: finer for a claw
            or a deck that moves at several hertz, such as a claw with noise or a record at 20 Hz.

    Raises:
        ConfigurationError: the control interval is no whole number of substeps, or a time is out of its range.
    """

    substep_s: float = 0.002
    control_interval_s: float = 0.1
    longest_node_s: float = NODE_SPACING_S

    def __post_init__(self) -> None:
        """Check the ranges, and that the interval is a whole number of substeps."""
        if not 0.0 < self.substep_s <= LONGEST_SUBSTEP_S:
            raise ConfigurationError(
                f"substep_s = {self.substep_s}: must be above 0 and at most {LONGEST_SUBSTEP_S} s; "
                "longer steps give wrong peaks that look healthy"
            )
        ratio = self.control_interval_s / self.substep_s
        if ratio < 0.5 or abs(ratio - round(ratio)) > 1e-6 * ratio:
            raise ConfigurationError(
                f"control_interval_s = {self.control_interval_s}: must be a whole number of "
                f"substeps of {self.substep_s} s"
            )
        if not self.substep_s <= self.longest_node_s <= NODE_SPACING_S:
            raise ConfigurationError(
                f"longest_node_s = {self.longest_node_s}: must be from the substep of {self.substep_s} s to "
                f"{NODE_SPACING_S} s"
            )

    @property
    def substeps(self) -> int:
        """Substeps in a control interval."""
        return round(self.control_interval_s / self.substep_s)

    @property
    def substeps_per_node(self) -> int:
        """Substeps between two nodes of a table."""
        return max(1, round(self.longest_node_s / self.substep_s))

    @property
    def node_spacing_s(self) -> float:
        """Time between two nodes of a table [s]: what `MotionSource.bake` must be given."""
        return self.substeps_per_node * self.substep_s
