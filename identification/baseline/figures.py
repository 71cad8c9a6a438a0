"""Figures of a model on a run: `Model` and `Run` in, `Figures` out, the same for every model.

free       RMS of (measured − simulated) position of one free simulation from the measured start,
torque     RMS of (measured − computed) torque along the measured motion, also relative to the torque's RMS,
horizon    RMS of (measured − simulated) position of simulations of 0.1, 1 and 10 s, each from the measured state,
closed     RMS of (measured − simulated) position through the recorded controller, from the measured start.

The free simulation shows drift, the torque shows what the model explains of the effort, and the horizons lie between.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from haptid.identification.baseline.baseline import Baseline
from haptid.identification.baseline.delay import with_delayed_torque
from haptid.identification.baseline.torque_along import TorqueAlong
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import initial_state
from haptid.identification.simulators.slow_rows import Mask, at_rest, near_reversal
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.filtered_motion import FilteredMotion
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import column_rms, rms


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """Parameters with all that simulates and inverts them.

    Parameters
    ----------
    simulator
        Kernel of the configuration.
    inverse
        Inverse dynamics of the same equations, whose friction states the simulations begin with.
    theta
        Parameters, shape (n_p,).
    baseline
        The plain model that the parameters are those of, which has a constant torque beside them; None for a fit.
    delay
        Delay T [s] of the recorded torque that the parameters were fitted with: τ(t − T) acts at t.
    """

    simulator: KernelSimulator
    inverse: TorqueAlong
    theta: Array
    baseline: Baseline | None = None
    delay: float = 0.0

    def torque(self, motion: FilteredMotion) -> Array:
        """Compute the recorded torque that a motion needs, at the time at which it acts.

        Parameters
        ----------
        motion
            Filtered motion of a run.

        Returns
        -------
        ndarray, shape (n, n_joints)
            Torque [N m], or force [N] of a prismatic joint.
        """
        return self.baseline.torque(motion) if self.baseline else self.inverse.torque(self.theta, motion)

    def recorded_torque(self, motion: FilteredMotion) -> Array:
        """Compute the torque that a motion needs, at the time at which it is recorded.

        Parameters
        ----------
        motion
            Filtered motion of a run.

        Returns
        -------
        ndarray, shape (n, n_joints)
            `torque` at t + T for the time t.
        """
        return replace(motion, torque=self.torque(motion)).with_delay(-self.delay).torque

    def driving(self, run: Run) -> Run:
        """Return a run with the torque that drives a simulation of this model.

        Parameters
        ----------
        run
            Run with its recorded torque.

        Returns
        -------
        Run
            Its torque delayed, and without the constant torque.
        """
        later = with_delayed_torque(run, self.delay)
        return later.but(u=later.u - self.offset)

    @property
    def offset(self) -> Array:
        """Constant torque that is subtracted from the recorded torque of a simulation, shape (n_joints,)."""
        return self.baseline.offset if self.baseline else np.zeros(len(self.inverse.prismatic))


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """Figures of one model on one run; NaN where a simulation did not stay finite, or a mass is negative.

    Parameters
    ----------
    free_rmse
        [rad] or [m], shape (n_joints,).
    torque_rmse
        [N m] or [N], shape (n_joints,). Rows at which a joint rests are left out: friction holds it there with any
        torque up to its level, which no motion tells.
    torque_error
        The same over the RMS of the torque [1], shape (n_joints,); NaN where that is zero throughout.
    away_rmse
        The same away from reversals too [N m] or [N], shape (n_joints,): the filter decides there when friction turns,
        and what it leaves would hide the difference of two models.
    horizon_rmse
        [rad] or [m] by horizon, shape (n_joints,) each; horizons longer than the run are left out.
    closed_rmse
        [rad] or [m] through the recorded controller, shape (n_joints,); None where there is none.
    """

    free_rmse: Array
    torque_rmse: Array
    torque_error: Array
    away_rmse: Array
    horizon_rmse: Mapping[str, Array] = field(default_factory=dict)
    closed_rmse: Array | None = None

    @property
    def badness(self) -> float:
        """Mean logarithm over torque and position: of the torque's RMS away from reversals, and of that over 1 s.

        Both count, because each fails where the other works: near resonance inertia and weight cancel in the torque,
        and under feedback a simulation drifts. Of runs below 1 s the longest horizon counts. Where the free simulation
        of the whole run misses less than those of 1 s, it is the measured states they begin from that miss, and the
        free simulation counts. Infinite where a simulation did not stay finite.
        """
        return _mean_logarithm(np.concatenate([self.away_rmse, self._position_rmse]))

    @property
    def position_badness(self) -> float:
        """Mean logarithm of the position's RMS alone, as `badness` takes it; infinite likewise."""
        return _mean_logarithm(self._position_rmse)

    @property
    def _position_rmse(self) -> Array:
        """RMS of the position over 1 s, or the longest below, or of the free simulation where that is less."""
        lengths = [h for h in self.horizon_rmse if float(h) <= THRESHOLDS.longest_judged_horizon_s]
        position = self.horizon_rmse[max(lengths, key=float)] if lengths else self.free_rmse
        # fmin passes over a free simulation that did not stay finite.
        return np.fmin(position, self.free_rmse)

    def as_json(self) -> dict[str, Any]:
        """Convert to ``figures.model`` or ``figures.baseline`` of a run in identification.json.

        Returns
        -------
        dict
            Each figure as one number for one joint and a list for several, None where it is not finite;
            ``horizon_rmse`` by horizon; ``closed_rmse`` only where a controller was simulated.
        """
        closed = {} if self.closed_rmse is None else {"closed_rmse": _plain(self.closed_rmse)}
        return {
            **closed,
            "free_rmse": _plain(self.free_rmse),
            "torque_rmse": _plain(self.torque_rmse),
            "torque_error": _plain(self.torque_error),
            "horizon_rmse": {name: _plain(rmse) for name, rmse in self.horizon_rmse.items()},
        }


def _mean_logarithm(values: Array) -> float:
    """Return the mean of ln of the values; infinite where one of them has none."""
    return float(np.mean(np.log(values))) if np.isfinite(values).all() and (values > 0).all() else np.inf


def _plain(values: Array) -> float | list[float | None] | None:
    numbers = [float(x) if np.isfinite(x) else None for x in values]
    return numbers[0] if len(numbers) == 1 else numbers


def figures_of(
    model: Model, run: Run, motion: FilteredMotion, error: Array, states: FilteredMotion | None = None
) -> Figures:
    """Compute the figures of a model on a run.

    Parameters
    ----------
    model
        Model of the run's configuration.
    run
        Run of any use; only its scored rows count.
    motion
        Its motion, filtered with the width of all runs of the configuration.
    error
        `torque_residual` of the model along that motion.
    states
        The motion that simulations begin from, whose filter may be narrower; the same motion where None.

    Returns
    -------
    Figures
    """
    states = states or motion
    torque = motion.through_filter(motion.with_delay(model.delay).torque)[motion.interior]
    moving, away = _moving(motion), _away(motion)
    size, torque_rmse = _rms_of(torque, moving), _rms_of(error, moving)
    driven = model.driving(run)
    length = run.t[-1] - run.t[run.score_from]
    moves = model.baseline is None or model.baseline.has_positive_masses(motion)
    nothing = np.full(run.y.shape[1], np.nan)
    lengths = [h for h in THRESHOLDS.horizons_of_prediction_s if length > h]
    return Figures(
        free_rmse=column_rms(run.y[run.score_from :] - simulate_freely(model, run, states)) if moves else nothing,
        torque_rmse=torque_rmse,
        # A torque that is zero throughout, as of a free swing, has no size that an error is a share of.
        torque_error=torque_rmse / np.where(size > 0, size, np.nan),
        away_rmse=_rms_of(error, away),
        horizon_rmse={f"{h:g}": _horizon(model, driven, states, h) if moves else nothing for h in lengths},
    )


def torque_residual(model: Model, motion: FilteredMotion) -> Array:
    """Compute measured minus computed torque along a motion.

    Parameters
    ----------
    model
        Model of the motion's configuration.
    motion
        Filtered motion.

    Returns
    -------
    ndarray, shape (n_interior, n_joints)
        [N m] or [N]. Both pass through the filter once more: a computed friction turns within a row, and the measured
        one was filtered.
    """
    return motion.through_filter(motion.with_delay(model.delay).torque - model.torque(motion))[motion.interior]


def _moving(motion: FilteredMotion) -> Mask:
    """Return the interior rows at which each joint moves, shape (n_interior, n_joints); all where it always rests."""
    rest = np.column_stack([at_rest(v, motion.width_in_rows) for v in motion.v.T])[motion.interior]
    return ~rest | rest.all(axis=0)


def _away(motion: FilteredMotion) -> Mask:
    """Return the interior rows at which each joint moves and does not turn; those of `_moving` where there are none."""
    turn = np.column_stack([near_reversal(v, motion.width_in_rows) for v in motion.v.T])[motion.interior]
    moving = _moving(motion)
    away = moving & ~turn
    return np.where(away.any(axis=0), away, moving)


def _rms_of(signal: Array, rows: Mask) -> Array:
    """Return the RMS of each column over its own rows, shape (n_joints,)."""
    return np.array([rms(column[of]) for column, of in zip(signal.T, rows.T, strict=True)])


class _States:
    """Measured states of a run: position and speed of the filtered motion, friction states driven by that speed."""

    def __init__(self, model: Model, run: Run, motion: FilteredMotion) -> None:
        self.model, self.run, self.motion = model, run, motion
        self._row = 0
        self._friction: list[Array | None] = [None] * len(run.free_joints)

    def at(self, row: int) -> Array:
        """Return the state at a row, shape (n_x,); rows must be asked for in ascending order."""
        run, motion, n = self.run, self.motion, len(self.run.free_joints)
        x = np.array(initial_state(self.model.simulator.equations, run))
        if row == 0:
            return x
        x[:n] = [np.interp(run.t[row], motion.t, q) for q in motion.q.T]
        x[n : 2 * n] = [np.interp(run.t[row], motion.t, v) for v in motion.v.T]
        place = int(np.searchsorted(motion.t, run.t[row], side="right"))
        if place > self._row + 1:
            rows = slice(self._row, place)
            for k in range(n):
                _, self._friction[k] = self.model.inverse.friction_along(
                    self.model.theta, motion, k, rows, self._friction[k]
                )
            self._row = place - 1
        known = [state for state in self._friction if state is not None]
        if known:
            x[2 * n :] = np.concatenate(known)
        return x


def simulate_freely(model: Model, run: Run, motion: FilteredMotion) -> Array:
    """Simulate a run from its measured start, without feedback.

    Parameters
    ----------
    model
        Model of the run's configuration.
    run
        Run with its recorded torque.
    motion
        Its filtered motion.

    Returns
    -------
    ndarray, shape (n_scored, n_joints)
        Positions at the scored rows [rad] or [m].
    """
    driven = model.driving(run)
    start = _States(model, driven, motion).at(run.score_from)
    y, _ = model.simulator.onward(model.theta, driven, slice(run.score_from, run.t.size), start)
    return y[:, : run.y.shape[1]]


def _horizon(model: Model, run: Run, motion: FilteredMotion, horizon: float) -> Array:
    """Return the RMS over all simulations of one length."""
    t, first = run.t, run.score_from
    spacing = max(horizon, (t[-1] - t[first]) / THRESHOLDS.most_simulations_of_horizon)
    states = _States(model, run, motion)
    errors = []
    for begin in np.arange(t[first], t[-1] - horizon, spacing):
        row = int(np.searchsorted(t, begin))
        end = int(np.searchsorted(t, t[row] + horizon, side="right"))
        y, _ = model.simulator.onward(model.theta, run, slice(row, end), states.at(row))
        errors.append(run.y[row + 1 : end] - y[1:, : run.y.shape[1]])
    return column_rms(np.concatenate(errors)) if errors else np.full(run.y.shape[1], np.nan)
