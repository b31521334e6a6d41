"""Runs from recordings of `ssmash simulate` and of cases.

Recordings hold telemetry, not states. What the picture needs of the state follows from them: the body from its place
and angles, each station from its compression and steer angle, the deck from the motion in the recording's
configuration.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.console.scene import frame_from, sea_of, setup_from
from ssmash_gym.dynamics.layout import (
    STATE_ROWS,
    STATION_COORDINATES,
    STATION_NAMES,
    STATION_ROWS,
    STATIONS,
    Mode,
    Par,
    Sta,
    State,
    StationKind,
)
from ssmash_gym.envs.rendering.pose import airframe_for, euler_matrix, helicopter_pose
from ssmash_gym.envs.rendering.scene import Airframe, Limits, Scene, rotation
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import digest
from ssmash_gym.ship.motion import MotionTable
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.simulation.batch import Batch

Array = NDArray[np.float64]
LEAST_INTERVAL_S: Final = 0.05  # between frames of a recording: the page interpolates
MOST_FRAMES: Final = 2400
RECORDING: Final = "ssmash_gym.configuration"  # key of a recording's file
_NEEDED: Final = (
    "time_s", "helicopter", "position_x", "position_y", "position_z", "roll", "pitch", "yaw", "claw_x", "claw_y",
    "claw_vx", "claw_vy", "probe_x", "probe_y", "probe_fx", "probe_fy", "probe_fz", "probe_in_plane",
    "probe_in_plane_max", "probe_captured", "deck_roll", "deck_pitch", "deck_yaw",
    *(f"{name}_{part}" for name in STATION_NAMES for part in ("vertical_load", "compression", "steer")),
)  # fmt: skip


def metadata_of(path: Path) -> dict[str, str]:
    """What a Parquet file says of itself.

    Raises:
        ConfigurationError: There is no such file, or it is no Parquet file.
    """
    if not path.is_file():
        raise ConfigurationError(f"{path}: there is no such file.")
    try:
        return pl.read_parquet_metadata(path)
    except Exception as error:  # polars has no one error for a file that is damaged or none of its kind
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ConfigurationError(f"{path}: this is no recording: no Parquet file can be read ({reason}).") from None


@dataclass(frozen=True)
class _Source:
    """What a recording's configuration says: parameters, layout and deck.

    Attributes:
        batch: A batch of one with the recorded helicopter and claw.
        deck: Motion of the deck from `start_s` of the recording's clock on; None where it is not known any more.
        start_s: See there.
        motion: Section of the deck's motion.
        seed: Of what was drawn.
        driver: What drove the claw, in words.
        note: What is to be said of the picture.
    """

    batch: Batch
    deck: MotionTable | None
    start_s: float
    motion: dict[str, Any]
    seed: int
    driver: str
    note: str


def run_of_recording(path: str | Path) -> dict[str, Any]:
    """The run of a recording of `ssmash simulate`, of a case or of a manoeuvre.

    Args:
        path: Parquet file with all channels of the telemetry and the configuration.

    Raises:
        ConfigurationError: Something that the picture needs is missing; one sentence.
    """
    path = Path(path)
    raw = metadata_of(path)
    table = pl.read_parquet(path)
    missing = next((name for name in _NEEDED if name not in table.columns), None)
    if missing is not None:
        raise ConfigurationError(f"{path}: the recording has no channel {missing}, which the picture needs.")
    if table.height == 0:
        raise ConfigurationError(f"{path}: the recording is empty.")
    configuration = json.loads(raw[RECORDING])
    source = _source(path, configuration)
    first = int(table["helicopter"].to_numpy().min())
    table = table.filter(pl.col("helicopter") == first)
    rows = _rows(table["time_s"].to_numpy())
    scenes = _scenes(table, rows, source)
    frames, peak = [], 0.0
    probe = 1e-3 * table["probe_in_plane_max"].to_numpy()
    for k, (row, scene) in enumerate(zip(rows, scenes, strict=True)):
        since = rows[k - 1] + 1 if k else 0
        largest = float(np.max(probe[since : row + 1]))
        peak = max(peak, largest)
        frame = frame_from(scene, step=int(row), probe_peak_kN=largest, peak_kN=peak, held=0.0)
        frames.append({**frame, "to_go_m": None})
    interval = frames[1]["t"] - frames[0]["t"] if len(frames) > 1 else LEAST_INTERVAL_S
    height = -float(source.batch.parameters[Par.CLAW_Z, 0])
    setup = setup_from(scenes[0], claw_height_m=height, track=None)
    setup |= {"interval_s": interval, "horizon_s": frames[-1]["t"], "sea": sea_of(source.motion)}
    return {
        "name": path.stem,
        "driver": source.driver,
        "note": source.note,
        "seed": source.seed,
        "configuration": digest(configuration),
        "version": raw.get("ssmash_gym.version", ""),
        "interval_s": interval,
        "setup": setup,
        "frames": frames,
        "moments": [],
        "result": None,
    }


def _source(path: Path, configuration: dict[str, Any]) -> _Source:
    """What the configuration of a recording says.

    Raises:
        ConfigurationError: It names no helicopter, or this version of the package does not take what it names.
    """
    if "case" in configuration:
        return _of_case(path, configuration["case"])
    if "helicopter" in configuration and "motion" in configuration:
        return _of_simulate(path, configuration)
    raise ConfigurationError(
        f"{path}: the recording's configuration names no helicopter and motion (keys helicopter and motion, or case), "
        "without which there is nothing to draw."
    )


def _of_simulate(path: Path, told: dict[str, Any]) -> _Source:
    """Helicopter and deck of a recording of `ssmash simulate`."""
    from ssmash_gym.ship.config import parse_motion
    from ssmash_gym.simulate import covered_time, realised
    from ssmash_gym.vehicle import helicopter_from

    batch = Batch(helicopter_from(told["helicopter"], f"{path}: helicopter"))
    deck, note = None, ""
    try:
        motion, _ = realised(parse_motion(told["motion"]), int(told["seed"]))
        covered = covered_time(motion, float(told["duration_s"]), batch)
        deck = motion.bake(covered, batch.timing.node_spacing_s, ramp_s=float(told["lead_in_s"]))
    except (ConfigurationError, OSError) as missing:
        note = _angles_only(missing)
    driver = f"constant command {told.get('along', 0.0):g} along, {told.get('across', 0.0):g} across"
    return _Source(batch, deck, 0.0, dict(told["motion"]), int(told["seed"]), driver, note)


def _of_case(path: Path, document: dict[str, Any]) -> _Source:
    """Helicopter and deck of a recorded case."""
    from ssmash_gym.cases.description import case_from
    from ssmash_gym.cases.run import prepared

    case = case_from(document, f"{path}: case")
    deck, note = None, ""
    try:
        batch = prepared(case)
        deck = MotionTable(batch.timing.node_spacing_s, batch.nodes[0])
    except (ConfigurationError, OSError) as missing:
        batch, note = Batch(case.vehicle), _angles_only(missing)
    title = case.title or case.name
    note = " ".join(words for words in (f"{title.rstrip('.')}.", note) if words)
    return _Source(batch, deck, case.solution.start_s, case.deck.model_dump(mode="json"), case.seed,
                   "the case's claw", note)  # fmt: skip


def _angles_only(missing: Exception) -> str:
    return f"The deck turns but does not heave in the picture: {str(missing).rstrip('.')}."


def _rows(time_s: Array) -> list[int]:
    """Rows to be drawn: at least `LEAST_INTERVAL_S` apart, at most `MOST_FRAMES`, the last one among them."""
    if time_s.size < 2:
        return list(range(time_s.size))
    interval = float(np.median(np.diff(time_s)))
    stride = max(1, round(LEAST_INTERVAL_S / max(interval, 1e-9)), -(-time_s.size // MOST_FRAMES))
    rows = list(range(0, time_s.size, stride))
    return rows if rows[-1] == time_s.size - 1 else [*rows, time_s.size - 1]


def _scenes(table: pl.DataFrame, rows: list[int], source: _Source) -> list[Scene]:
    """Scenes of the listed rows."""
    values = {name: table[name].to_numpy().astype(np.float64) for name in _NEEDED}
    parameters, batch = source.batch.parameters[:, 0], source.batch
    tires = [int(batch.mode[Mode.TIRES + i]) for i in range(STATIONS)]
    speed = KNOT * float(source.motion.get("speed_kn") or 0.0)
    scenes: list[Scene] = []
    airframe: Airframe | None = None
    for row in rows:
        at = {name: float(column[row]) for name, column in values.items()}
        loads = [at[f"{name}_vertical_load"] for name in STATION_NAMES]
        pose = helicopter_pose(state_of(at, batch), parameters, tires, loads)
        pose["r_SB_S"] = np.array([at["probe_x"], at["probe_y"], parameters[Par.CLAW_Z]])
        airframe = airframe or airframe_for(pose)
        r_NS_N, R_NS = _deck(at, source)
        scenes.append(
            Scene(
                time_s=at["time_s"],
                r_SC_S=np.array([at["claw_x"], at["claw_y"], parameters[Par.CLAW_Z]]),
                probe_force_S=pose["R_SH"] @ np.array([at["probe_fx"], at["probe_fy"], at["probe_fz"]]),
                captured=at["probe_captured"] > 0.5,
                r_NS_N=r_NS_N,
                R_NS=R_NS,
                claw_velocity_S=np.array([at["claw_vx"], at["claw_vy"]]),
                limits=Limits(),
                airframe=airframe,
                ship_speed_m_s=speed,
                **pose,
            )
        )
    return scenes


def _deck(at: dict[str, float], source: _Source) -> tuple[Array, Array]:
    """Place and attitude of the deck: by its motion where that is known, else by the recorded angles alone."""
    if source.deck is None:
        return np.zeros(3), rotation(at["deck_roll"], at["deck_pitch"], at["deck_yaw"])
    last = (source.deck.nodes.shape[0] - 1) * source.deck.spacing_s
    pose = source.deck.pose(min(max(at["time_s"] - source.start_s, 0.0), last))
    return pose.r_NS_N, pose.R_NS


# --- the state from telemetry ------------------------------------------------------------------------------


def state_of(at: dict[str, float], batch: Batch) -> Array:
    """The part of a state that the picture needs, from channels of the telemetry, rows of `layout.State`.

    Args:
        at: Channels at one instant, by name.
        batch: A batch of one with the helicopter.
    """
    state = np.zeros(STATE_ROWS)
    state[State.Q8 : State.Q10 + 1] = at["position_x"], at["position_y"], at["position_z"]
    half = 0.5 * np.array([at["yaw"], at["pitch"], at["roll"]])
    (cy, cp, cr), (sy, sp, sr) = np.cos(half), np.sin(half)
    body = multiplied(multiplied((cy, 0.0, 0.0, sy), (cp, 0.0, sp, 0.0)), (cr, sr, 0.0, 0.0))
    state[State.Q11 : State.Q14 + 1] = body
    for i, name in enumerate(STATION_NAMES):
        row, base = State.Q15 + STATION_COORDINATES * i, Par.STATION + i * STATION_ROWS
        at_droop = np.array(batch.helicopters[0].station_tuple[i].orientation, dtype=np.float64)
        compression, steer = at[f"{name}_compression"], at[f"{name}_steer"]
        station = batch.parameters[base : base + STATION_ROWS, 0]
        swing = 0.0
        state[row] = station[Sta.DROOP + 2]
        if int(batch.mode[Mode.STATION_KIND + i]) == StationKind.PRISMATIC:
            state[row] -= compression
        else:
            swing = swing_angle(station, at_droop, compression)
        turned = multiplied(_without_twist(at_droop), (np.cos(0.5 * swing), 0.0, np.sin(0.5 * swing), 0.0))
        state[row + 1 : row + 5] = multiplied(turned, (np.cos(0.5 * steer), 0.0, 0.0, np.sin(0.5 * steer)))
    return state


def swing_angle(station: Array, at_droop: Array, compression: float) -> float:
    """Angle of a swing arm about its y axis, from full droop, at which its strut is so much shorter [rad].

    Args:
        station: Parameters of the station, rows of `layout.Sta`.
        at_droop: Euler parameters of the arm at full droop, (4,).
        compression: Of the strut from full droop [m].
    """
    wanted = station[Sta.LENGTH] - compression
    offset = station[Sta.MOUNT : Sta.MOUNT + 3] - station[Sta.P1 : Sta.P1 + 3]

    def beyond(angle: float) -> float:
        arm = multiplied(at_droop / np.linalg.norm(at_droop), (np.cos(0.5 * angle), 0.0, np.sin(0.5 * angle), 0.0))
        return float(np.linalg.norm(offset + euler_matrix(arm) @ station[Sta.P2 : Sta.P2 + 3]) - wanted)

    angle, step = 0.0, 1e-6
    for _ in range(12):
        slope = (beyond(angle + step) - beyond(angle - step)) / (2.0 * step)
        if abs(slope) < 1e-9:
            break
        change = float(np.clip(beyond(angle) / slope, -0.3, 0.3))
        angle -= change
        if abs(change) < 1e-10:
            break
    return angle


def multiplied(a: Any, b: Any) -> Array:
    """Product of two quaternions w, x, y, z, (4,)."""
    aw, ax, ay, az = (float(v) for v in a)
    bw, bx, by, bz = (float(v) for v in b)
    return np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def _without_twist(q: Array) -> Array:
    """A rotation without its own turn about z: the steer angle in the telemetry is the whole turn."""
    unit = q / np.linalg.norm(q)
    size = float(np.hypot(unit[0], unit[3]))
    if size < 1e-9:
        return np.asarray(unit)
    return multiplied(unit, (unit[0] / size, 0.0, 0.0, -unit[3] / size))
