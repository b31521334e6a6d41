"""`ssmash simulate`: one helicopter on a moving deck, recorded."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import numpy as np
import tyro

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning

if TYPE_CHECKING:
    from ssmash_gym.ship.motion import Motion, MotionSource
    from ssmash_gym.simulation.batch import Batch

MARGIN_S: Final = 1.0  # by which the deck's table is longer than the run, where the motion lasts
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


def realised(source: MotionSource, seed: int) -> tuple[Motion, list[str]]:
    """The motion of a section, drawn with ``numpy.random.default_rng(seed)``, and the warnings that came with it.

    A record's own warning about its rates is held back: the verbs print the whole check.
    """
    from ssmash_gym.ship.recorded import RecordedMotion

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConfigurationWarning)
        motion = source.realise(np.random.default_rng(seed))
    remarks: dict[str, None] = {}  # each of them once, in their order
    for warning in caught:
        if not issubclass(warning.category, ConfigurationWarning):
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
        elif not isinstance(motion, RecordedMotion):
            remarks[str(warning.message)] = None
    return motion, list(remarks)


def simulate(
    helicopter: str = "generic_tricycle",
    motion: Path | None = None,
    out: Path = Path("recording.parquet"),
    duration_s: Annotated[float, tyro.conf.arg(aliases=("--duration",))] = 60.0,
    lead_in_s: float = 8.0,
    along: float = 0.0,
    across: float = 0.0,
    yaw_deg: float = 0.0,
    seed: int = 0,
) -> None:
    """Run one helicopter on a moving deck and record its telemetry in a Parquet file.

    The helicopter is settled on the deck with the claw at its probe; the motion is ramped in during the lead-in,
    while the claw is held; then the claw is driven at a constant command. No wind acts but one that the helicopter's
    own file has; wind that goes with a sea belongs to scenarios.

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

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
    """
    from ssmash_gym.ship.config import parse_motion
    from ssmash_gym.simulation.batch import Batch
    from ssmash_gym.simulation.recording import Recorder
    from ssmash_gym.vehicle import document_of, load_helicopter

    check_options(out, duration_s, lead_in_s, {"--along": along, "--across": across, "--yaw-deg": yaw_deg}, seed)
    source = parse_motion(motion_section(motion), folder=motion.parent if motion else None)
    description = load_helicopter(helicopter)
    batch = Batch(description)
    deck, remarks = realised(source, seed)
    covered_s = covered_time(deck, duration_s, batch)
    tell(source, deck, remarks, description.aerodynamics.wind_N_mps)
    batch.set_motion([deck.bake(covered_s, batch.timing.node_spacing_s, ramp_s=lead_in_s)])
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
    recorder.write(out, {"helicopter": document_of(description), **drawn, "warnings": remarks, **options})
    load = np.max(recorder.table()["probe_in_plane_max"].to_numpy())
    print(f"{out}: {len(recorder)} rows, {batch.time_s[0]:.1f} s, peak probe load {load / 1000.0:.2f} kN")


def check_options(out: Path, duration_s: float, lead_in_s: float, commands: dict[str, float], seed: int) -> None:
    """Refuse what cannot be run, before anything is read.

    Args:
        out: Recording to write.
        duration_s: Simulated time [s].
        lead_in_s: Part of it with the claw held [s].
        commands: Claw commands, -1 to 1, and the yaw angle, by their options.
        seed: Seed of the motion.

    Raises:
        ConfigurationError: One of them is refused.
    """
    if not out.parent.is_dir():
        raise ConfigurationError(f"--out {out} is refused: there is no folder {out.parent}.")
    if out.is_dir():
        raise ConfigurationError(f"--out {out} is refused: this is a folder, expected a file.")
    if not (math.isfinite(duration_s) and duration_s > 0.0):
        raise ConfigurationError(f"--duration-s {duration_s:g} is refused: it must be above 0 s.")
    if not 0.0 <= lead_in_s < duration_s:
        raise ConfigurationError(
            f"--lead-in-s {lead_in_s:g} is refused: it must be 0 s or more and below --duration-s, {duration_s:g} s."
        )
    for option, value in commands.items():
        if not (math.isfinite(value) and (option == "--yaw-deg" or abs(value) <= 1.0)):
            allowed = "an angle [deg]" if option == "--yaw-deg" else "a claw command within -1 to 1"
            raise ConfigurationError(f"{option} {value:g} is refused: it must be {allowed}.")
    if seed < 0:
        raise ConfigurationError(f"--seed {seed} is refused: it must not be negative.")


def covered_time(deck: Motion, duration_s: float, batch: Batch) -> float:
    """Length of the deck's table [s]: the run and a margin, or what a recorded motion has.

    Raises:
        ConfigurationError: The motion is shorter than the run.
    """
    whole = deck.tabled_s(batch.timing.node_spacing_s)
    if duration_s > whole + 1e-6:
        raise ConfigurationError(
            f"--duration-s {duration_s:g} is refused: the motion lasts {deck.duration_s:g} s, allowed is {whole:g} s."
        )
    return min(duration_s + MARGIN_S, whole)


def tell(source: Any, deck: Motion, remarks: list[str], wind_N_mps: tuple[float, ...]) -> None:
    """Print what the helicopter stands in: ship and sea or the kind of motion, the check of a record, and the wind."""
    from ssmash_gym.analysis.motion_report import flags, seaway_facts
    from ssmash_gym.ship.recorded import RecordedMotion
    from ssmash_gym.ship.seaway import Seaway, SeawayMotion

    if isinstance(source, Seaway) and isinstance(deck, SeawayMotion):
        for name, words in seaway_facts(source, deck):
            print(f"{name}: {words}")
    else:
        print(f"motion: {source.type}")
    if isinstance(deck, RecordedMotion):
        print(deck.report())
    speed = math.hypot(*wind_N_mps)
    told = f"{speed:.1f} m/s over the deck, from the helicopter's file" if speed > 0.0 else "none acts"
    print(f"wind: {told}")
    for flag in flags(deck, remarks):
        print(flag)
