"""A piece of a chain: the unit of work, of storage and of resumption.

A chunk's random numbers follow from the seed, the ensemble and the chunk's number alone. So a chain that is taken up
after its last stored chunk is the chain that would have been.
"""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import emcee
import h5py
import numpy as np

from haptid.measurement.values.run import Array
from haptid.support.files.files import write_bytes
from haptid.uq.density.straight import StraightDensity
from haptid.uq.sampling.moves import Proposal, moves


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Positions of all walkers over a few steps.

    Parameters
    ----------
    chain
        x as `uq.density.straight` has it, shape (n_steps, n_walkers, n).
    log_prob
        Log posterior, shape (n_steps, n_walkers).
    accepted
        Number of accepted steps of each walker, shape (n_walkers,).
    """

    chain: Array
    log_prob: Array
    accepted: Array

    def write(self, path: Path) -> None:
        """Write as HDF5, whole or not at all."""
        stream = io.BytesIO()
        with h5py.File(stream, "w") as file:
            for name in ("chain", "log_prob", "accepted"):
                file.create_dataset(name, data=getattr(self, name), track_times=False)
            file.attrs["sha256"] = self.digest
        write_bytes(path, stream.getvalue())

    @classmethod
    def read(cls, path: Path) -> Chunk:
        """Read back what `write` wrote.

        Raises
        ------
        ValueError
            Where the file is not what was written: truncated, changed, or of another kind.
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
        """Return a digest of all numbers."""
        parts = [np.ascontiguousarray(part).tobytes() for part in (self.chain, self.log_prob, self.accepted)]
        return hashlib.sha256(b"".join(parts)).hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What a worker needs to make a chunk.

    Parameters
    ----------
    density, move, proposal
        What is sampled, and how.
    coords, log_prob
        Where the walkers stand, (n_walkers, n) and (n_walkers,).
    steps
        Steps to go.
    seed
        Entropy of the random numbers: the user's seed, phase, ensemble, chunk.
    """

    density: StraightDensity
    move: str
    proposal: Proposal
    coords: Array
    log_prob: Array
    steps: int
    seed: tuple[int, ...]


def advance(task: Task) -> Chunk:
    """Run emcee for one chunk."""
    walkers, n = task.coords.shape
    sampler = emcee.EnsembleSampler(walkers, n, task.density, vectorize=True, moves=moves(task.move, task.proposal))
    random = np.random.RandomState(np.random.MT19937(np.random.SeedSequence(task.seed)))
    state = emcee.State(task.coords, log_prob=task.log_prob, random_state=random.get_state())
    sampler.run_mcmc(state, task.steps, skip_initial_state_check=True)
    return Chunk(
        chain=sampler.get_chain(), log_prob=sampler.get_log_prob(), accepted=np.asarray(sampler.backend.accepted)
    )
