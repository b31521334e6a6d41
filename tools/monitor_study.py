"""Judges the deck monitor's probabilities by what happens: ``python -m tools.monitor_study --out runs/monitor``.

Seaways are drawn by seed; at several starts of each the monitor's futures are sampled from the past, copies of the
secured helicopter are driven through them, and one more copy through what the record really does. To tell what the
forecast is worth, and what the simulation, copies are also driven through the record from many earlier times: the share
of those that exceeded a limit (`rehearsed past`) knows how severe the sea is and nothing of its future. Rows are kept
one Parquet file a chunk of records, so that a study that was stopped goes on where it was; then come the figures
(``summary.json``), the picture and the tables in Markdown.
"""

from __future__ import annotations

import itertools
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
from ssmash_gym.evaluation.statistics import Estimate, share
from ssmash_gym.files import whole_file, write_text
from ssmash_gym.monitor import Settings, scores
from ssmash_gym.monitor.futures import DeckModel, future_nodes, samples_ahead
from ssmash_gym.monitor.judging import JUDGED, NONE
from ssmash_gym.monitor.rehearsal import Copies, Scene, Shadow
from ssmash_gym.monitor.settings import SPACING_S
from ssmash_gym.progress import progress_bar
from ssmash_gym.ship import Motion, parse_motion
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, GRAVITY, pose_of
from tools.monitor_tables import picture, tables

SEA_STATES: Final = (4, 5, 6)
FASTEST_KN: Final = 20.0
COMPONENTS: Final = 256  # waves of a sea: it does not repeat within a record
SETTLE_S: Final = 60.0  # how long the secured helicopter has been at sea before the first start
RMS_S: Final = 60.0  # what the rule to compare with looks back on
RAMP_S: Final = 8.0
PAST_EVERY_S: Final = 5.0  # between the starts of the rehearsed past
PAST_BEGIN_S: Final = 30.0  # how long the helicopter has been at sea before each of them, and so the first of them
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
    records: int = 110
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


def past_rows(study: Study, records: list[int], scene: Scene) -> pl.DataFrame:
    """When traverses started at earlier times have exceeded a limit: one row a record and earlier start."""
    settings, seas = study.settings, [study.sea(record)[1] for record in records]
    last_s = settings.past_s + (study.starts - 1) * study.every_s - settings.horizon_s
    begins = np.arange(PAST_BEGIN_S, last_s + 1e-9, PAST_EVERY_S).tolist()
    pairs = [(record, sea, now_s) for record, sea in zip(records, seas, strict=True) for now_s in begins]
    shadow = Shadow(scene, len(pairs), settings.threads)
    pieces = [sea.bake(PAST_BEGIN_S, ramp_s=RAMP_S, start_s=now_s - PAST_BEGIN_S).nodes for _, sea, now_s in pairs]
    shadow.advance(np.stack(pieces), round(PAST_BEGIN_S / scene.task.control_interval_s))
    nodes = np.stack([sea.bake(settings.horizon_s, start_s=now_s).nodes for _, sea, now_s in pairs])
    copies = Copies(scene, len(pairs), settings.threads)
    found = copies.drive(shadow.snapshot(), np.arange(len(pairs)), nodes, settings.horizon_s)
    return pl.DataFrame(
        {
            "record": [record for record, _, _ in pairs],
            "start_s": [now_s for _, _, now_s in pairs],
            "first_s": found.first_s,
        }
    )


def rehearsed_past(study: Study, rows: pl.DataFrame, past: pl.DataFrame, horizon_s: float) -> Any:
    """Share of the traverses that a ship could have rehearsed by each start and that exceeded a limit, (n,)."""
    table = {record[0]: frame for record, frame in past.partition_by("record", as_dict=True).items()}
    said = []
    for record, now_s in rows.select("record", "start_s").iter_rows():
        frame = table[record]
        began = frame["start_s"].to_numpy()
        known = (began >= now_s - study.settings.past_s) & (began <= now_s - study.settings.horizon_s + 1e-9)
        said.append(np.mean(frame["first_s"].to_numpy()[known] <= horizon_s + 1e-9))
    return np.array(said)


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


def run(study: Study, out: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Run what has not been run, and read all rows: of the starts, and of the rehearsed past.

    Raises:
        ConfigurationError: The folder holds rows of another study.
    """
    kinds = {"rows": chunk_rows, "past": past_rows}
    for folder in kinds:
        (out / folder).mkdir(parents=True, exist_ok=True)
    about = out / "study.json"
    if about.is_file() and json.loads(about.read_text(encoding="utf-8"))["identity"] != study.identity:
        raise ConfigurationError(f"{out}: this folder holds rows of another study; give another one.")
    write_text(about, json.dumps({"identity": study.identity, **asdict(study)}, indent=1) + "\n")
    scene = Scene.of(study.settings)
    frames: dict[str, list[pl.DataFrame]] = {folder: [] for folder in kinds}
    with progress_bar("monitor study") as advance:
        for first in range(0, study.records, CHUNK):
            records = list(range(first, min(first + CHUNK, study.records)))
            for folder, made in kinds.items():
                path = out / folder / f"{first:04d}-{len(records)}.parquet"
                if not path.is_file():
                    with whole_file(path) as temporary:
                        made(study, records, scene).write_parquet(temporary)
                frames[folder].append(pl.read_parquet(path))
            advance((first + len(records)) / study.records)
    return pl.concat(frames["rows"]), pl.concat(frames["past"])


# --- figures ----------------------------------------------------------------------------------------------------


def summary(study: Study, rows: pl.DataFrame, past: pl.DataFrame) -> dict[str, Any]:
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
        "horizons": [at_horizon(study, sound, past, horizon) for horizon in horizons],
        "later": [h for pair in itertools.pairwise([0.0, *horizons]) if (h := later(sound, *pair)) is not None],
    }


def at_horizon(study: Study, rows: pl.DataFrame, past: pl.DataFrame, horizon_s: float) -> dict[str, Any]:
    """Figures of one horizon: scores of the monitor and of the rules that it is compared with."""
    said, happened = foreseen(rows, horizon_s)
    records = rows["record"].to_numpy()
    rms = np.log(np.maximum(rows.select("rms_lateral_g", "rms_roll_deg").to_numpy(), 1e-9))
    log_odds = scores.logit(said, study.settings.copies)[:, np.newaxis]
    rehearsed = rehearsed_past(study, rows, past, horizon_s)
    rules = {
        "rehearsed_past": rehearsed,
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
        ("monitor_over_rehearsed_past", said, rehearsed),
        ("fitted_over_rms_rule", rules["monitor_fitted"], rules["rms_rule"]),
        ("both_over_rms_rule", rules["monitor_and_rms"], rules["rms_rule"]),
    ):
        told[f"skill_{name}"] = _three(scores.by_records(records, scores.skill(better, worse, happened)))
    calm = said == 0.0
    told["no_copy"] = [int(np.sum(calm)), *_three(share(happened[calm]))] if calm.any() else [0, None, None, None]
    told["reliability"] = [asdict(b) for b in scores.reliability(said, happened)]
    told["reliability_rms_rule"] = [asdict(b) for b in scores.reliability(rules["rms_rule"], happened)]
    told["by_sea_state"] = {
        str(state): [int(np.sum(here)), float(np.mean(happened[here])), float(np.mean(said[here]))]
        for state in SEA_STATES
        if (here := rows["sea_state"].to_numpy() == state).any()
    }
    return told


def later(rows: pl.DataFrame, from_s: float, to_s: float) -> dict[str, Any] | None:
    """Figures of an exceedance between two times, given that there was none before: what each lead is worth alone.

    The monitor's word is the share of its copies among those that are still within the limits at the first time.
    """
    first = np.stack(rows["first_s"].to_numpy())
    still = rows["true_s"].to_numpy() > from_s + 1e-9
    if not still.any():
        return None
    left = np.sum(first > from_s + 1e-9, axis=1)
    hits = np.sum((first > from_s + 1e-9) & (first <= to_s + 1e-9), axis=1)
    said = ((hits + 0.5) / (left + 1.0))[still]
    happened = (rows["true_s"].to_numpy() <= to_s + 1e-9).astype(float)[still]
    records = rows["record"].to_numpy()[still]
    rms = np.log(np.maximum(rows.select("rms_lateral_g", "rms_roll_deg").to_numpy(), 1e-9))[still]
    rule = scores.left_out(records, rms, happened)
    return {
        "from_s": from_s,
        "to_s": to_s,
        "starts": int(np.sum(still)),
        "happened": float(np.mean(happened)),
        "said": float(np.mean(said)),
        "brier_monitor": _three(scores.by_records(records, lambda k: scores.brier(said[k], happened[k]))),
        "brier_rms_rule": _three(scores.by_records(records, lambda k: scores.brier(rule[k], happened[k]))),
        "skill_over_rms_rule": _three(scores.by_records(records, scores.skill(said, rule, happened))),
    }


def foreseen(rows: pl.DataFrame, horizon_s: float) -> tuple[Any, Any]:
    """Share of the copies that exceed a limit within a horizon, and whether the truth has, (n,) each."""
    first = np.stack(rows["first_s"].to_numpy())
    return np.mean(first <= horizon_s + 1e-9, axis=1), (rows["true_s"].to_numpy() <= horizon_s + 1e-9).astype(float)


def _three(estimate: Estimate) -> list[float | None]:
    return [None if math.isnan(value) else value for value in (estimate.value, estimate.low, estimate.high)]


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
    told = summary(study, *run(study, out))
    write_text(out / "summary.json", json.dumps(told, indent=1) + "\n")
    write_text(out / "tables.md", tables(told))
    if plot is not None:
        picture(told, plot)
    print(tables(told))


if __name__ == "__main__":
    tyro.cli(main)
