"""A run that diverges is caught, told (time, channel, value) and, if a folder is given, written down."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ssmash_gym.dynamics.layout import ODE_ROWS, STATE_ROWS, STATION_COORDINATES, STATIONS, TIRE_STATES, TIRES, State
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.telemetry import CHANNELS


def state_names() -> list[str]:
    """A name for each row of the state: u7-u18, q8-q29, the tires, the claw."""
    names = [f"u{7 + k}" for k in range(State.Q8)]
    names += [f"q{8 + k}" for k in range(State.Q15 - State.Q8 + STATIONS * STATION_COORDINATES)]
    names += [f"tire_{t}_{name}" for t in range(TIRES) for name in ("d_x", "d_y", "psi")[:TIRE_STATES]]
    return names + [State(row).name.lower() for row in range(ODE_ROWS, STATE_ROWS)]


def divergence(batch: Batch, k: int, start_clock: int) -> dict[str, Any]:
    """Which number of column k went wrong and when: ``time_s``, ``channel``, ``value`` (as text where not finite).

    Args:
        batch: The batch.
        k: Its column.
        start_clock: Substep at which the task's time is zero.
    """
    state = batch.state[:, k]
    flagged = state[State.DIVERGED]
    bad = np.flatnonzero(~np.isfinite(state[: State.DIVERGED]))
    clock = float(batch.clocks[k])
    if bad.size:
        name, value = state_names()[int(bad[0])], float(state[bad[0]])
    elif flagged > 0.5:
        row = int(flagged) - 1
        name = state_names()[row]
        value = float(state[State.DIVERGED_VALUE]) or float("nan")  # 0 stands for it; the state holds the one before
        clock = float(state[State.DIVERGED_CLOCK])
    else:
        name, value = _bad_output(batch, k)
    time_s = (clock - start_clock) * batch.timing.substep_s
    return {"time_s": time_s, "channel": name, "value": value if np.isfinite(value) else str(value)}


def _bad_output(batch: Batch, k: int) -> tuple[str, float]:
    """The first telemetry channel of column k that is not finite, within the interval."""
    telemetry = batch.telemetry
    for table in (telemetry.outputs, telemetry.highs, telemetry.lows):
        for channel in CHANNELS.values():
            if channel.has_peaks and not np.isfinite(table[channel.row, k]):
                return channel.name, float(table[channel.row, k])
    return "", 0.0


def dump(folder: str | Path, batch: Batch, k: int, draw: EpisodeDraw | None, told: dict[str, Any]) -> str:
    """Write state, parameters and draw of column k to ``divergence_<n>.npz``; returns the path.

    The arrays `state` (STATE_ROWS,), `parameters` (PARAMETER_ROWS,), `nodes` (nodes, 18) and `commands` (the claw's
    memory of commands) are SI, `clock` counts substeps, `modes` are the rows of `layout.Mode`; `timing`, `told` and
    `draw` are JSON texts.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    number = 0
    while (path := folder / f"divergence_{number}.npz").exists():
        number += 1
    np.savez(
        path,
        state=batch.state[:, k],
        parameters=batch.parameters[:, k],
        nodes=batch.nodes[k],
        commands=batch.snapshot().arrays["_commands"][:, k],
        clock=batch.clocks[k],
        modes=batch.mode,
        timing=json.dumps(asdict(batch.timing)),
        told=json.dumps(told),
        draw=json.dumps(None if draw is None else draw.to_dict()),
    )
    return str(path)
