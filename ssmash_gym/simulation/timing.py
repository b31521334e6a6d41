"""The time grid of a batch: substeps, control intervals, nodes of the deck motion."""

from __future__ import annotations

from dataclasses import dataclass

from ssmash_gym.errors import ConfigurationError

LONGEST_SUBSTEP_S = 0.005
NODE_SPACING_S = 0.25  # C2 quintic pieces: below 2e-5 of the acceleration's deviation in a seaway


@dataclass(frozen=True)
class Timing:
    """Substep, control interval and node spacing [s]; the latter two are whole numbers of substeps.

    Raises:
        ConfigurationError: the control interval is no whole number of substeps.
    """

    substep_s: float = 0.002
    control_interval_s: float = 0.1

    def __post_init__(self) -> None:
        """Check that the interval is a whole number of substeps."""
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

    @property
    def substeps(self) -> int:
        """Substeps in a control interval."""
        return round(self.control_interval_s / self.substep_s)

    @property
    def substeps_per_node(self) -> int:
        """Substeps between two nodes of a deck-motion table."""
        return max(1, round(NODE_SPACING_S / self.substep_s))

    @property
    def node_spacing_s(self) -> float:
        """Time between two nodes of a deck-motion table [s]: what `MotionSource.bake` must be given."""
        return self.substeps_per_node * self.substep_s
