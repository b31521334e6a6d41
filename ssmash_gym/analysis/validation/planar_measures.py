"""What the statements about manoeuvres 2A to 2C measure: trends free of the claw's noise, and what is left of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.analysis.validation.measures import curve, final, span, swing
from ssmash_gym.analysis.validation.statements import Runs

if TYPE_CHECKING:
    from ssmash_gym.cases import History

Array = NDArray[np.float64]
UNCOUPLED: Final = "independent"  # name of the variant without twist in the friction limit
SLOW_HZ: Final = 0.4  # what is slower is free of the claw's noise of about 1 Hz
DEFLECTIONS: Final = ("right_tire_deflection_mm", "left_tire_deflection_mm")
LOADS: Final = ("right_load_kN", "left_load_kN")
MOVING_S: Final = 5.0  # from here on the claw of 2B moves forward
BETWEEN: Final = (20.0, 30.0)  # time in 2C in which the vehicle of the trials differs from the thesis' simulation [s]


def smooth(history: History, values: Array) -> Array:
    """A curve without what is faster than `SLOW_HZ`, no lag, (m,)."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(4, SLOW_HZ, fs=1.0 / history.case.solution.output_step_s, output="sos")
    return np.asarray(sosfiltfilt(sections, values))


def trend(history: History, name: str) -> Array:
    """A quantity without the fluctuation that the claw's noise makes, (m,)."""
    return smooth(history, curve(history, name))


def fluctuation(history: History, name: str) -> float:
    """Root mean square of a quantity about its trend."""
    values = curve(history, name)
    return float(np.sqrt(np.mean((values - smooth(history, values)) ** 2)))


def at(history: History, values: Array, *times_s: float) -> list[float]:
    """A curve at some times, linear between the rows."""
    return [float(v) for v in np.interp(times_s, history.time_s, values)]


def within(history: History, values: Array, from_s: float, to_s: float) -> Array:
    """A curve within a time."""
    return values[(history.time_s >= from_s) & (history.time_s <= to_s)]


def mean_deflection(history: History) -> Array:
    """Mean lateral deflection of the main tires without fluctuation [mm], (m,)."""
    return 0.5 * (trend(history, DEFLECTIONS[0]) + trend(history, DEFLECTIONS[1]))


def relaxed_from(history: History) -> dict[str, float]:
    """When the main tires are deflected most, by how much, and when they first keep less than a third of it."""
    values = mean_deflection(history)
    top = int(np.argmax(values))
    later = np.flatnonzero(values[top:] < values[top] / 3.0)
    end = history.time_s[top + later[0]] if later.size else history.time_s[-1]
    return {"peak_mm": float(values[top]), "peak_s": float(history.time_s[top]), "relaxed_s": float(end)}


def claw_path(runs: Runs) -> dict[str, float]:
    """How far forward the claw goes, and its distance from the start at the end."""
    x, y = (curve(runs.default, f"claw_{axis}_m") for axis in "xy")
    return {"far_m": float(np.max(x) - x[0]), "end_m": float(np.hypot(x[-1] - x[0], y[-1] - y[0]))}


def yaw_swing(runs: Runs) -> dict[str, float]:
    """Least and greatest yaw."""
    low, high = span(runs.default, "yaw_deg")
    return {"low_deg": low, "high_deg": high}


def fx_trend(runs: Runs) -> dict[str, float]:
    """Trend of the probe's x-force: at the start, greatest on the way forward, least on the way back."""
    history = runs.default
    values = trend(history, "probe_x_kN")
    turn = float(history.time_s[np.argmax(trend(history, "claw_x_m"))])
    return {
        "start_kN": float(values[0]),
        "forward_kN": float(np.max(within(history, values, 0.0, turn))),
        "back_kN": float(np.min(within(history, values, turn, np.inf))),
    }


def frequency(runs: Runs) -> dict[str, float]:
    """Frequencies at which x-force and claw x-position fluctuate most [Hz]."""
    from scipy.signal import periodogram

    numbers = {}
    for key, name in (("force_hz", "probe_x_kN"), ("claw_hz", "claw_x_m")):
        values = curve(runs.default, name)
        rest = values - smooth(runs.default, values)
        hertz, power = periodogram(rest, 1.0 / runs.default.case.solution.output_step_s, "hann")
        numbers[key] = float(hertz[np.argmax(power)])
    return numbers


def fx_fluctuation(runs: Runs) -> dict[str, float]:
    """Fluctuation of x-force and claw, and the greatest trend of the force."""
    history = runs.default
    return {
        "force_kN": fluctuation(history, "probe_x_kN"),
        "claw_mm": 1e3 * fluctuation(history, "claw_x_m"),
        "trend_kN": float(np.max(np.abs(trend(history, "probe_x_kN")))),
    }


def fy_forward(runs: Runs) -> dict[str, float]:
    """Trend of the y-force at 5, 10, 15 and 20 s, and its peak."""
    values = trend(runs.default, "probe_y_kN")
    told = at(runs.default, values, 5.0, 10.0, 15.0, 20.0)
    return {**{f"at_{5 * (k + 1)}_kN": value for k, value in enumerate(told)}, "peak_kN": float(np.min(values))}


def fy_back(runs: Runs) -> dict[str, float]:
    """Trend of the y-force at the turn, at 28, 32 and 36 s."""
    values = trend(runs.default, "probe_y_kN")
    times = (23, 28, 32, 36)
    return {f"at_{t}_kN": value for t, value in zip(times, at(runs.default, values, *times), strict=True)}


def shares(runs: Runs) -> dict[str, float]:
    """Fluctuation over greatest trend of lateral deflection and of x-force."""
    history = runs.default
    top = max(float(np.max(np.abs(trend(history, name)))) for name in DEFLECTIONS)
    force = fx_fluctuation(runs)
    return {
        "deflection": max(fluctuation(history, name) for name in DEFLECTIONS) / top,
        "force": force["force_kN"] / force["trend_kN"],
    }


def out_of_plane(runs: Runs) -> dict[str, float]:
    """Greatest less least vertical load of each main tire, and the range of roll."""
    history = runs.default
    return {
        "right_kN": swing(history, LOADS[0]),
        "left_kN": swing(history, LOADS[1]),
        "roll_deg": swing(history, "roll_deg"),
    }


def yaw_end(runs: Runs) -> dict[str, float]:
    """Yaw at start and end."""
    return {"start_deg": float(curve(runs.default, "yaw_deg")[0]), "end_deg": final(runs.default, "yaw_deg")}


def steer_end(runs: Runs) -> dict[str, float]:
    """Steer angle at the end."""
    return {"end_deg": final(runs.default, "steer_deg")}


def uncoupled_steer(runs: Runs) -> dict[str, float]:
    """Steer angle at the end without twist in the friction limit."""
    return {"end_deg": final(runs.variants[UNCOUPLED], "steer_deg")}


def fx_least(runs: Runs) -> dict[str, float]:
    """While the claw moves: least trend of the x-force, when, and least x-force."""
    history = runs.default
    moving = history.time_s >= MOVING_S
    values = trend(history, "probe_x_kN")[moving]
    return {
        "trend_kN": float(np.min(values)),
        "time_s": float(history.time_s[moving][np.argmin(values)]),
        "least_kN": span(history, "probe_x_kN", MOVING_S)[0],
    }


def claw_pull(runs: Runs) -> dict[str, float]:
    """While the claw moves: range of the trend of the force with which it pulls the helicopter along the track."""
    history = runs.default
    yaw = np.radians(curve(history, "yaw_deg"))
    along = smooth(history, np.cos(yaw) * curve(history, "probe_x_kN") - np.sin(yaw) * curve(history, "probe_y_kN"))
    along = along[history.time_s >= MOVING_S]
    return {"least_kN": float(np.min(along)), "greatest_kN": float(np.max(along))}


def tires_apart(runs: Runs) -> dict[str, float]:
    """Greatest difference between the two lateral deflections, without fluctuation, and their greatest."""
    right, left = (trend(runs.default, name) for name in DEFLECTIONS)
    return {"apart_mm": float(np.max(np.abs(right - left))), "peak_mm": float(max(right.max(), left.max()))}


def pull_forward(runs: Runs) -> dict[str, float]:
    """Between 10 and 20 s: travel of the claw, mean and least trend of the x-force."""
    history = runs.default
    values = within(history, trend(history, "probe_x_kN"), 10.0, 20.0)
    start, end = at(history, curve(history, "claw_x_m"), 10.0, 20.0)
    return {"travel_m": end - start, "mean_kN": float(np.mean(values)), "least_kN": float(np.min(values))}


def yaw_rate(runs: Runs) -> dict[str, float]:
    """Greatest yaw rate, when, and the last time at which it is above half of that."""
    history = runs.default
    values = smooth(history, np.degrees(history["yaw_rate"]))
    top = float(np.max(values))
    last = history.time_s[values > 0.5 * top][-1]
    return {"rate_degps": top, "time_s": float(history.time_s[np.argmax(values)]), "last_s": float(last)}


def relaxation(runs: Runs) -> dict[str, float]:
    """`relaxed_from` of the manoeuvre as its file says."""
    return relaxed_from(runs.default)


def uncoupled_relaxation(runs: Runs) -> dict[str, float]:
    """`relaxed_from` without twist in the friction limit, and the last time of high yaw rate there."""
    history = runs.variants[UNCOUPLED]
    return {**relaxed_from(history), "last_s": yaw_rate(Runs(history))["last_s"]}


def uncoupled_growth(runs: Runs) -> dict[str, float]:
    """Mean lateral deflection at 20 s and its mean from there to 30 s, without twist in the friction limit."""
    history = runs.variants[UNCOUPLED]
    values = mean_deflection(history)
    return {"at_20_mm": at(history, values, 20.0)[0], "mean_mm": float(np.mean(within(history, values, *BETWEEN)))}


def both(runs: Runs, from_s: float, to_s: float) -> dict[str, float]:
    """Mean lateral deflection and y-force within a time, with and without twist in the friction limit."""
    numbers = {}
    for key, history in (("coupled", runs.default), ("uncoupled", runs.variants[UNCOUPLED])):
        numbers[f"{key}_mm"] = float(np.mean(within(history, mean_deflection(history), from_s, to_s)))
        numbers[f"{key}_kN"] = float(np.mean(within(history, curve(history, "probe_y_kN"), from_s, to_s)))
    return numbers


def both_2B(runs: Runs) -> dict[str, float]:
    """`both` over the whole of 2B."""
    return both(runs, 0.0, 90.0)


def both_2C(runs: Runs) -> dict[str, float]:
    """`both` of 2C between 20 and 30 s."""
    return both(runs, *BETWEEN)
