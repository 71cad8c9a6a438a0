"""One joint of the independent arm moved under position control, as a run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from haptid.measurement.signals.noise import with_noise
from haptid.measurement.values.run import Array, Run
from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.sensor import Sensor

STEP = 0.005
SENSOR = Sensor(noise=2e-4, resolution=1.5e-4, coloured=0.0)
KP, KD, FILTER = 0.4, 0.03, 0.02


def truth_of(joint: int) -> dict[str, float]:
    """Return the locked joint's true parameters by id, with all others at home."""
    return Arm(read_truth()).locked_joint(joint, np.zeros(JOINTS))


def controlled_joint(
    joint: int,
    reference: Callable[[Array], Array],
    *,
    seconds: float,
    seed: int,
    use: str = "fit",
    extra: float = 0.0,
    wave: float = 5.0,
) -> Run:
    """Move ``joint`` along ``reference(t)`` by proportional-derivative control; only the torque is recorded.

    ``extra`` is a torque extra·sin(wave·q) [N m; rad⁻¹] of which the recorded command knows nothing.
    """
    arm, t = Arm(read_truth()), np.round(np.arange(0.0, seconds, STEP), 6)
    rng, wanted = np.random.default_rng([joint, seed]), reference(t)
    state = arm.start(np.where(np.arange(JOINTS) == joint, wanted[0], 0.0))
    torque, read, velocity = np.zeros((t.size, JOINTS)), np.zeros(t.size), 0.0
    for k in range(t.size):
        read[k] = float(SENSOR.read(t[:2], state[None, :JOINTS].repeat(2, 0), rng)[0, joint])
        if k:
            velocity += STEP / (STEP + FILTER) * ((read[k] - read[k - 1]) / STEP - velocity)
        torque[k, joint] = KP * (wanted[k] - read[k]) - KD * velocity
        applied = torque[k].copy()
        applied[joint] += extra * np.sin(wave * state[joint])
        arm.advance((joint,), state, applied, STEP)
    run = Run(
        file=f"controlled_{seed}.csv",
        free_joints=(joint,),
        t=t,
        u=torque[:, [joint]],
        y=read[:, None],
        noise=[SENSOR.noise],
        resolution=[SENSOR.resolution],
        posture=np.zeros(JOINTS),
        use=use,
    )
    return with_noise(run)


def rich_motion(t: Array) -> Array:
    """Return two sines that pass from presliding to well above the Stribeck speed."""
    return np.asarray(0.25 * np.sin(1.1 * t) + 0.12 * np.sin(6.3 * t) + 0.01 * np.sin(2.9 * t))


def slow_sweep(t: Array) -> Array:
    """Return a triangle of 0.1 rad/s between -0.4 and 0.4 rad."""
    return np.asarray(0.4 - np.abs((0.1 * t) % 1.6 - 0.8))
