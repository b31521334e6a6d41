"""`ssmash ship-motion`: the deck of a ship in a seaway as a record, its figures and its picture."""

from __future__ import annotations

import inspect
import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import tyro
from rich.console import Console

from ssmash_gym import __version__
from ssmash_gym.analysis.motion_picture import NEEDS_MATPLOTLIB, draw_picture
from ssmash_gym.analysis.motion_record import Record, long_run_spectra, sample_record, write_spectra
from ssmash_gym.analysis.motion_report import caption, ship_label, show, subtitle, title
from ssmash_gym.analysis.motion_request import (
    COMPONENTS,
    DEFAULT_DURATION_S,
    Files,
    check_files,
    checked_gusts,
    checked_length,
    checked_step,
    companion_wind,
    repetition,
    wind_words,
)
from ssmash_gym.errors import ConfigurationError, ConfigurationWarning, require
from ssmash_gym.files import whole_files
from ssmash_gym.progress import progress_bar
from ssmash_gym.ship.config import parse_motion
from ssmash_gym.ship.motion import Motion
from ssmash_gym.ship.sea import SEA_STATES, SpectrumName, SpreadingName
from ssmash_gym.ship.seaway import Seaway, SeawayMotion
from ssmash_gym.ship.shipmo import Rates, write_shipmo
from ssmash_gym.ship.wind import write_wind
from ssmash_gym.simulate import motion_section, realised

DEFAULT_SEA_STATE: Final = 5
LONG_WORK_ROWS: Final = 20_000  # from here on a bar shows the progress
SPECTRUM_GRID: Final = np.linspace(0.0, 2.0, 501)  # [rad/s]


def ship_motion(
    ship: str = "frigate",
    sea_state: int | None = None,
    hs_m: float | None = None,
    tp_s: float | None = None,
    heading: float = 90.0,
    speed_kn: float = 10.0,
    spectrum: SpectrumName = "bretschneider",
    spreading: SpreadingName = "cos2",
    components: int | None = None,
    config: Path | None = None,
    duration: Annotated[float | None, tyro.conf.arg(aliases=("--duration-s",))] = None,
    dt: float | None = None,
    rates: Rates = "body",
    seed: int = 0,
    wind: bool = False,
    gusts: float | None = None,
    out: Path = Path("motion.csv"),
    plot: Path | None = None,
    spectra: Path | None = None,
) -> None:
    """Write a record of deck motion in a seaway, and print what it holds beside the long run.

    The record has the sixteen columns of SHIPMO.INP; a name that ends in .csv gets commas, column names and a head of
    comment lines (version, configuration, seed). Files are written whole or not at all.

    Args:
        ship: Name in the catalogue, or a YAML file.
        sea_state: 2 to 6, the STANAG 4194 pair of height and period; 5 where no sea is given.
        hs_m: Significant wave height [m], in place of a sea state.
        tp_s: Peak period [s] to that height; without it the one that goes with the height.
        heading: Direction the waves travel relative to the ship's heading [deg]: 0 following, 90 towards starboard,
            180 head.
        speed_kn: Ship's speed [kn].
        spectrum: Shape of the sea's spectrum.
        spreading: Directions of the waves: cos2 about the heading, or long_crested, all in one.
        components: Waves in the sea; 96 unless given, 256 for records of more than ten minutes.
        config: YAML file with a motion section, in place of the options above. For a record (type: file) the check of
            its rates is printed.
        duration: Length of the record [s]; 600 unless given, or the whole of a recorded motion.
        dt: Time between rows [s]; 0.05 unless given, or that of a recorded motion.
        rates: What columns 8-10 and 14-16 hold: body (angular velocity in ship axes) or euler (rates of the angles).
        seed: Seed of the sea.
        wind: Also write the wind over the deck beside the record (motion.wind.csv for motion.csv): the true
            wind that goes with the wave height, along the waves, with gusts, minus the ship's speed.
        gusts: RMS of the gusts over the mean true wind; 0.1 unless given (assumed).
        out: The record.
        plot: PNG with time histories and spectra (extra ``plot``).
        spectra: CSV with the long-run spectra over encounter frequency.

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    sea = {
        "ship": ship, "sea_state": sea_state, "hs_m": hs_m, "tp_s": tp_s, "heading_deg": heading,
        "speed_kn": speed_kn, "spectrum": spectrum, "spreading": spreading, "components": components,
    }  # fmt: skip
    if plot is not None:
        require("matplotlib", NEEDS_MATPLOTLIB)
    if seed < 0:
        raise ConfigurationError(f"--seed {seed} is refused: it must not be negative.")
    intensity = checked_gusts(wind, gusts)
    source = chosen_source(sea, config, duration)
    files = Files(out, out.with_name(f"{out.stem}.wind.csv") if wind else None, plot, spectra)
    check_files(files, source, config)
    motion, remarks = realised(source, seed)
    step_s = checked_step(motion, dt)
    length_s = checked_length(motion, duration, step_s)
    remarks += repetition(source, length_s)
    over_deck = companion_wind(source, intensity, seed) if wind else None
    comments = about(source, motion, seed, remarks) + ([wind_words(source, intensity)] if wind else [])
    console = Console()
    with (
        whole_files(files.named.values()) as staged,
        progress_bar("ship motion", shown=length_s / step_s >= LONG_WORK_ROWS) as advance,
    ):
        record = sample_record(motion, length_s, step_s, lambda share: advance(0.4 * share))
        write_shipmo(
            staged[out], motion, step_s, length_s, rates=rates,
            comments=[*comments, *record_words(source, rates)] if out.suffix.lower() == ".csv" else (),
            progress=lambda share: advance(0.4 + 0.6 * share),
        )  # fmt: skip
        if files.wind is not None and over_deck is not None:
            write_wind(staged[files.wind], *over_deck, step_s, length_s, comments=comments)
        write_spectra_and_picture(files, staged, source, motion, record, comments, remarks, seed)
    show(console, source, motion, record, remarks)
    if wind:
        console.print(wind_words(source, intensity), soft_wrap=True, highlight=False)
    names = ", ".join(map(str, files.named.values()))
    console.print(
        f"{len(record.time_s)} rows, {record.time_s[-1]:g} s at {step_s:g} s, seed {seed}: {names}", soft_wrap=True
    )


DEFAULT_SEA: Final = {
    "heading_deg" if name == "heading" else name: option.default
    for name, option in inspect.signature(ship_motion).parameters.items()
}


# --- what is asked for ----------------------------------------------------------------------------------------------


def chosen_source(sea: Mapping[str, Any], config: Path | None, duration_s: float | None) -> Any:
    """The motion source of the options or of the file.

    Args:
        sea: Values of the options, by their keys in a seaway section; None where there is none.
        config: File with a motion section.
        duration_s: Length asked for [s], which decides how many waves are drawn.

    Raises:
        ConfigurationError: Options beside a file, or a value that is refused.
    """
    if config is not None:
        if given := [_option(key) for key, value in sea.items() if value != DEFAULT_SEA.get(key)]:
            raise ConfigurationError(
                f"--config {config} describes the motion: {', '.join(given)} is not allowed beside it."
            )
        return parse_motion(motion_section(config), folder=config.parent, where=f"{config}: motion")
    section = {key: value for key, value in sea.items() if value is not None}
    state, height, period = section.get("sea_state"), section.get("hs_m"), section.get("tp_s")
    if state is not None and height is not None:
        raise ConfigurationError(f"--sea-state {state} and --hs-m {height:g} are both given: say one of the two.")
    if period is not None and height is None:
        raise ConfigurationError(f"--tp-s {period:g} is refused: it goes with --hs-m, a sea state has its own period.")
    if state is not None and state not in SEA_STATES:
        why = "the STANAG 4194 pairs that could be read stop at 6; " if state == 7 else ""
        raise ConfigurationError(
            f"--sea-state {state} is refused: there are {', '.join(map(str, SEA_STATES))} (STANAG 4194); {why}other "
            "seas by --hs-m and --tp-s."
        )
    if height is None:
        section.setdefault("sea_state", DEFAULT_SEA_STATE)
    long = duration_s is not None and duration_s > DEFAULT_DURATION_S
    section.setdefault("components", COMPONENTS[long])
    return parse_motion({"type": "seaway", **section}, where="sea")


def _option(key: str) -> str:
    """A key of a seaway section as the option of the command line."""
    return "--" + ("heading" if key == "heading_deg" else key).replace("_", "-")


# --- writing --------------------------------------------------------------------------------------------------------


def about(source: Any, motion: Motion, seed: int, remarks: Sequence[str]) -> list[str]:
    """What heads every file: version, configuration, seed, and what is to be known of its validity."""
    lines = [
        f"ssmash_gym {__version__}, ssmash ship-motion",
        f"motion: {json.dumps(source.model_dump(mode='json', exclude_none=True))}",
        f"seed: {seed}",
    ]
    if isinstance(source, Seaway):
        lines.insert(1, f"ship: {ship_label(source)}")
    if motion.outside_validity is not None:
        lines.append(f"outside validity: {motion.outside_validity}")
    return lines + [f"warning: {text}" for text in remarks]


def record_words(source: Any, rates: Rates) -> list[str]:
    """What heads the record alone: what its columns hold."""
    lines = [
        f"rates: {rates} (columns 8-10 and 14-16)",
        "axes: x forward, y to starboard, z down; roll starboard down, pitch bow up, yaw bow to starboard positive",
    ]
    if isinstance(source, Seaway):
        lines.append("velocities and accelerations: of the deck point, over the mean frame that moves with the ship")
    return lines


def write_spectra_and_picture(
    files: Files,
    staged: Mapping[Path, Path],
    source: Any,
    motion: Motion,
    record: Record,
    comments: Sequence[str],
    remarks: Sequence[str],
    seed: int,
) -> None:
    """Write the files that show the spectra, where they are asked for.

    Args:
        files: The files.
        staged: Where each is written to.
        source: The motion source.
        motion: Its motion.
        record: The record of it.
        comments: What heads the files, or goes into them unseen.
        remarks: Warnings that the picture shows.
        seed: Seed of the sea.
    """
    if files.plot is None and files.spectra is None:
        return
    long_run = None
    if isinstance(source, Seaway) and isinstance(motion, SeawayMotion):
        with warnings.catch_warnings():  # what there is to be warned of was said when the sea was drawn
            warnings.simplefilter("ignore", ConfigurationWarning)
            long_run = long_run_spectra(source, motion, SPECTRUM_GRID)
    if files.spectra is not None and long_run is not None:
        write_spectra(staged[files.spectra], long_run, comments)
    if files.plot is not None:
        words = (title(source), subtitle(source, motion, remarks), caption(record, long_run, seed))
        draw_picture(staged[files.plot], record, long_run, known_rms(motion), words, metadata(comments))


def known_rms(motion: Motion) -> dict[str, float]:
    """Long-run RMS of a seaway's deck and of its sea, in the units of the record; empty for other motions."""
    if not isinstance(motion, SeawayMotion):
        return {}
    return {**asdict(motion.deck_rms()), "elevation": motion.elevation_rms_m}


def metadata(comments: Sequence[str]) -> dict[str, str]:
    """Text that goes into the picture's file."""
    return {"Title": "Ship motion", "Software": comments[0], "Description": "\n".join(comments)}
