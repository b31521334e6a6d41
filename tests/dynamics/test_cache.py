"""The cache of machine code: used when it fits, never when a source changed, and harmless when it cannot be used."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from ssmash_gym.dynamics import cache
from ssmash_gym.dynamics.lane import WIDTH, kernel, load, of_width, store

DYNAMICS = Path(cache.__file__).parent
NEEDED = ("__init__", "primitives", "lowering", "compiler", "lane", "cache")

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs compiled kernels")

CALLEE = """
from ssmash_gym.dynamics.lane import kernel

@kernel
def scaled(x):
    return 2.0 * x
"""
CALLER = """
from ssmash_gym.dynamics.cache import enable_kernel_cache
from ssmash_gym.dynamics.callee import scaled
from ssmash_gym.dynamics.lane import kernel, load, store

@kernel
def run(table):
    store(table, 0, scaled(load(table, 0)))

enable_kernel_cache(run)
"""
SCRIPT = """
import numpy as np
from ssmash_gym.dynamics.caller import run
from ssmash_gym.dynamics.lane import WIDTH
table = np.ones((1, WIDTH))
run(table)
print(table[0, 0], sum(run.stats.cache_hits.values()), sum(run.stats.cache_misses.values()))
"""


def result_hits_misses(folder: Path) -> tuple[float, int, int]:
    """Run the small package in a new process."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA")}
    environment |= {"SSMASH_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(folder)}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # Python itself would not notice an edit of equal size and time
    command = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True)
    value, hits, misses = done.stdout.split()
    return float(value), int(hits), int(misses)


def test_an_edit_in_another_file_is_never_stale_and_a_second_process_loads(tmp_path: Path) -> None:
    package = tmp_path / "ssmash_gym" / "dynamics"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").touch()
    for name in NEEDED:
        shutil.copy(DYNAMICS / f"{name}.py", package)
    (package / "caller.py").write_text(CALLER)
    callee = package / "callee.py"
    callee.write_text(CALLEE)
    assert result_hits_misses(tmp_path) == (2.0, 0, 1)
    assert result_hits_misses(tmp_path) == (2.0, 1, 0)
    times = callee.stat()
    callee.write_text(CALLEE.replace("2.0", "3.0"))
    os.utime(callee, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert result_hits_misses(tmp_path) == (3.0, 0, 1)
    callee.write_text(CALLEE)
    assert result_hits_misses(tmp_path) == (2.0, 1, 0)


def double_rows(table: Any) -> None:
    for k in range(table.shape[0]):
        store(table, k, 2.0 * load(table, k))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Kernels of this file may be cached, below a fresh folder."""
    monkeypatch.setattr(cache, "SOURCES", Path(__file__).resolve().parent)
    monkeypatch.setenv("SSMASH_CACHE_DIR", str(tmp_path / "cache"))
    cache.fingerprint.cache_clear()
    yield tmp_path / "cache"
    cache.fingerprint.cache_clear()


def doubled(width: int = WIDTH) -> Any:
    """Call a new kernel with a cache, and give its statistics."""
    fresh = of_width(kernel(double_rows), width)
    cache.enable_kernel_cache(fresh)
    table = np.ones((3, width))
    fresh(table)
    np.testing.assert_array_equal(table, 2.0)
    return fresh.stats


def test_every_width_has_its_own_file(here: Path) -> None:
    for width in (WIDTH, 8, 2):
        assert sum(doubled(width).cache_misses.values()) == 1
    assert len(list(here.glob("*/*.nbi"))) == 3
    for width in (WIDTH, 8, 2):
        assert sum(doubled(width).cache_hits.values()) == 1


def test_a_damaged_file_costs_a_compilation_only(here: Path) -> None:
    doubled()
    assert sum(doubled().cache_hits.values()) == 1
    for pattern in ("*/*.nbc", "*/*.nbi"):
        (damaged,) = here.glob(pattern)
        damaged.write_bytes(damaged.read_bytes()[:100])
        assert sum(doubled().cache_misses.values()) == 1


def test_a_folder_that_cannot_be_used_costs_the_cache_only(here: Path) -> None:
    here.write_text("a file where the folder should be")
    assert sum(doubled().cache_misses.values()) == 1
    assert sum(doubled().cache_misses.values()) == 1
    assert here.is_file()


def test_old_fingerprints_make_room_for_new_ones(here: Path) -> None:
    for age in range(5):
        folder = here / f"{cache.PREFIX}{age:032x}"
        folder.mkdir(parents=True)
        (folder / "kernel.nbc").touch()
        os.utime(folder, (1e9 - age, 1e9 - age))
    (here / "not-ours").mkdir()
    doubled()
    names = {entry.name for entry in here.iterdir()}
    current = f"{cache.PREFIX}{cache.fingerprint()[:32]}"
    assert names == {current, "not-ours", *(f"{cache.PREFIX}{age:032x}" for age in range(cache.KEPT - 1))}


def test_the_default_folder_is_the_users(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SSMASH_CACHE_DIR", raising=False)
    assert cache.cache_folder().is_relative_to(Path.home()) or "XDG_CACHE_HOME" in os.environ
    assert "ssmash_gym" in cache.cache_folder().parts


def test_kernels_elsewhere_are_refused() -> None:
    with pytest.raises(ValueError, match=r"kernel double_rows of .*test_cache\.py cannot be cached"):
        cache.enable_kernel_cache(kernel(double_rows))


def test_nothing_of_the_users_numba_is_changed(here: Path) -> None:
    before = {name: getattr(numba.config, name) for name in dir(numba.config) if name.isupper()}
    doubled()
    assert {name: getattr(numba.config, name) for name in dir(numba.config) if name.isupper()} == before
    assert type(numba.njit(lambda x: x)._cache).__name__ == "NullCache"


def test_plain_functions_are_left_alone() -> None:
    assert cache.enable_kernel_cache(double_rows) is None
