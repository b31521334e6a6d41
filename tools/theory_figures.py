"""Makes the figures of the force elements' theory, docs/images/theory_*.png, with the project's own kernels.

    python tools/theory_figures.py               # all of them, and the numbers that the pages quote
    python tools/theory_figures.py probe oleo    # some

The kernels run uncompiled, on NumPy arrays. The tire is a 26x10.0-11 at 140 psi, the struts and the probe are those of
the catalogue helicopters with the changes that tools/theory_rig.py states.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from theory_rig import (
    ALIKE,
    POUND,
    PROBE,
    PSI,
    STRUT,
    column,
    deflection_at,
    dragged,
    elastic,
    loop_work,
    nose_strut,
    on_deck,
    printed_steps,
    probe_force,
    rolled,
    tire_block,
)

from ssmash_gym.dynamics import oleo as oleos
from ssmash_gym.dynamics import probe as probes
from ssmash_gym.dynamics import tire as tires
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import PARAMETER_ROWS, Friction, Par, Sta, Tir
from ssmash_gym.dynamics.patch import patch_factor
from ssmash_gym.dynamics.steering import play_moment, steer_moment
from ssmash_gym.files import whole_file

IMAGES: Final = Path(__file__).resolve().parent.parent / "docs" / "images"
BLUE, RED, GREEN, PINK, GREY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "0.45"


def panels(n: int, width: float = 9.4, height: float = 3.7) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(1, n, squeeze=False)[0]
    for place in axes:
        place.grid(alpha=0.3)
    return figure, axes


def tire_vertical() -> Figure:
    figure, (force, stiffness) = panels(2)
    dz = np.linspace(1e-5, 0.17, 1200)
    tail = {"diameter_m": 0.4445, "width_m": 0.155, "bottoming_deflection_m": 0.0394}
    main = {"pressure_Pa": 110 * PSI, "rated_pressure_Pa": 110 * PSI, "bottoming_deflection_m": 0.1448}
    for colour, name, changes, row, end in (
        (BLUE, "26x10.0-11, 110 psi", main, (0.066, 9700), 0.17),
        (RED, "17.5x6.25-11, 140 psi", tail, (0.0203, 2750), 0.05),
    ):
        p = tire_block(**changes)
        x = dz[dz < end]
        force.plot(1e3 * x, 1e-3 * elastic(p, x).F_z, color=colour, label=name)
        border = 10.0 / 3.0 * p[Tir.CTZ, 0] * p[Tir.WIDTH, 0]
        force.plot(1e3 * border, 1e-3 * elastic(p, np.array([border])).F_z, "|", color=colour, markersize=14)
        force.plot(1e3 * row[0], 1e-3 * POUND * row[1], "o", color=colour, markerfacecolor="none")
    force.plot([], [], "o", color=GREY, markerfacecolor="none", label="rated load of the catalogue")
    force.plot([], [], "|", color=GREY, markersize=14, label=r"$\delta_z/w_t = 10\, C_{tz}/3$")
    force.set(xlabel="vertical deflection [mm]", ylabel="vertical force [kN]", xlim=(0, 170), ylim=(0, 260))
    force.set_title("vertical force (2.122), rim included", fontsize=10)
    force.legend(fontsize=8)
    e = elastic(tire_block(), dz)
    for values, colour, name in ((e.k_x, BLUE, "$K_{tx}$ [MN/m]"), (e.k_y, RED, "$K_{ty}$ [MN/m]")):
        stiffness.plot(1e3 * dz, 1e-6 * values, color=colour, label=name)
    stiffness.plot(1e3 * dz, 1e-5 * e.k_psi, color=GREEN, label=r"$K_{t\psi}$ [100 kN m/rad]")
    stiffness.set(xlabel="vertical deflection [mm]", xlim=(0, 170), ylim=(0, None))
    stiffness.set_title("stiffnesses of 26x10.0-11, 140 psi", fontsize=10)
    stiffness.legend(fontsize=8)
    return figure


def tire_lateral() -> Figure:
    figure, (force, moment) = panels(2)
    one, angle = tire_block(), np.deg2rad(np.linspace(0.05, 14.0, 90))
    p = tire_block(angle.size)
    v = np.array([np.full(angle.size, 0.3), 0.3 * np.tan(angle)])
    for load, colour in ((15e3, BLUE), (30e3, RED), (45e3, GREEN)):
        dz = deflection_at(one, load)
        e = elastic(one, np.array([dz]))
        grip = one[Tir.MU, 0] * load
        phi = e.k_y * e.L_0 * angle / grip
        law = grip * uncompiled(tires.yawed_force)(phi)
        limited = -on_deck(p, dz, v, rolled(p, dz, v, 4.0)).F_y
        force.plot(np.rad2deg(angle), 1e-3 * law, color=colour)
        force.plot(np.rad2deg(angle), 1e-3 * limited, "--", color=colour)
        moment.plot(
            np.rad2deg(angle), grip * e.L_h * uncompiled(tires.yawed_moment)(phi), color=colour,
            label=f"{load / 1e3:g} kN",
        )  # fmt: skip
        if load == 30e3:
            least = (limited / law).argmin()
            print(
                f"30 kN: dz {1e3 * dz:.2f} mm, k_y {1e-3 * e.k_y[0]:.1f}, k_x {1e-3 * e.k_x[0]:.1f} kN/m, "
                f"k_psi {1e-3 * e.k_psi[0]:.2f} kN m/rad, N {1e-3 * e.k_y[0] * e.L_0[0]:.1f} kN/rad, "
                f"L_y {e.L_y[0]:.3f}, L_u {e.L_u[0]:.3f}, L_h {e.L_h[0]:.3f}, b_t {e.b_t[0]:.3f} m, "
                f"saturation {np.rad2deg(1.5 * angle[0] / phi[0]):.2f} deg"
            )
            print(f"limit surface: {(limited / law)[least]:.4f} of (2.137) at phi = {phi[least]:.2f}")
    force.plot([], [], color=GREY, label="(2.137)")
    force.plot([], [], "--", color=GREY, label="with the limit surface")
    force.set(xlabel="slip angle [deg]", ylabel="steady lateral force [kN]", xlim=(0, 14), ylim=(0, None))
    force.legend(fontsize=8)
    moment.set(xlabel="slip angle [deg]", ylabel="steady twisting moment (2.142) [N m]", xlim=(0, 14), ylim=(0, None))
    moment.legend(fontsize=8, title="vertical force")
    return figure


def tire_relaxation() -> Figure:
    figure, (lengths, saturated) = panels(2)
    one = tire_block()
    d, w = one[Tir.DIAMETER, 0], one[Tir.WIDTH, 0]
    dz = np.linspace(1e-4, 0.26 * d, 1200)
    e = elastic(one, dz)
    for values, style, name in (
        (e.L_y, BLUE, "$L_y$ (2.129)"), (e.L_u, RED, "$L_u$ (2.128)"), (e.L_h, GREEN, "$L_h$ (2.126)"),
        (e.L_y + e.L_h, "k", r"$\sigma(0) = L_y + L_h$"),
    ):  # fmt: skip
        lengths.plot(dz / d, values, color=style, label=name)
    lengths.axhline(0.05 * w, color=GREY, linestyle=":", label="floor $0.05\\, w_t$")
    lengths.set(xlabel=r"$\delta_z / d_t$", ylabel="length [m]", xlim=(0, 0.26), ylim=(0, None))
    lengths.legend(fontsize=8)
    angle = np.deg2rad(np.linspace(0.05, 40.0, 400))
    for load, colour in ((15e3, BLUE), (30e3, RED), (45e3, GREEN)):
        dz = deflection_at(one, load)
        e = elastic(one, np.array([dz]))
        slide = one[Tir.MU] * load / e.k_y
        v_x, v_y, n = np.ones(angle.size), np.tan(angle), np.ones(angle.size)
        rate, _, _ = uncompiled(tires.yawed_rolling)(
            v_x, v_y, v_x, (e.L_0 * n, e.L_y * n, e.L_u * n), slide * n, 1.0 / slide * n, one[Tir.SIGMA_MIN] * n
        )
        saturated.plot(np.rad2deg(angle), 1.0 / rate, color=colour, label=f"{load / 1e3:g} kN")
    saturated.set(xlabel="slip angle [deg]", ylabel=r"relaxation length $\sigma$ [m]", xlim=(0, 40), ylim=(0, None))
    saturated.legend(fontsize=8, title="vertical force")
    return figure


def tire_rolling() -> Figure:
    figure, (printed, distance) = panels(2)
    load, angle = 30e3, np.deg2rad(2.0)
    free, one = tire_block(pull_back_rate_ps=1e-9), tire_block()
    dz = deflection_at(one, load)
    e = elastic(one, np.array([dz]))
    grip = one[Tir.MU, 0] * load
    share = float(uncompiled(tires.yawed_force)(e.k_y * e.L_0 * angle / grip)[0])
    steady = -grip * share / e.k_y[0]
    metres = np.linspace(0.005, 2.5, 200)
    for step, colour in ((0.05, PINK), (0.3, RED), (1.0, GREEN)):
        x, d = printed_steps(e, steady, np.tan(angle), step, 2.5)
        printed.plot(
            x, -1e-3 * e.k_y * d, ".-", markersize=3 if step < 0.1 else 6, color=colour,
            label=f"printed, steps of {step:g} m",
        )  # fmt: skip
        print(f"printed stepping, {step:g} m: {d[-1] / steady:.3f} times (2.137)")
    print(f"printed stepping, fine steps: {1 + e.L_y[0] / e.L_0[0]:.3f} times (2.137)")
    for speed, style, name in ((0.2, "k", "state equation, 0.2 m/s"), (4.0, "w:", "state equation, 4 m/s")):
        v = (np.array([speed]), np.array([speed * np.tan(angle)]))
        printed.plot(metres, -1e-3 * e.k_y * rolled(free, dz, v, metres)[1, 0], style, label=name, linewidth=2)
    printed.axhline(1e-3 * grip * share, color=GREY, linestyle="--", label="(2.137)")
    printed.set(xlabel="distance rolled [m]", ylabel="lateral force [kN]", xlim=(0, 2.5), ylim=(0, 44))
    printed.set_title("2 deg of slip from rest, 30 kN", fontsize=10)
    printed.legend(fontsize=8, ncols=2, loc="upper center").get_frame().set_facecolor("0.85")
    for degrees, colour in ((1, BLUE), (2, "k"), (4, RED), (8, GREEN)):
        v = (np.array([0.2]), np.array([0.2 * np.tan(np.deg2rad(degrees))]))
        states = rolled(one, dz, v, metres)
        shares = [-on_deck(one, dz, v, states[:, :, k]).F_y[0] / grip for k in range(metres.size)]
        distance.plot(metres, shares, color=colour, label=f"{degrees} deg")
    distance.set(xlabel="distance rolled [m]", ylabel=r"lateral force over $\mu F_z$", xlim=(0, 2.5), ylim=(0, 1.05))
    distance.set_title("the state equation at four slip angles", fontsize=10)
    distance.legend(fontsize=8)
    return figure


def tire_limit() -> Figure:
    figure, (cut, forces) = panels(2)
    dz = deflection_at(tire_block(), 30e3)
    e = elastic(tire_block(), np.array([dz]))
    grip = 0.8 * 30e3
    most = 2.0 / 3.0 * grip * float(0.5 * e.L_h[0] + 0.25 * e.b_t[0])
    psi = np.linspace(0.0, 0.35, 400)
    p = tire_block(psi.size)
    state = (0.0, np.full(psi.size, 0.8 * grip / e.k_y[0]), psi)
    names = {Friction.LIMIT_SURFACE: "limit_surface", Friction.FRICTION_CIRCLE: "friction_circle",
             Friction.INDEPENDENT: "independent"}  # fmt: skip
    for (friction, name), colour, style in zip(names.items(), (BLUE, RED, GREEN), ("-", "--", ":"), strict=True):
        a = on_deck(p, dz, (0.0, 0.0), state, friction=friction)
        cut.plot(a.F_y / grip, a.M_z / most, style, color=colour, linewidth=2, label=name)
        forces.plot(np.rad2deg(psi), 1e-3 * a.F_y, style, color=colour, linewidth=2)
    turn = np.linspace(0.0, 0.5 * np.pi, 200)
    cut.plot(np.cos(turn), np.sin(turn), color=GREY, linewidth=0.8, label="$u = 1$")
    cut.plot(0.8, 0.0, "ko", markersize=4)
    cut.set(xlabel=r"lateral force over $\mu F_z$", ylabel=r"twisting moment over $M_{max}$", xlim=(0, 1.05),
            ylim=(0, 1.8))  # fmt: skip
    cut.legend(fontsize=8, loc="upper left")
    forces.set(xlabel="twist [deg]", ylabel="lateral force [kN]", xlim=(0, 20), ylim=(0, 21))
    forces.set_title("standing tire pushed aside, then turned in place", fontsize=10)
    return figure


def oleo() -> Figure:
    figure, (spring, damping) = panels(2)
    p = nose_strut(STRUT)
    x = np.linspace(-0.006, 0.42, 1500)
    spring.plot(1e3 * x, 1e-3 * uncompiled(oleos.spring)(p, 0, x), color=BLUE)
    borders = [0.0, *(float(p[row, 0]) for row in (Sta.X0, Sta.X1, Sta.X2))]
    for border, name in zip(borders, ("", "$x_0$", "$x_1$", "$x_2$"), strict=True):
        spring.axvline(1e3 * border, color=GREY, linewidth=0.8, linestyle=":")
        spring.text(1e3 * border + 3, 2.0, name, fontsize=9)
    for place, name in zip((-0.014, 0.0, 0.14, 0.325, 0.39), "12345", strict=True):
        spring.text(1e3 * place, 92, name, fontsize=10, color=RED, ha="center" if name > "2" else "left")
    spring.set(xlabel="compression [mm]", ylabel="spring force [kN]", xlim=(-16, 420), ylim=(-22, 100))
    spring.set_title("the five regions of (2.203)-(2.207)", fontsize=10)
    v = np.linspace(-1.2, 2.8, 3000)
    p[Sta.SEAL] = p[Sta.BEARING_MU] = p[Sta.STOP_K] = p[Sta.STOP_C] = 0.0
    force = uncompiled(oleos.gas_oleo)(p, 0, 0.0 * v, v, 0.0 * v)[0]
    up = v[v >= 0.0]
    for k, colour in ((1, RED), (4, GREEN), (7, PINK)):
        c = [float(p[Sta[f"C{k + j}"], 0]) for j in range(3)]
        damping.plot(up, 1e-3 * (c[0] + c[1] * up + c[2] * up**2), "--", linewidth=1, color=colour,
                     label=f"$F_{(k + 2) // 3}$: $c_{k}, c_{k + 1}, c_{k + 2}$")  # fmt: skip
    for row, name in ((Sta.REL1, "$F_{d,rel1}$"), (Sta.REL2, "$F_{d,rel2}$")):
        damping.axhline(1e-3 * float(p[row, 0]), color=GREY, linewidth=0.8, linestyle=":")
        damping.text(-1.15, 1e-3 * float(p[row, 0]) + 0.15, name, fontsize=9)
    damping.plot(v, 1e-3 * force, color=BLUE, linewidth=2, label="damping of the model")
    damping.set(xlabel="compression rate [m/s]", ylabel="damping force [kN]", xlim=(-1.2, 2.8), ylim=(-9, 9))
    damping.set_title("rebound (2.212) and staged compression (2.213)", fontsize=10)
    damping.legend(fontsize=8, loc="lower right")
    return figure


def friction() -> Figure:
    figure, (smooth, creep) = panels(2)
    v = np.linspace(-0.15, 0.15, 1201)
    w = np.maximum(np.abs(v), 1e-9)
    for beta, colour in ((10.0, GREEN), (30.0, RED), (100.0, BLUE)):
        slope = uncompiled(oleos.friction_slope)(beta, w, 1.0 / w)
        smooth.plot(v, slope * v, color=colour, label=rf"$\beta$ = {beta:g} s/m")
        share = np.linspace(0.0, 0.999, 500)
        creep.plot(share, -1e3 * np.log1p(-share) / beta, color=colour)
    smooth.set(xlabel="speed [m/s]", ylabel="friction over its full value", xlim=(-0.15, 0.15))
    smooth.set_title(r"sign(v) (1 - exp(-$\beta$|v|)), (2.8)", fontsize=10)
    smooth.legend(fontsize=8)
    creep.set(xlabel="steady load over full friction", ylabel="speed of the creep [mm/s]", xlim=(0, 1), ylim=(0.1, 1e3))
    creep.set_yscale("log")
    creep.set_title("a load below the friction creeps", fontsize=10)
    return figure


def probe() -> Figure:
    figure = Figure(figsize=(9.4, 6.8), layout="constrained")
    (alike, unlike), (turning, axial) = figure.subplots(2, 2)
    r = np.linspace(1e-6, 0.025, 400)
    angle = np.linspace(0.0, 0.5 * np.pi, 181)
    d = 0.02 * np.array([np.cos(angle), np.sin(angle)])
    for law, colour, style in (("potential", BLUE, "-"), ("ellipse", GREEN, "--"), ("printed", RED, "-.")):
        for place, changes in ((alike, ALIKE), (unlike, PROBE)):
            diagonal = np.sqrt(0.5) * np.array([r, r])
            along = -np.sum(probe_force(changes, diagonal, law) * diagonal, axis=0) / r
            place.plot(1e3 * r, 1e-3 * along, style, color=colour, label=law)
        F = -probe_force(PROBE, d, law)
        turning.plot(np.rad2deg(angle), np.rad2deg(np.arctan2(F[1], F[0]) - angle), style, color=colour, label=law)
        print(f"probe, {law}: net work of a loop over the work turned over {loop_work(law):.4f}")
    p, x = column("generic_tricycle", "probe.", PROBE), np.linspace(-0.004, 0.025, 600)
    for rate, colour in ((-0.3, GREEN), (0.0, BLUE), (0.3, RED)):
        tension = uncompiled(probes.axial_tension)(p, x, rate + 0.0 * x)
        axial.plot(1e3 * x, 1e-3 * tension, color=colour, label=f"{rate:g} m/s")
    for place, name in ((alike, "x and y alike, at 45 deg"), (unlike, "y twice as stiff, at 45 deg")):
        place.set(xlabel="displacement [mm]", ylabel="in-plane force along it [kN]", xlim=(0, 25), ylim=(0, 32))
        place.set_title(name, fontsize=10)
    turning.set(xlabel="direction of the displacement [deg]", ylabel="force off the displacement [deg]", xlim=(0, 90))
    turning.set_title("y twice as stiff, 20 mm", fontsize=10)
    axial.set(xlabel="extension [mm]", ylabel="tension [kN]", xlim=(-4, 25), ylim=(0, None))
    axial.set_title("axial force at three extension rates", fontsize=10)
    for place in (alike, unlike, turning, axial):
        place.grid(alpha=0.3)
        place.legend(fontsize=8)
    return figure


def steering() -> Figure:
    figure, (resisting, play) = panels(2)
    p = nose_strut({})
    rate = np.linspace(-1.0, 1.0, 801)
    for force, colour in ((0.0, GREY), (5e3, GREEN), (10e3, RED), (20e3, BLUE)):
        moment = uncompiled(steer_moment)(p, 0, rate, force + 0.0 * rate)[0]
        resisting.plot(rate, moment, color=colour, label=f"{1e-3 * force:g} kN")
    resisting.set(xlabel="steer rate [rad/s]", ylabel="moment [N m]", xlim=(-1, 1))
    resisting.set_title("friction and damping (2.163), nose of generic_tricycle", fontsize=10)
    resisting.legend(fontsize=8, title="in-plane tire force")
    p[Sta.STEER_PLAY], p[Sta.STEER_STOP_K], p[Sta.STEER_STOP_C] = np.deg2rad(2.0), 2.0e4, 200.0
    p[Sta.STEER_COS], p[Sta.STEER_SIN] = 1.0, 0.0
    angle = np.deg2rad(np.linspace(-5.0, 5.0, 1201))
    for turn, colour in ((-1.0, GREEN), (0.0, BLUE), (1.0, RED)):
        moment = uncompiled(play_moment)(p, 0, np.cos(0.5 * angle), np.sin(0.5 * angle), turn + 0.0 * angle)[0]
        play.plot(np.rad2deg(angle), 1e-3 * moment, color=colour, label=f"{turn:g} rad/s")
    play.set(xlabel="steer angle from the lock [deg]", ylabel="moment [kN m]", xlim=(-5, 5))
    play.set_title("free play of 2 deg, 20 kN m/rad, 200 N m s/rad", fontsize=10)
    play.legend(fontsize=8)
    return figure


def patch() -> Figure:
    figure, (factor, force) = panels(2)
    p = np.zeros((PARAMETER_ROWS, 1))
    p[Par.PATCH_X_MIN], p[Par.PATCH_X_MAX], p[Par.PATCH_Y_MIN], p[Par.PATCH_Y_MAX] = 0.5, 1.5, -1.0, 1.0
    p[Par.PATCH_LOSS], tire = 0.7, tire_block()
    x, dz = np.linspace(0.0, 2.0, 500), deflection_at(tire_block(), 30e3)
    for edge, colour in ((0.02, BLUE), (0.2, RED)):
        p[Par.PATCH_EDGE] = edge

        def on_patch(place: Any) -> Any:
            return uncompiled(patch_factor)(p, place, 0.0 * place)

        factor.plot(x, on_patch(x), color=colour, label=f"edge {1e3 * edge:g} mm")
        force.plot(x, -1e-3 * dragged(tire, dz, 0.2, on_patch, x), color=colour)
    factor.set(xlabel="x over the deck [m]", ylabel="factor of the friction coefficient", xlim=(0, 2), ylim=(0, 1.05))
    factor.legend(fontsize=8)
    force.set(xlabel="x over the deck [m]", ylabel="force of the locked tire [kN]", xlim=(0, 2), ylim=(0, 26))
    force.set_title("dragged ahead at 0.2 m/s under 30 kN", fontsize=10)
    return figure


FIGURES: Final[dict[str, Callable[[], Figure]]] = {
    "tire_vertical": tire_vertical,
    "tire_lateral": tire_lateral,
    "tire_relaxation": tire_relaxation,
    "tire_rolling": tire_rolling,
    "tire_limit": tire_limit,
    "oleo": oleo,
    "friction": friction,
    "probe": probe,
    "steering": steering,
    "patch": patch,
}


def main(names: list[str]) -> int:
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        print(f"no figure {', '.join(unknown)}: there are {', '.join(FIGURES)}", file=sys.stderr)
        return 2
    for name in names or FIGURES:
        drawn = BytesIO()
        FIGURES[name]().savefig(drawn, format="png", dpi=100)
        with whole_file(IMAGES / f"theory_{name}.png") as path:  # a palette: half the size, looks the same
            Image.open(drawn).convert("RGB").quantize(192).save(path, format="png", optimize=True)
        print(f"docs/images/theory_{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
