"""Model and plain model of a joint with a drive: as `compare`, on the torque that the fitted drive makes.

1. Compute the torque of the fitted drive along each measured motion.
2. Compare both models on these torques, without the drive.
3. Simulate both through the drive from the measured start: through its controller too where that is known
   (``closed_rmse``), else from its command (``free_rmse``), for the back-EMF of a simulation is that of its own motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.baseline.compared import Compared, compare
from haptid.identification.baseline.figures import Figures
from haptid.identification.baseline.plain_parameters import plain_theta, with_constant_torque
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Array, Run
from haptid.model.device.device import Device
from haptid.model.equations.drive import Drive
from haptid.model.equations.equations import Equations
from haptid.model.joint.drive_terms import drive_quantities, torque_along
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.linear_algebra import column_rms

EXACT_ALONG_MOTION = ("torque", "current")
"""Drives whose torque does not depend on the motion, so that a simulation from that torque is one from the command."""


def compare_driven(  # noqa: PLR0913 # a model, its runs, and how they were recorded, fitted and simulated
    equations: Equations,
    theta: Array,
    runs: Sequence[Run],
    device: Device | None,
    posture: Sequence[float],
    *,
    threads: int = 1,
    torque_scored: bool = False,
    step: float = MODEL.inner_step_s,
) -> Compared:
    """Compute the figures of a driven joint's model and of the plain model.

    Parameters
    ----------
    equations
        Equations of a single joint with a drive.
    theta
        Fitted parameters in the order of ``equations.parameters``, shape (n_p,).
    runs
        Runs of the configuration.
    device
        Device of the campaign; None for a single joint.
    posture
        Positions of the locked joints [rad].
    threads
        Threads that simulate the runs side by side.
    torque_scored
        Whether the parameters were fitted to the torque.
    step
        Longest inner step of the simulations [s].

    Returns
    -------
    Compared
        Its plain model is that of the drive's torque at the fitted torque constant and resistance.
    """
    drive = equations.drive
    if drive is None:
        return compare(equations, theta, runs, device, posture, threads=threads, torque_scored=torque_scored, step=step)
    values = {q.id: float(value) for q, value in zip(equations.parameters, theta, strict=True)}
    rigid = without_drive(equations, drive, prismatic=bool(runs[0].prismatic[0]))
    torques = [with_torque(run, drive, values) for run in runs if run.use != "excluded"]
    rigid_theta = np.array([values[q.id] for q in rigid.parameters])
    # The back-EMF in this torque is computed from the motion, and cannot be late behind it.
    compared = compare(rigid, rigid_theta, torques, device, posture, threads=threads, with_delay=False, step=step)
    if drive.kind in EXACT_ALONG_MOTION and not drive.is_closed:
        return compared
    models = {"model": np.asarray(theta, dtype=np.float64)}
    if compared.baseline is not None:
        plain = plain_theta(compared.baseline, rigid, torques)
        plain = with_constant_torque(plain, compared.baseline, rigid, torques)
        known = dict(zip((q.id for q in rigid.parameters), plain.tolist(), strict=True))
        models["baseline"] = np.array([known.get(q.id, values[q.id]) for q in equations.parameters])
    simulator = KernelSimulator.of(equations).with_step(step)
    through = {name: {run.file: _rmse_through(simulator, at, run) for run in runs} for name, at in models.items()}
    figures: dict[tuple[str, str], dict[str, Figures]] = {}
    for run in runs:
        both = compared.figures.get((run.file, run.use), {})
        figures[run.file, run.use] = {
            name: _with_rmse_through(one, through[name][run.file], is_closed=drive.is_closed)
            for name, one in both.items()
        }
    return replace(compared, figures=figures)


def without_drive(equations: Equations, drive: Drive, *, prismatic: bool) -> Equations:
    """Return the nominal equations of the same joint with the torque as input.

    Parameters
    ----------
    equations
        Equations of one joint with a drive.
    drive
        Its drive.
    prismatic
        Whether the joint slides.

    Returns
    -------
    Equations
        From torque to position, with the same parameters and friction law, those of the drive left out.
    """
    own = {q.id for q in drive_quantities(drive)}
    rows = tuple(q for q in equations.parameters if q.id not in own)
    return joint_equations(equations.joints[0], parameters=rows, prismatic=prismatic, friction=equations.friction[0])


def with_torque(run: Run, drive: Drive, values: dict[str, float]) -> Run:
    """Return a run whose input is the torque of its drive along the measured motion.

    Parameters
    ----------
    run
        Run of the driven joint.
    drive
        Its drive.
    values
        Parameters of the drive by id, in SI units.

    Returns
    -------
    Run
        Without inputs of the drive; the speed is the measured one, or that of the differenced position.
    """
    q = run.y[:, 0]
    v = np.gradient(q, run.t) if run.v is None else run.v[:, 0]
    torque = torque_along(drive, values, run.drive_inputs, q, v, run.t)
    return run.but(u=torque[:, None], drive_inputs={})


def _with_rmse_through(figures: Figures, rmse: Array, *, is_closed: bool) -> Figures:
    """Return the figures with that of a simulation through the drive."""
    if is_closed:
        return replace(figures, closed_rmse=rmse)
    # A plain model of negative mass has no simulation, with or without a drive.
    return replace(figures, free_rmse=np.where(np.isnan(figures.free_rmse), np.nan, rmse))


def _rmse_through(simulator: KernelSimulator, theta: Array, run: Run) -> Array:
    y = simulator.simulate(theta, run).y[run.scored, :1]
    return column_rms(run.y[run.scored] - y)
