"""Inference of an FMU's parameters: `Calibrated` and FMU in, `ForeignPosterior` out.

1. Take the normal approximation that the fit gives.
2. Sample the posterior by ensembles, as for a joint.
3. Summarise the coordinates, and predict all runs from draws.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.calibration.calibrate import simulator_of
from haptid.identification.calibration.simulator import ForeignSimulator
from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.workers.workers import Workers, tell_nobody
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.foreign.density import normal_approximation
from haptid.uq.foreign.source import Calibrated, with_finite_bounds
from haptid.uq.result.sampler_state import Chains
from haptid.uq.result.summary import chains_of, summarise
from haptid.uq.sampling.modes import count_modes
from haptid.uq.sampling.pace import TellPace
from haptid.uq.sampling.sampling import Sample, SamplingOptions, sample
from haptid.uq.thresholds import THRESHOLDS

SAMPLING = SamplingOptions(burn=60, pilot=0, longest=2000)
"""Options of a sampling whose every simulation is a call of an FMU: no trial of moves."""
QUICK = SamplingOptions(chunk=40, burn=40, pilot=0, longest=80)
"""Options of a short sampling."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """Predictive bands of a run.

    Parameters
    ----------
    run
        The run.
    lower, upper
        Ends of the 95 % band of a reading, shape (n_t, n_outputs).
    covered
        Share of the readings within the band, by its probability content.
    """

    run: Run
    lower: Array
    upper: Array
    covered: Mapping[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class ForeignPosterior(Chains):
    """Posterior of an FMU's parameters.

    Chains and their summaries are fields of `Chains`.

    Parameters
    ----------
    calibrated
        The calibration that it goes on from.
    coordinates
        Coordinates η: parameters, then the noise factor.
    bands
        Predictions of all runs but the excluded ones.
    wall_s
        Duration [s].
    """

    calibrated: Calibrated
    coordinates: Coordinates
    bands: tuple[Band, ...]
    wall_s: float

    def values(self) -> Array:
        """Convert all draws to the values of the FMU's variables.

        Returns
        -------
        ndarray, shape (n_ensembles, n_draws, n)
            Values in the units of the variables, walker after walker.
        """
        return self.coordinates.values(chains_of(self.sample))


def infer(
    calibrated: Calibrated, fmu: ForeignFmu, options: SamplingOptions, workers: Workers, tell: TellPace = tell_nobody
) -> ForeignPosterior:
    """Infer the posterior of a calibrated FMU's parameters.

    Parameters
    ----------
    calibrated
        The calibration.
    fmu
        The FMU, which stays open.
    options
        Options of the sampler; as many walkers as the dimension needs where they are 0.
    workers
        Workers that advance the ensembles.
    tell
        Told the share of the steps that is done, None where the end is not known, and figures.

    Returns
    -------
    ForeignPosterior

    Raises
    ------
    InputError
        Where no parameter is free, or a name no longer is that of a variable.
    NumericalError
        Where the FMU crashes or hangs, or hardly any point near the fit has a finite density.
    """
    begun = time.perf_counter()
    simulator = _bound_parameters(simulator_of(calibrated.campaign, fmu), calibrated)
    equations = simulator.equations
    theta = np.array([calibrated.values[q.structured] for q in equations.parameters])
    mode = normal_approximation(
        simulator,
        tuple(run for run in calibrated.campaign.runs if run.use == "fit"),
        theta,
        calibrated.covariance,
        correlation_time=calibrated.correlation_time,
        noise_given=all(calibrated.campaign.noise_given.values()),
    )
    coordinates = mode.density.coordinates
    # emcee asks for twice the dimension; each walker costs a simulation a step.
    walkers = options.walkers or 2 * (coordinates.size + 1)
    drawn = sample(mode, replace(options, walkers=walkers), workers=workers, tell=tell)
    rng = np.random.default_rng([options.seed, 11])
    return ForeignPosterior(
        calibrated=calibrated,
        coordinates=coordinates,
        sample=drawn,
        parameters=summarise(coordinates, drawn, rng),
        bands=tuple(
            _band(simulator, coordinates, drawn, run, rng) for run in calibrated.campaign.runs if run.use != "excluded"
        ),
        modes=count_modes(drawn.chain),
        wall_s=time.perf_counter() - begun,
    )


def _bound_parameters(simulator: ForeignSimulator, calibrated: Calibrated) -> ForeignSimulator:
    equations = simulator.equations
    free = [q.structured for q in equations.parameters if not q.fixed]
    if not free:
        where = f"{calibrated.campaign.folder / 'campaign.toml'}, parameters"
        raise InputError(where, expected="a parameter whose posterior is wanted", got="all fixed")
    std = dict(zip(free, np.sqrt(np.diag(calibrated.covariance)), strict=True))
    bounded = with_finite_bounds(equations.parameters, calibrated.values, std)
    return replace(simulator, equations=replace(equations, parameters=bounded))


def _band(
    simulator: ForeignSimulator, coordinates: Coordinates, drawn: Sample, run: Run, rng: np.random.Generator
) -> Band:
    """Predict a run from draws of the posterior, with noise."""
    flat = drawn.flat()
    eta = flat[np.linspace(0, len(flat) - 1, THRESHOLDS.draws_of_foreign_band).astype(int)]
    thetas, factors = coordinates.thetas(eta), coordinates.values(eta)[:, -1]
    made = []
    for theta, factor in zip(thetas, factors, strict=True):
        noise = factor * run.sensor_std * rng.standard_normal(run.y.shape)
        made.append(simulator.simulate(theta, run).y + noise)
    covered = {}
    for content in THRESHOLDS.probability_contents:
        lower, upper = np.nanquantile(made, [(1 - content) / 2, (1 + content) / 2], axis=0)
        covered[content] = float(np.mean((run.y >= lower) & (run.y <= upper)))
    # The contents ascend: the last band is the widest.
    return Band(run=run, lower=lower, upper=upper, covered=covered)
