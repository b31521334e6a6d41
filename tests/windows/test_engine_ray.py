"""The same window on a Ray cluster of two nodes on this machine: same rows, though a worker and a node are killed."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from ssmash_gym import cli
from ssmash_gym.windows.chunks import Chunk, Job
from ssmash_gym.windows.config import WindowConfig, load_window
from ssmash_gym.windows.engines import Done, Steps, Threads
from ssmash_gym.windows.rows import read_rows
from ssmash_gym.windows.sweep import prepared, run_sweep

ray = pytest.importorskip("ray")

DOCUMENT: dict[str, Any] = {
    "seed": 5, "scenario": "ss5", "stages": ["traverse", "secured"],
    "task": {
        "base": "traverse", "horizon_s": 6.0, "grace_s": 0.5, "track": {"goal_x_m": 0.4},
        "lead_in": {"duration_s": 1.0, "ramp_s": 1.0},
    },
    "policies": ["linear", "ppo_traverse"], "axes": {"sea_state": [3, 6], "speed_kn": [0, 15]},
    "limits": {"probe_in_plane_kN": 5.0}, "must_arrive": False, "effort": {"seeds": 10, "step": 5, "most": 20},
}  # fmt: skip


def config() -> WindowConfig:
    return load_window(DOCUMENT)


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two nodes, each with a raylet and workers of its own, on the loopback."""
    from ray.cluster_utils import Cluster

    found = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    found.add_node(num_cpus=1)
    ray.init(address=found.address, log_to_driver=False, logging_level="error")
    found.wait_for_nodes()
    yield found
    ray.shutdown()
    found.shutdown()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("threads")
    run_sweep(prepared(config(), "small"), out, Threads(2), shown=False)
    return out


class Harmed:
    """Ray, with something done to the cluster when some chunks have come back."""

    def __init__(self, harm: Any, after: int = 2) -> None:
        from ssmash_gym.windows.engine_ray import Ray

        self._ray, self._harm, self._left = Ray(), harm, after

    @property
    def workers(self) -> int:
        return self._ray.workers

    def run(self, job: Job, chunks: Sequence[Chunk], tell: Steps) -> Done:
        for done in self._ray.run(job, chunks, tell):
            self._left -= 1
            if self._left == 0:
                self._harm()
            yield done


def kill_a_worker() -> None:
    """SIGKILL to a process that is in the middle of a chunk."""
    for folder in Path("/proc").iterdir():
        try:
            if folder.name.isdigit() and (folder / "cmdline").read_bytes().startswith(b"ray::_work"):
                os.kill(int(folder.name), signal.SIGKILL)
                return
        except OSError:
            continue
    raise AssertionError("no worker was at work")


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="finds the worker in /proc")
def test_ray_and_threads_give_the_same_rows_though_a_worker_is_killed(
    cluster: Any, whole: Path, tmp_path: Path
) -> None:
    run_sweep(prepared(config(), "small", size=5), tmp_path, Harmed(kill_a_worker), shown=False)
    assert read_rows(tmp_path).equals(read_rows(whole))


def test_a_node_that_dies_loses_nothing(cluster: Any, whole: Path, tmp_path: Path) -> None:
    node = cluster.add_node(num_cpus=2)
    cluster.wait_for_nodes()

    def harm() -> None:
        cluster.remove_node(node, allow_graceful=False)

    run_sweep(prepared(config(), "small", size=5), tmp_path, Harmed(harm), shown=False)
    assert read_rows(tmp_path).equals(read_rows(whole))


def test_a_cluster_that_is_not_there_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"  # nobody listens there
    for given in (address, f"ray://{address}", "nowhere"):
        assert cli.main(["window", "frigate_traverse", "--engine", "ray", "--address", given]) == 1
        assert f"--address {given} is refused" in capfd.readouterr().err
