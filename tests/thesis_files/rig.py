"""Cases and helicopters for the tests of the thesis' files."""

from __future__ import annotations

import copy
import math
from functools import cache
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from ssmash_gym.cases import Case, case_from
from ssmash_gym.vehicle import load_helicopter

STATIONS = ("auxiliary", "right", "left")
GIVEN: dict[str, Any] = {
    "type": "state",
    "position_m": [0.0, 0.0, -2.6],
    "orientation": [1.0, 0.0, 0.0, 0.0],
    "strut_m": [1.0, 1.0, 1.0],
    "strut_orientations": [[1.0, 0.0, 0.0, 0.0]] * 3,
}
SHORT: dict[str, Any] = {"end_s": 0.2, "output_step_s": 0.02, "solver": "engine"}
CLAW_ROWS = "0 0 0 0\n0.5 0.01 0 0\n1 0.02 0 0\n1.5 0.03 0 0\n2 0.03 0 0\n"


@cache
def plain_helicopter(name: str = "generic_tricycle") -> dict[str, Any]:
    """A helicopter of the catalogue without its marks; copy before changing it."""
    return load_helicopter(name).model_dump(mode="json", exclude={"provenance"})


def document(**changes: Any) -> dict[str, Any]:
    """A case that needs no engine to be written: an unmarked tricycle in a given state, the claw at a given place."""
    base: dict[str, Any] = {
        "name": "hop",
        "helicopter": copy.deepcopy(plain_helicopter()),
        "start": copy.deepcopy(GIVEN),
        "claw": {"type": "still", "x_m": 0.0, "y_m": 0.0, "z_m": 0.0},
        "solution": dict(SHORT),
    }
    return {**base, **changes}


def case(**changes: Any) -> Case:
    return case_from(document(**changes))


def write_deck(path: Path, rows: int = 61, step: float = 0.05) -> None:
    """A record of a slowly rolling deck."""
    lines = [f"{k * step!r} {0.3 * k / rows!r} " + "0.0 " * 14 for k in range(rows)]
    path.write_text("\n".join(lines) + "\n")


# --- random cases ---------------------------------------------------------------------------------------------------

numbers = st.floats(min_value=-1e3, max_value=1e3, allow_nan=False, width=64)
positive = st.floats(min_value=1e-3, max_value=1e5)
vectors = st.tuples(numbers, numbers, numbers).map(list)


@st.composite
def quaternions(draw: st.DrawFn) -> list[float]:
    parts = draw(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda e: sum(x * x for x in e) > 0.01))
    norm = sum(x * x for x in parts) ** 0.5
    return [x / norm for x in parts]


steered = st.floats(-3.0, 3.0).map(lambda angle: (math.cos(angle), 0.0, 0.0, math.sin(angle)))


@st.composite
def helicopters(draw: st.DrawFn) -> dict[str, Any]:
    """A valid helicopter: one of the catalogue with every number that can vary freely drawn anew."""
    h = copy.deepcopy(plain_helicopter(draw(st.sampled_from(["generic_tricycle", "seahawk_like"]))))
    h["mass_kg"] = draw(st.floats(500.0, 5e4))
    h["inertia_kgm2"][0][1] = h["inertia_kgm2"][1][0] = draw(st.floats(-500.0, 500.0))
    h["aerodynamics"]["centre_of_pressure_m"] = draw(vectors)
    h["aerodynamics"]["drag_areas_m2"] = [abs(x) for x in draw(vectors)]
    h["aerodynamics"]["wind_N_mps"] = draw(vectors)
    h["surroundings"]["gravity_mps2"] = draw(st.floats(1.0, 20.0))
    h["cg_offset_m"] = draw(st.sampled_from([[0.0, 0.0, 0.0], [0.1, 0.0, -0.05]]))
    for key in ("active", "captured"):
        h["probe"][key] = draw(st.booleans())
    for key in h["probe"]:
        if key.endswith(("_Npm", "_Nspm")):
            h["probe"][key] = draw(positive)
    alike = draw(st.booleans())
    friction = draw(positive)
    for name in STATIONS:
        station = h["stations"][name]
        station["steer_friction_m"] = friction if alike else draw(positive)
        station["steer_damping_Nmspr"] = draw(positive)
        station["mass_kg"] = draw(st.floats(10.0, 1000.0))
        station["rolling"] = draw(st.sampled_from(["locked", "free"]))
        if station["kind"] == "prismatic":
            station["steering"] = draw(st.sampled_from(["locked", "free"]))
        tires = station["tires"]
        if len(tires) == 2 and draw(st.booleans()):
            tires.pop()
        for tire in tires:
            tire["type"] = draw(st.sampled_from(["I", "III", "VII"]))
            tire["friction_coefficient"] = draw(st.floats(0.0, 2.0))
            tire["pressure_Pa"] = draw(st.floats(1e5, 2e6))
            tire["rolling_decay_spm"] = draw(positive)
            tire["pitch_moment_coefficient"] = draw(st.floats(-1.0, 1.0))
        if draw(st.booleans()):
            station["spring"] = {
                "type": "linear_strut",
                "stiffness_Npm": draw(positive),
                "damping_Nspm": draw(positive),
            }
        else:
            for key in ("c01_N", "c02_Nspm", "c03_Ns2pm2", "c5_Nspm", "seal_drag_N", "bearing_friction"):
                station["spring"][key] = draw(positive)
    return h


marks = st.fixed_dictionaries({"origin": st.sampled_from(["source", "assumed"]), "note": st.sampled_from(["", "so"])})


@st.composite
def decks(draw: st.DrawFn) -> dict[str, Any]:
    pose = {key: draw(numbers) for key in ("roll_deg", "pitch_deg", "yaw_deg")}
    if draw(st.booleans()):
        return {"type": "fixed", **pose, "z_m": draw(st.sampled_from([0.0, 1.5]))}
    dof = draw(st.sampled_from(["roll", "pitch", "yaw", "surge", "sway", "heave"]))
    key = "amplitude_deg" if dof in ("roll", "pitch", "yaw") else "amplitude_m"
    phase = draw(st.sampled_from([0.0, 30.0]))
    return {"type": "sinusoid", "dof": dof, key: draw(numbers), "period_s": draw(positive), "phase_deg": phase, **pose}


@st.composite
def documents(draw: st.DrawFn) -> dict[str, Any]:
    """A valid case that needs no engine to be written."""
    h = draw(helicopters())
    h["mass_kg"] = {"value": h["mass_kg"], **draw(marks)}
    h["probe"]["capture_radius_m"] = {"value": 0.07, **draw(marks)}
    start = {
        "type": "state",
        "position_m": draw(vectors),
        "orientation": draw(quaternions()),
        "strut_m": draw(vectors),
        "strut_orientations": [draw(quaternions()) for _ in STATIONS],
        "velocity_mps": draw(vectors),
        "angular_velocity_radps": draw(vectors),
        "strut_rates": draw(vectors),
        "steer_rates_radps": draw(vectors),
    }
    step = draw(st.sampled_from([0.005, 0.01, 0.02, 0.1]))
    begin = draw(st.sampled_from([0.0, 1.0]))
    solution = {
        "start_s": begin,
        "end_s": begin + step * draw(st.integers(1, 50)),
        "output_step_s": step,
        "solver": draw(st.sampled_from(["adams", "gear", "automatic", "engine", "dop853"])),
        "rtol": draw(st.floats(1e-12, 1e-3)),
        "atol": draw(st.floats(1e-14, 1e-3)),
        "substep_s": 0.001,
    }
    claw = {"type": "still", "x_m": draw(numbers), "y_m": draw(numbers), "z_m": -abs(draw(numbers))}
    extra = draw(
        st.fixed_dictionaries(
            {},
            optional={
                "title": st.sampled_from(["a run", "Fahrt über Deck"]),
                "held": st.sampled_from([[], ["u9", "u12"]]),
                "model": st.sampled_from([{}, {"friction": "independent", "contact": "centre"}]),
                "ramp_s": st.sampled_from([0.0, 2.5]),
                "seed": st.integers(0, 9),
                "probe_turn": st.just({"angle_deg": {"value": 20.0, "origin": "source"}, "from_s": 3.0, "to_s": 4.0}),
                "patch": st.just({"x_m": [0.0, 1.0], "y_m": [-1.0, 1.0], "friction_factor": 0.3}),
                "changes": st.just({"stations.*.tires.*.axle_friction": 0.03}),
            },
        )
    )
    return {"name": "drawn", "helicopter": h, "start": start, "deck": draw(decks()), "claw": claw,
            "solution": solution, **extra}  # fmt: skip
