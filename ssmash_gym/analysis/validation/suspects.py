"""What the thesis suspects behind its misfits in 2A to 2C, each as a variant of the manoeuvre (section 3.2.2).

The thesis compares its simulation with trials and names causes that it could not model. Here each of them is an option
of a case, so that one can see what it would do. None of them is identified: sizes are assumed, and said with each.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ssmash_gym.analysis.validation import planar_measures as measured
from ssmash_gym.analysis.validation.manoeuvres import Variant
from ssmash_gym.analysis.validation.measures import curve
from ssmash_gym.analysis.validation.statements import Runs, Statement

PLAY: Final = "steer_play"
QUIET: Final = "quiet_claw"
TURN_2B: Final = "probe_turn"
PATCH: Final = "patch"
TURN_2C: Final = "probe_turn"

# --- 2A: free play of the tail wheel's lock ---------------------------------------------------------------------


def yaw_gained(runs: Runs) -> dict[str, float]:
    """Yaw with play less that without: greatest while pulled forward, when the y-force reverses, at the end [deg]."""
    own, other = runs.default, runs.variants[PLAY]
    gained = measured.trend(other, "yaw_deg") - measured.trend(own, "yaw_deg")
    force = measured.trend(other, "probe_y_kN")
    low = int(np.argmin(force))
    released = low + int(np.argmax(force[low:] > 0.0))
    return {
        "forward_deg": float(np.max(gained[: low + 1])),
        "released_s": float(own.time_s[released]),
        "released_deg": float(gained[released]),
        "end_deg": float(gained[-1]),
    }


def release_rate(runs: Runs) -> dict[str, float]:
    """Mean rate at which the y-force is released between 24 and 34 s [kN/s]."""
    numbers = {}
    for key, history in (("own", runs.default), ("play", runs.variants[PLAY])):
        first, last = measured.at(history, measured.trend(history, "probe_y_kN"), 24.0, 34.0)
        numbers[f"{key}_kNps"] = (last - first) / 10.0
    return numbers


STEER_PLAY: Final = Variant(
    name=PLAY,
    label="2 deg of free play in the tail wheel's lock",
    changes={
        "changes": {
            "stations.auxiliary.steer_play": {
                "play_rad": {"value": 0.0349, "origin": "assumed", "note": "2 deg to either side"},
                "stop_stiffness_Nmprad": {"value": 3.0e5, "origin": "assumed"},
                "stop_damping_Nmspr": {"value": 500.0, "origin": "assumed"},
            }
        }
    },
    words=(
        'Section 3.2.2, 2A: the measured yaw ends 0.5 deg higher and departs "around the time of load reversal on the '
        "probe. [...] it could also correspond to some free steering play in the DLTV tail suspension that is not "
        'modelled in the simulation. Such an effect could also explain the difference in load relaxation rate." The '
        "size of the play is assumed."
    ),
    figures=("3.18", "3.19", "3.20"),
    statements=(
        Statement(
            thesis="free steering play raises the final yaw by about 0.5 deg, from the load reversal on",
            source="section 3.2.2, figure 3.19",
            measure=yaw_gained,
            words=(
                "play changes yaw by {forward_deg:+.2f} deg while pulled forward, {released_deg:+.2f} deg when the "
                "load reverses at {released_s:.0f} s, {end_deg:+.2f} deg at the end"
            ),
            holds=lambda n: n["end_deg"] > 0.3 and n["released_deg"] < 0.5 * n["end_deg"],
            taken_as="more than 0.3 deg at the end, and less than half of that before the load reverses",
            needs=(PLAY,),
        ),
        Statement(
            thesis="it could also explain the load release, which is slightly faster in the trial",
            source="section 3.2.2, figure 3.18",
            measure=release_rate,
            words="y-force released by {own_kNps:.2f} kN/s without and {play_kNps:.2f} kN/s with play",
            holds=lambda n: n["play_kNps"] > n["own_kNps"],
            needs=(PLAY,),
        ),
    ),
)

# --- 2A: noise of the claw's position ---------------------------------------------------------------------------


def quiet(runs: Runs) -> dict[str, float]:
    """Fluctuation of the probe forces and of the lateral deflection with and without noise of the claw."""
    own, other = runs.default, runs.variants[QUIET]
    return {
        "noisy_kN": measured.fluctuation(own, "probe_x_kN"),
        "quiet_kN": measured.fluctuation(other, "probe_x_kN"),
        "noisy_mm": max(measured.fluctuation(own, name) for name in measured.DEFLECTIONS),
        "trend_kN": float(np.max(np.abs(measured.trend(other, "probe_x_kN")))),
    }


QUIET_CLAW: Final = Variant(
    name=QUIET,
    label="claw without noise",
    changes={"claw.noise": None},
    words=(
        'Section 3.2.2, 2A: "the oscillations become too large in the simulated case due to small amounts of RSD claw '
        'position measurement error in the experimental test." Here the noise is taken away.'
    ),
    figures=("3.16", "3.17", "3.18", "3.20"),
    statements=(
        Statement(
            thesis="noise of the claw's position makes the fluctuations of the probe x-force",
            source="section 3.2.2, figure 3.17",
            measure=quiet,
            words="rms {noisy_kN:.2f} kN with and {quiet_kN:.2f} kN without noise; peak without it {trend_kN:.2f} kN",
            holds=lambda n: n["quiet_kN"] < 0.2 * n["noisy_kN"],
            taken_as="without noise less than a fifth is left",
            needs=(QUIET,),
        ),
    ),
)

# --- 2B and 2C: the probe turned about its axis -----------------------------------------------------------------


def turned_2B(runs: Runs) -> dict[str, float]:
    """Trend of the measured x-force at 30 s and at the end, and what the turn changes of anything else."""
    own, other = runs.default, runs.variants[TURN_2B]
    values = measured.trend(other, "probe_x_kN")
    first, last = measured.at(other, values, 30.0, 88.0)
    return {
        "at_30_kN": first,
        "end_kN": last,
        "own_end_kN": measured.at(own, measured.trend(own, "probe_x_kN"), 88.0)[0],
        "states": float(np.max(np.abs(own.states - other.states))),
    }


def turned_2C(runs: Runs) -> dict[str, float]:
    """Mean measured x-force from 10 to 20 s, with the probe turned and not."""
    numbers = {}
    for key, history in (("own", runs.default), ("turned", runs.variants[TURN_2C])):
        numbers[f"{key}_kN"] = float(np.mean(measured.within(history, curve(history, "probe_x_kN"), 10.0, 20.0)))
    return numbers


PROBE_TURN_2B: Final = Variant(
    name=TURN_2B,
    label="probe turned by 50 deg from 30 to 80 s",
    changes={"probe_turn": {"angle_deg": 50.0, "from_s": 30.0, "to_s": 80.0}},
    words=(
        'Section 3.2.2, 2B: after 30 s "the experimental longitudinal probe force begins a steady decline, ultimately '
        "becoming negative. [...] This indicates potential drift in the experimental data or rotation of the securing "
        'probe in its housing." The gauges turn with the probe, so that only what is measured changes. Angle and times '
        "are assumed."
    ),
    figures=("3.23", "3.24", "3.25"),
    statements=(
        Statement(
            thesis="a probe that turns in its housing makes the measured x-force decline steadily and become negative",
            source="section 3.2.2, figure 3.23",
            measure=turned_2B,
            words="measured {at_30_kN:.2f} kN at 30 s, {end_kN:.2f} kN at 88 s; unturned {own_end_kN:.2f} kN then",
            holds=lambda n: n["end_kN"] < 0.0 < n["at_30_kN"] and n["own_end_kN"] > 0.0 and n["states"] == 0.0,
            taken_as="negative at the end only by the turn, and the helicopter's motion the same to the last bit",
            needs=(TURN_2B,),
        ),
    ),
)
PROBE_TURN_2C: Final = Variant(
    name=TURN_2C,
    label="probe turned by 30 deg",
    changes={"probe_turn": {"angle_deg": 30.0, "from_s": 0.0, "to_s": 0.0}},
    words=(
        "Section 3.2.2, 2C: the experimental x-force is negative between 10 and 20 s while the claw pulls forward, "
        'which "could be due to loss of strain gauge calibration, securing probe rotation, or other unmeasured '
        'events". The angle is assumed, the same from the start.'
    ),
    figures=("3.30", "3.31"),
    statements=(
        Statement(
            thesis="a turned probe makes the measured x-force negative while the claw pulls forward (10 to 20 s)",
            source="section 3.2.2, figure 3.30",
            measure=turned_2C,
            words="mean {turned_kN:.2f} kN turned, {own_kN:.2f} kN unturned",
            holds=lambda n: n["turned_kN"] < 0.0 < n["own_kN"],
            needs=(TURN_2C,),
        ),
    ),
)

# --- 2B: a patch of low friction under the right tire -----------------------------------------------------------


def patch(runs: Runs) -> dict[str, float]:
    """Change that the patch makes in the two lateral deflections before it and on it, and in the final yaw."""
    own, other = runs.default, runs.variants[PATCH]
    right, left = (measured.trend(other, name) - measured.trend(own, name) for name in measured.DEFLECTIONS)
    return {
        "before_mm": float(np.max(np.abs(measured.within(own, right, 0.0, 45.0)))),
        "right_mm": float(np.min(measured.within(own, right, 55.0, 75.0))),
        "left_mm": float(np.min(measured.within(own, left, 55.0, 75.0))),
        "yaw_deg": float(curve(other, "yaw_deg")[-1] - curve(own, "yaw_deg")[-1]),
    }


PATCH_2B: Final = Variant(
    name=PATCH,
    label="patch of a fifth of the friction under the right tire",
    changes={"patch": {"x_m": [3.29, 3.8], "y_m": [1.6, 2.5], "friction_factor": 0.2, "edge_m": 0.02}},
    words=(
        'Section 3.2.2, 2B: "It is possible that the right side tire encountered an area of ground with a much reduced '
        'friction coefficient or other surface irregularity around 60 seconds into the manoeuvre." The patch lies '
        "where the right tire comes at about that time; its place and friction are assumed."
    ),
    figures=("3.24", "3.25", "3.27"),
    statements=(
        Statement(
            thesis="a patch of much reduced friction lets the right tire relax, and only that one, from about 60 s on",
            source="section 3.2.2, figure 3.27",
            measure=patch,
            words=(
                "deflection changes by {right_mm:+.1f} mm (right) and {left_mm:+.1f} mm (left) on the patch, by "
                "{before_mm:.2f} mm before it; final yaw by {yaw_deg:+.2f} deg"
            ),
            holds=lambda n: (
                n["right_mm"] < -1.0 and abs(n["left_mm"]) < 0.5 * abs(n["right_mm"]) and n["before_mm"] < 0.01
            ),
            taken_as="the right deflection falls by more than 1 mm, the left one by less than half of that",
            needs=(PATCH,),
        ),
    ),
)
SUSPECTS: Final[dict[str, tuple[Variant, ...]]] = {
    "2A": (STEER_PLAY, QUIET_CLAW),
    "2B": (PROBE_TURN_2B, PATCH_2B),
    "2C": (PROBE_TURN_2C,),
}
