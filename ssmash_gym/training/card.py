"""The model card of an agent: what a reader should know before using it, as Markdown.

Every number comes from the agent's folder and its evaluation; what it must not be used for is the same for all.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from ssmash_gym.envs.loading import names
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.training.card_tables import (
    by_condition,
    by_policy,
    by_severity,
    by_training_seed,
    endings,
    prose,
    table,
    targets,
    worst_conditions,
)
from ssmash_gym.training.config import TrainingConfig

if TYPE_CHECKING:
    from ssmash_gym.training.card_figures import Figures

ALGORITHMS: Final = {
    "ppo": "proximal policy optimisation (PPO)",
    "sac": "soft actor-critic (SAC)",
    "tqc": "truncated quantile critics (TQC)",
    "cloning": "behaviour cloning (supervised learning on recorded episodes)",
}
USE: Final = """```python
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.evaluation.policies import find_agent

agent = find_agent("{name}")  # or a folder; deterministic, without memory, without PyTorch
core = TraverseBatch(4, task=agent.task, scenario=agent.scenario)
observations = core.reset(seeds=[1, 2, 3, 4])
result = core.step(agent.act(observations))  # (4, {inputs}) -> (4, 2)
```"""
NOT_FOR: Final = """\
- **No operational use.** It is a research model that has met no hardware, no crew and no ship. It is not certified for
  anything, and nothing bounds what it does with observations it has never seen.
- Not as evidence that a real helicopter can be moved in a given sea: loads are those of a model with assumed numbers.
  Limits, drive, sensors, corridor and goal are assumed as well (`task.yaml`, `scenario.yaml`, docs/assumptions.md).
- Not for another helicopter, another class of ships, another drive of the claw or another track: it has seen one
  helicopter ({helicopter}) and {ship}.
- Not with other sensors, other units or another control interval, and not with a hand on the claw beside it."""
FILES: Final = {
    "agent.json": "name, versions, network, every input with its scale, seed, fingerprint of the configuration",
    "policy.npz": "the network in plain numbers: enough to act, with `normaliser.json`",
    "policy.onnx": "normaliser, network and bound of the action in one graph",
    "policy.zip": "the model for Stable-Baselines3, with value networks and optimisers: to train on",
    "normaliser.json": "moments of observations and rewards, plain numbers",
    "training.yaml, task.yaml, scenario.yaml": "resolved configurations",
    "curve.csv, curve.png": "the training (and evolution.csv, where its last layer was evolved)",
    "evaluation.json": "its figures on unseen seas, with intervals",
}


def brief_card(record: Mapping[str, Any], training: TrainingConfig) -> str:
    """The card of an agent that has just been trained, before any evaluation.

    Args:
        record: Contents of ``agent.json``.
        training: Resolved configuration of the training.
    """
    lines = [
        f"# {record['name']}",
        "",
        training.description or "A policy for `ssmash/Traverse-v0`.",
        "",
        *facts(record, training),
        "",
        "Use it: `evaluate.py --agent FOLDER`, or `ssmash_gym.training.agent.load_agent(FOLDER).act(observations)`.",
        "`ssmash ship RUN_FOLDER` makes a folder of it that can be given away, with an ONNX file and a complete card.",
        "",
    ]
    return "\n".join(lines)


def model_card(
    record: Mapping[str, Any],
    training: TrainingConfig,
    task: TaskConfig,
    scenario: ScenarioConfig,
    helicopter: str,
    figures: Figures | None,
) -> str:
    """The card of a shipped agent.

    Args:
        record: Contents of ``agent.json``.
        training: Its training, resolved.
        task: Its task, resolved.
        scenario: What its episodes were drawn from, resolved.
        helicopter: Name of the one it was trained on.
        figures: Of its evaluation; None without one.
    """
    ship = getattr(scenario.motion, "ship", None)
    ship = f"one class of ships ({ship})" if isinstance(ship, str) else "one kind of deck motion"
    parts: list[tuple[str, Iterable[str]]] = [
        (f"# {record['name']}", [training.description or "A policy for `ssmash/Traverse-v0`."]),
        ("", facts(record, training)),
        ("## Use", _use(record, task)),
        ("## Figures", _figures(record, figures)),
        ("## Where it fails", _failures(figures)),
        ("## What it must not be used for", [NOT_FOR.format(helicopter=helicopter, ship=ship)]),
        ("## What it was trained on", _trained_on(record, training, task, scenario)),
        ("## Inputs and outputs", _interface(record, task)),
        ("## Files", _files(record, figures)),
    ]
    blocks = ["\n\n".join(filter(None, (head, "\n".join(body)))) for head, body in parts]
    return "\n\n".join(blocks) + "\n"


def facts(record: Mapping[str, Any], training: TrainingConfig) -> list[str]:
    """What it is, as a list."""
    method = ALGORITHMS[training.algorithm]
    hidden = " - ".join(map(str, training.network.layers)) or "none"
    evolution = record.get("evolution")
    after = ""
    if evolution is not None:
        after = f" and {evolution['generations']} generations of evolution of its last layer"
        after += "" if evolution["kept"] else " (not kept)"
    return [
        f"- Trained by {method} for {record.get('steps', 0):,} control intervals{after}, seed "
        f"{training.seed}, with "
        f"ssmash_gym {record.get('versions', {}).get('ssmash_gym', '?')}.",
        f"- Reads {len(record['observation'])} named numbers (`agent.json`), acts every "
        f"{record['control_interval_s']:g} s on the claw's velocity, along and across the track.",
        f"- Policy: perceptron, hidden layers {hidden}, {record['activation']}; deterministic when evaluated, without "
        "memory; the normaliser is frozen.",
        "- Trained in the seas, poses and disturbances of `scenario.yaml`; outside of them nothing is known."
        + (" The last layer was chosen in those of `evolution` in `training.yaml`." if after else ""),
        "- A research model on assumed numbers. Not for use on a ship.",
    ]


def _use(record: Mapping[str, Any], task: TaskConfig) -> Iterator[str]:
    yield USE.format(name=record["name"], inputs=len(record["observation"]))
    yield ""
    yield from prose(
        "`policy.onnx` needs no code of this package: `observation` (n, inputs) as the environment gives it goes in,",
        "`action` (n, 2) comes out, both float32. docs/guide/agents.md has an example and says what the numbers mean.",
    )
    if task.residual is not None:
        yield ""
        yield from prose(
            f"**Its output is a correction** of the baseline `{task.residual.baseline}`, within",
            f"+-{task.residual.along:g} along and +-{task.residual.across:g} across: the environment with",
            "`task.residual` adds both. The ONNX file holds the correction only.",
        )


def _figures(record: Mapping[str, Any], figures: Figures | None) -> Iterator[str]:
    yield "![success and peak loads over the training](curve.png)"
    yield ""
    if figures is None:
        yield f"No evaluation has been shipped with it. `ssmash evaluate --agent {record['name']}` makes one."
        return
    shared, main = figures.shared, figures.conditions[figures.main]
    own = main["policies"][figures.policy]
    seeds = own["training_seeds"]
    count = f"{len(seeds)} training seeds together" if len(seeds) > 1 else "one training seed"
    yield from prose(
        f"Study `{shared.get('study')}`, evaluation seed {shared.get('seed')}, ssmash_gym",
        f"{shared.get('versions', {}).get('ssmash_gym', '?')}: frozen seas that no training and no tuning has seen,",
        "the same for all. A failed episode counts with the ultimate load. In brackets: 95 % intervals. Made by",
        f"`ssmash evaluate --study {shared.get('study')} --agent {figures.policy}=RUN_FOLDERS --out DIR`.",
    )
    yield ""
    yield from prose(
        f"Main condition: `{figures.main}` ({main['description'].rstrip('.')}), {own['seas']} seas. Figures of",
        f"`{figures.policy}` are of {count}; this agent is training seed {figures.training_seed}.",
    )
    yield ""
    yield from by_policy(figures.policy, main, figures.roles)
    yield ""
    if figures.targets:
        yield "The project's aims:"
        yield ""
        yield from targets(figures.targets)
        yield ""
    yield from by_training_seed(figures.policy, figures.training_seed, main)
    yield from prose(
        f"This training seed alone, in all conditions that it was run in, beside `{figures.roles['book']}` and the",
        "best law of the condition (docs/guide/baselines.md says in what its gains were searched):",
    )
    yield ""
    yield from by_condition(figures.conditions, figures.roles)


def _failures(figures: Figures | None) -> Iterator[str]:
    if figures is None:
        yield "Not known: it has not been evaluated."
        return
    own = figures.conditions[figures.main]["own"]
    yield f"- In `{figures.main}`: {endings(own)}."
    yield from worst_conditions(figures.conditions)
    yield ""
    yield "By severity of the sea, the long-run RMS of the deck's lateral specific force, in the main condition:"
    yield ""
    yield from by_severity(own["by_lateral_g"])


def _seas(scenario: ScenarioConfig) -> str:
    """What the scenario says of itself, unless that is of the package's scenario that it changes."""
    shipped = map(load_scenario, names("scenarios"))
    base = next((one for one in shipped if one.description == scenario.description), scenario)
    if base == scenario:
        return scenario.description or "The scenario of `scenario.yaml`."
    return "The scenario of `scenario.yaml`, which changes one of the package's."


def _trained_on(
    record: Mapping[str, Any], training: TrainingConfig, task: TaskConfig, scenario: ScenarioConfig
) -> Iterator[str]:
    yield from prose(_seas(scenario), "Ranges of an episode:")
    yield ""
    drawn = scenario.model_dump(mode="json", exclude_defaults=True, exclude={"description"})
    yield from table(("quantity", "range"), ((f"`{key}`", words) for key, words in _ranges(drawn)))
    yield ""
    goal, track = task.goal, task.track
    versions = ", ".join(f"{key} {value}" for key, value in record.get("versions", {}).items())
    yield from prose(
        f"Task: from x = {track.start_x_m:g} m to {track.goal_x_m:g} m within {task.horizon_s:g} s; straight within",
        f"{goal.yaw_tolerance_deg:g} deg and {goal.y_tolerance_m:g} m of the line, held for {goal.hold_s:g} s.",
        f"Seed {training.seed}; its seas come from a block of seeds that evaluation never meets. Versions: {versions}.",
        f"Fingerprint of the configuration: `{record.get('configuration', '?')}`.",
        "`ssmash train --config training.yaml` repeats the training.",
    )


def _ranges(section: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, str]]:
    """Quantities of a scenario by dotted path, with their ranges in words."""
    for key, value in section.items():
        if not isinstance(value, Mapping):
            yield path + key, str(value)
        elif "uniform" in value:
            yield path + key, f"{value['uniform'][0]:g} to {value['uniform'][1]:g}"
        elif "constant" in value:
            yield path + key, f"{value['constant']:g}"
        elif "choice" in value:
            yield path + key, " or ".join(f"{one:g}" for one in value["choice"])
        elif "normal" in value:
            yield path + key, f"normal, {value['normal'][0]:g} +- {value['normal'][1]:g}"
        else:
            yield from _ranges(value, f"{path}{key}.")


def _interface(record: Mapping[str, Any], task: TaskConfig) -> Iterator[str]:
    yield from prose(
        f"An input is the quantity in its unit over its scale, clipped to +-{task.observation_clip:g}; frames and",
        "sensors are those of docs/environments/traverse.md.",
    )
    yield ""
    yield from inputs_table(record["observation"])
    yield ""
    yield "An output is a share of the claw's speed, -1 to 1, held for one control interval:"
    yield ""
    rows = [
        (0, "along", "along the track, forward positive", f"{task.claw.speed_along_m_s:g} m/s"),
        (1, "across", "across it, to starboard positive", f"{task.claw.speed_across_m_s:g} m/s"),
    ]
    yield from table(("Nr", "output", "meaning", "1 is"), rows)


def inputs_table(observation: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the inputs are, as a Markdown table.

    Args:
        observation: Of ``agent.json``.
    """
    rows = [
        (k, f"`{one['name']}`", one.get("meaning", ""), one["unit"], f"{one['scale']:g}")
        for k, one in enumerate(observation)
    ]
    return table(("Nr", "input", "meaning", "unit", "scale"), rows)


def _files(record: Mapping[str, Any], figures: Figures | None) -> list[str]:
    named = {key: words for key, words in FILES.items() if figures is not None or key != "evaluation.json"}
    return table(("file", "holds"), ((f"`{key}`", words) for key, words in named.items()))
