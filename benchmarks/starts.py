"""What a newcomer waits for: first step of a fresh process, and how much memory a large batch takes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FIRST_STEP = "from benchmarks.scenario import Traverse; Traverse('generic_tricycle', 1).advance(1)"
MEMORY = """
import json, resource
from benchmarks.scenario import Traverse
import sys
traverse = Traverse('generic_tricycle', int(sys.argv[1]))
traverse.advance(3)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps(peak / 2**10 if sys.platform != 'darwin' else peak / 2**20))
"""


def _run(code: str, *arguments: str, cache: str | None = None) -> str:
    """Run code in a fresh process; what it prints."""
    environment = os.environ | ({"SSMASH_CACHE_DIR": cache} if cache else {})
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True).stdout


def start_times_s() -> dict[str, float]:
    """Wall time of a whole process that imports the package, settles one helicopter and makes one step."""
    times = {}
    with tempfile.TemporaryDirectory() as cache:
        for name in ("cold", "cached"):
            start = time.perf_counter()
            _run(FIRST_STEP, cache=cache)
            times[name] = round(time.perf_counter() - start, 2)
    return times


def peak_memory_mb(count: int) -> float:
    """Greatest resident memory [MiB] of a process that holds `count` helicopters and advances them."""
    return round(float(json.loads(_run(MEMORY, str(count)))), 0)
