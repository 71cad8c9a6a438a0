"""Sampling of the posterior by several independent ensembles: `Laplace` in, `Sample` out.

1. Draw the walkers of every ensemble around the mode, those of every second ensemble more widely.
2. Burn in, in three parts; after each part refit the proposal of independent draws to the ensembles.
3. Pilot: let the ensembles try different moves, and keep the move of shortest autocorrelation time τ.
4. Advance all ensembles chunk by chunk until the chains are many τ long and τ hardly changes.

Chunks that a folder holds already are read instead of computed, so that a killed command continues.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from haptid.identification.problem.valleys import Valleys
from haptid.identification.workers.workers import Here, Workers, tell_nobody
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError, NumericalError
from haptid.support.files.files import read_json, write_json
from haptid.support.linear_algebra import inverse
from haptid.uq.density.laplace import Laplace, lowest_reached
from haptid.uq.density.valley_density import ValleyDensity
from haptid.uq.sampling.autocorrelation import autocorrelation_time
from haptid.uq.sampling.chunk import Chunk, Task, advance
from haptid.uq.sampling.moves import MOVES, Proposal
from haptid.uq.sampling.pace import Pace, TellPace
from haptid.uq.thresholds import THRESHOLDS

PHASES = {"burn": 0, "pilot": 1, "main": 2}
"""Number of each phase, which enters the seeds of its chunks."""

WALKERS_OF_FULL_VECTORS = 16
"""Walkers come in multiples of this, so that half an ensemble fills whole vectors of the compiled kernel."""

SWEEPS_FROM_MODE = 3
"""How often walkers that start on the mode step along every coordinate: an end may open only when another is left."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplingOptions:
    """Options of the sampler.

    Parameters
    ----------
    ensembles, walkers
        Independent ensembles (one chain each in the diagnostics), and walkers in each (0: by the dimension).
    chunk, burn, pilot
        Steps of a chunk, of the burn-in, and of the trial of moves (0: no trial, ``move`` is used).
    longest
        Most steps, whether the autocorrelation time is known or not; whole chunks.
    lengths, change
        The autocorrelation time τ counts as known where the chains have ``lengths``·τ steps and the last chunk changed
        τ by less than the share ``change``.
    move
        Name of the moves of the burn-in, and of the chains where there is no trial.
    seed
        Seed of all random numbers.
    """

    ensembles: int = 4
    walkers: int = 0
    chunk: int = 50
    burn: int = 100
    pilot: int = 100
    longest: int = 5000
    lengths: float = 50.0
    change: float = 0.01
    move: str = "independent"
    seed: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """Chains of the posterior with their autocorrelation time.

    Parameters
    ----------
    chain
        Coordinates η, shape (n_ensembles, n_steps, n_walkers, n).
    log_prob
        Log posterior density of η, shape (n_ensembles, n_steps, n_walkers).
    acceptance
        Mean share of accepted steps of each ensemble, shape (n_ensembles,).
    tau
        Integrated autocorrelation time of every coordinate [steps], shape (n,).
    reached
        Whether the chains are as long and τ as steady as the options ask.
    move
        Name of the moves of the chains.
    trials
        Largest τ of a coordinate [steps] by the name of each move of the pilot.
    """

    chain: Array
    log_prob: Array
    acceptance: Array
    tau: Array
    reached: bool
    move: str
    trials: dict[str, float] = field(default_factory=dict)

    @property
    def effective(self) -> Array:
        """Effective sample size n_ensembles·n_steps·n_walkers/τ of every coordinate, shape (n,)."""
        e, s, w, _ = self.chain.shape
        return np.asarray(e * s * w / self.tau)

    def flat(self) -> Array:
        """Lay the draws of all ensembles, steps and walkers one after the other.

        Returns
        -------
        ndarray, shape (n_draws, n)
            Draws of η, n_draws = n_ensembles·n_steps·n_walkers.
        """
        return self.chain.reshape(-1, self.chain.shape[-1])


@dataclass(slots=True)
class _Store:
    """Chunks by phase, ensemble and number, in memory and, where there is a folder, on disk."""

    folder: Path | None
    kept: dict[tuple[str, int, int], Chunk] = field(default_factory=dict)

    def path(self, phase: str, ensemble: int, number: int) -> Path | None:
        return None if self.folder is None else self.folder / f"{phase}_{ensemble}_{number:05d}.h5"

    def get(self, phase: str, ensemble: int, number: int) -> Chunk | None:
        path = self.path(phase, ensemble, number)
        if (phase, ensemble, number) not in self.kept and path is not None and path.exists():
            with suppress(ValueError):  # a damaged chunk is made again: its numbers follow from the seed
                self.kept[phase, ensemble, number] = Chunk.read(path)
        return self.kept.get((phase, ensemble, number))

    def put(self, phase: str, ensemble: int, number: int, chunk: Chunk) -> None:
        path = self.path(phase, ensemble, number)
        if path is not None:
            chunk.write(path)
        self.kept[phase, ensemble, number] = chunk


@dataclass(slots=True)
class _Ensembles:
    """Present positions of all walkers, and the means to advance them."""

    density: ValleyDensity
    options: SamplingOptions
    workers: Workers
    store: _Store
    pace: Pace
    coords: list[Array]
    log_prob: list[Array]

    def step(self, phase: str, number: int, steps: int, names: Sequence[str], proposal: Proposal) -> list[Chunk]:
        """Advance every ensemble by one chunk; a chunk that is stored already is read instead.

        Parameters
        ----------
        phase, number
            Phase (`PHASES`) and number of the chunk.
        steps
            Steps of the chunk.
        names
            Move of each ensemble.
        proposal
            Proposal of independent draws.
        """
        tasks = {}
        for e, name in enumerate(names):
            if self.store.get(phase, e, number) is None:
                seed = (self.options.seed, PHASES[phase], e, number)
                tasks[e] = Task(
                    density=self.density, move=name, proposal=proposal, coords=self.coords[e],
                    log_prob=self.log_prob[e], steps=steps, seed=seed,
                )  # fmt: skip
        work = [(task,) for task in tasks.values()]
        watch = self.pace.begin_chunk(steps, len(work))

        def keep(done: Sequence[Chunk]) -> int:
            # A chunk of many simulations may take minutes: a stop keeps those of the ensembles that are through.
            for e, made in zip(tasks, done, strict=False):
                if self.store.get(phase, e, number) is None:
                    self.store.put(phase, e, number, made)
            return len(work) - len(done)

        keep(self.workers.until(advance, work, keep, watch=watch))
        self.pace.end_chunk(steps, read=not work)
        chunks = [chunk for e in range(len(names)) if (chunk := self.store.get(phase, e, number)) is not None]
        for e, chunk in enumerate(chunks):
            self.coords[e], self.log_prob[e] = chunk.chain[-1], chunk.log_prob[-1]
        return chunks


def sample(
    start: Laplace,
    options: SamplingOptions,
    *,
    workers: Workers | None = None,
    folder: Path | None = None,
    tell: TellPace = tell_nobody,
) -> Sample:
    """Sample the posterior, starting from its normal approximation.

    Parameters
    ----------
    start
        Normal approximation with the posterior density.
    options
        Length and width of the sampling.
    workers
        Processes that compute the chunks; this process where None.
    folder
        Folder of the chunks. Chunks of the same density, start and options are continued, others removed.
    tell
        Told the share of the steps that is done once τ has settled, and τ and the effective sample size so far.

    Returns
    -------
    Sample
        Chains of the move with the shortest autocorrelation time of the pilot (``options.move`` without one), as long
        as ``options`` ask or ``options.longest``.

    Raises
    ------
    NumericalError
        Where hardly any point near the mode has a finite density.
    InputError, WritingError
        Where ``folder`` cannot be written, as `write_bytes`.
    """
    if folder is not None:
        _claim(folder, start, options)
    valleys = Valleys.of(start.density.coordinates.parametrisation)
    J = valleys.jacobian(start.eta)
    mean, covariance = valleys.forward(start.eta), J @ start.covariance @ J.T
    density = ValleyDensity(density=start.density, valleys=valleys)
    coords = [_first_points(density, mean, covariance, e, options) for e in range(options.ensembles)]
    log_prob = [density(points) for points in coords]
    pace = Pace(tell=tell, most=options.burn + options.pilot + options.longest)
    ensembles = _Ensembles(density, options, workers or Here(), _Store(folder), pace, coords, log_prob)
    names = [options.move] * options.ensembles
    proposal = Proposal.of(mean, covariance)
    if options.burn:
        for number, steps in enumerate(_shares(options.burn)):
            proposal = fit_proposal(ensembles.step("burn", number, steps, names, proposal))
    move, trials = options.move, {}
    if options.pilot:
        tried = [MOVES[e % len(MOVES)] for e in range(options.ensembles)]
        chunks = ensembles.step("pilot", 0, options.pilot, tried, proposal)
        trials = {name: float(autocorrelation_time(c.chain[None]).max()) for name, c in zip(tried, chunks, strict=True)}
        # The slowest coordinate decides how long the chains have to be: its τ ranks the moves.
        move = min(trials, key=lambda name: trials[name])
    return _run(ensembles, move, proposal, trials)


def _shares(burn: int) -> list[int]:
    """Return the steps of the burn-in's parts: the proposal is refitted after a quarter, after half and at the end."""
    return [part for part in (burn // 4, burn // 4, burn - 2 * (burn // 4)) if part]


def _run(ensembles: _Ensembles, move: str, proposal: Proposal, trials: dict[str, float]) -> Sample:
    options, before = ensembles.options, np.inf
    chunks: list[list[Chunk]] = []
    while True:
        made = ensembles.step("main", len(chunks), options.chunk, [move] * options.ensembles, proposal)
        chunks.append(made)
        moved = np.concatenate([np.stack([c.chain for c in row]) for row in chunks], axis=1)
        chain = ensembles.density.valleys.back(moved)
        tau = autocorrelation_time(chain)
        steps, longest = chain.shape[1], float(tau.max())
        left = math.ceil(max(options.lengths * longest - steps, options.chunk) / options.chunk) * options.chunk
        effective = float((chain[..., 0].size / tau).min())
        ensembles.pace.learn(min(left, max(options.longest - steps, 0)), longest, effective)
        reached = steps >= options.lengths * longest and abs(longest - before) < options.change * longest
        before = longest
        if reached or steps >= options.longest:
            break
    accepted = np.sum([[c.accepted.mean() for c in row] for row in chunks], axis=0) / chain.shape[1]
    log_prob = np.concatenate([np.stack([c.log_prob for c in row]) for row in chunks], axis=1)
    log_prob = log_prob - ensembles.density.valleys.log_volume(moved)  # density of z to that of η
    return Sample(
        chain=chain, log_prob=log_prob, acceptance=accepted, tau=tau, reached=reached, move=move, trials=trials
    )


def fit_proposal(chunks: Sequence[Chunk]) -> Proposal:
    """Fit the proposal of independent draws to the second halves of all ensembles' chunks.

    Parameters
    ----------
    chunks
        One chunk per ensemble.

    Returns
    -------
    Proposal
        With mean and covariance of the draws. Draws that the posterior does not reach (`lowest_reached`) are left out:
        walkers far from the mode would widen the proposal. All are taken where hardly a walker has reached the mode.
    """
    half = [slice(c.chain.shape[0] // 2, None) for c in chunks]
    draws = np.concatenate([c.chain[h].reshape(-1, c.chain.shape[-1]) for c, h in zip(chunks, half, strict=True)])
    log_prob = np.concatenate([c.log_prob[h].ravel() for c, h in zip(chunks, half, strict=True)])
    kept = draws[log_prob >= lowest_reached(float(np.max(log_prob)), draws.shape[1])]
    if len(np.unique(kept, axis=0)) <= draws.shape[1]:
        kept = draws  # so few points span no covariance: independent draws would all be one point
    return Proposal.of(kept.mean(axis=0), np.cov(kept.T).reshape(kept.shape[1], -1))


def walkers_of(dimension: int) -> int:
    """Return the number of walkers in an ensemble.

    Parameters
    ----------
    dimension
        Number of coordinates.

    Returns
    -------
    int
        At least twice one more than the dimension, rounded up to full vectors.
    """
    vectors = math.ceil(2 * (dimension + 1) / WALKERS_OF_FULL_VECTORS)
    return WALKERS_OF_FULL_VECTORS * vectors


def _first_points(
    density: ValleyDensity, mean: Array, covariance: Array, ensemble: int, options: SamplingOptions
) -> Array:
    """Draw the walkers of an ensemble around the mode, all of finite density, shape (n_walkers, n).

    Every second ensemble is `THRESHOLDS.dispersed_start_over_std` times as wide, so that R̂ compares chains from
    different starts. Where four attempts leave too few, because the mode lies near ends of ranges, walkers step away
    from the mode instead.
    """
    n = mean.size
    walkers = options.walkers or walkers_of(n)
    rng = np.random.default_rng([options.seed, 99, ensemble])
    spread = THRESHOLDS.dispersed_start_over_std if ensemble % 2 else 1.0
    scatter = spread**2 * covariance
    lower = np.linalg.cholesky(scatter)
    kept = np.empty((0, n))
    for _ in range(4):
        drawn = mean + rng.standard_normal((2 * walkers, n)) @ lower.T
        kept = np.concatenate([kept, drawn[np.isfinite(density(drawn))]])
        if len(kept) >= walkers:
            return kept[:walkers]
    return _walk_from_mode(density, mean, scatter, walkers, rng)


def _walk_from_mode(
    density: ValleyDensity, mean: Array, scatter: Array, walkers: int, rng: np.random.Generator
) -> Array:
    """Walk from the mode to points of finite density, shape (n_walkers, n).

    A mode on the ends of k ranges has 1/2ᵏ of all directions inside, so that no draw around it may be. Along one
    coordinate one of two directions is, and once that end is left the others open.
    """
    n = mean.size
    alone = np.diag(1 / np.sqrt(np.diag(inverse(scatter))))  # of each coordinate where the others are given
    together = np.linalg.cholesky(scatter) / np.sqrt(n * SWEEPS_FROM_MODE)
    points = np.tile(mean, (walkers, 1))
    for _ in range(SWEEPS_FROM_MODE):
        for along in alone:
            points = _step_inside(density, points, rng.standard_normal((walkers, 1)) * along)
        for _ in range(n):
            points = _step_inside(density, points, rng.standard_normal((walkers, n)) @ together.T)
    if np.ptp(points, axis=0).all() and np.isfinite(density(points)).all():
        return points
    msg = (
        "hardly any point near the fit has a finite posterior density: the runs do not determine the parameters; "
        "measure with more motion, or state priors or fixed values in campaign.toml"
    )
    raise NumericalError(msg)


def _step_inside(density: ValleyDensity, points: Array, steps: Array) -> Array:
    """Take the steps (n_walkers, n); one that leaves the density's support is turned round and halved, ten times."""
    points = points.copy()
    waiting = np.arange(len(points))
    for _ in range(10):
        inside = np.isfinite(density(points[waiting] + steps[waiting]))
        points[waiting[inside]] += steps[waiting[inside]]
        waiting = waiting[~inside]
        if not waiting.size:
            break
        steps = -steps / 2
    return points


def _claim(folder: Path, start: Laplace, options: SamplingOptions) -> None:
    """Keep the folder's chunks where density, start and options are those of the chunks; else remove them."""
    digest = hashlib.sha256()
    for array in (
        start.eta,
        start.covariance,
        *(a for t in start.density.terms for a in (t.x0, t.fixed, t.data, t.run.u)),
    ):
        digest.update(np.ascontiguousarray(array).tobytes())
    limits = {"longest", "lengths", "change"}  # they end the chains and change no chunk: longer chains continue these
    told = {name: getattr(options, name) for name in options.__slots__ if name not in limits}
    coordinates = start.density.coordinates
    valleys = Valleys.of(coordinates.parametrisation)  # chunks hold the walkers in their coordinates
    digest.update(repr((start.density.equations.digest, coordinates.names, valleys, told)).encode())
    name = digest.hexdigest()[:16]
    path = folder / "chain.json"
    if _digest_in(path) == name:
        return
    for old in folder.glob("*.h5"):
        old.unlink()
    write_json(path, {"digest": name, **told})


def _digest_in(path: Path) -> object:
    """Return the digest of the problem whose chunks lie beside ``path``; None where it cannot be read."""
    try:
        return read_json(path, "the digest of a chain").get("digest")
    except InputError:  # cut off, or not there: the chunks are of no use
        return None
