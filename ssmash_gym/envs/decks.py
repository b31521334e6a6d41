"""The deck and the wind of a draw in time: tables for the simulation, and what the sea amounts to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.motions import plain
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Motion, MotionSource, MotionTable, parse_motion
from ssmash_gym.ship.seaway import Seaway
from ssmash_gym.ship.wind import Gust, GustTable
from ssmash_gym.simulation.batch import Timing

Array = NDArray[np.float64]
_REMEMBERED: Final = 4096  # seas whose figures are kept; more are worked out anew
_GUST_TABLES: Final = 128  # that are kept, 30 kB each
_GUSTS: Final = 1  # distinguishes the gusts' random numbers from the waves' of the same seed
_CERTAIN: Final = ("fixed", "sinusoid", "file")  # types of motion that draw nothing: the same whatever the seed


@dataclass(frozen=True)
class SeaFigures:
    """What the deck motion of an episode amounts to in the long run, whatever happens in its minute.

    Attributes:
        lateral_g: RMS of the deck's lateral specific force (what tires and probe feel) [g].
        roll_deg: RMS of the roll about its mean [deg].
        pitch_deg: RMS of the pitch about its mean [deg].
        vertical_velocity_m_s: RMS of the vertical velocity of the deck's origin [m/s].
        hs_m: Significant wave height [m]; this and the next two are None where the deck moves without a sea.
        heading_deg: Where the waves travel relative to the ship: 0 with it, 90 to starboard, 180 against it [deg].
        speed_kn: Speed of the ship [kn].
        within_validity: Whether the model of the motion holds for it.
    """

    lateral_g: float
    roll_deg: float
    pitch_deg: float
    vertical_velocity_m_s: float
    hs_m: float | None
    heading_deg: float | None
    speed_kn: float | None
    within_validity: bool

    def metrics(self) -> dict[str, float | bool | None]:
        """As they stand in an episode's metrics; None for what does not exist."""
        return {
            "sea_lateral_g": self.lateral_g,
            "sea_roll_deg": self.roll_deg,
            "sea_pitch_deg": self.pitch_deg,
            "sea_vertical_velocity_m_s": self.vertical_velocity_m_s,
            "sea_hs_m": self.hs_m,
            "sea_heading_deg": self.heading_deg,
            "sea_speed_kn": self.speed_kn,
            "within_validity": self.within_validity,
        }


class Decks:
    """Realises draws: deck motion, gusts, figures. The same draw always gives the same.

    Args:
        task: Its lead-in and horizon set the length of the tables.
        timing: Its node spacing is the tables'.
    """

    def __init__(self, task: TaskConfig, timing: Timing) -> None:
        self._ramp_s = task.lead_in.ramp_s
        self._spacing_s = timing.node_spacing_s
        self._duration_s = task.lead_in.duration_s + task.horizon_s + timing.node_spacing_s
        self._records: dict[tuple[str, ...], MotionSource] = {}
        self._figures: dict[str, SeaFigures] = {}
        self._gusts: dict[tuple[float, float, int], GustTable] = {}

    def motion(self, given: Mapping[str, Any], seed: int) -> tuple[Motion, float]:
        """The motion of a drawn section, and its time when the lead-in starts [s].

        Raises:
            ConfigurationError: The section is refused, or a record cannot be read.
        """
        source, start_s = self._source(given)
        return source.realise(np.random.default_rng(seed)), start_s

    def baked(self, given: Mapping[str, Any], seed: int) -> MotionTable:
        """Table of a drawn section: lead-in with its ramp, horizon and a little more.

        Raises:
            ConfigurationError: As of `motion`; or the motion is too fast for the table, or too short.
        """
        source, start_s = self._source(given)
        motion = source.realise(np.random.default_rng(seed))
        if given["type"] not in _CERTAIN:  # where what was drawn is at hand, its figures cost next to nothing
            self._remember(_key(given, seed), source, motion)
        return motion.bake(self._duration_s, self._spacing_s, ramp_s=self._ramp_s, start_s=start_s)

    def _source(self, given: Mapping[str, Any]) -> tuple[MotionSource, float]:
        section, besides = plain(given)
        start_s = float(besides.get("start_s", 0.0))
        if section["type"] != "file":
            return parse_motion(section, where="motion"), start_s
        key = tuple(f"{name}={value}" for name, value in sorted(section.items()))
        if key not in self._records:  # a record is read once
            self._records[key] = parse_motion(section, where="motion")
        return self._records[key], start_s

    def gusts(self, draw: EpisodeDraw) -> GustTable | None:
        """Table of the gust speed along the true wind, ramped in with the sea; None where there is no gust.

        The random numbers come from the motion's seed, and are others than the waves'.
        """
        if draw.wind_gust_intensity * draw.wind_speed_mps == 0.0:
            return None
        key = draw.wind_speed_mps, draw.wind_gust_intensity, draw.motion_seed
        if key not in self._gusts:  # on another course through the same sea they are the same
            while len(self._gusts) >= _GUST_TABLES:
                del self._gusts[next(iter(self._gusts))]
            rng = np.random.default_rng(np.random.SeedSequence([draw.motion_seed, _GUSTS]))
            gust = Gust.draw(draw.wind_speed_mps, draw.wind_gust_intensity, rng)
            self._gusts[key] = gust.bake(self._duration_s, self._spacing_s, ramp_s=self._ramp_s)
        return self._gusts[key]

    def tables(self, draws: Sequence[EpisodeDraw]) -> tuple[list[MotionTable], list[GustTable | None]]:
        """Deck motion and gusts of draws, one table each.

        Raises:
            ConfigurationError: A draw is refused by its table: the motion is too fast for it, or too short.
        """
        try:
            decks = [self.baked(draw.motion, draw.motion_seed) for draw in draws]
        except ConfigurationError as error:
            raise ConfigurationError(f"draw: motion: {error}") from None
        return decks, [self.gusts(draw) for draw in draws]

    def figures(self, draw: EpisodeDraw) -> SeaFigures:
        """What the deck motion of a draw amounts to."""
        key = _key(draw.motion, draw.motion_seed)
        if key not in self._figures:
            source, _ = self._source(draw.motion)
            self._remember(key, source, source.realise(np.random.default_rng(draw.motion_seed)))
        return self._figures[key]

    def _remember(self, key: str, source: MotionSource, motion: Motion) -> None:
        if len(self._figures) >= _REMEMBERED:
            del self._figures[next(iter(self._figures))]
        found = motion.deck_rms()
        self._figures[key] = SeaFigures(
            lateral_g=float(found.lateral_specific_force_g),
            roll_deg=float(found.roll_deg),
            pitch_deg=float(found.pitch_deg),
            vertical_velocity_m_s=float(found.vertical_velocity_m_s),
            hs_m=float(source.sea().hs_m) if isinstance(source, Seaway) else None,
            heading_deg=source.heading_deg if isinstance(source, Seaway) else None,
            speed_kn=source.speed_kn if isinstance(source, Seaway) else None,
            within_validity=motion.outside_validity is None,
        )


def _key(given: Mapping[str, Any], seed: int) -> str:
    """Tells motions apart; the start within a record makes no other motion, nor does a seed where nothing is drawn."""
    section = dict(sorted(plain(given)[0].items()))
    return f"{0 if section['type'] in _CERTAIN else seed} {section!r}"
