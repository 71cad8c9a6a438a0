"""Fits on a running Dask cluster: a scheduler and two workers in processes of their own, reached by address."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from identification.dask_workers import Cluster
from identification.fitting import fit
from identification.kernel_simulator import KernelSimulator
from identification.options import FitOptions
from identification.simulator import initial_state
from identification.workers import Here
from measurement.run import Run
from model.joint import joint_equations
from support.errors import InputError

ROOT = Path(__file__).parents[2]
SERVE = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@contextmanager
def cluster(folder: Path, path: str) -> Iterator[str]:
    """Serve a cluster from ``folder`` whose processes import from ``path``; ends with its standard input."""
    script = folder / "serve.py"
    script.write_text(SERVE, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": path}
    with subprocess.Popen(
        [sys.executable, str(script)], cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
    ) as served:  # fmt: skip
        try:
            yield served.stdout.readline().strip()
        finally:
            served.stdin.close()
            served.wait(30)


def test_the_same_fit_on_a_cluster_and_here(tmp_path: Path):
    equations = joint_equations(0).with_parameters({id: {"fixed": True} for id in ("Kp", "gravity_cos", "gravity_sin")})
    simulator = KernelSimulator.of(equations)
    t = np.arange(0.0, 3.0, 0.01)
    run = Run(
        file="a", free_joints=(0,), t=t, u=0.01 * np.cos(4 * t)[:, None], y=np.zeros((t.size, 1)),
        noise=np.array([2e-4]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
    )  # fmt: skip
    theta = np.array([q.initial for q in equations.parameters])
    y = simulator.simulate(theta * 1.1, run, x0=initial_state(equations, run)).y
    run = run.but(y=y + 2e-4 * np.random.default_rng(0).standard_normal(y.shape))
    options = FitOptions(starts=3, agree=3)
    here = fit(simulator, [run], options=options, workers=Here())
    with cluster(tmp_path, str(ROOT)) as address, Cluster(address) as workers:
        assert workers.count == 2
        there = fit(simulator, [run], options=options, workers=workers)
    np.testing.assert_array_equal(here.theta, there.theta)
    assert here.simulations == there.simulations


def test_a_cluster_without_haptid_is_refused_in_one_line(tmp_path: Path):
    with (
        cluster(tmp_path, "") as address,
        pytest.raises(InputError, match=r"can import haptid, got tcp.*No module named 'identification'.*PYTHONPATH"),
    ):
        Cluster(address)


def test_no_scheduler_at_the_address():
    with pytest.raises(InputError, match="the address of a running Dask scheduler"):
        Cluster("tcp://127.0.0.1:1")
