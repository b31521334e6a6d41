"""The claw of the securing device: a rigid drive that follows a velocity command.

Command -> delay (whole substeps) -> speed, acceleration and travel limits -> position and velocity in S, plus an
optional ripple of the drive. Along the track (x) and across it (y) are independent. The acceleration is constant
within a substep, so position is exact. Nothing pushes the claw: it is a prescribed motion for the helicopter.
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, maximum, minimum, sqrt, store, where
from ssmash_gym.dynamics.layout import Deck, Par, State
from ssmash_gym.dynamics.maths import cos, sin


@kernel
def delayed_command(p: Any, commands: Any, history: int, axis: int, since: float, interval: float, dt: float) -> Any:
    """The normalised command in force `since` seconds after the start of the interval.

    Row ``2 j + axis`` of `commands` is the command given j intervals ago; a command acts CLAW_DELAY after it was
    given, from a substep boundary on.
    """
    lag = load(p, Par.CLAW_DELAY) - since
    command = load(commands, axis)
    for j in range(1, history):
        command = where(lag > (j - 1) * interval + 0.5 * dt, load(commands, 2 * j + axis), command)
    return command


@kernel
def drive(x: Any, v: Any, target: Any, accel: Any, low: Any, high: Any, h: float) -> Any:
    """Position and velocity after a substep `h`, and the acceleration in it.

    The velocity changes by at most ``accel * h``, and is kept low enough that the claw can stop at its travel
    limits `low`, `high` with that acceleration: v'^2 / (2 a) + h (v + v') / 2 <= distance left.
    """
    step = accel * h
    next_v = v + minimum(maximum(target - v, -step), step)
    up = 0.5 * (sqrt(maximum(step * step + 8.0 * accel * (high - x) - 4.0 * step * v, 0.0 * x)) - step)
    down = 0.5 * (sqrt(maximum(step * step + 8.0 * accel * (x - low) + 4.0 * step * v, 0.0 * x)) - step)
    next_v = maximum(minimum(next_v, maximum(up, 0.0 * x)), -maximum(down, 0.0 * x))
    next_x = x + 0.5 * h * (v + next_v)
    next_x = where(x <= high, minimum(next_x, high), next_x)
    next_x = where(x >= low, maximum(next_x, low), next_x)
    return (next_x, next_v)


@kernel
def advance_claw(
    y: Any, p: Any, commands: Any, history: int, since: float, interval: float, h: float, out: Any
) -> None:
    """Claw rows of `out` from those of `y` one substep later."""
    for axis in range(2):
        target = delayed_command(p, commands, history, axis, since, interval, h) * load(p, Par.CLAW_SPEED_X + axis)
        moved = drive(
            load(y, State.CLAW_X + axis),
            load(y, State.CLAW_VX + axis),
            target,
            load(p, Par.CLAW_ACCEL_X + axis),
            load(p, Par.CLAW_X_MIN + 2 * axis),
            load(p, Par.CLAW_X_MAX + 2 * axis),
            h,
        )
        store(out, State.CLAW_X + axis, moved[0])
        store(out, State.CLAW_VX + axis, moved[1])


@kernel
def place_claw(y: Any, p: Any, ripple: int, time: Any, d: Any) -> None:
    """Claw centre and velocity in S at `time` [s], ripple (about 1 Hz, millimetres) added."""
    for axis in range(2):
        store(d, Deck.C_CLAW_S + axis, load(y, State.CLAW_X + axis))
        store(d, Deck.V_CLAW_S + axis, load(y, State.CLAW_VX + axis))
    store(d, Deck.C_CLAW_S + 2, load(p, Par.CLAW_Z))
    store(d, Deck.V_CLAW_S + 2, 0.0 * time)
    if ripple:
        omega = load(p, Par.RIPPLE_OMEGA)
        angle = omega * time + load(p, Par.RIPPLE_PHASE)
        s = sin(angle)
        c = omega * cos(angle)
        for axis in range(2):
            amplitude = load(p, Par.RIPPLE_X + axis)
            store(d, Deck.C_CLAW_S + axis, load(d, Deck.C_CLAW_S + axis) + amplitude * s)
            store(d, Deck.V_CLAW_S + axis, load(d, Deck.V_CLAW_S + axis) + amplitude * c)
