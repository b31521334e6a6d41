"""What the deck does: motion sources and the node table that the dynamics read.

Every source of `MotionConfig` (and every further one) realises a `Motion`, and every `Motion` bakes a `MotionTable`.
"""

from __future__ import annotations

from ssmash_gym.ship.config import MotionConfig, parse_motion
from ssmash_gym.ship.harmonics import Component, Harmonics
from ssmash_gym.ship.motion import (
    CHANNELS,
    DEFAULT_SPACING_S,
    DeckPose,
    DeckRms,
    Motion,
    MotionSource,
    MotionTable,
    Signal,
    pose_of,
    smootherstep,
)
from ssmash_gym.ship.recorded import Discrepancy, RecordedMotion
from ssmash_gym.ship.sea import SEA_STATES, Spectrum, Spreading, comes_from_deg, named_spectrum, period_of_height
from ssmash_gym.ship.seaway import Seaway, SeawayMotion, draw_seaway
from ssmash_gym.ship.seaway_statistics import spectral_deck_rms
from ssmash_gym.ship.shipmo import ShipmoRecord, read_shipmo, write_shipmo
from ssmash_gym.ship.sources import (
    DOFS,
    Fixed,
    Irregular,
    IrregularRotation,
    IrregularTranslation,
    MotionFile,
    Sinusoid,
)

__all__ = [
    "CHANNELS",
    "DEFAULT_SPACING_S",
    "DOFS",
    "SEA_STATES",
    "Component",
    "DeckPose",
    "DeckRms",
    "Discrepancy",
    "Fixed",
    "Harmonics",
    "Irregular",
    "IrregularRotation",
    "IrregularTranslation",
    "Motion",
    "MotionConfig",
    "MotionFile",
    "MotionSource",
    "MotionTable",
    "RecordedMotion",
    "Seaway",
    "SeawayMotion",
    "ShipmoRecord",
    "Signal",
    "Sinusoid",
    "Spectrum",
    "Spreading",
    "comes_from_deg",
    "draw_seaway",
    "named_spectrum",
    "parse_motion",
    "period_of_height",
    "pose_of",
    "read_shipmo",
    "smootherstep",
    "spectral_deck_rms",
    "write_shipmo",
]
