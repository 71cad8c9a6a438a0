"""Own code against a library's, where both exist: store of chains, picture of an FMU, autocorrelation times.

``python -m benchmarks.posteriors.libraries kill`` also ends writers of both stores with SIGKILL and compares the
resumed chains.
"""

from __future__ import annotations

import hashlib
import io
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import emcee
import numpy as np
from scipy.signal import lfilter

from haptid.fmu_build.content.picture import picture
from haptid.identification.baseline.least_squares import correlation_length as of_torque
from haptid.identification.statistics.covariance import _window, autocovariance
from haptid.uq.sampling.autocorrelation import autocorrelation_time
from haptid.uq.sampling.chunk import Chunk

WALKERS, N, STEPS, CHUNKS = 32, 8, 50, 6
"""Shape of the chains: walkers, parameters, steps of a chunk, chunks."""
KILLS = 10


def log_density(x: np.ndarray) -> np.ndarray:
    """Return the log density of a standard normal distribution."""
    return -0.5 * np.sum(x**2, axis=1)


def state_of(number: int, coords: np.ndarray) -> emcee.State:
    """Return the state at the beginning of a chunk, its random numbers seeded by the chunk's number."""
    random = np.random.RandomState(np.random.MT19937(np.random.SeedSequence((0, number))))
    return emcee.State(coords, log_prob=log_density(coords), random_state=random.get_state())


def chunks(folder: Path) -> np.ndarray:
    """Sample, one file a chunk; continue after the last readable file."""
    coords, chain = np.random.default_rng(0).standard_normal((WALKERS, N)), []
    for number in range(CHUNKS):
        path = folder / f"{number:05d}.h5"
        try:
            chunk = Chunk.read(path)
        except ValueError:
            sampler = emcee.EnsembleSampler(WALKERS, N, log_density, vectorize=True)
            sampler.run_mcmc(state_of(number, coords), STEPS, skip_initial_state_check=True)
            accepted = np.asarray(sampler.backend.accepted)
            chunk = Chunk(chain=sampler.get_chain(), log_prob=sampler.get_log_prob(), accepted=accepted)
            chunk.write(path)
        chain.append(chunk.chain)
        coords = chunk.chain[-1]
    return np.concatenate(chain)


def backend(folder: Path) -> np.ndarray:
    """Sample into emcee's HDFBackend; continue after its last step."""
    store = emcee.backends.HDFBackend(str(folder / "chain.h5"))
    if not (folder / "chain.h5").exists():
        store.reset(WALKERS, N)
    sampler = emcee.EnsembleSampler(WALKERS, N, log_density, vectorize=True, backend=store)
    while store.iteration < STEPS * CHUNKS:
        number, done = divmod(store.iteration, STEPS)
        state = store.get_last_sample() if store.iteration else None
        if not done:
            coords = np.random.default_rng(0).standard_normal((WALKERS, N)) if state is None else state.coords
            state = state_of(number, coords)
        sampler.run_mcmc(state, STEPS - done, skip_initial_state_check=True)
    return store.get_chain()


STORES = {"chunks": chunks, "backend": backend}


def size_of(folder: str | Path) -> int:
    """Return the bytes of all finished files in a folder."""
    return sum(path.stat().st_size for path in Path(folder).glob("*.h5"))


def digest(data: bytes) -> str:
    """Return twelve hex digits."""
    return hashlib.sha256(data).hexdigest()[:12]


def compare_stores() -> None:
    """Print time and bytes of both stores."""
    for name, run in STORES.items():
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            chain = run(Path(folder))
            spent = time.perf_counter() - began
            size = size_of(folder)
        print(
            f"{name:8s} {1e3 * spent / len(chain):6.2f} ms a step, {size / chain.nbytes:.1f} times its numbers on disk"
        )


def kill_writers() -> None:
    """End writers twice at random moments, continue, and compare with the chain of an uninterrupted writer."""
    random = np.random.default_rng(1)
    for name, run in STORES.items():
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            expected = digest(run(Path(folder)).tobytes())
            spent = time.perf_counter() - began
        same = 0
        for _ in range(KILLS):
            with tempfile.TemporaryDirectory() as folder:
                command = [sys.executable, "-m", "benchmarks.posteriors.libraries", "store", name, folder]
                for _ in range(2):
                    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                    before = size_of(folder)
                    while size_of(folder) == before and process.poll() is None:
                        time.sleep(1e-3)
                    time.sleep(float(random.uniform(0.0, 0.4 * spent)))  # while it writes
                    process.kill()
                    process.wait()
                done = subprocess.run(command, capture_output=True, text=True, check=False)
                same += done.stdout.strip() == expected
        print(f"{name:8s} {same} of {KILLS} chains have the same bits after two kills")


def compare_pictures() -> None:
    """Print import, time and bytes of the own picture and of matplotlib's."""
    t = np.linspace(0.0, 10.0, 2001)
    y = np.sin(t) * np.exp(-t / 5.0)
    began = time.perf_counter()
    data = picture(t, y)
    print(f"own        {time.perf_counter() - began:.2f} s, {len(data)} bytes, {digest(data)}")
    began = time.perf_counter()
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 # its import is what is measured
    from matplotlib.figure import Figure  # noqa: PLC0415

    imported = time.perf_counter() - began
    figure, stream = Figure(figsize=(2.4, 1.6), dpi=100), io.BytesIO()
    FigureCanvasAgg(figure)
    figure.add_axes((0.05, 0.075, 0.9, 0.85)).plot(t, y)
    figure.savefig(stream, format="png", metadata={"Software": None})
    spent, data = time.perf_counter() - began, stream.getvalue()
    print(f"matplotlib {spent:.2f} s, of these {imported:.2f} s of import, {len(data)} bytes, {digest(data)}")


def compare_autocorrelation_times() -> None:
    """Print the three autocorrelation times of autoregressive noise beside the true one."""
    random, rows = np.random.default_rng(0), 2000
    for phi in (0.0, 0.5, 0.9):
        found = []
        for _ in range(100):
            r = lfilter([1.0], [1.0, -phi], random.standard_normal(2 * rows))[rows:]
            c = autocovariance((r[:, None],), rows // 10)
            weights = _window(c, rows)
            bartlett = 1.0 + 2.0 * (weights * c[: weights.size])[1:].sum() / c[0]
            found.append((float(autocorrelation_time(r[None, :, None, None])[0]), of_torque(r), bartlett))
        told = [f"{mean:.1f} ± {std:.1f}" for mean, std in zip(np.mean(found, 0), np.std(found, 0), strict=True)]
        print(f"true {(1 + phi) / (1 - phi):.0f}: chains {told[0]}, torque {told[1]}, covariance {told[2]}")


def main() -> None:
    """Print all comparisons, or write one store and print the digest of its chain."""
    if sys.argv[1:2] == ["store"]:
        print(digest(STORES[sys.argv[2]](Path(sys.argv[3])).tobytes()))
        return
    compare_stores()
    compare_pictures()
    compare_autocorrelation_times()
    if sys.argv[1:] == ["kill"]:
        kill_writers()


if __name__ == "__main__":
    main()
