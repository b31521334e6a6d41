"""A made-up window: smooth probabilities and binomial draws, no simulation and no helicopter behind them."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import polars as pl

LIMITS: dict[str, dict[str, Any]] = {
    "probe_in_plane": {"value": 15.0, "unit": "kN", "label": "probe load in the deck plane", "sense": "above"},
    "probe_axial": {"value": 25.0, "unit": "kN", "label": "probe load along its axis", "sense": "above"},
    "main_gear": {"value": 60.0, "unit": "kN", "label": "main gear, load of a tire", "sense": "above"},
    "roll": {"value": 9.0, "unit": "deg", "label": "roll of the deck", "sense": "above"},
    "sliding": {"value": 0.05, "unit": "m", "label": "sliding of a tire", "sense": "above"},
    "corridor": {"value": 0.0, "unit": "m", "label": "clearance to the corridor's edge", "sense": "below"},
}
AXES: dict[str, dict[str, Any]] = {
    "sea_state": {"label": "sea state", "unit": "", "values": [3, 4, 5, 6]},
    "waves_from_deg": {"label": "relative wave direction, waves come from", "unit": "deg",
                       "values": list(range(0, 360, 15))},
    "speed_kn": {"label": "ship speed", "unit": "kn", "values": [0, 5, 10, 15, 20]},
}  # fmt: skip
COLUMNS = {"probe_in_plane": "peak_probe_kN", "probe_axial": "peak_axial_kN", "main_gear": "peak_main_kN",
           "roll": "peak_roll_deg", "sliding": "sliding_m", "corridor": "corridor_clearance_m"}  # fmt: skip


def document(axes: dict[str, dict[str, Any]] | None = None, **changes: Any) -> dict[str, Any]:
    """Contents of a made-up ``window.json``."""
    given = {name: one | {"note": "assumed"} for name, one in LIMITS.items()}
    return {
        "name": "made-up window", "description": "Made-up numbers that show what the page looks like.",
        "configuration": "0123abcd", "seed": 7, "versions": {"ssmash_gym": "0.0", "code": "feed1234"},
        "axes": axes or AXES, "limits": given, "acceptance": 0.1, "confidence": 0.95, "stages": ["traverse", "secured"],
        "policies": {"agent": {"kind": "agent"}, "trapezoid": {"kind": "scripted"}}, "helicopter": "made_up_helicopter",
        "task": "made_up_task", "scenario": "made_up_scenario",
    } | changes  # fmt: skip


def _means(values: dict[str, float], policy: str) -> np.ndarray:
    """Mean use of each limit in a cell, (limits,): a smooth function of the axes."""
    state, speed = values.get("sea_state", 5.0), values.get("speed_kn", 10.0)
    angle = np.radians(values.get("waves_from_deg", 90.0))
    others = sum(0.02 * one for name, one in values.items() if name not in AXES)
    beam, ahead = abs(np.sin(angle)), np.cos(angle)
    rough = (state - 2.0) / 3.0 + others
    gain = 0.8 if policy == "agent" else 1.0
    return np.array([
        gain * rough * (0.3 + 0.62 * beam + 0.012 * speed * max(ahead, 0.0)),
        rough * (0.25 + 0.045 * speed * max(ahead, 0.0)),
        rough * (0.35 + 0.3 * beam),
        rough * (0.28 + 0.6 * beam * (1.0 + 0.008 * speed) * (0.9 if np.sin(angle) > 0 else 1.0)),
        rough * (0.2 + 0.85 * max(-ahead, 0.0) * (1.0 - 0.01 * speed)),
        rough * 0.5,
    ])  # fmt: skip


def tables(
    told: dict[str, Any], episodes: int = 40, seed: int = 0, drop: float = 0.0
) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Cells and episodes of a made-up window, as a sweep would give them."""
    rng = np.random.default_rng(seed)
    axes = {name: one["values"] for name, one in told["axes"].items()}
    cells: list[dict[str, Any]] = []
    rows: list[dict[str, Any]] = []
    names = list(told["limits"])
    for stage, policy in product(told["stages"], told["policies"]):
        for cell, at in enumerate(product(*axes.values())):
            if rng.random() < drop:
                continue
            values = dict(zip(axes, map(float, at), strict=True))
            use = _means(values, policy) * np.exp(0.28 * rng.standard_normal((episodes, 6)) - 0.04)
            use = use[:, : len(names)] * (1.1 if stage == "secured" else 1.0)
            head = {"stage": stage, "policy": policy, "cell": cell} | values
            cells.append(head | _cell(use, names, values, 100000 + 1000 * cell))
            rows += [head | _episode(one, k, 100000 + 1000 * cell + k, names) for k, one in enumerate(use)]
    return pl.DataFrame(cells, infer_schema_length=None), pl.DataFrame(rows, infer_schema_length=None)


def _cell(use: np.ndarray, names: list[str], values: dict[str, float], seed: int) -> dict[str, Any]:
    over = use > 1.0
    n, exceeded = len(use), int(over.any(axis=1).sum())
    share = exceeded / n
    half = 2.2 * np.sqrt((share * (1.0 - share) + 0.02) / n)
    low, high = max(0.0, share - half), min(1.0, share + half)
    verdict = "within" if high <= 0.1 else "beyond" if low > 0.1 else "undecided"
    counts = over.sum(axis=0)
    valid = not (values.get("sea_state", 0.0) >= 6 and abs(values.get("waves_from_deg", 0.0) - 90.0) <= 30.0)
    return {
        "episodes": n, "exceeded": exceeded, "share": share, "low": low, "high": high, "verdict": verdict,
        "limiting": names[int(counts.argmax())] if exceeded else None, "valid": valid,
        "worst_seed": seed + int(use.max(axis=1).argmax()), "worst_use": float(use.max()),
        **{f"over_{name}": int(count) for name, count in zip(names, counts, strict=True)},
        **{f"use_{name}": float(p) for name, p in zip(names, np.percentile(use, 95, axis=0), strict=True)},
    }  # fmt: skip


def _episode(use: np.ndarray, number: int, seed: int, names: list[str]) -> dict[str, Any]:
    over = [name for name, one in zip(names, use, strict=True) if one > 1.0]
    peaks = {COLUMNS.get(name, f"peak_{k}_kN"): (LIMITS.get(name, {"value": 1.0})["value"] or 1.0) * one
             for k, (name, one) in enumerate(zip(names, use, strict=True))}  # fmt: skip
    done = bool(use[0] < 1.6)
    head = {"number": number, "seed": seed, "reason": "goal" if done else "time_out", "success": done}
    return head | {"time_s": 40.0 + 5.0 * use[0], "exceeds": ",".join(over), "worst_use": float(use.max())} | peaks
