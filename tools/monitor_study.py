"""Judges the deck monitor's probabilities by what happens: ``python tools/monitor_study.py --out runs/monitor``.

Seaways are drawn by seed; at several starts of each the monitor's futures are sampled from the past, copies of the
secured helicopter are driven through them, and one more copy through what the record really does. Rows are kept one
Parquet file a chunk of records, so that a study that was stopped goes on where it was; then come the figures
(``summary.json``), the picture and the tables in Markdown.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import polars as pl
import tyro

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import digest
from ssmash_gym.evaluation.statistics import Estimate
from ssmash_gym.files import whole_file, write_text
from ssmash_gym.monitor import Settings, scores
from ssmash_gym.monitor.futures import DeckModel, future_nodes, samples_ahead
from ssmash_gym.monitor.judging import JUDGED, NONE
from ssmash_gym.monitor.rehearsal import Copies, Scene, Shadow
from ssmash_gym.monitor.settings import SPACING_S
from ssmash_gym.progress import progress_bar
from ssmash_gym.ship import Motion, parse_motion
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, GRAVITY, pose_of

SEA_STATES: Final = (4, 5, 6)
FASTEST_KN: Final = 20.0
COMPONENTS: Final = 256  # waves of a sea: it does not repeat within a record
SETTLE_S: Final = 60.0  # how long the secured helicopter has been at sea before the first start
RMS_S: Final = 60.0  # what the rule to compare with looks back on
RAMP_S: Final = 8.0
HORIZONS_S: Final = (5.0, 10.0, 20.0, 45.0)
CHUNK: Final = 10  # records in a file of rows
# With the task's own 15 kN next to nothing happens in sea state 4: here something does and does not happen in each.
LIMITS: Final = {"probe_in_plane_kN": 6.0}


@dataclass(frozen=True)
class Study:
    """What is run.

    Attributes:
        seed: Of the seas and of the futures.
        records: Seaways.
        starts: Start times in each.
        every_s: Time between two of them [s]: no less than the horizon, so that what happens does not overlap.
        settings: Of the monitor.
    """

    seed: int = 20
    records: int = 100
    starts: int = 10
    every_s: float = 50.0
    settings: Settings = field(default_factory=lambda: Settings(limits=LIMITS))

    @property
    def identity(self) -> str:
        """Hash of everything that rows depend on; more records or another number of workers keep the old rows."""
        told = {key: value for key, value in asdict(self).items() if key not in ("records", "settings")}
        return digest(told, self.settings.answered_from)

    def sea(self, record: int) -> tuple[dict[str, Any], Motion]:
        """One seaway: its section and its motion."""
        rng = np.random.default_rng([self.seed, record])
        section = {
            "type": "seaway",
            "ship": "frigate",
            "sea_state": int(rng.choice(SEA_STATES)),
            "heading_deg": float(rng.uniform(0.0, 360.0)),
            "speed_kn": float(rng.uniform(0.0, FASTEST_KN)),
            "components": COMPONENTS,
        }
        return section, parse_motion(section).realise(rng)


# --- rows -------------------------------------------------------------------------------------------------------


def chunk_rows(study: Study, records: list[int], scene: Scene) -> pl.DataFrame:
    """One row a start of the listed records: what was foreseen and what has happened."""
    settings, seas = study.settings, [study.sea(record) for record in records]
    shadow = Shadow(scene, len(records), settings.threads)
    copies = Copies(scene, len(records) * (settings.copies + 1), settings.threads)
    of = np.repeat(np.arange(len(records)), settings.copies + 1)
    rows: list[dict[str, Any]] = []
    begun_s = settings.past_s - SETTLE_S
    for start in range(study.starts):
        now_s = settings.past_s + start * study.every_s
        ramp_s = RAMP_S if start == 0 else 0.0
        past_s = now_s - begun_s
        pieces = [sea.bake(past_s, ramp_s=ramp_s, start_s=begun_s).nodes for _, sea in seas]
        shadow.advance(np.stack(pieces), round(past_s / scene.task.control_interval_s))
        begun_s = now_s
        told = [ahead(study, record, sea, now_s) for record, (_, sea) in zip(records, seas, strict=True)]
        nodes = np.concatenate([np.concatenate([futures, truth]) for futures, truth, _ in told])
        found = copies.drive(shadow.snapshot(), of, nodes, settings.horizon_s)
        first_s = found.first_s.reshape(len(records), -1)
        limit = found.limit.reshape(len(records), -1)
        for k, (record, (section, _), (_, _, severity)) in enumerate(zip(records, seas, told, strict=True)):
            rows.append(
                {
                    "record": record, "start_s": now_s, "lost": bool(shadow.lost(k)), **severity,
                    "sea_state": section["sea_state"], "heading_deg": section["heading_deg"],
                    "speed_kn": section["speed_kn"], "true_s": float(first_s[k, -1]),
                    "true_limit": _name(limit[k, -1]), "first_s": first_s[k, :-1].tolist(),
                    "limits": [_name(which) for which in limit[k, :-1]],
                }
            )  # fmt: skip
    return pl.DataFrame(rows)


def ahead(study: Study, record: int, sea: Motion, now_s: float) -> tuple[Any, Any, dict[str, float]]:
    """Nodes of the futures, nodes of the truth, and the severity of the last minute."""
    settings = study.settings
    count = round(settings.past_s / SPACING_S)
    past = sea.sample(now_s - (count - 1) * SPACING_S, SPACING_S, count)
    series = np.concatenate([past.rate[:, :3], past.position[:, 3:]], axis=1)
    rng = np.random.default_rng([study.seed, record, round(now_s)])
    sampled = DeckModel.fit(series).sample(settings.copies, samples_ahead(settings.horizon_s), rng)[1:]
    nodes = future_nodes(series, sampled, math.ceil(settings.horizon_s / DEFAULT_SPACING_S) + 1)
    truth = sea.bake(settings.horizon_s, start_s=now_s).nodes[np.newaxis, : nodes.shape[1]]
    last = round(RMS_S / SPACING_S)
    lateral_g = pose_of(past).specific_force_S(GRAVITY)[-last:, 1] / GRAVITY
    return nodes, truth, {
        "rms_lateral_g": float(np.std(lateral_g)),
        "rms_roll_deg": float(np.rad2deg(np.std(past.position[-last:, 3]))),
    }  # fmt: skip


def _name(which: int) -> str:
    return "" if which == NONE else JUDGED[which]


def run(study: Study, out: Path) -> pl.DataFrame:
    """Run what has not been run, and read all rows.

    Raises:
        ConfigurationError: The folder holds rows of another study.
    """
    folder = out / "rows"
    folder.mkdir(parents=True, exist_ok=True)
    about = out / "study.json"
    if about.is_file() and json.loads(about.read_text(encoding="utf-8"))["identity"] != study.identity:
        raise ConfigurationError(f"{out}: this folder holds rows of another study; give another one.")
    write_text(about, json.dumps({"identity": study.identity, **asdict(study)}, indent=1) + "\n")
    scene = Scene.of(study.settings)
    frames = []
    with progress_bar("monitor study") as advance:
        for first in range(0, study.records, CHUNK):
            records = list(range(first, min(first + CHUNK, study.records)))
            path = folder / f"{first:04d}-{len(records)}.parquet"
            if not path.is_file():
                with whole_file(path) as temporary:
                    chunk_rows(study, records, scene).write_parquet(temporary)
            frames.append(pl.read_parquet(path))
            advance((first + len(records)) / study.records)
    return pl.concat(frames)


# --- figures ----------------------------------------------------------------------------------------------------


def summary(study: Study, rows: pl.DataFrame) -> dict[str, Any]:
    """All figures of a study: plain numbers, intervals as three of them."""
    sound = rows.filter(~pl.col("lost"))
    horizons = sorted({h for h in HORIZONS_S if h < study.settings.horizon_s} | {study.settings.horizon_s})
    met = sound.filter(pl.col("true_limit") != "")["true_limit"].value_counts(sort=True).rows()
    return {
        "identity": study.identity,
        "study": asdict(study),
        "records": rows["record"].n_unique(),
        "starts": sound.height,
        "lost": rows.height - sound.height,
        "first_limit": dict(met),
        "horizons": [at_horizon(study, sound, horizon) for horizon in horizons],
    }


def at_horizon(study: Study, rows: pl.DataFrame, horizon_s: float) -> dict[str, Any]:
    """Figures of one horizon: scores of the monitor and of the rules that it is compared with."""
    said, happened = foreseen(rows, horizon_s)
    records = rows["record"].to_numpy()
    rms = np.log(np.maximum(rows.select("rms_lateral_g", "rms_roll_deg").to_numpy(), 1e-9))
    log_odds = scores.logit(said, study.settings.copies)[:, np.newaxis]
    rules = {
        "base_rate": scores.base_rate(records, rows["sea_state"].to_numpy(), happened),
        "rms_rule": scores.left_out(records, rms, happened),
        "monitor_fitted": scores.left_out(records, log_odds, happened),
        "monitor_and_rms": scores.left_out(records, np.column_stack([rms, log_odds]), happened),
    }
    told: dict[str, Any] = {"horizon_s": horizon_s, "happened": float(np.mean(happened)), "said": float(np.mean(said))}
    for name, probabilities in {"monitor": said, **rules}.items():
        told[f"brier_{name}"] = _three(
            scores.by_records(records, lambda k, p=probabilities: scores.brier(p[k], happened[k]))
        )
    for name, better, worse in (
        ("monitor_over_base_rate", said, rules["base_rate"]),
        ("monitor_over_rms_rule", said, rules["rms_rule"]),
        ("fitted_over_rms_rule", rules["monitor_fitted"], rules["rms_rule"]),
        ("both_over_rms_rule", rules["monitor_and_rms"], rules["rms_rule"]),
    ):
        told[f"skill_{name}"] = _three(scores.by_records(records, scores.skill(better, worse, happened)))
    told["reliability"] = [asdict(b) for b in scores.reliability(said, happened)]
    told["reliability_rms_rule"] = [asdict(b) for b in scores.reliability(rules["rms_rule"], happened)]
    told["by_sea_state"] = {
        str(state): [int(np.sum(here)), float(np.mean(happened[here])), float(np.mean(said[here]))]
        for state in SEA_STATES
        if (here := rows["sea_state"].to_numpy() == state).any()
    }
    return told


def foreseen(rows: pl.DataFrame, horizon_s: float) -> tuple[Any, Any]:
    """Share of the copies that exceed a limit within a horizon, and whether the truth has, (n,) each."""
    first = np.stack(rows["first_s"].to_numpy())
    return np.mean(first <= horizon_s + 1e-9, axis=1), (rows["true_s"].to_numpy() <= horizon_s + 1e-9).astype(float)


def _three(estimate: Estimate) -> list[float | None]:
    return [None if math.isnan(value) else value for value in (estimate.value, estimate.low, estimate.high)]


def _words(three: list[float | None], digits: int) -> str:
    value, low, high = ("-" if number is None else f"{number:.{digits}f}" for number in three)
    return f"{value} ({low} to {high})"


def tables(told: dict[str, Any]) -> str:
    """The figures as Markdown."""
    lines = [
        "| Horizon [s] | exceeded / foreseen | Brier: monitor | base rate | RMS rule | skill over base rate "
        "| skill over RMS rule | both together over RMS rule |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for h in told["horizons"]:
        cells = [h[f"brier_{name}"] for name in ("monitor", "base_rate", "rms_rule")]
        skills = [h[f"skill_{n}"] for n in ("monitor_over_base_rate", "monitor_over_rms_rule", "both_over_rms_rule")]
        words = [f"{h['horizon_s']:g}", f"{h['happened']:.3f} / {h['said']:.3f}"]
        words += [_words(cell, 3) for cell in cells]
        words += [_words(cell, 2) for cell in skills]
        lines.append("| " + " | ".join(words) + " |")
    lines += ["", "| Foreseen, 45 s | starts | exceeded |", "|---|---|---|"]
    for b in told["horizons"][-1]["reliability"]:
        happened = b["happened"]
        lines.append(
            f"| {b['said']:.2f} | {b['count']} | {happened['value']:.2f} ({happened['low']:.2f} to "
            f"{happened['high']:.2f}) |"
        )
    return "\n".join(lines) + "\n"


def picture(told: dict[str, Any], path: Path) -> None:
    """Reliability at every horizon, with counts."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    count = len(told["horizons"])
    figure, axes = plt.subplots(2, count, figsize=(3.0 * count, 4.6), height_ratios=(3, 1), squeeze=False)
    for (top, below), h in zip(axes.T, told["horizons"], strict=True):
        top.plot([0, 1], [0, 1], color="0.6", linewidth=1)
        for key, label, colour in (
            ("reliability", "monitor", "tab:blue"),
            ("reliability_rms_rule", "RMS rule", "tab:orange"),
        ):
            said = [b["said"] for b in h[key]]
            value = np.array([[b["happened"][k] for k in ("value", "low", "high")] for b in h[key]])
            error = np.maximum(np.abs(value[:, 1:] - value[:, :1]).T, 0.0)
            top.errorbar(said, value[:, 0], error, marker="o", markersize=3, linewidth=1, color=colour, label=label)
        top.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.02), title=f"within {h['horizon_s']:g} s", aspect="equal")
        below.bar([b["said"] for b in h["reliability"]], [b["count"] for b in h["reliability"]], 0.06, log=True)
        below.set(xlim=(-0.02, 1.02), xlabel="foreseen")
    axes[0, 0].set_ylabel("exceeded")
    axes[0, 0].legend(loc="upper left", fontsize="small")
    axes[1, 0].set_ylabel("starts")
    figure.tight_layout()
    with whole_file(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110)
    plt.close(figure)


def main(
    out: Path,
    study: Annotated[Study, tyro.conf.arg(name="")] = Study(),
    plot: Path | None = None,
) -> None:
    """Run the study, or what is left of it, and write its figures.

    Args:
        out: Folder of the rows and the figures.
        study: What is run.
        plot: PNG with the reliability curves.
    """
    rows = run(study, out)
    told = summary(study, rows)
    write_text(out / "summary.json", json.dumps(told, indent=1) + "\n")
    write_text(out / "tables.md", tables(told))
    if plot is not None:
        picture(told, plot)
    print(tables(told))


if __name__ == "__main__":
    tyro.cli(main)
