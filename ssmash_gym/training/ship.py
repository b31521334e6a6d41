"""`ssmash ship`: a trained agent as a folder that can be given away.

Beside what the run's agent holds (see `ssmash_gym.training.agent`) a shipped agent has

```
policy.onnx       normaliser, network and bound of the action in one graph, for use without this package
curve.csv curve.png   how the training went (and evolution.csv, where there was one)
evaluation.json   its figures on unseen seas, beside those of others (with --evaluation)
README.md         the model card, made from all of this
```

It is written whole or not at all, and only if it acts bit for bit as the run's agent does.
"""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import tyro
from numpy.typing import NDArray
from rich.console import Console

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.training.agent import ABOUT, FORMAT, NORMALISER, WEIGHTS, Agent, load_agent, whole_folder
from ssmash_gym.training.card import model_card
from ssmash_gym.training.card_curve import draw_curve, require_matplotlib
from ssmash_gym.training.card_figures import Figures, study_figures
from ssmash_gym.training.evolution import CURVE as EVOLVED
from ssmash_gym.training.onnx import check_onnx, export_onnx, require_onnx
from ssmash_gym.training.seeds import TUNING, block

MODEL: Final = "policy.zip"
ONNX: Final = "policy.onnx"
CURVE: Final = "curve.csv"
PICTURE: Final = "curve.png"
EVALUATED: Final = "evaluation.json"
COPIED: Final = (WEIGHTS, MODEL, NORMALISER, "training.yaml", "task.yaml", "scenario.yaml")
LARGEST_MB: Final = 5.0
TRIED: Final = (1, 7, 300)  # sizes of the batches of random observations
HELICOPTERS: Final = 4
HELICOPTER: Final = str(signature(TraverseBatch).parameters["helicopter"].default)  # trainings take it as it comes
INTERVALS: Final = 30


def ship(
    run: Annotated[Path, tyro.conf.Positional],
    name: str | None = None,
    evaluation: Path | None = None,
    out: Path = Path("agents/trained"),
) -> None:
    """Make a folder of a trained agent that can be given away: model, ONNX file, curve, figures, card.

    Args:
        run: Run folder of a finished training; or a checkpoint in it.
        name: Of the agent, and of its folder; its own by default.
        evaluation: Folder of a study in which the agent took part; its figures go into the card.
        out: Where the agent's folder is made; one of that name is replaced.

    Raises:
        ConfigurationError: A folder or a name is refused, or the agent is too large; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    require_onnx()
    require_matplotlib()
    source = agent_of(run)
    agent = load_agent(source)
    called = agent.name if name is None else name
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", called):
        raise ConfigurationError(f"--name {called!r} is refused: letters, digits and _ . - only.")
    target = out / called
    refuse_loss(source, target, evaluation)
    lines = curve_lines(source, int(agent.about.get("steps", 0)))
    evolved = evolution_lines(source, agent)
    figures = None if evaluation is None else study_figures(evaluation, source)
    with whole_folder(target.resolve()) as folder:
        write_agent(folder, source, replace(agent, name=called), lines, figures, evolved)
        worst = check(folder, agent)
        size_MB = checked_size(folder, called)
    Console().print(f"{target}: {size_MB:.2f} MB; ONNX and NumPy agree to {worst:.0e}")


def refuse_loss(source: Path, target: Path, evaluation: Path | None) -> None:
    """Refuse to make an agent's folder of itself, or to replace one with figures by one without.

    Raises:
        ConfigurationError: It would be so.
    """
    if target.exists() and source.resolve() == target.resolve():
        raise ConfigurationError(f"{source}: this folder has been shipped already: give the run that it comes from.")
    if evaluation is None and (target / EVALUATED).is_file():
        raise ConfigurationError(
            f"{target}: the agent there has figures of an evaluation, which would be lost: give --evaluation, another "
            "--name or another --out."
        )


def agent_of(run: Path) -> Path:
    """The agent's folder of a run: of a finished one, or the folder itself.

    Raises:
        ConfigurationError: There is no agent.
    """
    for folder in (run / "agent", run):
        if (folder / ABOUT).is_file():
            return folder
    raise ConfigurationError(f"{run}: there is no agent in this folder: give that of a finished run, or a checkpoint.")


def curve_lines(source: Path, steps: int) -> list[dict[str, str]]:
    """The lines of the run's curve up to the agent's steps.

    Raises:
        ConfigurationError: There is no curve, or it does not reach that far.
    """
    lines = [line for line in lines_of_run(source, CURVE) if int(line["steps"]) <= steps]
    if not lines:
        raise ConfigurationError(f"{source}: {CURVE}: there is no line up to the agent's {steps:,} steps.")
    return lines


def evolution_lines(source: Path, agent: Agent) -> list[dict[str, str]]:
    """The generations of the run's evolution; none where the agent has not come out of one.

    Raises:
        ConfigurationError: They are missing.
    """
    return lines_of_run(source, EVOLVED) if "evolution" in agent.about else []


def lines_of_run(source: Path, name: str) -> list[dict[str, str]]:
    """The lines of a table of the run that an agent comes from: beside the agent, or in the run folder above it.

    Raises:
        ConfigurationError: It is missing.
    """
    places = [folder / name for folder in (source, *source.resolve().parents[:2])]
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        raise ConfigurationError(f"{source}: the run's {name} is missing; it lies in the run folder.")
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_agent(
    folder: Path,
    source: Path,
    agent: Agent,
    lines: Sequence[dict[str, str]],
    figures: Figures | None,
    evolved: Sequence[dict[str, str]] = (),
) -> None:
    """Write the files of a shipped agent.

    Args:
        folder: Where: an empty folder.
        source: The run's agent.
        agent: The same, with its new name.
        lines: Of the curve.
        figures: Of the evaluation; None without one.
        evolved: Of the evolution.
    """
    for name in COPIED:
        if not (source / name).is_file():
            raise ConfigurationError(f"{source}: {name} is missing.")
        shutil.copyfile(source / name, folder / name)
    about = {**agent.about, "name": agent.name, "format": FORMAT, "squash": agent.network.squash}
    write_text(folder / ABOUT, json.dumps(about, indent=1) + "\n")
    for table, name in ((lines, CURVE), (evolved, EVOLVED)):
        if table:
            write_lines(folder / name, table)
    draw_curve(lines, folder / PICTURE, agent.name, evolved)
    export_onnx(agent, folder / ONNX)
    if figures is not None:
        write_text(folder / EVALUATED, json.dumps(figures.document(), indent=1) + "\n")
    card = model_card(about, agent.training, agent.task, agent.scenario, HELICOPTER, figures)
    write_text(folder / "README.md", card)


def write_lines(path: Path, lines: Sequence[dict[str, str]]) -> None:
    """A table as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(lines[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(lines)


def check(folder: Path, agent: Agent) -> float:
    """Compare a shipped agent with the run's, on random observations and on those of its own episodes.

    Args:
        folder: The shipped agent.
        agent: The run's.

    Returns:
        Largest difference between the ONNX file's actions and the agent's.

    Raises:
        ConfigurationError: They do not act alike.
    """
    shipped = load_agent(folder)
    seen = tried_observations(agent)
    for batch in seen:
        if not np.array_equal(shipped.act(batch), agent.act(batch)):
            raise ConfigurationError(f"{folder}: the shipped agent does not act as the run's; nothing is shipped.")
    return check_onnx(shipped, folder / ONNX, seen)


def tried_observations(agent: Agent) -> list[NDArray[np.float32]]:
    """Batches of observations: random ones, and those of an agent's own episodes in its own seas."""
    rng = np.random.default_rng(0)
    size, clip = agent.network.sizes[0], agent.task.observation_clip
    found = [rng.uniform(-clip, clip, (n, size)).astype(np.float32) for n in TRIED]
    core = TraverseBatch(HELICOPTERS, task=agent.task, scenario=agent.scenario)
    seen = core.reset(seeds=block(0, TUNING, HELICOPTERS))
    for _ in range(INTERVALS):
        found.append(seen.copy())
        result = core.step(agent.act(seen))
        if result.endings:
            break
        seen = result.observation
    return found


def checked_size(folder: Path, name: str) -> float:
    """Size of a shipped agent [MB].

    Raises:
        ConfigurationError: It is larger than `LARGEST_MB`.
    """
    sizes: dict[str, Any] = {path.name: path.stat().st_size for path in folder.iterdir()}
    total_MB = sum(sizes.values()) / 1e6
    if total_MB >= LARGEST_MB:
        largest = max(sizes, key=lambda key: int(sizes[key]))
        raise ConfigurationError(
            f"{name}: {total_MB:.1f} MB is refused, most of it {largest} with {sizes[largest] / 1e6:.1f} MB: a shipped "
            f"agent must stay below {LARGEST_MB:g} MB."
        )
    return float(total_MB)
