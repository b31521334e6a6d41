"""Write requirements.lock: the newest versions that pyproject.toml allows, in a fresh virtual environment.

Versions are exact and carry no hashes and no local suffix (``+cpu``), so that any build of a version satisfies
the lock. What only one build of PyTorch brings along (its GPU libraries) is left out.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TORCH = "torch==2.13.0"
ONE_BUILD_ONLY = re.compile(r"(nvidia|cuda|triton)", re.IGNORECASE)
HEADER = "# Written by tools/write_lock.py (`make lock`). Exact versions of everything that `make` installs.\n"


def requirements(project: dict) -> list[str]:
    """The project's dependencies and those of every extra, without the project itself."""
    lines = list(project["dependencies"])
    for extra in project["optional-dependencies"].values():
        lines += extra
    return [line for line in lines if not line.startswith(project["name"])]


def lock_lines(freeze: str) -> list[str]:
    """Lines of the lock from the output of ``pip freeze``."""
    kept = [line.split("+")[0] for line in freeze.splitlines() if re.match(r"[A-Za-z0-9]\S*==", line)]
    return sorted((line for line in kept if not ONE_BUILD_ONLY.match(line)), key=str.lower)


def main() -> None:
    """Install, freeze, write."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = str(Path(folder) / ("Scripts" if sys.platform == "win32" else "bin") / "python")
        subprocess.run([python, "-m", "pip", "install", "-q", TORCH, *requirements(project)], check=True)
        freeze = subprocess.run([python, "-m", "pip", "freeze"], check=True, capture_output=True, text=True).stdout
    (ROOT / "requirements.lock").write_text(HEADER + "\n".join(lock_lines(freeze)) + "\n")


if __name__ == "__main__":
    main()
