"""Friction of a run over its speed, as measured and as modelled: `Compared` and `Run` in, `FrictionLoop` out."""

from __future__ import annotations

from dataclasses import dataclass

from haptid.identification.baseline.compared import Compared
from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Array, Run


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionLoop:
    """Friction torque of one joint along the measured motion of one run.

    Parameters
    ----------
    file, use
        File of the run and its use.
    joint, prismatic
        Number of the joint, and whether it slides: then rad and N m below are m and N.
    speed
        Measured speed, filtered [rad/s], shape (n,).
    measured
        Recorded torque less what the model needs for inertia, gravity and spring [N m], shape (n,).
    model
        Friction of the model along the same motion [N m], shape (n,).
    """

    file: str
    use: str
    joint: int
    prismatic: bool
    speed: Array
    measured: Array
    model: Array


def friction_loop(compared: Compared, run: Run, k: int) -> FrictionLoop:
    """Compute the friction of a joint along a run.

    Parameters
    ----------
    compared
        Model of the configuration, with its inverse dynamics.
    run
        One of its runs.
    k
        Index of the joint among the free ones.

    Returns
    -------
    FrictionLoop
        ``measured`` is Kp·τ − (torque of the model without friction), so that what the model leaves of the torque
        stands between both curves.
    """
    model = compared.models["model"]
    # The width of the figures: loop and figures then show the same residual.
    motion = filter_run(run, compared.width)
    inside = motion.interior
    friction = model.inverse.filtered_friction(model.theta, motion, k)
    gain = model.inverse.value(model.theta, "Kp", k)
    left = gain * (motion.with_delay(model.delay).torque - model.torque(motion))[:, k]
    return FrictionLoop(
        file=run.file,
        use=run.use,
        joint=run.free_joints[k],
        prismatic=run.prismatic[k],
        speed=motion.v[inside, k],
        measured=(friction + left)[inside],
        model=friction[inside],
    )
