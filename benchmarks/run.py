"""`make bench`: the engine, and a MuJoCo model of the same helicopter beside it, in one run.

Prints a table and JSON; ``--out FILE`` writes the JSON too. Turns of the engine and of MuJoCo alternate, so that
both meet the same neighbours on the machine.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import mujoco_side, parallel, starts
from benchmarks.scenario import CONTROL_INTERVAL_S, SUBSTEP_S, Traverse
from benchmarks.timing import Rate, cpu_rate, rate
from ssmash_gym.dynamics import engine
from ssmash_gym.vehicle import load_helicopter

# Intervals of one turn: about a second of processor time each.
TURNS = {1: 5000, 64: 300, 1024: 20}
STAGES = 2  # right-hand sides a substep


def right_hand_side_ns(count: int, calls: int) -> float:
    """Nanoseconds of one right-hand side of one helicopter, called by itself."""
    state, parameters, mode, decks = Traverse("generic_tricycle", count).right_hand_side()
    engine.derivative(state, parameters, mode, decks)
    start = time.process_time()
    for _ in range(calls):
        engine.derivative(state, parameters, mode, decks)
    return (time.process_time() - start) / calls / count * 1e9


def in_turns(turns: dict[str, Callable[[], float]], repeats: int) -> dict[str, Rate]:
    """Time several jobs in alternation: simulated seconds per second of processor time."""
    values: dict[str, list[float]] = {name: [] for name in turns}
    for _ in range(repeats):
        for name, turn in turns.items():
            values[name].append(cpu_rate(turn))
    return {name: rate(list_) for name, list_ in values.items()}


def helicopter_rates(name: str, counts: list[int], repeats: int) -> dict[str, Any]:
    """The engine at several batch sizes and MuJoCo, on one helicopter."""
    batches = {count: Traverse(name, count) for count in counts}
    for batch in batches.values():
        batch.advance(2)
    turns: dict[str, Callable[[], float]] = {
        str(count): lambda count=count: batches[count].advance(TURNS[count]) for count in counts
    }
    turns["mujoco"] = mujoco_side.traverse(load_helicopter(name))
    rates = in_turns(turns, repeats)
    mujoco_rate = rates.pop("mujoco")
    return {
        "simulated_s_per_cpu_s": {key: value.as_dict() for key, value in rates.items()},
        "ns_per_right_hand_side_with_integrator": {
            key: round(1e9 * SUBSTEP_S / STAGES / value.best, 1) for key, value in rates.items()
        },
        "mujoco_simulated_s_per_cpu_s": mujoco_rate.as_dict(),
        "times_mujoco": {key: round(value.median / mujoco_rate.median, 1) for key, value in rates.items()},
    }


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    libraries = ("numba", "numpy", "mujoco", "ssmash_gym")
    return {
        "processor": platform.processor() or platform.machine(),
        "widest_lane": engine.WIDE,
        "cores": engine.available_threads(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in libraries},
    }


def measure(quick: bool) -> dict[str, Any]:
    """Every figure of the benchmark."""
    repeats = 1 if quick else 5
    threads = [parallel.two_threads("generic_tricycle", 64, 300) for _ in range(repeats)]
    processes = [parallel.two_processes("generic_tricycle", 64, 300) for _ in range(repeats)]
    return {
        "machine": machine(),
        "settings": {"substep_s": SUBSTEP_S, "control_interval_s": CONTROL_INTERVAL_S, "telemetry": True},
        "generic_tricycle": helicopter_rates("generic_tricycle", [1, 64, 1024], repeats),
        "seahawk_like": helicopter_rates("seahawk_like", [1, 64], repeats),
        "right_hand_side_ns": round(min(right_hand_side_ns(256, 40) for _ in range(repeats)), 1),
        "two_cores_simulated_s_per_wall_s": {
            "two_threads": rate(threads).as_dict(),
            "two_processes": rate(processes).as_dict(),
            "threads_over_processes": round(np.median(threads) / np.median(processes), 3),
        },
        "start_s": starts.start_times_s(),
        "training_episode_ms": starts.sea_costs_ms(),
        "peak_memory_mb_1024": starts.peak_memory_mb(1024),
    }


def show(figures: dict[str, Any], console: Console) -> None:
    """The figures as a table."""
    table = Table("quantity", "measured", "aim", title="ssmash_gym: traverse, 2 ms, twin tires, telemetry on")
    aims = {"1": "450 or more", "64": "2000, floor 1500"}
    for name in ("generic_tricycle", "seahawk_like"):
        part = figures[name]
        for key, value in part["simulated_s_per_cpu_s"].items():
            text = f"{value['best']:.0f} (median {value['median']:.0f}), {part['times_mujoco'][key]:.0f} x MuJoCo"
            aim = aims.get(key, "") if name == "generic_tricycle" else ""
            table.add_row(f"{name}, N = {key}: simulated s per CPU s and core", text, aim)
        slow = part["mujoco_simulated_s_per_cpu_s"]
        table.add_row(f"{name}, MuJoCo: the same", f"{slow['best']:.0f} (median {slow['median']:.0f})", "")
    table.add_row("right-hand side alone, ns per helicopter", f"{figures['right_hand_side_ns']:.0f}", "")
    cores = figures["two_cores_simulated_s_per_wall_s"]
    two = f"{cores['two_threads']['median']:.0f} : {cores['two_processes']['median']:.0f}"
    table.add_row("two threads : two processes, simulated s per wall s", two, "")
    table.add_row("cold start to first step, s", f"{figures['start_s']['cold']:.1f}", "under 25")
    table.add_row("cached start to first step, s", f"{figures['start_s']['cached']:.1f}", "under 3")
    costs = figures["training_episode_ms"]
    sea = costs["draw"] + costs["deck"] + costs["gusts"]
    text = f"{costs['episode']:.0f}, start {costs['start']:.0f}, sea {sea:.1f}: {100 * sea / costs['episode']:.0f} %"
    table.add_row("a training episode of 40 s, CPU ms; its start; its sea and wind and their share", text, "")
    table.add_row("peak memory, 1024 helicopters, MB", f"{figures['peak_memory_mb_1024']:.0f}", "under 600")
    console.print(table)


def main() -> None:
    """Measure, show, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, help="file for the JSON")
    parser.add_argument("--quick", action="store_true", help="one turn each: a check that it runs, not a measurement")
    options = parser.parse_args()
    figures = measure(options.quick)
    text = json.dumps(figures, indent=2)
    if options.out:
        options.out.parent.mkdir(parents=True, exist_ok=True)
        options.out.write_text(text + "\n")
    show(figures, Console(stderr=True))
    sys.stdout.write(text + "\n")


if __name__ == "__main__":
    main()
