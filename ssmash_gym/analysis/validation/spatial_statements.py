"""What section 3.2.1 says of manoeuvres 1A to 1D, made checkable."""

from __future__ import annotations

from typing import Final

import numpy as np

from ssmash_gym.analysis.validation.measures import curve, final, maxima, span, swing, value_at
from ssmash_gym.analysis.validation.statements import Runs, Statement

REST_Z_M: Final = -2.292  # Table 3.1, case 1
REST_PITCH_DEG: Final = 0.436
LEAN_DEG: Final = 2.023  # Table 3.1, case 7: roll relative to a deck that is rolled by 5 deg
NEAR_M: Final = 0.02  # from the length at full droop: "near full extension"
FITTED: Final = "damping and seal drag of the oleos"
RECORD: Final = "the sea, its heading and its seed"
STATIONS: Final = ("nose", "right", "left")


# --- measures ---------------------------------------------------------------------------------------------------


def clearance(runs: Runs) -> dict[str, float]:
    """Height of the lowest point of nose and main tires over the deck at the start [m]."""
    from ssmash_gym.dynamics.layout import State
    from ssmash_gym.vehicle.geometry import lowest_points, rotation

    history = runs.default
    vehicle = history.case.vehicle
    e, height = history.states[State.Q11 : State.Q14 + 1, 0], -float(history.states[State.Q10, 0])
    R_SH = rotation((float(e[0]), float(e[1]), float(e[2]), float(e[3])))
    down = [float(np.max(lowest_points(station, R_SH)[:, 2])) for station in vehicle.station_tuple]
    down = [d - float((R_SH @ np.array(vehicle.cg_offset_m))[2]) for d in down]
    return {"nose_m": height - down[0], "main_m": height - max(down[1:])}


def rest(runs: Runs) -> dict[str, float]:
    """Height and pitch at the end."""
    return {"z_m": final(runs.default, "z_N_m"), "pitch_deg": final(runs.default, "pitch_N_deg")}


def pitch_peaks(runs: Runs) -> dict[str, float]:
    """Local maxima of pitch within the figure."""
    return {"count": float(maxima(runs.default, "pitch_N_deg", 0.01, 0.0, 5.0).size)}


def largest_pitch(runs: Runs) -> dict[str, float]:
    """Largest magnitude of pitch."""
    return {"pitch_deg": max(map(abs, span(runs.default, "pitch_N_deg")))}


def sides(runs: Runs) -> dict[str, float]:
    """Largest difference between the two main oleos."""
    right, left = (curve(runs.default, f"{side}_extension_m") for side in ("right", "left"))
    return {"difference_mm": 1e3 * float(np.max(np.abs(right - left)))}


def lean(runs: Runs) -> dict[str, float]:
    """Roll at the end, at its greatest, and its change in the last second."""
    history = runs.default
    end = float(history.time_s[-1])
    return {
        "end_deg": final(history, "roll_N_deg"),
        "peak_deg": span(history, "roll_N_deg")[1],
        "last_second_deg": swing(history, "roll_N_deg", end - 1.0, end),
    }


def nose_down(runs: Runs) -> dict[str, float]:
    """When pitch is least, how much, and when the left main oleo is longest within half a second of that."""
    history = runs.default
    pitch, time = curve(history, "pitch_N_deg"), history.time_s
    at = float(time[np.argmin(pitch)])
    near = np.abs(time - at) <= 0.5
    left = float(time[near][np.argmax(curve(history, "left_extension_m")[near])])
    return {"time_s": at, "pitch_deg": float(np.min(pitch)), "left_s": left}


def roll_amplitude(runs: Runs) -> dict[str, float]:
    """Half the range of roll after the first quarter of a period, and the same of the deck."""
    return {
        "roll_deg": 0.5 * swing(runs.default, "roll_N_deg", 2.5),
        "deck_deg": 0.5 * swing(runs.default, "deck_roll_deg", 2.5),
    }


def lag(runs: Runs) -> dict[str, float]:
    """By how much the helicopter's roll extremes come after those of the deck [s]: the mean of three of them."""
    history = runs.default
    delays = []
    for low, high, sign in ((1.0, 4.5, 1.0), (6.0, 9.5, -1.0), (11.0, 14.5, 1.0)):
        inside = (history.time_s >= low) & (history.time_s <= high)
        times = [history.time_s[inside][np.argmax(sign * curve(history, name)[inside])]
                 for name in ("roll_N_deg", "deck_roll_deg")]  # fmt: skip
        delays.append(times[0] - times[1])
    return {"lag_s": float(np.mean(delays))}


def coupling(runs: Runs) -> dict[str, float]:
    """Range of pitch and of roll."""
    return {name: swing(runs.default, f"{name}_N_deg") for name in ("pitch", "roll")}


def severity(runs: Runs) -> dict[str, float]:
    """Extremes of roll to the inertial frame, and the deck's."""
    low, high = span(runs.default, "roll_N_deg")
    deck = span(runs.default, "deck_roll_deg")
    return {"low_deg": low, "high_deg": high, "deck_low_deg": deck[0], "deck_high_deg": deck[1]}


def yaw_range(runs: Runs) -> dict[str, float]:
    """Extremes of yaw to the inertial frame."""
    low, high = span(runs.default, "yaw_N_deg")
    return {"low_deg": low, "high_deg": high}


def six_motions(runs: Runs) -> dict[str, float]:
    """Range of each of the deck's six motions: m and deg."""
    nodes = runs.default.deck.nodes
    ranges = np.ptp(nodes[:, :6], axis=0) * np.array([1.0, 1.0, 1.0, *[180.0 / np.pi] * 3])
    return dict(zip(("surge", "sway", "heave", "roll", "pitch", "yaw"), ranges.tolist(), strict=True))


def events(low: np.ndarray[tuple[int], np.dtype[np.bool_]], time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> int:
    """Times that a condition comes true, those within a second of each other counted once."""
    times = time[low]
    return 0 if times.size == 0 else 1 + int(np.count_nonzero(np.diff(times) > 1.0))


def extensions(runs: Runs) -> dict[str, float]:
    """Events of a main oleo near full extension, and of a main wheel without load."""
    history = runs.default
    numbers = {"near": 0.0, "airborne": 0.0, "greatest_m": 0.0}
    for station, name in zip(history.case.vehicle.station_tuple[1:], STATIONS[1:], strict=True):
        length = curve(history, f"{name}_extension_m")
        numbers["near"] += events(length > station.droop_m[2] - NEAR_M, history.time_s)
        numbers["airborne"] += events(history.peak_min(f"{name}_vertical_load") <= 0.0, history.time_s)
        numbers["greatest_m"] = max(numbers["greatest_m"], float(np.max(length)))
    return numbers


def held(runs: Runs) -> dict[str, float]:
    """Greatest in-plane load of the probe, and whether it was lost."""
    history = runs.default
    return {"load_kN": 1e-3 * history.largest("probe_in_plane"), "lost": float(history["probe_lost"][-1])}


def motion_at_start(runs: Runs) -> dict[str, float]:
    """Height, pitch and roll at the start."""
    history = runs.default
    return {name.partition("_")[0]: value_at(history, name, 0.0) for name in ("pitch_deg", "roll_deg", "z_m")}


# --- statements -------------------------------------------------------------------------------------------------

CLEARANCE: Final = Statement(
    "Dropped from a c.g. height of 2.7 m, which gives about 0.2 m of tire ground clearance",
    "section 3.2.1, 1A",
    clearance,
    "main tires {main_m:.3f} m, nose tires {nose_m:.3f} m above the deck",
    lambda n: abs(n["main_m"] - 0.2) <= 0.01,
    taken_as="main tires 0.19 to 0.21 m",
    chosen="the height of the main tires below the c.g.",
    note="Nose tires cannot have 0.2 m: Table 3.1 prints their oleo's compression, which leaves 0.07 m.",
)
SETTLES: Final = Statement(
    "Settles to the reference state of Table 3.1, the steady state of a drop: z -2.292 m, pitch 0.436 deg",
    "section 3.1, Table 3.1",
    rest,
    "z {z_m:.4f} m, pitch {pitch_deg:.3f} deg at 5 s",
    lambda n: abs(n["z_m"] - REST_Z_M) <= 0.002 and abs(n["pitch_deg"] - REST_PITCH_DEG) <= 0.02,
    taken_as="within 2 mm and 0.02 deg",
    note="What is left at 5 s is the oleos' friction, which creeps to zero.",
)
FOUR_PEAKS: Final = Statement(
    "Pitch has a second, a third and a fourth oscillation peak",
    "section 3.2.1, figure 3.3",
    pitch_peaks,
    "{count:.0f} peaks",
    lambda n: n["count"] >= 4,
    taken_as="local maxima that stand out by 0.01 deg",
    chosen=FITTED,
)
SMALL_PITCH: Final = Statement(
    "The pitching motion is very small",
    "section 3.2.1, figure 3.3",
    largest_pitch,
    "at most {pitch_deg:.2f} deg",
    lambda n: n["pitch_deg"] < 1.0,
    taken_as="below 1 deg",
)
SYMMETRY: Final = Statement(
    "Right and left main oleo move alike",
    "figure 3.2 (implied by the symmetry of drop and helicopter)",
    sides,
    "differ by {difference_mm:.4f} mm at most",
    lambda n: n["difference_mm"] < 1e-3,
    basis="expected",
)
MORE_DYNAMIC: Final = Statement(
    "The rolled ship elicits a more significant dynamic response than 1A",
    "section 3.2.1, 1B",
    lean,
    "roll reaches {peak_deg:.2f} deg and ends at {end_deg:.2f} deg",
    lambda n: n["peak_deg"] - n["end_deg"] > 1.0,
    taken_as="roll, which 1A does not have at all, overshoots its end by more than 1 deg",
)
LEANS: Final = Statement(
    "Settles at a roll beyond the ship's 5 deg: Table 3.1, case 7, has 2.023 deg relative to the deck",
    "figure 3.6; Table 3.1, case 7",
    lean,
    "{end_deg:.2f} deg to the inertial frame; changes by {last_second_deg:.2f} deg in the last second",
    lambda n: abs(n["end_deg"] - 5.0 - LEAN_DEG) <= 0.2,
    taken_as="within 0.2 deg of 7.02 deg, the difference that the thesis finds between its two simulations",
    note="The oleos' friction holds some of the lean back.",
)
NOSE_DOWN: Final = Statement(
    "A nose-down pitch peak near 1.5 s, as the left main oleo is at its longest",
    "section 3.2.1, figures 3.5 and 3.7",
    nose_down,
    "{pitch_deg:.2f} deg at {time_s:.2f} s; left main oleo longest at {left_s:.2f} s",
    lambda n: abs(n["time_s"] - 1.5) <= 0.25 and abs(n["left_s"] - n["time_s"]) <= 0.25,
    taken_as="1.25 to 1.75 s, and the two within 0.25 s of each other",
    note="Only the time is stated. It is not among what the oleos were fitted to.",
)
SMALL_PITCH_1B: Final = Statement(
    "The pitch response is again small in absolute magnitude",
    "section 3.2.1, figure 3.7",
    largest_pitch,
    "at most {pitch_deg:.2f} deg",
    lambda n: n["pitch_deg"] < 1.0,
    taken_as="below 1 deg",
)
HIGHER: Final = (
    "The axis begins at -3 m, so that the thesis may have dropped its helicopter from higher than the 2.7 m of 1A; "
    "from 2.95 m all curves stay within their axes too."
)
FROM_REST: Final = Statement(
    "The initial state is the steady state of 1A",
    "section 3.2.1",
    motion_at_start,
    "z {z:.4f} m, pitch {pitch:.3f} deg, roll {roll:z.3f} deg",
    lambda n: abs(n["z"] - REST_Z_M) <= 0.002 and abs(n["pitch"] - REST_PITCH_DEG) <= 0.02 and abs(n["roll"]) < 1e-3,
    taken_as="the rest on a level deck, within 2 mm and 0.02 deg of Table 3.1",
)
AMPLITUDE: Final = Statement(
    "The amplitude of roll is slightly greater than the deck's 5 deg",
    "section 3.2.1, figure 3.8",
    roll_amplitude,
    "{roll_deg:.2f} deg, deck {deck_deg:.2f} deg",
    lambda n: n["deck_deg"] < n["roll_deg"] < 8.0,
    taken_as="greater than the deck's and within the printed axis of 8 deg",
    note=(
        "The word slightly is loose: Table 3.1, case 7, leans 2.02 deg further at a steady roll of 5 deg, so that 7.0 "
        "deg are reached without any inertia."
    ),
)
QUASI_STATIC: Final = Statement(
    "Inertia makes the difference to the deck's roll",
    "section 3.2.1, 1C",
    lambda runs: roll_amplitude(runs) | lag(runs),
    "{roll_deg:.2f} deg against 7.02 deg of the static lean; {lag_s:.2f} s behind the deck",
    lambda n: n["roll_deg"] > 5.0 + LEAN_DEG,
    taken_as="more than the static lean of Table 3.1, case 7",
    note=(
        "Does not hold: at a period of 10 s the lean is quasi-static, and the oleos' friction takes more off it than "
        "inertia adds."
    ),
)
SMALL_COUPLING: Final = Statement(
    "A small amount of coupling between roll and pitch",
    "section 3.2.1, figure 3.10",
    coupling,
    "pitch moves by {pitch:.2f} deg while roll moves by {roll:.1f} deg",
    lambda n: 0.02 < n["pitch"] < 0.05 * n["roll"],
    taken_as="more than 0.02 deg and less than 5 % of the roll",
)
SEVERE: Final = Statement(
    "The ship motion creates a significant dynamic response: peak roll of the helicopter",
    "section 3.2.1, figure 3.11",
    severity,
    "{low_deg:.1f} to {high_deg:.1f} deg; deck {deck_low_deg:.1f} to {deck_high_deg:.1f} deg",
    lambda n: min(-n["low_deg"], n["high_deg"]) > 15.0,
    taken_as="more than 15 deg to either side",
    chosen=RECORD,
)
AS_SEVERE: Final = Statement(
    "Roll as severe as the printed axis (-40 to 30 deg in steps of 10) suggests: beyond -30 and 20 deg",
    "figure 3.11",
    severity,
    "{low_deg:.1f} to {high_deg:.1f} deg",
    lambda n: n["low_deg"] < -30.0 and n["high_deg"] > 20.0,
    basis="axis",
    note="The sea is milder than the thesis' unpublished record. In a heavier one the ship would pass the roll for "
    "which its response is valid (6 deg RMS).",
)
YAW_RANGE: Final = Statement(
    "Yaw as large as the printed axis (-8 to 10 deg in steps of 2) suggests: beyond -6 and 8 deg",
    "figure 3.12",
    yaw_range,
    "{low_deg:.1f} to {high_deg:.1f} deg",
    lambda n: n["low_deg"] < -6.0 and n["high_deg"] > 8.0,
    basis="axis",
    note="A beam sea hardly yaws the ship, and the helicopter hardly slides on the deck; the thesis' record must have "
    "yawed the ship.",
)
SIX: Final = Statement(
    "The deck combines roll, pitch, yaw, surge, sway and heave",
    "section 3.2.1, 1D",
    six_motions,
    "ranges: surge {surge:.2f} m, sway {sway:.2f} m, heave {heave:.2f} m, roll {roll:.1f} deg, pitch {pitch:.1f} deg, "
    "yaw {yaw:.1f} deg",
    lambda n: min(n.values()) > 0.1,
    taken_as="each ranges over more than 0.1 m or 0.1 deg",
    chosen=RECORD,
)
FULL_EXTENSION: Final = Statement(
    "Several events in which one of the main oleos is at or near full extension",
    "section 3.2.1, figure 3.14",
    extensions,
    "{near:.0f} events; greatest length {greatest_m:.3f} m",
    lambda n: n["near"] >= 3,
    taken_as="three or more within 2 cm of full droop",
    chosen=RECORD,
)
LIFT_OFF: Final = Statement(
    "Tire lift-off from the deck is either occurring or imminent at these times",
    "section 3.2.1, figure 3.14",
    extensions,
    "a main wheel without load in {airborne:.0f} of {near:.0f} events",
    lambda n: n["near"] >= 1 and n["airborne"] >= 1,
    taken_as="at least one main wheel leaves the deck",
    chosen=RECORD,
)
PROBE_HOLDS: Final = Statement(
    "The securing probe is activated",
    "section 3.2.1, 1D",
    held,
    "in-plane load up to {load_kN:.1f} kN; lost: {lost:.0f}",
    lambda n: n["load_kN"] > 0.0 and n["lost"] == 0.0,
    taken_as="it carries load and is not lost",
)
