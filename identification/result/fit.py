"""The result of a fit: `Fit`, which uncertainty, the search for missing effects and the report take in.

All values are frozen: equations, estimates, covariance, scores of the runs, minima and statuses.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from haptid.identification.result.outcome import Outcome
from haptid.measurement.values.run import Array, freeze
from haptid.model.equations.equations import Equations
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.linear_algebra import rms


def scatter_of_correlation(rows: int) -> float:
    """Return the correlation up to which an estimate from white residuals counts as 0.

    Parameters
    ----------
    rows
        Number of residuals.

    Returns
    -------
    float
        Two of its standard deviations 1/√rows [1].
    """
    return 2.0 / math.sqrt(rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunScore:
    """Score of one run.

    Parameters
    ----------
    file, use
        File of the run, and its use: ``fit`` or ``validate``.
    rmse
        RMS of (measured − simulated) per joint [rad], shape (n_joints,).
    over_noise
        RMS of (measured − simulated)/σ over rows and joints; σ = √(noise² + resolution²/12).
    nrmse
        RMS of (measured − simulated) over the range of the measured position, the largest of the joints.
    x0
        Initial state of the simulation, shape (n_x,); its position is fitted with the prior N(y[0], σ²).
    rows
        Number of readings of the scored rows, over all joints.
    correlation_time
        Integrated autocorrelation time of the residual over the noise [rows]; None where it is not known.
    beyond_open
        RMS over the noise that neither the initial state, which the first rows of an unseen run tell, nor the spread of
        the parameters explains; None where it was not asked.
    """

    file: str
    use: str
    rmse: Array
    over_noise: float
    nrmse: float
    x0: Array
    rows: int = 0
    correlation_time: float | None = None
    beyond_open: float | None = None

    @property
    def unexplained(self) -> float:
        """RMS over the noise that counts against the model."""
        return self.over_noise if self.beyond_open is None else self.beyond_open

    @property
    def is_correlated(self) -> bool:
        """Whether the residual is correlated from row to row by more than that of white noise scatters."""
        time = self.correlation_time
        # Where the first lag is within the scatter, the time is 1 plus the correlation there.
        return time is not None and self.rows > 0 and time > 1.0 + scatter_of_correlation(self.rows)

    @property
    def rmse_rad(self) -> float:
        """RMS over all joints [rad]."""
        return rms(self.rmse)


@dataclass(frozen=True, slots=True, kw_only=True)
class Basin:
    """Minimum that one or several starts reached.

    Parameters
    ----------
    over_noise
        Root of the weighted mean square of the residual over the noise at the minimum.
    starts
        Numbers of the starts, from 0.
    theta
        Parameters at the minimum, shape (n_p,).
    simulations
        Number of simulated runs of these starts.
    """

    over_noise: float
    starts: tuple[int, ...]
    theta: Array
    simulations: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Combination:
    """Identifiable combination Σ coefficient·parameter, linearised at the estimate.

    Parameters
    ----------
    coefficients
        Coefficient by id of the members, which the data do not identify alone; the largest member has 1.
    value, std
        Value and standard deviation of the sum, in the unit of the largest member.
    """

    coefficients: Mapping[str, float]
    value: float
    std: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """95 % interval of a parameter.

    Parameters
    ----------
    lower, upper
        Ends in the parameter's unit; None where a bound ends the interval or no end was found.
    """

    lower: float | None
    upper: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """Fit of one configuration.

    Parameters
    ----------
    equations
        Equations that were fitted, with bounds and priors.
    theta
        All parameters in the order of ``equations.parameters``, shape (n_p,).
    free
        Ids of the fitted parameters.
    covariance
        Covariance of the fitted parameters in physical units, shape (n_free, n_free), residual correlation taken into
        account.
    information
        Fisher information of the data alone about the fitted parameters (no priors), shape (n_free, n_free), divided by
        the residual's excess over the noise and by its correlation time.
    cost
        Weighted mean square of residual over noise at the minimum; 1 is the noise.
    outcome
        How the fit ended.
    basins
        Minima that the starts reached, the best first.
    starts
        Number of starts that ran.
    x0
        Fitted initial state of every run by file.
    sigma
        Sensor standard deviation used, by file, shape (n_joints,) each.
    correlation_time
        Integrated autocorrelation time of the residuals, in rows; 1 is white.
    simulations, wall_s
        Number of simulated runs of this fit alone, and duration [s] of all fits of the joint, those that it replaced
        too, with scores, covariance and comparisons. Compiling the simulator, FMUs and pages are not counted.
    statuses
        ``identified``, ``unidentifiable``, ``prior``, ``at_bound`` or ``fixed`` by id.
    combinations
        Identifiable combinations of parameters that the data do not identify alone.
    warnings, notes
        Sentences on missing excitation; sentences on runs and strategy.
    runs
        Scores of fitted and validation runs.
    observer_gain
        Gain [1/s] with which the measured position was fed back in the residuals and scores; 0 for a free simulation.
    profiles
        95 % intervals of the profile likelihood by id, where they were asked for.
    inner_step
        Longest inner step of the integration [s].
    """

    equations: Equations
    theta: Array
    free: tuple[str, ...]
    covariance: Array
    information: Array
    cost: float
    outcome: Outcome
    basins: tuple[Basin, ...]
    starts: int
    x0: Mapping[str, Array]
    sigma: Mapping[str, Array]
    correlation_time: float
    simulations: int
    wall_s: float
    statuses: Mapping[str, str]
    combinations: tuple[Combination, ...] = ()
    warnings: tuple[str, ...] = ()
    runs: tuple[RunScore, ...] = ()
    notes: tuple[str, ...] = field(default=())
    observer_gain: float = 0.0
    profiles: Mapping[str, Interval] = field(default_factory=dict)
    inner_step: float = MODEL.inner_step_s

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for name in ("theta", "covariance", "information"):
            object.__setattr__(self, name, freeze(getattr(self, name)))

    @property
    def std(self) -> Array:
        """Standard deviation of every parameter, 0 where fixed, shape (n_p,)."""
        result = np.zeros(len(self.equations.parameters))
        for id, variance in zip(self.free, np.diag(self.covariance), strict=True):
            result[self.index(id)] = np.sqrt(max(float(variance), 0.0))
        return result

    @property
    def values(self) -> dict[str, float]:
        """Estimates of all parameters by id, in their units."""
        return {q.id: float(v) for q, v in zip(self.equations.parameters, self.theta, strict=True)}

    def index(self, id: str) -> int:
        """Find the place of a parameter in ``theta``.

        Parameters
        ----------
        id
            Id of the parameter.

        Returns
        -------
        int

        Raises
        ------
        KeyError
            Where the equations have no such parameter.
        """
        for i, quantity in enumerate(self.equations.parameters):
            if quantity.id == id:
                return i
        raise KeyError(id)

    def but(self, **changes: Any) -> Fit:
        """Return a copy with the fields that ``changes`` names replaced.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Fit
            The copy, its arrays read-only.
        """
        return replace(self, **changes)
