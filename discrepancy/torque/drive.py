"""The torque that a drive makes along its measured motion: equations with a drive in, `KnownDrive` out.

Inertia, gravity and friction are known from a motor voltage up to one common factor, R/kt. So the drive keeps the
parameters that were identified or stated. Where inertia or gravity is known, the plant gain takes that factor; what the
back-EMF is off by goes to the viscous friction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.baseline.driven import with_torque, without_drive
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.inverse_dynamics import torque_runs
from haptid.measurement.signals.filtered_motion import common_width, filter_run
from haptid.measurement.values.run import Run
from haptid.model.equations.drive import Drive
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.drive_terms import drive_quantities
from haptid.support.linear_algebra import rms

OF_RIGID_BODY = ("inertia", "gravity_cos", "gravity_sin")
"""Parameters each of which sets the scale of the torque where it is known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownDrive:
    """A drive with its parameters.

    Parameters
    ----------
    drive
        Drive of the joint.
    rows
        Its parameters with the values that are used as ``initial``.
    """

    drive: Drive
    rows: tuple[Quantity, ...]

    @property
    def values(self) -> Mapping[str, float]:
        """Parameters by id, in SI units."""
        return {q.id: q.initial for q in self.rows}

    def torque_of(self, run: Run) -> Run:
        """Return a run whose input is the torque of the drive along the measured motion.

        Parameters
        ----------
        run
            Run of the driven joint.

        Returns
        -------
        Run
            Torque as ``u``, shape (n_t, 1) [N m]; without inputs of the drive.
        """
        return with_torque(run, self.drive, dict(self.values))

    def turn(self, runs: Sequence[Run]) -> tuple[Run, ...]:
        """Exchange torque and position of runs, as `torque_runs` does, with one noise for all of them.

        Parameters
        ----------
        runs
            Runs of the driven joint.

        Returns
        -------
        tuple of Run
            The noise is what the position's noise makes of the torque through the controller, or that of the torque's
            neighbouring rows where it is larger, root mean square of all runs. A torque that was computed from a
            rounded position does not change between most rows, which show no noise then.
        """
        torques = [self.torque_of(run) for run in runs]
        gain = filter_run(torques[0], common_width(torques)).white_noise_gain
        turned = torque_runs(torques)
        largest = [
            max(float(one.noise[0]), gain * self._noise_through_controller(run))
            for run, one in zip(runs, turned, strict=True)
        ]
        noise = rms(largest)
        return tuple(one.but(noise=np.array([noise])) for one in turned)

    def _noise_through_controller(self, run: Run) -> float:
        """Return how the torque changes with an error of the position of one standard deviation [N m], RMS."""
        error = run.sensor_std
        above, below = (self.torque_of(run.but(y=run.y + sign * error)).u for sign in (0.5, -0.5))
        return rms(above - below)

    def rigid(self, equations: Equations, *, prismatic: bool) -> Equations:
        """Return the equations of the same joint with the torque as input.

        Parameters
        ----------
        equations
            Equations of the joint with its drive.
        prismatic
            Whether the joint is prismatic.

        Returns
        -------
        Equations
            Its plant gain ``Kp`` is free, near 1, where a parameter of the rigid body is known and not 0: a gain far
            from 1 would make what is known too small to count.
        """
        known = [equations.parameter(id) for id in OF_RIGID_BODY if any(q.id == id for q in equations.parameters)]
        most = THRESHOLDS.torque.largest_gain_of_known_drive
        scaled = any(q.fixed and q.initial for q in known)
        torque = without_drive(equations, self.drive, prismatic=prismatic)
        if not scaled:
            return torque
        near_1 = {"fixed": False, "initial": 1.0, "lower": 1.0 / most, "upper": most}
        return torque.with_parameters({"Kp": near_1})


def known_drive(equations: Equations, carried: Fit | None = None) -> KnownDrive | None:
    """Choose the parameters of a drive.

    Parameters
    ----------
    equations
        Equations of the joint, with the stated parameters of the drive.
    carried
        Fit of the same runs by the identification.

    Returns
    -------
    KnownDrive or None
        With the fitted parameters, or the stated ones without a fit; None where the joint has no drive.
    """
    if equations.drive is None:
        return None
    own = {q.id for q in drive_quantities(equations.drive)}
    fitted = {} if carried is None else carried.values
    rows = (q.but(initial=fitted.get(q.id, q.initial)) for q in equations.parameters if q.id in own)
    return KnownDrive(drive=equations.drive, rows=tuple(rows))
