"""Verification of the whole model: `Device`, identified values and `Run`s with all joints free in, `Verification` out.

1. Build the equations of the whole device and set the values; parameters without one keep their first guess.
2. Halve the inner step until its error hides in what the model leaves: friction that is rigid in one joint alone may
   need a shorter one where all joints move.
3. Simulate every run under the stated controller, where controller and references are known, and under the recorded
   torques; repeat both for every draw of the values.
4. Compare with the measured positions: RMS over noise, over the range, and over noise and spread of the draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from haptid.identification.simulators.closed_loop import (
    Controller,
    reference_of,
    simulate_closed_loop,
    simulate_recorded,
)
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.verification.result import JointCheck, Mode, RunCheck, Verification
from haptid.measurement.values.run import Array, Run
from haptid.model.device.device import Device
from haptid.model.joint.joint_in_device import Effects
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.errors import InputError
from haptid.support.linear_algebra import column_rms, rms
from haptid.support.processes.threads import map_threads


def verify(
    device: Device,
    values: Mapping[str, float],
    runs: Sequence[Run],
    controller: Controller | Mapping[str, Any] | None,
    *,
    draws: Sequence[Mapping[str, float]] | None = None,
    effects: Effects | None = None,
    threads: int = 1,
) -> Verification:
    """Simulate the runs with all joints free by the whole model and compare them with the measurement.

    Parameters
    ----------
    device
        Device of the campaign.
    values
        Parameters of `model.joint.whole_device.full_equations` by id; those left out keep the device's first guess and
        are listed as assumed.
    runs
        Runs of any configuration; those with all joints free and not excluded are used.
    controller
        The controller, or the ``[controller]`` table of the campaign; None where there is none.
    draws
        Draws of the values by id from their uncertainty; an id that a draw leaves out has its entry in ``values``.
    effects
        Effects that are added to the model, by joint.
    threads
        Threads that simulate the draws side by side; the result does not depend on their number.

    Returns
    -------
    Verification
        Without runs where no run has all joints free.

    Raises
    ------
    InputError
        For an id that the model does not have, or a controller table that does not fit the device.
    NumericalError
        Where the compiler is missing or fails.
    """
    equations = full_equations(device, effects)
    wanted = [run for run in runs if run.free_joints == equations.joints and run.use != "excluded"]
    if isinstance(controller, Mapping):
        controller = Controller.from_table(controller, len(equations.joints)) if controller else None
    ids = [q.id for q in equations.parameters]
    theta = _theta({q.id: q.initial for q in equations.parameters}, values)
    drawn = [_theta(dict(zip(ids, theta, strict=True)), draw) for draw in draws or ()]
    checks, step = list[RunCheck](), MODEL.inner_step_s
    if wanted:
        kernel = cached_kernel(equations)
        step = _needed_step(kernel, theta, wanted)
        kernel = kernel.with_step(step)
        for run in wanted:
            checks += _check_run(kernel, [theta, *drawn], run, controller, threads)
    assumed = tuple(q.id for q in equations.parameters if q.id not in values and not q.fixed)
    law = controller.law if controller else ""
    return Verification(runs=tuple(checks), law=law, assumed=assumed, inner_step=step)


def _needed_step(kernel: CompiledKernel, theta: Array, runs: Sequence[Run]) -> float:
    """Return the longest inner step h whose error y_h − y_{h/2} hides in the residual y − y_{h/2} of every run [s].

    A run of which no step is short enough, as where small errors grow, asks for none.
    """
    step = kernel.kernel.step
    for run in runs:
        tried, y = step, simulate_recorded(kernel.with_step(step), theta, run)
        for _ in range(THRESHOLDS.most_halvings_of_whole_step):
            finer = simulate_recorded(kernel.with_step(tried / 2), theta, run)
            least = THRESHOLDS.largest_inner_step_error_over_residual * column_rms(run.y - finer)
            if np.all(column_rms(finer - y) <= least):  # False where a simulation is not finite
                step = tried
                break
            tried, y = tried / 2, finer
    return step


def _theta(base: Mapping[str, float], values: Mapping[str, float]) -> Array:
    unknown = sorted(set(values) - set(base))
    if unknown:
        raise InputError("values of the whole model", expected="ids of its parameters", got=", ".join(unknown))
    return np.array([values.get(id, value) for id, value in base.items()])


def _check_run(
    kernel: CompiledKernel, thetas: Sequence[Array], run: Run, controller: Controller | None, threads: int
) -> list[RunCheck]:
    """Check a run at the identified values, which come first, and at draws of them."""
    checks, reference = [], reference_of(run)
    if controller is not None and reference is not None:
        closed = partial(simulate_closed_loop, kernel, run=run, controller=controller, reference=reference)
        made = map_threads(closed, thetas, threads=threads)
        checks.append(_check(run, "closed_loop", [y for y, _ in made], made[0][1]))
    opened = map_threads(partial(simulate_recorded, kernel, run=run), thetas, threads=threads)
    checks.append(_check(run, "open_loop", opened, run.u))
    return checks


def _check(run: Run, mode: Mode, positions: Sequence[Array], torque: Array) -> RunCheck:
    simulated, drawn = positions[0], [y for y in positions[1:] if np.isfinite(y).all()]
    # One draw has no standard deviation: the spread is then unknown, not 0.
    spread = np.std(drawn, axis=0, ddof=1) if len(drawn) > 1 else np.full_like(run.y, np.nan)
    rmse = column_rms(run.y - simulated)
    torque_difference = column_rms(run.u - torque)
    joints = tuple(
        JointCheck(
            joint=joint,
            prismatic=run.prismatic[i],
            rmse_rad=float(rmse[i]),
            rmse_over_noise=float(rmse[i] / run.sensor_std[i]),
            nrmse=float(rmse[i] / max(float(np.ptp(run.y[:, i])), 1e-300)),
            torque_difference_Nm=float(torque_difference[i]),
            torque_rms_Nm=rms(run.u[:, i]),
            spread_rad=rms(spread[:, i]),
        )
        for i, joint in enumerate(run.free_joints)
    )
    return RunCheck(
        file=run.file,
        use=run.use,
        mode=mode,
        joints=joints,
        draws=len(drawn),
        t=run.t,
        measured=run.y,
        simulated=simulated,
        spread=spread,
    )
