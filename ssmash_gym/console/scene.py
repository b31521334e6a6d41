"""What the page draws, in plain numbers: a setup (what stands still) and a frame for each instant.

Positions in metres, deck frame S (x towards the hangar, y starboard, z down), unless a name says otherwise; loads in
kN, angles in degrees. A quaternion is ``w, x, y, z`` and takes the first-named frame's components to the second's:
``ship`` is the deck S in the inertial frame N, ``body`` the helicopter H in S. Shapes are those of
`ssmash_gym.envs.rendering`; the page has none of its own of the helicopter.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import STATION_NAMES, Par
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.pictures import scene_of
from ssmash_gym.envs.rendering import scenery
from ssmash_gym.envs.rendering.geometry import Mesh, airframe_mesh, claw_mesh
from ssmash_gym.envs.rendering.scene import History, Limits, Scene, Track

Array = NDArray[np.float64]
PLACES: Final = 4  # of a position [m], an angle [deg] or a load [kN]: below what can be seen
TURNS: Final = 5  # decimals of a quaternion
_NO_HISTORY: Final = History()


def setup_of(core: TraverseBatch, k: int = 0) -> dict[str, Any]:
    """Everything of column k's episode that does not move: shapes, track, limits, claw, sea.

    Args:
        core: A batch whose column has been reset.
        k: The column.

    Returns:
        JSON-able; the keys are those of `setup_from` and those of the task.
    """
    scene = scene_of(core, k, _NO_HISTORY)
    parameters, task, draw = core.batch.parameters[:, k], core.task, core.draws[k]
    setup = setup_from(scene, claw_height_m=-float(parameters[Par.CLAW_Z]), track=scene.track)
    setup["claw"] = {
        "speed_along_m_s": float(parameters[Par.CLAW_SPEED_X]),
        "speed_across_m_s": float(parameters[Par.CLAW_SPEED_Y]),
        "y_travel_m": float(parameters[Par.CLAW_Y_MAX]),
    }
    setup["interval_s"] = core.control_interval_s
    setup["horizon_s"] = task.horizon_s
    setup["grace_s"] = task.grace_s
    setup["goal_hold_s"] = task.goal.hold_s
    setup["sea"] = None if draw is None else sea_of(draw.motion)
    return setup


def frame_of(core: TraverseBatch, k: int = 0) -> dict[str, Any]:
    """Column k as it stands, after a reset or a step; the keys are those of `frame_from`."""
    book = core.book
    steps = int(book.steps[k])
    telemetry = core.telemetry
    probe = telemetry.peak_max("probe_in_plane") if steps else telemetry["probe_in_plane"]
    return frame_from(
        scene_of(core, k, _NO_HISTORY),
        step=steps,
        probe_peak_kN=1e-3 * float(probe[k]),
        peak_kN=1e-3 * float(book.peak_probe_N[k]),
        held=min(1.0, float(book.held[k]) / (core.task.hold_steps + 1)),
    )


def sea_of(motion: Mapping[str, Any]) -> dict[str, float] | None:
    """Wave height, direction and speed of a motion section, or None where it has no sea."""
    if motion.get("type") != "seaway" or motion.get("hs_m") is None:
        return None
    return {name: float(motion.get(name) or 0.0) for name in ("hs_m", "heading_deg", "speed_kn")}


def setup_from(scene: Scene, *, claw_height_m: float, track: Track | None) -> dict[str, Any]:
    """The setup of any scene; what a task alone knows is null.

    Args:
        scene: The helicopter at the start.
        claw_height_m: Of the claw plane over the deck.
        track: Markings, corridor and goal; None draws a deck without them.

    Returns:
        ``meshes`` (`packed`), ``airframe``, ``tires``, ``stations``, ``track``, ``limits``, ``ship`` (measures of the
        drawn ship), ``claw``, ``interval_s``, ``horizon_s``, ``grace_s``, ``goal_hold_s``, ``ship_speed_m_s``, ``sea``.
    """
    a, wheels = scene.airframe, scene.wheels
    meshes = [packed("body", "H", airframe_mesh(a)), packed("claw", "C", claw_mesh(claw_height_m))]
    if track is not None:
        drawn = scenery.scenery(track)
        meshes.append(packed("door", "S", drawn.solids))
        meshes.append(_markings(drawn))
    return {
        "meshes": meshes,
        "airframe": {
            "nose_x": a.nose_x, "tail_x": a.tail_x, "half_width": a.half_width, "floor_z": a.floor_z,
            "roof_z": a.roof_z, "hub_x": a.hub_x, "blade_length": a.blade_length,
        },
        "tires": [
            {"station": int(station), "diameter_m": round(float(d), PLACES), "width_m": round(float(w), PLACES)}
            for station, d, w in zip(wheels.station, wheels.diameter_m, wheels.width_m, strict=True)
        ],
        "stations": list(STATION_NAMES),
        "track": None if track is None else _track(track),
        "limits": _limits(scene.limits),
        "ship": _ship(scene.track),
        "claw": None, "interval_s": None, "horizon_s": None, "grace_s": 0.0, "goal_hold_s": None,
        "ship_speed_m_s": scene.ship_speed_m_s, "sea": None,
    }  # fmt: skip


def frame_from(scene: Scene, *, step: int, probe_peak_kN: float, peak_kN: float, held: float) -> dict[str, Any]:
    """One instant, rounded.

    Args:
        scene: Its numbers.
        step: Control steps since the start.
        probe_peak_kN: Largest in-plane probe load since the frame before.
        peak_kN: The same of the episode so far, as the task counts it.
        held: Share of the goal's holding time, 0 to 1.

    Returns:
        ``t``, ``k``, ``ship`` and ``body`` (x, y, z, quaternion), ``claw`` (x, y, z, vx, vy), ``probe`` (both ends),
        ``force`` (in-plane probe force on the helicopter), ``captured``, ``struts`` (mount and carriage of each
        station), ``tires`` (centre, two components of the axle... see `_tires`), ``command``, loads, angles, distances.
    """
    wheels, deg = scene.wheels, 180.0 / np.pi
    roll, pitch, yaw = scene.angles_SH
    deck_roll, deck_pitch, _ = scene.angles_NS
    return {
        "t": round(scene.time_s, PLACES),
        "k": step,
        "ship": _pose(scene.r_NS_N, scene.R_NS),
        "body": _pose(scene.r_SH_S, scene.R_SH),
        "claw": _rounded(np.concatenate([scene.r_SC_S, scene.claw_velocity_S])),
        "probe": _rounded(np.concatenate([scene.r_SA_S, scene.r_SB_S])),
        "force": _rounded(1e-3 * scene.in_plane_force_S, 2),
        "captured": bool(scene.captured),
        "struts": _rounded(np.concatenate([wheels.r_SO_S, wheels.r_SW_S], axis=1)),
        "tires": _tires(scene),
        "command": _rounded(scene.claw_command),
        "probe_kN": round(1e-3 * scene.probe_in_plane_N, 3),
        "probe_peak_kN": round(probe_peak_kN, 3),
        "axial_kN": round(1e-3 * scene.probe_axial_N, 2),
        "load_kN": _rounded(1e-3 * wheels.station_load_N, 2),
        "yaw_deg": round(yaw * deg, 3),
        "roll_deg": round(roll * deg, 3),
        "pitch_deg": round(pitch * deg, 3),
        "deck_roll_deg": round(deck_roll * deg, 3),
        "deck_pitch_deg": round(deck_pitch * deg, 3),
        "lateral_m": round(scene.lateral, PLACES),
        "to_go_m": round(scene.to_go_m, PLACES),
        "held": round(held, 3),
        "peak_kN": round(peak_kN, 3),
    }


def packed(name: str, frame: str, mesh: Mesh) -> dict[str, Any]:
    """A mesh as flat lists.

    Args:
        name: What it is.
        frame: Axes of its vertices: H, S, or C (S axes from the deck point under the claw's centre).
        mesh: Faces of four corners; a triangle repeats its last one.

    Returns:
        ``name``, ``frame``; ``positions`` (3 for each vertex) [m]; ``indices`` (3 for each triangle, counter-clockwise
        from outside in right-handed axes); ``colours`` (0-255, 3 for each triangle); ``two_sided`` (0 or 1 for each
        triangle).
    """
    faces = mesh.faces
    halves = np.stack([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]], axis=1)
    real = np.stack([np.ones(len(faces), bool), faces[:, 2] != faces[:, 3]], axis=1)
    colours = np.repeat(mesh.colour[:, None, :], 2, axis=1)[real]
    return {
        "name": name,
        "frame": frame,
        "positions": np.round(mesh.vertices, 3).ravel().tolist(),
        "indices": halves[real].ravel().tolist(),
        "colours": np.round(colours).astype(int).ravel().tolist(),
        "two_sided": np.repeat(mesh.two_sided[:, None], 2, axis=1)[real].astype(int).tolist(),
    }


def quaternion(R_AB: Array) -> Array:
    """The unit quaternion w, x, y, z (w not negative) of a rotation matrix that takes B to A components, (4,)."""
    trace = R_AB[0, 0] + R_AB[1, 1] + R_AB[2, 2]
    squares = 0.25 * np.array([1.0 + trace, *(1.0 - trace + 2.0 * np.diag(R_AB))])
    i = int(np.argmax(squares))
    x, y, z = R_AB[2, 1] - R_AB[1, 2], R_AB[0, 2] - R_AB[2, 0], R_AB[1, 0] - R_AB[0, 1]
    xy, xz, yz = R_AB[0, 1] + R_AB[1, 0], R_AB[0, 2] + R_AB[2, 0], R_AB[1, 2] + R_AB[2, 1]
    size = 4.0 * np.sqrt(squares[i])
    products = np.array([[0.0, x, y, z], [x, 0.0, xy, xz], [y, xy, 0.0, yz], [z, xz, yz, 0.0]])[i] / size
    products[i] = 0.25 * size
    return np.asarray(products if products[0] >= 0.0 else -products)


def _pose(r: Array, R: Array) -> list[float]:
    return [*_rounded(r), *_rounded(quaternion(R), TURNS)]


def _rounded(values: Array, places: int = PLACES) -> list[Any]:
    return list((np.round(values, places) + 0.0).tolist())  # + 0.0: no minus before a zero


def _tires(scene: Scene) -> list[list[float]]:
    """Of each tire: centre x, y, z [m], unit vector along the axle x, y, z, vertical load [kN]."""
    wheels = scene.wheels
    rows = np.concatenate([np.round(wheels.r_ST_S, PLACES), np.round(wheels.axle_S, 3)], axis=1) + 0.0
    return [[*row, round(1e-3 * float(load), 2)] for row, load in zip(rows.tolist(), wheels.load_N, strict=True)]


def _track(track: Track) -> dict[str, float]:
    return {
        "start_x_m": track.start_x_m,
        "goal_x_m": track.goal_x_m,
        "goal_tolerance_m": track.goal_tolerance_m,
        "lateral_tolerance_m": track.lateral_tolerance_m,
        "yaw_tolerance_deg": round(float(np.rad2deg(track.yaw_tolerance_rad)), 6),
        "corridor_m": track.corridor_m,
        "door_corridor_m": track.door_corridor_m,
        "door_claw_x_m": track.door_claw_x_m,
        "hangar_door_x_m": track.hangar_door_x_m,
    }


def _limits(limits: Limits) -> dict[str, float]:
    return {
        "probe_soft_kN": 1e-3 * limits.probe_soft_N,
        "probe_kN": 1e-3 * limits.probe_cost_N,
        "probe_ultimate_kN": 1e-3 * limits.probe_ultimate_N,
        "station_kN": 1e-3 * limits.station_N,
        "lift_off_kN": 1e-3 * limits.lift_off_N,
        "roll_deg": round(float(np.rad2deg(limits.roll_rad)), 6),
    }


def _ship(track: Track) -> dict[str, float]:
    """Measures of the drawn ship [m]; for the eye only, as in `ssmash_gym.envs.rendering.scenery`."""
    return {
        "half_beam": scenery.HALF_BEAM,
        "aft_x": scenery.AFT_X,
        "above_sea": scenery.DECK_ABOVE_SEA,
        "door_x": track.hangar_door_x_m,
        "door_half_width": track.door_corridor_m + scenery.DOOR_MARGIN,
        "door_height": scenery.DOOR_HEIGHT,
        "hangar_length": scenery.HANGAR_LENGTH,
        "hangar_half_width": scenery.HANGAR_HALF_WIDTH,
        "hangar_height": scenery.HANGAR_HEIGHT,
    }


def _markings(drawn: scenery.Scenery) -> dict[str, Any]:
    """Paint on the deck as a flat mesh, in the order of painting."""
    count = len(drawn.markings)
    corners = 4 * np.arange(count)[:, None]
    return {
        "name": "markings",
        "frame": "S",
        "positions": np.round(drawn.markings, 3).ravel().tolist(),
        "indices": (corners + np.array([0, 2, 1, 0, 3, 2])).ravel().tolist(),
        "colours": np.repeat(np.array(drawn.marking_colours, int), 2, axis=0).ravel().tolist(),
        "two_sided": [1] * (2 * count),
    }
