"""What is measured: one piece of work of a given size, in the process that is timed.

``python -m benchmarks.performance.work CURVE SIZE`` does one and prints its wall time, processor time and peak memory,
workers included.
"""

from __future__ import annotations

import json
import resource
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import psutil
from scipy.integrate import solve_ivp

from haptid import Campaign, FitOptions

RATE_HZ = 250.0
ROWS = 1000
"""Rows of a run where they are not what grows."""
ONE_START = FitOptions(method="gauss_newton", starts=1)
FIXED = {"gravity_cos": 0.0, "gravity_sin": 0.3, "Ks": 0.4, "epos": 0.0, "sigma1": 0.1, "sigma2": 0.02, "vs": 0.2}
"""True values of parameters that are fixed, one after the other, where parameters grow."""
MOST_FREE = 11
SAMPLED_EVERY_S = 0.2
"""Time between two readings of the memory [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """One quantity that grows.

    Parameters
    ----------
    title
        What is done.
    axis
        What grows.
    sizes
        Sizes that are measured.
    prepare
        Makes the work of a size, which is not timed, and returns what is.
    """

    title: str
    axis: str
    sizes: tuple[int, ...]
    prepare: Callable[[int], Callable[[], object]]


def record(amplitude: float, omega: float, seed: int, rows: int) -> pd.DataFrame:
    """Simulate a pendulum on a spring with LuGre friction, as a logger would record it."""
    step = 1.0 / RATE_HZ
    t = np.arange(rows) * step
    torque = amplitude * np.cos(omega * t)

    def slope(time_s: float, state: np.ndarray) -> tuple[float, float, float]:
        angle, speed, bristle = state
        rate = speed - 30.0 * abs(speed) / (0.03 + 0.01 * np.exp(-((speed / 0.2) ** 2))) * bristle
        friction = 30.0 * bristle + 0.1 * rate + 0.02 * speed
        held = torque[min(int(time_s / step + 1e-9), t.size - 1)]
        return speed, (held - 0.3 * np.sin(angle) - 0.4 * angle - friction) / 0.012, rate

    path = solve_ivp(slope, (0.0, t[-1]), (0.0,) * 3, t_eval=t, method="LSODA", max_step=step, rtol=1e-7, atol=1e-9)
    angle = path.y[0] + 2e-4 * np.random.default_rng(seed).standard_normal(t.size)
    return pd.DataFrame({"time_s": t, "torque_0_Nm": torque, "position_0_rad": angle})


def campaign_of(runs: int, rows: int, free: int = MOST_FREE) -> Campaign:
    """Return a campaign of fitted runs and one unseen one; all but ``free`` parameters are fixed at their truth."""
    frames = {f"run{k}": record(0.3 + 0.3 * k / max(runs, 1), 2.0 + 0.37 * k, k, rows) for k in range(runs)}
    frames["unseen"] = record(0.4, 2.5, 99, ROWS)
    fixed = {id: {"fixed": value} for id, value in list(FIXED.items())[: MOST_FREE - free]}
    joints = {0: {"parameters": fixed}} if fixed else None
    return Campaign.from_frames(frames, validate=["unseen"], measured=False, title="pendulum", joints=joints)


def fit(campaign: Campaign, options: FitOptions = ONE_START) -> Callable[[], object]:
    """Return the identification of a campaign by the compiled kernel."""
    campaign.identify(kind=None, options=ONE_START)  # compiles the kernel, and loads what is loaded once
    return lambda: campaign.identify(kind=None, options=options)


def several_joints(count: int) -> Callable[[], object]:
    """Return the derivation of the equations of the last joints of the built-in device."""
    from haptid.identification.sequence.equations_for import equations_for  # noqa: PLC0415
    from haptid.measurement.format.devices import device_of  # noqa: PLC0415

    values = Campaign.read().values
    device = device_of(values)
    return lambda: equations_for(values, device, tuple(range(6 - count, 6)), (0.0,) * 6)


def posterior(walkers: int) -> Callable[[], object]:
    """Return the sampling of a short chain."""
    from haptid.identification.workers.chosen_workers import workers_of  # noqa: PLC0415
    from haptid.support.listener import Listener  # noqa: PLC0415
    from haptid.uq.job.job import Job  # noqa: PLC0415
    from haptid.uq.job.sample import sample_joints  # noqa: PLC0415
    from haptid.uq.result.infer import QUICK, InferOptions  # noqa: PLC0415

    campaign = campaign_of(2, ROWS)
    identified = campaign.identify(kind=None, options=ONE_START)
    # No trial of moves, and a length that does not depend on how soon the chains settle.
    sampling = replace(QUICK, walkers=walkers, pilot=0, burn=50, longest=100, lengths=1e6)
    options = InferOptions(sampling=sampling, noise_given=campaign.values.noise_given)
    job = Job(campaign=campaign.values, device=None, out=identified.folder, options=options, kind=None)

    def sample() -> object:
        with workers_of(None, 1) as pool:
            return list(sample_joints(job, job.configurations(None), pool, Listener()))

    return sample


CURVES: Mapping[str, Curve] = {
    "rows": Curve(
        title="fit of one run, one start", axis="rows of the run", sizes=(500, 1000, 2000, 4000, 8000, 16000),
        prepare=lambda size: fit(campaign_of(1, size)),
    ),
    "runs": Curve(
        title=f"fit of runs of {ROWS} rows, one start", axis="fitted runs", sizes=(1, 2, 4, 8, 16),
        prepare=lambda size: fit(campaign_of(size, ROWS)),
    ),
    "parameters": Curve(
        title=f"fit of two runs of {ROWS} rows, one start", axis="free parameters", sizes=(4, 5, 7, 9, 11),
        prepare=lambda size: fit(campaign_of(2, ROWS, size)),
    ),
    "workers": Curve(
        title=f"fit of eight runs of {4 * ROWS} rows, sixteen starts by SLSQP", axis="workers", sizes=(1, 2),
        prepare=lambda size: fit(campaign_of(8, 4 * ROWS), FitOptions(starts=16, agree=16, workers=size)),
    ),
    "joints": Curve(
        title="equations of the last joints of the Freedom 6S", axis="free joints", sizes=(1, 2, 3, 4),
        prepare=several_joints,
    ),
    "walkers": Curve(
        title=f"150 steps of four ensembles, two runs of {ROWS} rows", axis="walkers of an ensemble",
        sizes=(32, 64, 128), prepare=posterior,
    ),
}  # fmt: skip


def main() -> None:
    """Do one piece of work and print what it took."""
    curve, size = CURVES[sys.argv[1]], int(sys.argv[2])
    timed = curve.prepare(size)
    memory = Memory()
    begun, spent = time.perf_counter(), processor_seconds()
    with memory:
        timed()
    wall, cpu = time.perf_counter() - begun, processor_seconds() - spent
    print(json.dumps({"size": size, "wall_s": wall, "cpu_s": cpu, "peak_mb": memory.peak_mb}))


def processor_seconds() -> float:
    """Return the processor time of this process and of its workers that have ended [s]."""
    own, workers = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + workers.ru_utime + workers.ru_stime


class Memory:
    """Highest memory of this process and its workers together [MB], read in a thread while it is entered.

    A page that several processes share counts once (proportional set size).
    """

    def __init__(self) -> None:
        self.peak_mb = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> None:
        """Begin to read."""
        self._thread.start()

    def __exit__(self, *error: object) -> None:
        """Read no more; what this process alone had at its peak is never missed."""
        self._over.set()
        self._thread.join()
        self.peak_mb = max(self.peak_mb, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)

    def _watch(self) -> None:
        this = psutil.Process()
        while not self._over.wait(SAMPLED_EVERY_S):
            together = 0.0
            for process in (this, *this.children(recursive=True)):
                with suppress(psutil.Error):  # a worker may have ended
                    together += process.memory_full_info().pss / 2**20
            self.peak_mb = max(self.peak_mb, together)


if __name__ == "__main__":
    main()
