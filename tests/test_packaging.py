"""The project as a product: the wheel outside the checkout, missing extras, the text of the project, its measures."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
TEXT = {".py", ".md", ".toml", ".yaml", ".yml", ".cff", ".cfg", ".txt", ".lock", ".sh", ".json", ".csv", ".html", ".js"}
NOT_OURS = {".git", ".venv", "build", "dist", "runs", "videos", "node_modules"}
LONGEST_FILE = 400
LONGEST_FUNCTION = 60


def project_files(*suffixes: str) -> list[Path]:
    """Files of the project itself: nothing that a tool or a run has left in the checkout."""
    found = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [f for f in folders if f not in NOT_OURS and not f.endswith((".egg-info", "cache", "__"))]
        found += [Path(folder, name) for name in names if Path(name).suffix in suffixes]
    return sorted(found)


# --- the wheel -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built without a network."""
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(out)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Python of a fresh environment that holds the wheel and, besides, only the libraries of this one."""
    folder = tmp_path_factory.mktemp("elsewhere")
    venv.create(folder / "venv", with_pip=False, symlinks=os.name != "nt")
    site = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder / "venv")}))
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    libraries = folder / "libraries"
    libraries.mkdir()
    for path in map(Path, {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}):
        for entry in path.iterdir():
            if not entry.name.lower().startswith(("ssmash", "_ssmash", "__editable__")) and entry.suffix != ".pth":
                (libraries / entry.name).symlink_to(entry)
    (site / "libraries.pth").write_text(f"{libraries}\n")
    scripts = "Scripts" if os.name == "nt" else "bin"
    return folder / "venv" / scripts / "python"


def run_elsewhere(python: Path, code: str) -> str:
    """Run code outside the checkout; what it prints."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "COV"))}
    done = subprocess.run([python, "-c", code], cwd=python.parent, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_wheel_carries_configurations_agents_and_the_type_marker(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    here = {p.relative_to(ROOT).as_posix() for p in project_files(".yaml") if p.relative_to(ROOT).parts[0] == "configs"}
    assert here
    assert {f"ssmash_gym/_assets/{name}" for name in here} <= names
    assert "ssmash_gym/py.typed" in names
    assert any(name.startswith("ssmash_gym/_assets/agents/") and name.endswith(".py") for name in names)
    assert not [name for name in names if "__pycache__" in name or name.startswith(("agents/", "configs/", "tests/"))]


def test_wheel_works_outside_the_checkout(installed: Path) -> None:
    where = run_elsewhere(installed, "import ssmash_gym; print(ssmash_gym.__file__)")
    assert ROOT not in Path(where).parents
    catalogue = (
        "from ssmash_gym.vehicle import helicopter_names as n, load_helicopter; print(*map(load_helicopter, n()))"
    )
    assert "generic_tricycle" in run_elsewhere(installed, catalogue)
    agents = "import ssmash_gym.agents.baselines as b; print(b.__file__)"
    assert "_assets" in run_elsewhere(installed, agents)


def test_wheel_makes_the_environment(installed: Path) -> None:
    code = "import gymnasium, ssmash_gym; e = gymnasium.make('ssmash/Traverse-v0'); print(e.action_space.shape)"
    assert run_elsewhere(installed, code) == "(2,)"


def test_wheel_finds_the_trained_agents_by_name(installed: Path) -> None:
    code = "import ssmash_gym.evaluation.policies as p; print(*(p.find_agent(name).name for name in p.trained()))"
    here = {path.parent.name for path in (ROOT / "agents" / "trained").glob("*/agent.json")}
    assert "ppo_traverse" in here
    assert set(run_elsewhere(installed, code).split()) == here


def test_command_line_lists_its_verbs(installed: Path) -> None:
    code = "import sys; from ssmash_gym.cli import main; main(['--help']); print('numba' in sys.modules)"
    printed = run_elsewhere(installed, code)
    assert all(verb in printed for verb in ("train", "evaluate", "simulate", "info"))
    assert printed.endswith("False"), "`ssmash --help` must not load the engine"


def test_every_verb_leads_to_a_function() -> None:
    from importlib import import_module

    from ssmash_gym.cli import VERBS

    for verb in VERBS.values():
        module, name = verb.function.split(":")
        assert callable(getattr(import_module(module), name))


def test_unknown_verb_is_told_in_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    from ssmash_gym.cli import main

    assert main(["fly"]) == 2
    message = capsys.readouterr().err
    assert "'fly'" in message
    assert "train" in message
    assert message.count("\n") == 1


# --- extras ----------------------------------------------------------------------------------------------

EXTRAS = {
    "train": ("stable_baselines3", "sb3_contrib", "torch", "tensorboard", "tqdm"),
    "tune": ("optuna", "cmaes"),
    "onnx": ("onnx", "onnxruntime"),
    "report": ("jinja2",),
    "render": ("pygame", "imageio_ffmpeg", "moviepy"),
    "plot": ("matplotlib",),
    "web": ("websockets",),
    "data": ("minari",),
}
IMPORT_EVERYTHING = """
import importlib, pkgutil, re, sys
sys.modules.update(dict.fromkeys(sys.argv[1:]))
import ssmash_gym
for module in pkgutil.walk_packages(ssmash_gym.__path__, "ssmash_gym.", onerror=lambda name: None):
    try:
        importlib.import_module(module.name)
    except ImportError as refusal:
        if not re.search(r"ssmash_gym\\[(train|tune|onnx|report|render|plot|web|data)\\]", str(refusal)):
            print(f"{module.name}: {refusal}")
"""


def test_every_module_imports_without_the_extras_or_names_the_missing_one() -> None:
    blocked = [name for names in EXTRAS.values() for name in names]
    command = [sys.executable, "-c", IMPORT_EVERYTHING, *blocked]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not done.stdout, done.stdout


# --- versions --------------------------------------------------------------------------------------------


def test_lock_is_exact_and_satisfies_the_ranges() -> None:
    from packaging.requirements import Requirement

    lines = [line for line in (ROOT / "requirements.lock").read_text().splitlines() if not line.startswith("#")]
    pins = {Requirement(line).name.lower().replace("_", "-"): Requirement(line) for line in lines}
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines), "exact, without hashes or local versions"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [line for extra in project["optional-dependencies"].values() for line in extra]
    for line in project["dependencies"] + extras:
        wanted = Requirement(line)
        if wanted.name == project["name"]:
            continue
        version = next(iter(pins[wanted.name.lower().replace("_", "-")].specifier)).version
        assert version in wanted.specifier, line
    assert str(pins["torch"].specifier) == "==2.13.0"


# --- the project's text ----------------------------------------------------------------------------------

# Written in pieces, so that this file passes its own test.
FORBIDDEN = [
    r"(?<![\w.-])/" + r"(?:work|home|root|Users|tmp)/\w",
    r"py" + r"pi\.(?:org|python)",
    r"file" + r"s\.pythonhosted",
    r"ind" + r"ex-url",
    r"find" + r"-links",
    r"registry\." + r"npmjs",
]


def test_text_names_no_local_path_and_no_registry() -> None:
    pattern = re.compile("|".join(FORBIDDEN))
    found = []
    for path in [*project_files(*TEXT), ROOT / "Makefile", ROOT / ".ci" / "run"]:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if pattern.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}")
    assert not found, "\n".join(found)


def code_lines(function: ast.FunctionDef) -> int:
    """Lines of a function without its docstring."""
    first = function.body[0]
    documented = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
    docstring = first.end_lineno - first.lineno + 1 if documented else 0
    return function.end_lineno - function.lineno + 1 - docstring


def test_files_and_functions_stay_short() -> None:
    offenders = []
    for path in project_files(".py"):
        text = path.read_text(encoding="utf-8")
        if (lines := text.count("\n")) > LONGEST_FILE:
            offenders.append(f"{path.relative_to(ROOT)}: {lines} lines")
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and (length := code_lines(node)) > LONGEST_FUNCTION:
                offenders.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.name}: {length} lines")
    assert not offenders, "\n".join(offenders)


def test_every_link_of_the_pages_leads_somewhere() -> None:
    done = subprocess.run([sys.executable, ROOT / "tools" / "check_links.py"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_python_is_found_or_asked_for() -> None:
    shell = shutil.which("sh")
    if shell is None:
        pytest.skip("no POSIX shell")
    script = ROOT / "tools" / "find_python.sh"
    found = subprocess.run([shell, script, sys.executable], capture_output=True, text=True)
    assert found.returncode == 0
    assert Path(found.stdout.strip()).exists()
    missing = subprocess.run([shell, script, "no-such-python"], capture_output=True, text=True)
    assert missing.returncode == 1
    assert "3.11, 3.12 or 3.13" in missing.stderr
