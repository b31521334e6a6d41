"""What section 3.2.2 says of manoeuvres 2A to 2C, made checkable."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from ssmash_gym.analysis.validation import planar_measures as measured
from ssmash_gym.analysis.validation.statements import Statement

REBUILT: Final = "claw history and vehicle"

# --- 2A ---------------------------------------------------------------------------------------------------------

BACK_TO_START: Final = Statement(
    thesis="the manoeuvre terminates with the RSD claw moving rearward to its approximate starting position",
    source="section 3.2.2, 2A",
    measure=measured.claw_path,
    words="forward by {far_m:.2f} m, {end_m:.2f} m from the start at the end",
    holds=lambda n: 0.6 <= n["far_m"] <= 0.7 and n["end_m"] < 0.2,
    taken_as="forward by 0.6 to 0.7 m (axis of figure 3.16), back to within 0.2 m",
    chosen="the claw history",
)
YAW_MAINTAINED: Final = Statement(
    thesis="the tail wheel is not allowed to rotate, so this orientation is maintained during the manoeuvre",
    source="section 3.2.2, 2A",
    measure=measured.yaw_swing,
    words="yaw {low_deg:.2f} to {high_deg:.2f} deg",
    holds=lambda n: n["high_deg"] - n["low_deg"] < 1.2,
    taken_as="yaw changes by less than the 1.2 deg of the axis of figure 3.19",
)
FX_RISES: Final = Statement(
    thesis="the rise of longitudinal force required to pull the helicopter forward",
    source="section 3.2.2, figure 3.17",
    measure=measured.fx_trend,
    words="x-force without fluctuation: {start_kN:.2f} kN at first, {forward_kN:.2f} kN forward, {back_kN:.2f} kN back",
    holds=lambda n: n["forward_kN"] > max(n["start_kN"], 0.0) + 1.0 and n["back_kN"] < 0.0,
    taken_as="it rises by more than 1 kN, and turns with the direction",
)
ONE_HERTZ: Final = Statement(
    thesis="significant force oscillations at approximately 1 Hz, likely corresponding to noise in the claw x position",
    source="section 3.2.2, figure 3.17",
    measure=measured.frequency,
    words="x-force fluctuates most at {force_hz:.2f} Hz, the claw at {claw_hz:.2f} Hz",
    holds=lambda n: 0.7 <= n["force_hz"] <= 1.3 and 0.7 <= n["claw_hz"] <= 1.3,
    taken_as="0.7 to 1.3 Hz",
    chosen="the band of the claw's noise",
)
FX_FLUCTUATES: Final = Statement(
    thesis="small oscillations in the claw position can cause large fluctuations in the probe force",
    source="section 3.2.2, 2A",
    measure=measured.fx_fluctuation,
    words="{claw_mm:.1f} mm rms of the claw, {force_kN:.2f} kN rms of x-force; its trend peaks at {trend_kN:.2f} kN",
    holds=lambda n: n["force_kN"] > 0.25 * n["trend_kN"],
    taken_as="the rms of the force exceeds a quarter of the peak of its trend",
    chosen="the size of the claw's noise",
)
FY_GROWS: Final = Statement(
    thesis="load increase and peak load of the probe y-force while the helicopter is pulled forward",
    source="section 3.2.2, figure 3.18",
    measure=measured.fy_forward,
    words="{at_5_kN:.1f}, {at_10_kN:.1f}, {at_15_kN:.1f}, {at_20_kN:.1f} kN at 5, 10, 15, 20 s; peak {peak_kN:.1f} kN",
    holds=lambda n: 0.0 > n["at_5_kN"] > n["at_10_kN"] > n["at_15_kN"] > n["at_20_kN"] > 1.1 * n["peak_kN"],
)
FY_RELEASED: Final = Statement(
    thesis="load release while the helicopter is traversed rearwards",
    source="section 3.2.2, figure 3.18",
    measure=measured.fy_back,
    words="{at_23_kN:.1f}, {at_28_kN:.1f}, {at_32_kN:.1f}, {at_36_kN:.1f} kN at 23, 28, 32, 36 s",
    holds=lambda n: n["at_23_kN"] < n["at_28_kN"] < n["at_32_kN"] < n["at_36_kN"],
)
DEFLECTION_STEADY: Final = Statement(
    thesis="the absence of large fluctuations [of lateral deflection]: the stiff probe makes those of the x-force",
    source="section 3.2.2, figure 3.20",
    measure=measured.shares,
    words="rms of the fluctuation over peak of the trend: deflection {deflection:.3f}, x-force {force:.2f}",
    holds=lambda n: n["deflection"] < 0.25 * n["force"],
    taken_as="a quarter of that of the x-force, or less",
)
OUT_OF_PLANE: Final = Statement(
    thesis="the changing vertical load confirms that out-of-plane helicopter response is present",
    source="section 3.2.2, figures 3.21, 3.28, 3.35",
    measure=measured.out_of_plane,
    words="vertical load varies by {right_kN:.1f} kN (right) and {left_kN:.1f} kN (left), roll by {roll_deg:.2f} deg",
    holds=lambda n: min(n["right_kN"], n["left_kN"]) > 1.0,
    taken_as="each main tire's load varies by more than 1 kN",
    note="Most of it is the moment of the probe's y-force at the height of the claw, and that height is assumed.",
)

# --- 2B ---------------------------------------------------------------------------------------------------------

YAW_REACHED: Final = Statement(
    thesis="the helicopter is yawed to nearly 90 degrees from an initial angle of approximately 9 degrees",
    source="section 3.2.2, 2B",
    measure=measured.yaw_end,
    words="from {start_deg:.1f} to {end_deg:.1f} deg",
    holds=lambda n: 80.0 <= n["end_deg"] <= 90.0,
    taken_as="80 to 90 deg at the end",
    chosen="the distance of the probe behind the main wheels",
)
TAIL_FOLLOWS: Final = Statement(
    thesis="tail wheel steer angle, down to about -90 deg",
    source="figure 3.26",
    measure=measured.steer_end,
    words="{end_deg:.1f} deg at the end",
    holds=lambda n: -100.0 <= n["end_deg"] <= -80.0,
    taken_as="-80 to -100 deg at the end: between the last two marks of the axis",
    basis="axis",
)
FX_OSCILLATES: Final = replace(
    FX_FLUCTUATES,
    thesis="the claw signal contains visible noise, so large fluctuations in the probe x force are expected",
    source="section 3.2.2, figures 3.22 and 3.23",
)
FX_POSITIVE: Final = Statement(
    thesis="it is not physically plausible for the probe x force to become negative because the claw traverses forward",
    source="section 3.2.2, figure 3.23",
    measure=measured.fx_least,
    words="x-force without fluctuation at least {trend_kN:.2f} kN (at {time_s:.0f} s), with it {least_kN:.2f} kN",
    holds=lambda n: n["trend_kN"] >= 0.0,
    taken_as="the force without fluctuation is never negative",
    note=(
        "The sentence is not strict: the x-axis is the helicopter's. A tail wheel that has steered out and is dragged "
        "sideways pushes the helicopter along that axis; in 2C the claw then holds it back while it moves forward."
    ),
)
CLAW_PULLS: Final = Statement(
    thesis="the force along the track is that of a claw which pulls forward",
    source="section 3.2.2, 2B",
    measure=measured.claw_pull,
    words="along the track, without fluctuation, {least_kN:.2f} to {greatest_kN:.2f} kN",
    holds=lambda n: n["least_kN"] > -0.05,
    taken_as="not below -0.05 kN without fluctuation: work is done on the helicopter throughout",
    basis="expected",
)
TIRES_ALIKE: Final = Statement(
    thesis="it is expected that similar deformation would be observed from both main tires",
    source="section 3.2.2, figure 3.27",
    measure=measured.tires_apart,
    words="at most {apart_mm:.1f} mm apart, greatest deflection {peak_mm:.1f} mm",
    holds=lambda n: n["apart_mm"] < 0.25 * n["peak_mm"],
    taken_as="apart by less than a quarter of the greatest deflection",
)
TWIST_MATTERS_LITTLE: Final = Statement(
    thesis="twist relaxes the tires when large yaw gain is accompanied by little forward traverse: not in 2B",
    source="section 3.2.2, summary",
    measure=measured.both_2B,
    words="mean deflection {coupled_mm:.1f} mm with and {uncoupled_mm:.1f} mm without twist in the friction limit",
    holds=lambda n: abs(n["coupled_mm"] - n["uncoupled_mm"]) < 0.25 * abs(n["uncoupled_mm"]),
    taken_as="the mean deflection of 2B changes by less than a quarter",
    basis="expected",
    needs=(measured.UNCOUPLED,),
)

# --- 2C ---------------------------------------------------------------------------------------------------------

TAIL_FLIPS: Final = Statement(
    thesis="nearly 180 degrees of tail wheel steer rotation",
    source="section 3.2.2, 2C",
    measure=measured.steer_end,
    words="{end_deg:.1f} deg at the end",
    holds=lambda n: -181.0 <= n["end_deg"] <= -160.0,
    taken_as="160 to 180 deg, to port",
    chosen="claw history, castor trail and joint friction",
)
TAIL_STAYS: Final = Statement(
    thesis="excellent correlation of [the thesis' simulated] steer angle with the trial but for 20 to 30 s",
    source="section 3.2.2, figure 3.34",
    measure=measured.uncoupled_steer,
    words="friction independent of twist: {end_deg:.1f} deg at the end",
    holds=lambda n: -181.0 <= n["end_deg"] <= -160.0,
    taken_as="160 to 180 deg, to port, as in the trial",
    note=(
        "The thesis has no limit of the twisting moment. That of the two tail tires, which have to turn on the spot, "
        "then grows to 2.5 times what friction could hold, and keeps the wheel from turning."
    ),
    needs=(measured.UNCOUPLED,),
)
PULL_FORWARD: Final = Statement(
    thesis="between 10 and 20 seconds a negative probe x force seems inconsistent: the probe is pulling forward",
    source="section 3.2.2, figure 3.30",
    measure=measured.pull_forward,
    words="claw {travel_m:.2f} m forward; x-force without fluctuation: mean {mean_kN:.2f} kN, least {least_kN:.2f} kN",
    holds=lambda n: n["mean_kN"] > 0.0 and n["least_kN"] >= 0.0,
    taken_as="the force without fluctuation is never negative in that time",
    note=(
        "A tail wheel that has steered out and is dragged sideways pushes the helicopter forward along its x-axis, "
        "and the claw holds it back: a negative x-force is no contradiction to a claw that moves forward."
    ),
)
YAW_RATE: Final = Statement(
    thesis="high yaw rates are achieved in this trial (20 to 32 s)",
    source="section 3.2.2, figure 3.33",
    measure=measured.yaw_rate,
    words="up to {rate_degps:.2f} deg/s at {time_s:.0f} s, above half of that until {last_s:.0f} s",
    holds=lambda n: 20.0 <= n["time_s"] <= 32.0 and n["last_s"] <= 34.0,
    taken_as="the greatest between 20 and 32 s, above half of it not after 34 s",
    chosen="the claw history",
)
DLTV_RELAXES: Final = Statement(
    thesis="from 20 to 30 s the lateral deflections in the DLTV trial are allowed to relax",
    source="section 3.2.2, figure 3.32",
    measure=measured.relaxation,
    words="greatest mean deflection {peak_mm:.1f} mm at {peak_s:.0f} s, less than a third of it from {relaxed_s:.0f} s",
    holds=lambda n: 20.0 <= n["relaxed_s"] <= 30.0,
    taken_as="less than a third of the greatest deflection is left before 30 s",
)
THESIS_HOLDS_ON: Final = Statement(
    thesis="whereas they further increase in the [thesis'] simulated response",
    source="section 3.2.2, figure 3.32",
    measure=measured.uncoupled_growth,
    words="friction independent of twist: {at_20_mm:.1f} mm at 20 s, {mean_mm:.1f} mm in the mean from then to 30 s",
    holds=lambda n: n["mean_mm"] > 1.25 * n["at_20_mm"] > 0.0,
    taken_as="the mean from 20 to 30 s is more than 1.25 times the deflection at 20 s",
    chosen="the claw history",
    needs=(measured.UNCOUPLED,),
)
THESIS_RELAXES: Final = Statement(
    thesis="[in the thesis] finally relaxed around 32 seconds, aligned with the final period of high yaw rate",
    source="section 3.2.2, 2C",
    measure=measured.uncoupled_relaxation,
    words=(
        "friction independent of twist: greatest {peak_mm:.1f} mm at {peak_s:.0f} s, less than a third from "
        "{relaxed_s:.0f} s; yaw rate high until {last_s:.0f} s"
    ),
    holds=lambda n: 29.0 <= n["relaxed_s"] <= 36.0,
    taken_as="less than a third of the greatest deflection is left first between 29 and 36 s",
    chosen="the claw history",
    needs=(measured.UNCOUPLED,),
)
TWIST_RELAXES: Final = Statement(
    thesis="twist-induced lateral tire relaxation accounts for the discrepancies of 20 to 30 s (recommendation 1)",
    source="section 3.2.2, summary; section 4.2",
    measure=measured.both_2C,
    words=(
        "mean from 20 to 30 s: deflection {coupled_mm:.1f} mm, y-force {coupled_kN:.1f} kN with twist in the friction "
        "limit; {uncoupled_mm:.1f} mm and {uncoupled_kN:.1f} kN without"
    ),
    holds=lambda n: n["coupled_mm"] < 0.75 * n["uncoupled_mm"] and abs(n["coupled_kN"]) < 0.75 * abs(n["uncoupled_kN"]),
    taken_as="both are smaller by a quarter or more with the coupling",
    note="The claw history was chosen for the deflection without the coupling, not for what the coupling does.",
    needs=(measured.UNCOUPLED,),
)
