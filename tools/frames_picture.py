"""Makes docs/images/frames.png: the frames of reference and what stands between them.

python tools/frames_picture.py

A drawing, to no scale: no number of it comes from a helicopter.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ssmash_gym.files import whole_file

Array = NDArray[np.float64]
OUT = Path("docs/images/frames.png")
COLOURS = {
    "N": "#555555",
    "S": "#1f5fa8",
    "H": "#b3261e",
    "O": "#2e7d32",
    "W": "#8e5a00",
    "T": "#6a3fa0",
    "C": "#00798c",
}
AZIMUTH, ELEVATION = np.deg2rad(38.0), np.deg2rad(20.0)  # of the viewer: ahead to starboard, above


def seen(points: Array) -> Array:
    """Picture coordinates of points (..., 3), x forward, y to starboard, z down."""
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)
    right = -x * np.cos(AZIMUTH) + y * np.sin(AZIMUTH)
    depth = -x * np.sin(AZIMUTH) - y * np.cos(AZIMUTH)
    return np.stack([-right, -z * np.cos(ELEVATION) + depth * np.sin(ELEVATION)], axis=-1)


def turn(axis: str, degrees: float) -> Array:
    """Rotation matrix, rotated to non-rotated."""
    a, b = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    R = np.eye(3)
    R[a, a] = R[b, b] = c
    R[b, a], R[a, b] = s, -s
    return R


def line(ax: Axes, points: Array, **style: object) -> None:
    ax.plot(*seen(np.asarray(points)).T, **style)


def fill(ax: Axes, points: Array, **style: object) -> None:
    ax.fill(*seen(np.asarray(points)).T, **style)


def text(
    ax: Axes, point: Array, words: str, colour: str = "black", shift: tuple[float, float] = (0, 0), size: float = 11
) -> None:
    x, y = seen(np.asarray(point))
    ax.plot(x, y, alpha=0.0)  # counts for the limits of the axes
    ax.annotate(
        words,
        (x, y),
        shift,
        textcoords="offset points",
        color=colour,
        fontsize=size,
        ha="center",
        va="center",
        zorder=9,
    )


def arrow(
    ax: Axes, start: Array, end: Array, colour: str, width: float = 1.6, style: str = "-|>", dashes: str = "-"
) -> None:
    a, b = seen(np.asarray(start)), seen(np.asarray(end))
    form = {"arrowstyle": style, "color": colour, "lw": width, "ls": dashes}
    ax.annotate("", b, a, zorder=8, arrowprops={**form, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11})


def triad(ax: Axes, origin: Array, R: Array, letter: str, size: float, name: str | None = None,
          shift: tuple[float, float] = (0, 0), z_shift: tuple[float, float] = (9, 0)) -> None:  # fmt: skip
    """The three axes of a frame with their names, and the name of the frame; `z_shift` moves that of z."""
    colour = COLOURS[letter]
    for k, axis in enumerate("xyz"):
        end = origin + size * R[:, k]
        arrow(ax, origin, end, colour)
        text(
            ax,
            origin + 1.22 * size * R[:, k],
            rf"${letter.lower()}_{axis}$",
            colour,
            z_shift if axis == "z" else (0, 0),
            10,
        )
    ax.plot(*seen(origin), "o", color=colour, ms=4, zorder=9)
    text(ax, origin, name or letter, colour, shift, 15)


def wheel(ax: Axes, centre: Array, R: Array, radius: float) -> None:
    """A wheel: its two rims and the tread between them."""
    angle = np.linspace(0.0, 2.0 * np.pi, 61)
    circle = radius * np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=-1)
    for side in (-0.12, 0.12):
        rim = centre + (circle + np.array([0.0, side, 0.0])) @ R.T
        fill(ax, rim, color="#d9d9d9", ec="#777777", lw=0.9, alpha=0.75, zorder=3)


def body(ax: Axes, cg: Array, R: Array) -> None:
    """Outline of a helicopter's body: cross sections along x and the lines between them."""
    stations = [
        (3.0, 0.35, 0.35, 0.3),
        (2.5, 0.75, 0.65, 0.15),
        (1.5, 1.0, 0.95, 0.0),
        (-1.0, 1.0, 0.9, 0.0),
        (-2.4, 0.5, 0.45, -0.25),
        (-5.6, 0.18, 0.2, -0.5),
    ]
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    rings = [
        np.stack([0.0 * angle + x, half * np.cos(angle), up * np.sin(angle) + z], axis=-1)
        for x, half, up, z in stations
    ]
    rings = [cg + ring @ R.T for ring in rings]
    for ring in rings:
        fill(ax, ring, color="#f2e3e1", ec="#c9a5a1", lw=0.8, alpha=0.55, zorder=2)
    for k in range(0, 48, 6):
        line(ax, [ring[k] for ring in rings], color="#c9a5a1", lw=0.8, zorder=2)


def overview(ax: Axes) -> None:
    """Ship, helicopter, claw."""
    deck = np.array([[-7.0, -4.2, 0], [6.2, -4.2, 0], [6.2, 4.2, 0], [-7.0, 4.2, 0]])
    fill(ax, deck, color="#e3ebf4", ec="#8aa5c4", lw=1.2, zorder=0)
    for y in (-0.12, 0.12):
        line(ax, [[-6.6, y, 0], [5.8, y, 0]], color="#8aa5c4", lw=0.8, zorder=1)
    S, C = np.array([-5.9, 0.0, 0.0]), np.array([-1.3, 0.0, 0.0])
    cg, R = np.array([0.4, 0.3, -2.4]), turn("z", 7) @ turn("y", 2)
    body(ax, cg, R)
    N = np.array([-7.6, -1.4, 3.4])
    triad(ax, N, np.eye(3), "N", 1.5, shift=(-14, 8))
    triad(ax, S, np.eye(3), "S", 1.5, shift=(-13, 12))
    arrow(ax, N, S, "#888888", 1.0, "->", "--")
    text(ax, 0.5 * (N + S), r"$\mathbf{r}_{NS}$", "#555555", (-16, 4))
    triad(ax, cg, R, "H", 1.6, shift=(-13, 12), z_shift=(-10, 12))
    arrow(ax, S, cg, "#888888", 1.0, "->", "--")
    text(ax, S + 0.45 * (cg - S), r"$\mathbf{r}_{SH}$", "#555555", (0, 12))
    triad(ax, C, np.eye(3), "C", 0.85, shift=(-15, 10))
    arrow(ax, cg + R @ np.array([-1.65, 0.0, 0.85]), C + np.array([0.0, 0.1, -0.06]), "#333333", 2.2, "-")
    text(ax, C + np.array([0.0, 0.1, -0.8]), "probe", "#333333", (17, 1), 9.5)
    mounts = {"1": (-4.6, 0.0, 0.1), "2": (1.9, 1.45, 0.7), "3": (1.9, -1.45, 0.7)}
    for i, mount in mounts.items():
        steer = R @ turn("z", 0 if i != "1" else 25)
        joint = cg + R @ np.array(mount)
        W = np.array([joint[0], joint[1], -0.42]) + R @ np.array([0.0, 0.05, 0.0])
        line(ax, [joint, W], color="#4d4d4d", lw=2.4, zorder=4)
        wheel(ax, W, steer, 0.42)
        ax.plot(*seen(joint), "o", color=COLOURS["O"], ms=5, zorder=9)
        ax.plot(*seen(W), "o", color=COLOURS["W"], ms=5, zorder=9)
        text(ax, joint, rf"$O_{i}$", COLOURS["O"], (17, 5), 14)
        text(ax, W, rf"$W_{i}$", COLOURS["W"], (22, -10), 14)
    text(ax, np.array([3.4, 2.6, 0.0]), "flight deck: $s_z = 0$", "#3f6590", (0, 0), 10)
    ax.set_title("Ship S, helicopter H, stations 1 to 3, claw C", fontsize=11, pad=10)


def close_up(ax: Axes) -> None:
    """One station: oleo, carriage and tire frames."""
    deck = np.array([[-1.6, -1.5, 0], [1.9, -1.5, 0], [1.9, 1.7, 0], [-1.6, 1.7, 0]])
    fill(ax, deck, color="#e3ebf4", ec="#8aa5c4", lw=1.2, zorder=0)
    H = np.array([-1.5, -1.0, -3.1])
    steer = turn("x", 4) @ turn("z", 18)
    joint, W = np.array([0.0, 0.0, -2.6]), np.array([0.0, 0.0, -0.75])
    tire = W + steer @ np.array([0.0, 0.55, 0.0])
    T = np.array([tire[0], tire[1], 0.0])
    line(ax, [joint, W], color="#8c8c8c", lw=3.0, zorder=4, solid_capstyle="butt")
    line(ax, [joint, 0.5 * joint + 0.5 * W], color="#c4c4c4", lw=9.0, zorder=4, solid_capstyle="butt")
    line(ax, [W, tire], color="#4d4d4d", lw=3.0, zorder=4)
    wheel(ax, tire, steer, 0.75)
    triad(ax, joint, steer, "O", 0.75, r"$O_i$", (-18, 8))
    triad(ax, W, steer, "W", 0.75, r"$W_i$", (20, 12))
    triad(ax, T, turn("z", 18), "T", 0.75, "T", (-13, -15))
    ax.plot(*seen(H), "o", color=COLOURS["H"], ms=5)
    text(ax, H, "H", COLOURS["H"], (-12, 8), 15)
    for start, end, words, shift in (
        (H, joint, r"$\mathbf{r}_{HO}$", (-15, -4)),
        (joint, W, r"$\mathbf{r}_{OW}$", (20, -16)),
        (W, tire, "", (0, 0)),
    ):
        arrow(ax, start, end, "#666666", 1.0, "->", "--")
        text(ax, 0.5 * (start + end), words, "#444444", shift)
    middle = seen(0.5 * (W + tire))
    ax.annotate(
        r"$\mathbf{r}_{WT}$",
        middle,
        (-62, 30),
        textcoords="offset points",
        color="#444444",
        fontsize=11,
        ha="center",
        va="center",
        zorder=9,
        arrowprops={"arrowstyle": "-", "color": "#666666", "lw": 0.7},
    )
    rates = "$u_j$ along $o_z$\n$u_{j+1}$ about $o_z$\n$j = 13, 15, 17$"
    text(ax, joint, rates, COLOURS["O"], (84, 22), 10.5)
    ax.set_title("One station: oleo frame O, carriage frame W, tire frame T", fontsize=11, pad=10)


def main() -> None:
    figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.3), width_ratios=(1.9, 1.0), layout="constrained")
    overview(axes[0])
    close_up(axes[1])
    for ax in axes:
        ax.set_aspect("equal")
        ax.axis("off")
    with whole_file(OUT) as path:
        figure.savefig(path, dpi=150, bbox_inches="tight", format="png")


if __name__ == "__main__":
    main()
