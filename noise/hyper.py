"""Parameters of the noise model with their priors, each a `Hyper` that the posterior density samples in log x."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.measurement.values.run import Array
from haptid.noise.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfNormal:
    """Half-normal prior of a standard deviation x ≥ 0, sampled in log x: p(x) = √(2/π)/scale·exp(−x²/(2·scale²)).

    Parameters
    ----------
    scale
        Standard deviation of the normal distribution of which x is the absolute value, in the unit of x.
    """

    scale: float

    def widen(self, factor: float) -> HalfNormal:
        """Return the prior with ``factor`` times the scale.

        Parameters
        ----------
        factor
            Positive factor [1].

        Returns
        -------
        HalfNormal
            A copy.
        """
        return HalfNormal(scale=factor * self.scale)

    def log_density(self, log_x: Array) -> Array:
        """Return the log density of log x, log p(x) + log x; same shape as ``log_x``.

        Parameters
        ----------
        log_x
            Natural logarithm of x in its unit, any shape.

        Returns
        -------
        ndarray, shape of ``log_x``
            Normalised log density.
        """
        x = np.exp(np.minimum(log_x, 300.0))  # its square still is a finite number
        return np.asarray(0.5 * np.log(2 / np.pi) - np.log(self.scale) - 0.5 * (x / self.scale) ** 2 + log_x)

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw log x from the prior, shape (size,).

        Parameters
        ----------
        rng
            Source of random numbers.
        size
            Number of draws.

        Returns
        -------
        ndarray, shape (size,)
            Natural logarithms of x in its unit.
        """
        return np.asarray(np.log(np.abs(self.scale * rng.standard_normal(size))))

    @property
    def words(self) -> str:
        """The prior as a report writes it."""
        return f"half-normal, scale {self.scale:.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LogNormal:
    """Log-normal prior: log x ~ N(log median, width²).

    Parameters
    ----------
    median
        Median of x, in its unit.
    width
        Standard deviation of log x [1].
    """

    median: float
    width: float

    def widen(self, factor: float) -> LogNormal:
        """Return the prior with the same median and ``factor`` times the width.

        Parameters
        ----------
        factor
            Positive factor [1].

        Returns
        -------
        LogNormal
            A copy.
        """
        return LogNormal(median=self.median, width=factor * self.width)

    def log_density(self, log_x: Array) -> Array:
        """Return the log density of log x; same shape as ``log_x``.

        Parameters
        ----------
        log_x
            Natural logarithm of x in its unit, any shape.

        Returns
        -------
        ndarray, shape of ``log_x``
            Normalised log density.
        """
        z = (log_x - np.log(self.median)) / self.width
        return np.asarray(-0.5 * z**2 - np.log(self.width) - 0.5 * np.log(2 * np.pi))

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw log x from the prior, shape (size,).

        Parameters
        ----------
        rng
            Source of random numbers.
        size
            Number of draws.

        Returns
        -------
        ndarray, shape (size,)
            Natural logarithms of x in its unit.
        """
        return np.asarray(np.log(self.median) + self.width * rng.standard_normal(size))

    @property
    def words(self) -> str:
        """The prior as a report writes it."""
        return f"log-normal, median {self.median:.3g}, factor {np.exp(self.width):.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Hyper:
    """A parameter of the noise model.

    Parameters
    ----------
    id, unit, description
        Name in files and tables, unit, and meaning for reports.
    prior
        Prior of the positive parameter.
    start
        Value from which the optimiser begins, in ``unit``.
    """

    id: str
    unit: str
    description: str
    prior: HalfNormal | LogNormal
    start: float


def noise_prior_width(*, stated: bool) -> float:
    """Return the standard deviation of ln(noise factor) in its prior [1], by whether the campaign states the noise.

    Parameters
    ----------
    stated
        Whether the campaign states the noise; otherwise it was estimated from the rows.

    Returns
    -------
    float
        Standard deviation [1].
    """
    return THRESHOLDS.stated_noise_log_std if stated else THRESHOLDS.estimated_noise_log_std


def noise_factor(width: float) -> Hyper:
    """Describe the factor on the sensor's standard deviation √(noise² + resolution²/12).

    Parameters
    ----------
    width
        Standard deviation of the factor's logarithm in the prior [1].

    Returns
    -------
    Hyper
        Log-normal prior of median 1.
    """
    text = "sensor noise over its stated standard deviation"
    return Hyper(id="noise_factor", unit="1", description=text, prior=LogNormal(median=1.0, width=width), start=1.0)


def cycle_scatter() -> Hyper:
    """Describe the scatter s of a cycle's amplitude factor 1 + s·ξ, ξ ~ N(0, 1).

    Returns
    -------
    Hyper
        Half-normal prior of scale `THRESHOLDS.scatter_prior_scale` [1].
    """
    text = "relative scatter of the amplitude from cycle to cycle"
    prior = HalfNormal(scale=THRESHOLDS.scatter_prior_scale)
    return Hyper(id="cycle_scatter", unit="1", description=text, prior=prior, start=3e-4)


def run_scatter() -> Hyper:
    """Describe the scatter s of a run's amplitude factor 1 + s·ξ, ξ ~ N(0, 1).

    Returns
    -------
    Hyper
        Half-normal prior of scale `THRESHOLDS.scatter_prior_scale` [1].
    """
    text = "relative scatter of the amplitude from run to run"
    prior = HalfNormal(scale=THRESHOLDS.scatter_prior_scale)
    return Hyper(id="run_scatter", unit="1", description=text, prior=prior, start=3e-4)


def model_error(travel: float, unit: str = "rad") -> tuple[Hyper, Hyper]:
    """Return the standard deviation a and the correlation time T of a model error of covariance a²·exp(−|Δt|/T).

    Parameters
    ----------
    travel
        Travel of the runs, or range of their torques, in ``unit``, to which the prior of the standard deviation is
        scaled.
    unit
        Unit of the readings.

    Returns
    -------
    tuple of Hyper
        ``model_error``, in ``unit``, and ``error_time`` [s].
    """
    size = HalfNormal(scale=THRESHOLDS.model_error_prior_scale_over_travel * travel)
    time = LogNormal(median=THRESHOLDS.error_time_prior_median_s, width=THRESHOLDS.error_time_prior_log_std)
    return (
        Hyper(id="model_error", unit=unit, description="correlated model error", prior=size, start=1e-3 * travel),
        Hyper(id="error_time", unit="s", description="correlation time of the model error", prior=time, start=0.3),
    )
