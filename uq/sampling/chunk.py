"""Pieces of a chain as units of work, storage and resumption: `Task` in, `Chunk` out.

The random numbers of a chunk follow from seed, phase, ensemble and the chunk's number alone. So a chain that is resumed
after its last stored chunk equals the chain of an uninterrupted command.
"""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import emcee
import h5py
import numpy as np

from haptid.identification.workers.workers import Tell, tell_nobody
from haptid.measurement.values.run import Array
from haptid.support.files.files import write_bytes
from haptid.uq.density.valley_density import ValleyDensity
from haptid.uq.sampling.moves import Proposal, moves


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Positions of all walkers over a few steps.

    Parameters
    ----------
    chain
        Coordinates z of `uq.density.valley_density`, shape (n_steps, n_walkers, n).
    log_prob
        Log posterior density of x, shape (n_steps, n_walkers).
    accepted
        Number of accepted steps of each walker, shape (n_walkers,).
    """

    chain: Array
    log_prob: Array
    accepted: Array

    def write(self, path: Path) -> None:
        """Write the chunk as HDF5 with a digest of its numbers, whole or not at all.

        Parameters
        ----------
        path
            File to write.

        Raises
        ------
        InputError, WritingError
            As `write_bytes`.
        """
        stream = io.BytesIO()
        with h5py.File(stream, "w") as file:
            for name in ("chain", "log_prob", "accepted"):
                file.create_dataset(name, data=getattr(self, name), track_times=False)  # same numbers, same bytes
            file.attrs["sha256"] = self.digest
        write_bytes(path, stream.getvalue())

    @classmethod
    def read(cls, path: Path) -> Chunk:
        """Read a file that `write` wrote.

        Parameters
        ----------
        path
            File to read.

        Returns
        -------
        Chunk
            Equal to the written one bit for bit.

        Raises
        ------
        ValueError
            Where the file is truncated, changed, or of another kind.
        """
        try:
            with h5py.File(path, "r") as file:
                found = cls(**{name: np.asarray(file[name]) for name in ("chain", "log_prob", "accepted")})
                recorded = file.attrs.get("sha256")
        except (OSError, KeyError, RuntimeError) as error:
            msg = f"{path} is damaged"
            raise ValueError(msg) from error
        if recorded != found.digest:
            msg = f"{path} is damaged"
            raise ValueError(msg)
        return found

    @property
    def digest(self) -> str:
        """Return the SHA-256 digest of all numbers, in hexadecimal."""
        parts = [np.ascontiguousarray(part).tobytes() for part in (self.chain, self.log_prob, self.accepted)]
        return hashlib.sha256(b"".join(parts)).hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Arguments of `advance`, in one value that crosses processes.

    Parameters
    ----------
    density
        Log density of x that is sampled.
    move, proposal
        Name of the moves (`MOVES`), and the proposal of independent draws.
    coords, log_prob
        Present positions x of the walkers, shape (n_walkers, n), and their log density, shape (n_walkers,).
    steps
        Number of steps.
    seed
        Entropy of the random numbers: the user's seed, phase, ensemble, chunk.
    """

    density: ValleyDensity
    move: str
    proposal: Proposal
    coords: Array
    log_prob: Array
    steps: int
    seed: tuple[int, ...]


def advance(task: Task, tell: Tell = tell_nobody) -> Chunk:
    """Advance one ensemble by one chunk with emcee.

    Parameters
    ----------
    task
        Density, moves, present positions and seed.
    tell
        Told the share of the steps that is done.

    Returns
    -------
    Chunk
        The same numbers for the same task, in whichever process it runs.
    """
    walkers, n = task.coords.shape
    sampler = emcee.EnsembleSampler(walkers, n, task.density, vectorize=True, moves=moves(task.move, task.proposal))
    sampler.log_prob_fn = task.density  # emcee's wrapper prints a traceback at Ctrl-C, and its walkers on stdout
    random = np.random.RandomState(np.random.MT19937(np.random.SeedSequence(task.seed)))
    state = emcee.State(task.coords, log_prob=task.log_prob, random_state=random.get_state())
    # emcee refuses walkers whose covariance is nearly singular: walkers of a resumed chain are taken as they are.
    for done, _ in enumerate(sampler.sample(state, iterations=task.steps, skip_initial_state_check=True), start=1):
        tell(done / task.steps, "")
    return Chunk(
        chain=sampler.get_chain(), log_prob=sampler.get_log_prob(), accepted=np.asarray(sampler.backend.accepted)
    )
