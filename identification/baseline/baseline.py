"""The field's plain model of a configuration: `Run`s in, `Baseline` out.

Inertia, gravity, Coulomb and viscous friction and a constant torque are fitted to the torque of all fitted runs by
weighted least squares of the inverse dynamic model (IDIM-LS). Motion and torque pass through one filter, and columns
and torque through it once more (the parallel filter of Gautier 1997). For coupled joints the rigid body is the
regressor of the locked motion. No other fit is to do worse than this one of seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.identification.baseline.delay import Delay, estimate_delay
from haptid.identification.baseline.least_squares import LeastSquares, weighted_least_squares
from haptid.identification.baseline.regressor import UNITS, Regressor
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.control_detection import position_control
from haptid.measurement.signals.filtered_motion import FilteredMotion, common_width, filter_run
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.model.device.device import Device
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.support.linear_algebra import column_rms
from haptid.support.processes.threads import on_one_thread


@dataclass(frozen=True, slots=True, kw_only=True)
class Baseline:
    """The plain model with its estimates.

    Parameters
    ----------
    regressor
        Columns of the model.
    estimate
        Parameters, in the order of ``regressor.ids``, of the torque times ``gain``.
    gain
        Factor of each joint on the recorded torque, shape (n_joints,).
    delay
        Delay of the recorded torque; None where none earned its place.
    """

    regressor: Regressor
    estimate: LeastSquares
    gain: Array
    delay: Delay | None = None

    @property
    def delay_s(self) -> float:
        """Delay of the recorded torque [s]; 0 where none earned its place."""
        return 0.0 if self.delay is None else self.delay.value

    @property
    def values(self) -> dict[str, float]:
        """Estimates by id."""
        return dict(zip(self.regressor.ids, self.estimate.theta.tolist(), strict=True))

    def of_joint(self, id: str, k: int) -> float:
        """Return a parameter of the free joint at index k by its id without number.

        Parameters
        ----------
        id
            Id without the joint's number, as ``Fc``.
        k
            Index of the joint among the free ones.

        Returns
        -------
        float
            Estimate in the parameter's unit.
        """
        return self.values[id + id_suffixes(self.regressor.joints)[k]]

    @property
    def offset(self) -> Array:
        """Constant torque of every free joint as it was recorded [N m], shape (n_joints,)."""
        return np.array([self.of_joint("offset", k) for k in range(len(self.regressor.joints))]) / self.gain

    def torque(self, motion: FilteredMotion) -> Array:
        """Predict the torque that a motion needs.

        Parameters
        ----------
        motion
            Filtered motion of the free joints.

        Returns
        -------
        ndarray, shape (n, n_joints)
            Torque as it was recorded [N m], without the gain, at the time at which it acts.
        """
        return np.asarray(self.regressor.columns(motion) @ self.estimate.theta / self.gain)

    def has_positive_masses(self, motion: FilteredMotion) -> bool:
        """Say whether the mass matrix is positive definite along a motion: else no torque moves the model that way.

        Parameters
        ----------
        motion
            Filtered motion of the free joints.

        Returns
        -------
        bool
            False also where a rounded eigenvalue is 0. Least squares know of no sign: what the plain model lacks, as a
            spring, may come out as a negative mass.
        """
        places = np.linspace(0, motion.t.size - 1, min(motion.t.size, THRESHOLDS.postures_of_mass_check)).astype(int)
        q, joints = motion.q[places], range(motion.q.shape[1])

        def inertial(a: Array) -> Array:
            at = replace(motion, t=motion.t[places], q=q, v=np.zeros_like(q), a=a, torque=np.zeros_like(q))
            return np.asarray(self.regressor.columns(at) @ self.estimate.theta)

        rest = inertial(np.zeros_like(q))
        columns = [inertial(np.broadcast_to(np.eye(len(joints))[j], q.shape)) - rest for j in joints]
        mass = np.stack(columns, axis=-1)
        return bool(np.linalg.eigvalsh((mass + np.swapaxes(mass, -1, -2)) / 2).min() > 0.0)

    def as_json(self) -> dict[str, Any]:
        """Return ``baseline`` of identification.json; the std of what the rows do not determine is None.

        Returns
        -------
        dict
            ``parameters``: value, std and unit by id. A single joint without gravity has the gravity terms at 0.
            ``delay`` of the torque; None where none earned its place.
        """
        rows = zip(self.regressor.ids, self.estimate.theta, self.estimate.std, self.regressor.units, strict=True)
        parameters: dict[str, dict[str, float | str | None]] = {
            id: {"value": float(value), "std": float(std) if np.isfinite(std) else None, "unit": unit}
            for id, value, std, unit in rows
        }
        # A single joint without gravity, such as a slide, has the other keys of the format as well, at 0.
        if len(self.regressor.joints) == 1:
            slides = [self.regressor.units[-1] == "N"]
            for id, unit in UNITS.items():
                parameters.setdefault(id, {"value": 0.0, "std": None, "unit": unit_for(unit, slides)})
        return {"parameters": parameters, "delay": None if self.delay is None else self.delay.as_json()}


@on_one_thread
def fit_baseline(
    runs: Sequence[Run],
    device: Device | None,
    posture: Sequence[float],
    gain: Sequence[float],
    *,
    with_delay: bool = True,
) -> Baseline | None:
    """Fit the plain model to the fitted runs of a configuration.

    Parameters
    ----------
    runs
        Runs of the configuration, whatever their use.
    device
        Device of the campaign; None for a single joint.
    posture
        Positions of the locked joints [rad], shape (n_q,).
    gain
        Factor of each free joint on the recorded torque.
    with_delay
        Whether the torque may have a delay: not where it was computed along the motion.

    Returns
    -------
    Baseline or None
        None where the fitted runs have too few rows inside the reach of the filter.
    """
    fitted = [run for run in runs if run.use == "fit"]
    regressor = Regressor.of(device, fitted[0].free_joints, posture, fitted[0].prismatic)
    width = common_width(runs)
    motions = [filter_run(run, width) for run in fitted]
    moving = [moving_rows(m) for m in motions]
    least_rows = max(THRESHOLDS.least_rows_of_plain_model, 2 * len(regressor.ids))
    if sum(rows[m.interior].all(axis=1).sum() for m, rows in zip(motions, moving, strict=True)) < least_rows:
        return None
    columns = [m.through_filter(regressor.columns(m)) for m in motions]
    factor = np.asarray(gain, dtype=np.float64)
    driven = [replace(m, torque=m.torque * factor) for m in motions]

    def fit(delay: Delay | None) -> Baseline:
        later = [m.with_delay(0.0 if delay is None else delay.value) for m in driven]
        estimate = weighted_least_squares(
            [(W * rows[:, :, None])[m.interior] for m, W, rows in zip(later, columns, moving, strict=True)],
            [(m.through_filter(m.torque) * rows)[m.interior] for m, rows in zip(later, moving, strict=True)],
            regressor.nonnegative,
        )
        return Baseline(regressor=regressor, estimate=estimate, gain=factor, delay=delay)

    prompt = fit(None)
    if not with_delay:
        return prompt
    controlled = any(position_control(run, k) for run in fitted for k in range(len(run.free_joints)))
    delay = estimate_delay(driven, columns, moving, controlled=controlled)
    if delay is None:
        return prompt
    # Rows at rest took part in nothing so far; the figures of a run have them.
    late = fit(delay)
    return late if _error_of(late, motions) < _error_of(prompt, motions) else prompt


def _error_of(baseline: Baseline, motions: Sequence[FilteredMotion]) -> float:
    """Return the energy of the residual torque over that of the torque, summed over runs and joints."""
    total = 0.0
    for motion in motions:
        torque = motion.with_delay(baseline.delay_s).torque
        inside = motion.interior
        left = motion.through_filter(torque - baseline.torque(motion))[inside]
        size = np.sum(motion.through_filter(torque)[inside] ** 2, axis=0)
        total += float(np.sum(np.sum(left**2, axis=0) / np.maximum(size, np.finfo(float).tiny)))
    return total


def delay_of_torque(runs: Sequence[Run], device: Device | None = None, posture: Sequence[float] = ()) -> float:
    """Return the delay of the recorded torque that the plain model finds, for what follows the torque of the same runs.

    Parameters
    ----------
    runs
        Runs of the configuration, whatever their use.
    device
        Device of the campaign; None for a single joint.
    posture
        Positions of the locked joints [rad].

    Returns
    -------
    float
        T [s], so that τ(t − T) acts at t; 0 where none earned its place.
    """
    used = [run for run in runs if run.use != "excluded"]
    baseline = fit_baseline(used, device, posture, [1.0] * len(used[0].free_joints))
    return 0.0 if baseline is None else baseline.delay_s


def moving_rows(motion: FilteredMotion) -> NDArray[np.bool_]:
    """Say which rows of which joint move: at rest, friction takes any value up to its level.

    Parameters
    ----------
    motion
        Filtered motion of the free joints.

    Returns
    -------
    ndarray of bool, shape (n_t, n_joints)
        True where the speed is above `THRESHOLDS.largest_rest_speed_over_rms_speed` times the joint's RMS speed.
    """
    rms = column_rms(motion.v)
    return np.asarray(np.abs(motion.v) > THRESHOLDS.largest_rest_speed_over_rms_speed * rms)
