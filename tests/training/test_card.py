"""`ssmash ship`: a folder that can be given away, its card, and the manual's page about it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym import assets
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.policies import find_agent, trained
from ssmash_gym.evaluation.study import load_study
from ssmash_gym.evaluation.study_entrants import agent_entrants
from ssmash_gym.evaluation.study_rows import labelled, write_rows
from ssmash_gym.evaluation.study_summary import summarise
from ssmash_gym.training import ship as shipping
from ssmash_gym.training.agent import inputs, load_agent
from ssmash_gym.training.card import inputs_table
from ssmash_gym.training.card_curve import smoothed
from ssmash_gym.training.card_tables import by_severity, prose, table
from ssmash_gym.training.onnx import check_onnx
from ssmash_gym.training.ship import EVALUATED, LARGEST_MB, ship, tried_observations

pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")
pytest.importorskip("matplotlib")

ROOT = Path(__file__).resolve().parents[2]
GUIDE = ROOT / "docs" / "guide" / "agents.md"
SEAS = 40
CONDITIONS = ("ss5", "ss5_straight")
SUCCESS = {"small": 0.9, "yield": 1.0, "trapezoid": 1.0, "hold": 0.0}
LOADS_KN = {"small": 8.0, "yield": 12.0, "trapezoid": 30.0, "hold": 14.0}


@pytest.fixture(scope="module")
def shipped(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shipped agent without an evaluation."""
    out = tmp_path_factory.mktemp("shipped")
    ship(finished, name="small", out=out)
    return out / "small"


def made_rows(policy: str, seed: int | None) -> pl.DataFrame:
    """Rows as `run_episodes` gives them, made up."""
    rng = np.random.default_rng([SEAS, len(policy), seed or 0])
    success = np.arange(SEAS) >= (1.0 - SUCCESS[policy]) * SEAS - 1e-9
    return pl.DataFrame(
        {
            "seed": np.arange(SEAS),
            "success": success,
            "failed": np.zeros(SEAS, bool),
            "aligned": success | (np.arange(SEAS) < 2),
            "reason": np.where(success, "goal", "time"),
            "time_s": np.where(success, 43.0, 60.0),
            "scored_peak_kN": LOADS_KN[policy] + rng.normal(size=SEAS),
            "peak_probe_kN": LOADS_KN[policy] + np.zeros(SEAS),
            "peak_main_kN": 70.0 + np.zeros(SEAS),
            "over_limit_s": np.zeros(SEAS),
            "lift_offs": np.zeros(SEAS),
            "final_yaw_deg": np.zeros(SEAS),
            "cost_corridor": np.zeros(SEAS, int),
            "sea_lateral_g": np.linspace(0.01, 0.09, SEAS),
        }
    )


@pytest.fixture(scope="module")
def evaluated(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a study with made-up rows, in which the agent took part as one of two training seeds."""
    out = tmp_path_factory.mktemp("study")
    study = load_study("smoke")
    (entrant,) = agent_entrants([f"small={finished}"])
    for condition in CONDITIONS:
        for policy, seed in (*((name, None) for name in ("hold", "trapezoid", "yield")), ("small", 0), ("small", 1)):
            key = (policy, seed, condition)
            write_rows(out, key, labelled(made_rows(policy, seed), key, "made up", "made up"), 0)
    scripted = {"kind": "scripted", "seeds": {"None": {"identity": "-"}}}
    kinds = {name: scripted for name in ("hold", "trapezoid", "yield")}
    seeds = {"0": {"identity": entrant.identity}, "1": {"identity": "of another one"}}
    record = {
        "study": "smoke",
        "configuration": "-",
        "versions": {"ssmash_gym": "9.9.9"},
        "resolved": study.model_dump(mode="json"),
        "seed": study.seed,
        "conditions": {name: {"description": f"About {name}."} for name in CONDITIONS},
        "policies": {**kinds, "small": {"kind": "agent", "seeds": seeds}},
    }
    (out / "study.json").write_text(json.dumps(record))
    summarise(out, shown=False)
    return out


@pytest.fixture(scope="module")
def with_figures(finished: Path, evaluated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shipped agent with its figures."""
    out = tmp_path_factory.mktemp("shipped")
    ship(finished, name="small", evaluation=evaluated, out=out)
    return out / "small"


# --- the folder ------------------------------------------------------------------------------------------


def test_a_shipped_agent_is_complete_small_and_acts_as_the_run_does(finished: Path, shipped: Path) -> None:
    found = {path.name for path in shipped.iterdir()}
    assert found == {
        "agent.json", "policy.npz", "policy.zip", "policy.onnx", "normaliser.json", "training.yaml", "task.yaml",
        "scenario.yaml", "curve.csv", "curve.png", "README.md",
    }  # fmt: skip
    assert sum(path.stat().st_size for path in shipped.iterdir()) < LARGEST_MB * 1e6
    agent, run = load_agent(shipped), load_agent(finished / "agent")
    assert (agent.name, run.name) == ("small", "smoke")
    for batch in tried_observations(run):
        np.testing.assert_array_equal(agent.act(batch), run.act(batch))
    assert agent.about["configuration"] == run.about["configuration"]
    assert (shipped / "curve.csv").read_text().split() == (finished / "curve.csv").read_text().split()
    assert (shipped / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_shipping_again_gives_the_same_files(finished: Path, shipped: Path, tmp_path: Path) -> None:
    (tmp_path / "small").mkdir()
    (tmp_path / "small" / "left.txt").write_text("from an older one")
    ship(finished, name="small", out=tmp_path)
    assert {p.name: p.read_bytes() for p in (tmp_path / "small").iterdir()} == {
        p.name: p.read_bytes() for p in shipped.iterdir()
    }
    assert [path.name for path in tmp_path.iterdir()] == ["small"]


WITHOUT_TRAINING = """
import sys
sys.modules.update(dict.fromkeys(("torch", "stable_baselines3", "onnx", "onnxruntime", "matplotlib")))
import numpy as np
from ssmash_gym.training.agent import load_agent
agent = load_agent(sys.argv[1])
print(agent.act(np.zeros((2, agent.network.sizes[0]), np.float32)).shape)
"""


def test_a_shipped_agent_acts_without_the_extras(shipped: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-c", WITHOUT_TRAINING, str(shipped)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.strip() == "(2, 2)", done.stderr


def test_a_shipped_agent_is_found_by_name_in_an_installed_package(
    shipped: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "site-packages" / "ssmash_gym"
    shutil.copytree(shipped, package / "_assets" / "agents" / "trained" / "small")
    shutil.copytree(ROOT / "configs", package / "_assets" / "configs")
    monkeypatch.setattr(assets, "_PACKAGE", package)
    monkeypatch.chdir(tmp_path)
    assert list(trained()) == ["small"]
    assert find_agent("small").about == load_agent(shipped).about


def test_a_checkpoint_is_shipped_with_the_curve_up_to_it(finished: Path, tmp_path: Path) -> None:
    first = sorted((finished / "checkpoints").iterdir())[0]
    ship(first, name="early", out=tmp_path)
    lines = (tmp_path / "early" / "curve.csv").read_text().splitlines()
    assert len(lines) == 2
    assert int(lines[1].split(",")[0]) == load_agent(first).about["steps"] == 256


# --- what is refused -------------------------------------------------------------------------------------


def refused(match: str, out: Path, run: Path, **options: Any) -> None:
    with pytest.raises(ConfigurationError, match=match):
        ship(run, out=out, **options)
    assert not out.exists() or not list(out.iterdir()), "nothing may be left behind"


def test_mistakes_cost_one_sentence_and_leave_nothing(finished: Path, tmp_path: Path, monkeypatch: Any) -> None:
    out = tmp_path / "out"
    refused("there is no agent in this folder", out, tmp_path)
    refused(r"--name 'a/b' is refused", out, finished, name="a/b")
    alone = Path(shutil.copytree(finished / "agent", tmp_path / "somewhere" / "else" / "agent"))
    refused(r"curve\.csv is missing", out, alone)
    shutil.copy(finished / "curve.csv", alone)
    (alone / "policy.zip").unlink()
    refused(r"policy\.zip is missing", out, alone)
    monkeypatch.setattr(shipping, "LARGEST_MB", 0.05)
    refused(r"0\.1 MB is refused, most of it policy\.zip", out, finished)


def test_a_shipped_agent_does_not_lose_its_figures(finished: Path, with_figures: Path, shipped: Path) -> None:
    before = (with_figures / "evaluation.json").read_bytes()
    with pytest.raises(ConfigurationError, match="figures of an evaluation, which would be lost"):
        ship(finished, name=with_figures.name, out=with_figures.parent)
    with pytest.raises(ConfigurationError, match="has been shipped already"):
        ship(shipped, name=shipped.name, out=shipped.parent)
    assert (with_figures / "evaluation.json").read_bytes() == before


def test_an_agent_that_would_act_otherwise_is_not_shipped(finished: Path, tmp_path: Path, monkeypatch: Any) -> None:
    copyfile = shutil.copyfile

    def careless(source: Path, target: Path) -> None:
        copyfile(source, target)
        if target.name == "policy.npz":
            with np.load(source) as arrays:
                np.savez(target, **{name: np.float32(1.0001) * arrays[name] for name in arrays})

    monkeypatch.setattr(shipping.shutil, "copyfile", careless)
    refused("does not act as the run's", tmp_path / "out", finished)


def test_a_study_without_the_agent_is_refused(finished: Path, evaluated: Path, tmp_path: Path) -> None:
    other = Path(shutil.copytree(finished, tmp_path / "run"))
    with np.load(other / "agent" / "policy.npz") as arrays:
        numbers = {name: arrays[name] for name in arrays}
    np.savez(other / "agent" / "policy.npz", **numbers | {"bias_0": numbers["bias_0"] + np.float32(0.1)})
    refused("did not take part in this study as it is now; its agents are: small", tmp_path / "out", other,
            evaluation=evaluated)  # fmt: skip
    refused(r"study\.json: this file is missing", tmp_path / "out", finished, evaluation=tmp_path)


# --- the card --------------------------------------------------------------------------------------------


def rows_of(text: str) -> dict[str, list[str]]:
    """Rows of the tables of a text by their first cell."""
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return {row[0]: row[1:] for row in cells}


def test_a_card_without_evaluation_says_so(shipped: Path) -> None:
    card = (shipped / "README.md").read_text()
    assert "No evaluation has been shipped" in card
    assert "Not known: it has not been evaluated." in card
    assert not (shipped / EVALUATED).exists()


def test_the_card_warns_and_says_where_the_agent_comes_from(shipped: Path) -> None:
    card = (shipped / "README.md").read_text()
    for words in (
        "No operational use", "one\n  helicopter (generic_tricycle)", "seed 0", "768 control intervals", "assumed",
        "`start.yaw_deg` | -8 to 8", "curve.png", load_agent(shipped).about["configuration"],
    ):  # fmt: skip
        assert words in card, words
    assert max(map(len, card.splitlines())) < 300


def test_the_figures_of_the_card_are_those_of_the_study(evaluated: Path, with_figures: Path) -> None:
    summary = json.loads((evaluated / "summary.json").read_text())
    card = (with_figures / "README.md").read_text()
    rows = rows_of(card)
    for name in ("small", "yield", "trapezoid", "hold"):
        figure = summary["conditions"]["ss5"]["policies"][name]["peak_probe_kN"]["p95"]
        low, high = figure["ci"]
        assert rows[f"**{name}**" if name == "small" else name][2] == f"{figure['value']:.1f} [{low:.1f}, {high:.1f}]"
    each = summary["conditions"]["ss5"]["policies"]["small"]["per_seed"]
    assert rows["**0** (this agent)"] == ["90.0", f"{each[0]['p95_kN']:.1f}", f"{each[0]['mean_kN']:.1f}"]
    assert f"| 1 | 90.0 | {each[1]['p95_kN']:.1f} | {each[1]['mean_kN']:.1f} |" in card
    assert each[0]["p95_kN"] != each[1]["p95_kN"]
    assert rows["`ss5_straight`"][:3] == ["40", "90.0", f"{each[0]['p95_kN']:.1f}"]
    assert "of 40 episodes 36 reached the goal, 4 ran out of time; of those without success 2 ended crooked" in card
    assert "ssmash_gym 9.9.9" in card
    assert "evaluation seed 100000" in card
    assert len([line for line in card.splitlines() if line.startswith("| 1 | ")]) >= len(
        [check for check in summary["targets"] if check["line"] == 1]
    )


def test_the_evaluation_of_the_folder_is_of_this_agent(with_figures: Path) -> None:
    found = json.loads((with_figures / EVALUATED).read_text())
    assert (found["policy"], found["training_seed"], found["main"]) == ("small", 0, "ss5")
    own = found["conditions"]["ss5"]["own"]
    peaks = made_rows("small", 0)["scored_peak_kN"].to_numpy()
    assert own["p95_kN"] == pytest.approx(np.percentile(peaks, 95.0))
    assert own["reasons"] == {"goal": 36, "time": 4}
    assert sum(band["episodes"] for band in own["by_lateral_g"]) == SEAS


def test_a_bar_inside_a_cell_does_not_end_it() -> None:
    assert table(("a",), [("|d|",)])[-1] == r"| \|d\| |"


def test_a_command_stays_on_its_line() -> None:
    command = "`ssmash evaluate --study standard --agent one=two`"
    lines = prose(*["words and words"] * 6, command, *["words and words"] * 5)
    assert any(command in line for line in lines)
    assert max(map(len, lines)) <= 120
    assert " ".join(lines) == " ".join(["words and words"] * 6 + [command] + ["words and words"] * 5)


def test_the_last_band_has_no_upper_end() -> None:
    load = {"mean": 1.0, "p95": None}
    band = {"from_g": 0.08, "to_g": None, "episodes": 3, "success_rate": 1.0, "peak_probe_kN": load}
    assert by_severity([band])[-1] == "| 0.08 g and more | 3 | 100 | - | 1.0 |"


def test_lines_without_a_number_do_not_blot_out_their_neighbours() -> None:
    found = smoothed(np.array([np.nan, 1.0, 3.0, np.nan, np.nan, np.nan]), window=0.34)
    np.testing.assert_allclose(found, [1.0, 2.0, 2.0, 3.0, np.nan, np.nan])


# --- what the repository ships ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(trained()))
def test_every_agent_of_the_repository_stands_on_its_own(name: str) -> None:
    folder = trained()[name]
    agent = load_agent(folder)
    assert agent.name == name
    assert sum(path.stat().st_size for path in folder.iterdir()) < LARGEST_MB * 1e6
    rng = np.random.default_rng(0)
    seen = rng.uniform(-5.0, 5.0, (300, agent.network.sizes[0])).astype(np.float32)
    check_onnx(agent, folder / "policy.onnx", [seen])
    assert json.loads((folder / EVALUATED).read_text())["training_seed"] == agent.training.seed
    card = (folder / "README.md").read_text()
    assert "No operational use" in card
    assert "\n".join(inputs_table(agent.about["observation"])) in card


# --- the manual ------------------------------------------------------------------------------------------


def test_the_examples_of_the_manual_run(shipped: Path) -> None:
    text = GUIDE.read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 3
    space: dict[str, Any] = {}
    for block in blocks:
        code = block.replace("agents/trained/ppo_traverse", shipped.as_posix())
        exec(code.replace('"ppo_traverse"', repr(str(shipped))).replace('"ss5"', '"calm"'), space)
    assert space["action"].shape == (1, 2)
    np.testing.assert_allclose(space["agent"].act(space["observations"]).shape, (4, 2))
    space["env"].close()


def test_the_inputs_in_the_manual_are_those_of_the_task() -> None:
    known = inputs_table(inputs(load_task()))
    told = [line for line in GUIDE.read_text().splitlines() if re.match(r"\| \d+ \| `", line)]
    assert len(told) >= 6
    assert set(told) <= set(known)
