"""Simulation-based calibration (Talts, Betancourt, Simpson, Vehtari, Gelman 2018): ranks of the truth are uniform.

Draw parameters from the prior, data from the model, draws from the posterior: the rank of each parameter among its
posterior draws is then uniform, and a p-interval holds it in a share p of the data sets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.noise.noise_model import NoiseModel
from haptid.noise.thresholds import THRESHOLDS as NOISE
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.equilibrium import equilibrium
from haptid.uq.density.forward import KernelForward, kernel_of
from haptid.uq.density.laplace import Laplace
from haptid.uq.density.solver_step import longest_step
from haptid.uq.prediction.choice import Problem
from haptid.uq.sampling.sampling import SamplingOptions, sample
from haptid.uq.thresholds import THRESHOLDS

RANKS = 199
"""Posterior draws among which the truth is ranked: ranks 0 to 199, of which 95 % are a whole number."""
STEPS = (1e-2, 5e-3, 2.5e-3)
"""Inner steps [s] among which the longest that suffices is taken; data are made with a fine one."""
SAMPLING = SamplingOptions(
    ensembles=1, chunk=40, burn=60, pilot=0, longest=4000, lengths=25.0, change=float("inf"), move="independent"
)
"""One ensemble of 32 walkers until it is 25 autocorrelation times long: 800 independent draws.

One of 10 makes 95 % intervals 2 to 5 % too narrow: it has not seen the tails.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """What a synthetic data set looks like.

    Parameters
    ----------
    equations
        With a proper prior on every free parameter.
    model
        Noise model from which data are drawn and under which they are read.
    torques
        Amplitude [N m] and frequency [rad/s] of every run.
    duration, spacing
        Length of a run and time between rows [s].
    noise
        Standard deviation of the sensor [rad].
    """

    equations: Equations
    model: NoiseModel
    torques: tuple[tuple[float, float], ...]
    duration: float = 12.0
    spacing: float = 0.02
    noise: float = 2e-4

    @property
    def words(self) -> str:
        """The design as a report says it."""
        drives = ", ".join(f"{a:g} N m at {w:.2f} rad/s" for a, w in self.torques)
        return (
            f"{len(self.torques)} runs of {self.duration:g} s ({drives}), a row every {1e3 * self.spacing:g} ms, noise "
            f"{1e3 * self.noise:g} mrad"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One data set: ranks of the truths, or why there are none.

    Parameters
    ----------
    number
        Number of the data set.
    ranks
        Rank of each truth among ``RANKS`` posterior draws, shape (n,); None where the posterior failed.
    effective
        Number of independent draws behind the ranks, by the slowest coordinate.
    failure
        Why there are no ranks.
    """

    number: int
    ranks: tuple[int, ...] | None
    effective: float = 0.0
    failure: str = ""


def synthetic_runs(design: Design, eta: Array, coordinates: Coordinates, rng: np.random.Generator) -> tuple[Run, ...]:
    """Draw runs from the model, with scatter of the cycles and noise.

    Parameters
    ----------
    design
        Design of the data sets.
    eta
        True coordinates η, shape (n,).
    coordinates
        Coordinates with the priors of the design.
    rng
        Random generator, which moves on.

    Returns
    -------
    tuple of Run
        A run for each torque of the design; positions are NaN where the simulation diverged.
    """
    equations = design.equations
    theta = coordinates.thetas(eta)
    hyper = dict(zip(coordinates.names, coordinates.values(eta), strict=True))
    rest = float(equilibrium(equations, theta[None], 0.0)[0])
    simulator = kernel_of(equations).with_step(THRESHOLDS.inner_step_of_correction_s)
    t = np.arange(round(design.duration / design.spacing) + 1, dtype=np.float64) * design.spacing
    made = []
    for k, (amplitude, omega) in enumerate(design.torques):
        u = amplitude * np.cos(omega * t)[:, None]
        x0 = np.zeros(len(equations.states))
        x0[0] = rest + 0.02 * rng.standard_normal()
        run = Run(
            file=f"set{k}.csv",
            free_joints=equations.joints,
            t=t,
            u=u,
            y=np.zeros((t.size, 1)),
            noise=np.array([design.noise]),
            resolution=np.zeros(1),
            posture=np.empty(0),
            use="fit",
        )
        y = simulator.simulate(theta, run, x0=x0).y[:, 0]
        cycle = whole_cycles(run).index
        xi = hyper.get("cycle_scatter", 0.0) * rng.standard_normal(cycle[-1] + 1)
        y = rest + (y - rest) * (1 + xi[cycle])
        y = y + design.noise * hyper["noise_factor"] * rng.standard_normal(t.size)
        made.append(run.but(y=y[:, None]))
    return tuple(made)


def rank_one_set(design: Design, number: int, seed: int) -> Outcome:
    """Draw a data set, sample its posterior and rank its truth.

    Parameters
    ----------
    design
        Design of the data sets.
    number
        Number of the data set.
    seed
        Seed; with ``number`` it fixes all random draws.

    Returns
    -------
    Outcome
        Without ranks where the true motion does not stay finite.
    """
    rng = np.random.default_rng([seed, number])
    hyper = design.model.hyper(noise_width=NOISE.stated_noise_log_std, travel=0.5)
    coordinates = Coordinates.of(design.equations, hyper=hyper)
    truth = coordinates.draw(rng, 1)[0]
    runs = synthetic_runs(design, truth, coordinates, rng)
    if not all(np.isfinite(run.y).all() for run in runs):
        return Outcome(number=number, ranks=None, failure="the truth blew up")
    mode, _ = longest_step(lambda step: _mode(design, runs, number, step), lambda mode: mode, STEPS)
    drawn = sample(mode, SAMPLING)
    flat = drawn.flat()
    picked = flat[rng.permutation(len(flat))[:RANKS]]
    ranks = tuple(int(r) for r in np.sum(picked < truth, axis=0))
    return Outcome(number=number, ranks=ranks, effective=float(drawn.effective.min()))


def _mode(design: Design, runs: tuple[Run, ...], seed: int, step: float) -> Laplace:
    """Climb from the prior's centre; where that leaves more than noise, also from a fit, and keep the higher mode."""
    forward = KernelForward(equations=design.equations, step=step)
    simulator = forward.simulator()
    problem = Problem(
        simulator=simulator, forward=forward, fitted=runs, unseen=(), noise_width=NOISE.stated_noise_log_std
    )
    centre = np.array([q.initial for q in design.equations.parameters])
    mode = problem.mode(design.model, centre, {"cycle_scatter": 0.05})
    if abs(float(mode.density.hyper(mode.eta[None])["noise_factor"][0]) - 1.0) < 4 * NOISE.stated_noise_log_std:
        return mode
    found = fit(simulator, runs, options=FitOptions(method="gauss_newton", starts=2, seed=seed))
    other = problem.mode(design.model, np.array(found.theta), {"cycle_scatter": 0.05})
    return other if other.log_density > mode.log_density else mode


def chi_square_bins(ranks: Sequence[int], bins: int = 20) -> Array:
    """Count the ranks 0..RANKS in equal bins.

    Parameters
    ----------
    ranks
        Ranks of one coordinate.
    bins
        Number of bins.

    Returns
    -------
    ndarray, shape (bins,)
        Number of ranks in each bin.
    """
    counts, _ = np.histogram(ranks, bins=bins, range=(-0.5, RANKS + 0.5))
    return counts.astype(np.float64)


def coverage(ranks: Sequence[int], level: float) -> float:
    """Return the share of data sets whose truth lies in the equal-tailed interval of a level.

    Parameters
    ----------
    ranks
        Ranks of one coordinate.
    level
        Probability of the interval [1].

    Returns
    -------
    float
        Share [1].
    """
    place = (np.asarray(ranks) + 0.5) / (RANKS + 1)
    return float(np.mean(np.abs(place - 0.5) <= level / 2))
