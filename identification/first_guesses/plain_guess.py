"""First guesses from the plain model: `Equations`, `Run`s and perhaps their `Baseline` in, `Equations` out.

A simulation that begins with friction of a thousandth of the machine's own, as the default beside a URDF is, runs away
from the data, and a fit takes minutes to come back, or does not. Along a measured motion, too small a guess of Coulomb
friction bounds stiction below what friction is. The plain model tells sliding friction by least squares, also where
the joint moves at one speed and rests:

1. Fit the plain model to the fitted runs.
2. Give the friction that neither device nor user states the sizes that follow from it.
3. Begin the inertial coefficients at the plain model's as well, within their bounds.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.baseline.baseline import Baseline, fit_baseline
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.filtered_motion import FilteredMotion, common_width, filter_run
from haptid.measurement.values.run import Array, Run
from haptid.model.device.device import Device
from haptid.model.device.stated_parameters import ROWS, possible_guess
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.law import Sliding
from haptid.model.friction.registry import law_named
from haptid.model.joint.coupled_joints import configuration_equations


def guess_of_device(
    equations: Equations, runs: Sequence[Run], device: Device, posture: Sequence[float], stated: Collection[str]
) -> Equations:
    """Set first guesses and bounds of friction that nobody states.

    Parameters
    ----------
    equations
        Equations of the free joints of a device.
    runs
        Runs of these joints, whatever their use.
    device
        The device.
    posture
        Positions of the locked joints [rad], shape (n_q,).
    stated
        Ids of the parameters that the user states.

    Returns
    -------
    Equations
        The same where all friction is stated, or the runs do not show the plain model.
    """
    joints = runs[0].free_joints if runs else ()
    suffixes = id_suffixes(joints)
    open_ones = [_ids_at_defaults(equations, suffix, k, stated) for k, suffix in enumerate(suffixes)]
    if not any(open_ones) or not any(run.use == "fit" for run in runs):
        return equations
    gain = [equations.parameter(f"Kp{suffix}").initial for suffix in suffixes]
    plain = fit_baseline(runs, device, posture, gain)
    if plain is None:
        return equations
    changes = _friction(equations, plain, runs, dict(zip(suffixes, open_ones, strict=True)))
    if all(open_ones):
        changes |= _begin_at(equations, plain, stated)
    return equations.with_parameters(changes)


def states_no_friction(device: Device, joints: Sequence[int], posture: Sequence[float]) -> bool:
    """Whether a device leaves the friction of all free joints open, so that their runs tell the first guess.

    Parameters
    ----------
    device
        The device.
    joints
        Numbers of the free joints.
    posture
        Positions of the locked joints [rad], shape (n_q,); may be empty.

    Returns
    -------
    bool
    """
    equations = configuration_equations(device, joints, posture or None)
    return all(_ids_at_defaults(equations, suffix, k, ()) for k, suffix in enumerate(id_suffixes(joints)))


def friction_left_open(
    device: Device, joints: Sequence[int], posture: Sequence[float], stated: Collection[str]
) -> tuple[str, ...]:
    """List the friction parameters whose range haptid chose, because neither device nor user states them.

    Parameters
    ----------
    device
        The device.
    joints
        Numbers of the free joints.
    posture
        Positions of the locked joints [rad], shape (n_q,); may be empty.
    stated
        Ids of the parameters that the user states.

    Returns
    -------
    tuple of str
        Ids as in the equations of the free joints, as ``sigma0_1``, or ``sigma0`` for a single joint.
    """
    equations = configuration_equations(device, joints, posture or None)
    left_open: list[str] = []
    for k, suffix in enumerate(id_suffixes(joints)):
        left_open += [f"{id}{suffix}" for id in _ids_at_defaults(equations, suffix, k, stated)]
    return tuple(left_open)


def guess_along(
    equations: Equations, plain: Baseline | None, runs: Sequence[Run], stated: Collection[str]
) -> Equations:
    """Set first guesses and bounds of a single joint whose torque is scored along its measured motion.

    Parameters
    ----------
    equations
        Equations of the joint, whose guesses are those of its runs alone.
    plain
        The plain model of the runs; None where they do not show it.
    runs
        Runs of the joint, whatever their use.
    stated
        Ids of the parameters that the user states, which stay as they are.

    Returns
    -------
    Equations
    """
    coulomb = law_named(equations.friction[0]).roles.coulomb
    # The larger guess counts: stiction is bounded by a multiple of it, and too low a bound holds all friction down.
    if plain is None or plain.of_joint("Fc", 0) <= equations.parameter(coulomb).initial:
        return equations
    rows = [equations.parameter(row.id) for row in law_named(equations.friction[0]).parameters]
    own = [q.id for q in rows if q.scale == "log" and not q.fixed and q.id not in stated]
    changes = _friction(equations, plain, runs, {"": own})
    return equations.with_parameters(changes | _begin_at(equations, plain, stated))


def _friction(
    equations: Equations, plain: Baseline, runs: Sequence[Run], own: Mapping[str, Sequence[str]]
) -> dict[str, dict[str, object]]:
    """Return guesses and bounds of friction by id; ``own`` has the ids of each joint by what ends them."""
    width = common_width(runs)
    motions = [filter_run(run, width) for run in runs if run.use == "fit"]
    changes: dict[str, dict[str, object]] = {}
    for k, (suffix, ids) in enumerate(own.items()):
        guessed = law_named(equations.friction[k]).guess(_sliding(plain, motions, k))
        for id in ids:
            changes[f"{id}{suffix}"] = _around(id, guessed[id])
    return changes


def _ids_at_defaults(equations: Equations, suffix: str, k: int, stated: Collection[str]) -> list[str]:
    """Return the ids of a joint's positive friction parameters that stand at the defaults, without its number."""
    found = []
    for row in law_named(equations.friction[k]).parameters:
        quantity = equations.parameter(f"{row.id}{suffix}")
        default = ROWS[row.id]
        at_default = (quantity.initial, quantity.lower, quantity.upper) == (
            default.initial,
            default.lower,
            default.upper,
        )
        if at_default and quantity.scale == "log" and not quantity.fixed and f"{row.id}{suffix}" not in stated:
            found.append(row.id)
    return found


def _sliding(plain: Baseline, motions: Sequence[FilteredMotion], k: int) -> Sliding:
    """Return what the plain model tells of a joint in gross sliding; no size of 0, around which there is no range."""
    q, v, torque = (np.concatenate([getattr(m, name)[:, k] for m in motions]) for name in ("q", "v", "torque"))
    speed = max(float(np.abs(v).max()), np.finfo(float).tiny)
    least = THRESHOLDS.least_friction_guess_over_torque * max(float(np.abs(torque).max()), np.finfo(float).tiny)
    return Sliding(
        coulomb=max(plain.of_joint("Fc", k), least),
        viscous=max(plain.of_joint("Fv", k), least / speed),
        inertia=max(_inertia(plain, motions[0], k), np.finfo(float).tiny),
        travel=max(float(np.ptp(q)), np.finfo(float).tiny),
        speed=speed,
    )


def _inertia(plain: Baseline, motion: FilteredMotion, k: int) -> float:
    """Return the torque of joint k for an acceleration of 1 in the middle of a run, less that for none."""
    middle = motion.t.size // 2
    rows = slice(middle, middle + 1)
    still = np.zeros_like(motion.q[rows])
    moved: Array = still.copy()
    moved[0, k] = 1.0

    def torque(a: Array) -> float:
        at = replace(motion, t=motion.t[rows], q=motion.q[rows], v=still, a=a, torque=still)
        return float((plain.regressor.columns(at) @ plain.estimate.theta)[0, k])

    return torque(moved) - torque(still)


def _around(id: str, value: float) -> dict[str, object]:
    factor = THRESHOLDS.bounds_over_guess
    return possible_guess(id, value, value / factor, value * factor)


def _begin_at(equations: Equations, plain: Baseline, stated: Collection[str]) -> dict[str, dict[str, object]]:
    """Return inertial coefficients of the plain model as first guesses, within the device's bounds."""
    changes: dict[str, dict[str, object]] = {}
    known = dict(zip(plain.regressor.ids[: plain.regressor.n_rigid], plain.estimate.theta.tolist(), strict=False))
    for quantity in equations.parameters:
        if quantity.id in known and not quantity.fixed and quantity.id not in stated:
            inside = float(np.clip(known[quantity.id], quantity.lower, quantity.upper))
            changes[quantity.id] = {"initial": inside}
    return changes
