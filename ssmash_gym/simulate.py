"""`ssmash simulate`: one helicopter on a moving deck, recorded."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning

if TYPE_CHECKING:
    from ssmash_gym.ship.motion import Motion, MotionSource

DEFAULT_MOTION = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 5.0, "period_s": 10.0}


def motion_section(path: Path | None) -> dict[str, Any]:
    """The motion section of a YAML file: its `motion` key, or the whole file; a 5 degree roll without a file.

    Raises:
        ConfigurationError: The file is missing, is not YAML, or holds no mapping.
    """
    import yaml

    if path is None:
        return dict(DEFAULT_MOTION)
    if not path.is_file():
        raise ConfigurationError(f"{path}: there is no such motion file.")
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ConfigurationError(f"{path}: this is no YAML: {' '.join(str(error).split())}") from None
    if not isinstance(document, dict):
        raise ConfigurationError(f"{path}: a motion file holds keys and values, found {document!r}")
    section = document.get("motion", document)
    return dict(section) if isinstance(section, dict) else section


def realised(source: MotionSource, seed: int) -> Motion:
    """The motion of a section, drawn with ``numpy.random.default_rng(seed)``.

    A record's own warning about its rates is held back: the verbs print the whole check.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConfigurationWarning)
        return source.realise(np.random.default_rng(seed))


def simulate(
    helicopter: str = "generic_tricycle",
    motion: Path | None = None,
    out: Path = Path("recording.parquet"),
    duration_s: float = 60.0,
    lead_in_s: float = 8.0,
    along: float = 0.0,
    across: float = 0.0,
    yaw_deg: float = 0.0,
    seed: int = 0,
) -> None:
    """Run one helicopter on a moving deck and record its telemetry in a Parquet file.

    The helicopter is settled on the deck with the claw at its probe; the motion is ramped in during the lead-in,
    while the claw is held; then the claw is driven at a constant command.

    Args:
        helicopter: Name in the catalogue, or a YAML file.
        motion: YAML file with a motion section (type: fixed, sinusoid, irregular, seaway or file); 5 degrees of roll
            in 10 s without one. For a record (type: file) the check of its rates is printed.
        out: Recording to write.
        duration_s: Simulated time [s], lead-in included.
        lead_in_s: Time with the claw held, in which the motion is ramped in [s].
        along: Claw command along the track after the lead-in, as a share of its greatest speed, -1 to 1.
        across: The same across the track, starboard positive.
        yaw_deg: Yaw at the start [deg].
        seed: Seed of motions that draw.
    """
    from ssmash_gym.ship.config import parse_motion
    from ssmash_gym.ship.recorded import RecordedMotion
    from ssmash_gym.simulation.batch import Batch
    from ssmash_gym.simulation.recording import Recorder
    from ssmash_gym.vehicle import document_of, load_helicopter

    for name, value in (("along", along), ("across", across)):
        if not -1.0 <= value <= 1.0:
            raise ConfigurationError(f"{name} = {value:g} is refused: a claw command must be within -1 to 1.")
    if not 0.0 <= lead_in_s < duration_s:
        raise ConfigurationError(f"lead_in_s = {lead_in_s:g} is refused: it must be 0 or more and below duration_s.")
    source = parse_motion(motion_section(motion), folder=motion.parent if motion else None)
    description = load_helicopter(helicopter)
    batch = Batch(description)
    deck = realised(source, seed)
    if isinstance(deck, RecordedMotion):
        print(deck.report())
    if deck.outside_validity is not None:
        print(f"outside validity: {deck.outside_validity}")
    batch.set_motion([deck.bake(duration_s + 1.0, batch.timing.node_spacing_s, ramp_s=lead_in_s)])
    batch.place(0.0, 0.0, np.radians(yaw_deg))

    recorder = Recorder(batch)
    recorder.sample()
    interval_s = batch.timing.control_interval_s
    for k in range(round(duration_s / interval_s)):
        driven = k * interval_s >= lead_in_s
        batch.advance(np.array([[along, across]]) if driven else None)
        recorder.sample()
        if batch.diverged[0]:
            print(f"diverged at {batch.time_s[0]:.2f} s; the recording ends there")
            break
    options = {"duration_s": duration_s, "lead_in_s": lead_in_s, "along": along, "across": across, "yaw_deg": yaw_deg}
    drawn = {"motion": source.model_dump(mode="json"), "outside_validity": deck.outside_validity, "seed": seed}
    recorder.write(out, {"helicopter": document_of(description), **drawn, **options})
    load = np.max(recorder.table()["probe_in_plane_max"].to_numpy())
    print(f"{out}: {len(recorder)} rows, {batch.time_s[0]:.1f} s, peak probe load {load / 1000.0:.2f} kN")
