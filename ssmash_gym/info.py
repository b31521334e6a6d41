"""`ssmash info`: what is installed, where compiled kernels are kept, which configurations there are."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console
from rich.table import Table

import ssmash_gym
from ssmash_gym.assets import asset_path

LIBRARIES = ("numpy", "scipy", "numba", "gymnasium", "polars", "pydantic")
EXTRAS = {
    "train": ("stable-baselines3", "torch", "tensorboard", "tqdm"),
    "render": ("pygame-ce", "imageio-ffmpeg", "moviepy"),
    "plot": ("matplotlib",),
    "report": ("jinja2",),
    "distributed": ("ray",),
}
CATALOGUE = ("helicopters", "ships", "scenarios", "tasks", "training", "evaluation", "windows")


def installed(name: str) -> str:
    """Version of a library, or a dash."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "-"


def cache_summary(folder: Path) -> str:
    """The kernel cache in one line: where it is and how much it holds."""
    files = [path for path in folder.rglob("*") if path.is_file()] if folder.is_dir() else []
    return f"{folder} ({len(files)} files, {sum(path.stat().st_size for path in files) / 2**20:.1f} MB)"


def catalogue(kind: str) -> list[str]:
    """Names of the configurations of one kind, e.g. ``"helicopters"``."""
    return sorted(path.stem for path in asset_path("configs", kind).glob("*.yaml"))


def info() -> None:
    """Show versions, the kernel cache and the catalogue."""
    from ssmash_gym.dynamics.cache import cache_folder

    table = Table(show_header=False, box=None)
    table.add_row("ssmash_gym", ssmash_gym.__version__)
    table.add_row("Python", platform.python_version())
    table.add_row("libraries", ", ".join(f"{name} {installed(name)}" for name in LIBRARIES))
    for extra, names in EXTRAS.items():
        table.add_row(f"extra {extra}", ", ".join(f"{name} {installed(name)}" for name in names))
    table.add_row("kernel cache", cache_summary(cache_folder()))
    for kind in CATALOGUE:
        table.add_row(kind, ", ".join(catalogue(kind)) or "-")
    Console().print(table)
