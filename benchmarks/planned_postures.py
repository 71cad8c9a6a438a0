"""How far locked tests carry: error of the full-model torque on random devices, after tests at home and as planned.

Twenty devices around the Freedom 6S first guesses (masses, centroids, inertias ±30 %), coefficients without noise,
links by `consistent_links`, torque on fifty random motions: rms error over rms torque, the worst joint.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.links.consistent_links import consistent_links, pseudo_inertia
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.planning.inertial_belief import Measurement
from haptid.model.planning.lock_postures import plan_postures, random_motion
from haptid.model.planning.locking_order import locking_order
from haptid.model.rigid_body.inertial_parameters import Array, pi_prior, standard_initial, to_pi
from haptid.model.rigid_body.locked_dynamics import LockedDynamics
from haptid.model.rigid_body.regressor import regressor

DEVICES, MOTIONS, SAMPLES, ACCURACY = 20, 50, 40, 1e-6


def drawn(device: Device, rng: np.random.Generator) -> Array:
    """Return π of a physical device: standard parameters within ±30 %, products within ±5 % of the least moment."""
    first = standard_initial(device)
    n = len(device.massive)
    while True:
        standard = first * rng.uniform(0.7, 1.3, first.size)
        for i in range(0, 10 * n, 10):
            standard[i + 7 : i + 10] = 0.05 * standard[i + 4 : i + 7].min() * rng.uniform(-1, 1, 3)
            standard[i + 1 : i + 4] += 0.003 * rng.uniform(-1, 1, 3)
        pi = to_pi(device, standard)
        if all(np.linalg.eigvalsh(pseudo_inertia(list(pi[i : i + 10])))[0] > 0 for i in range(0, 10 * n, 10)):
            return pi


def fitted(device: Device, tests: list[LockedDynamics], pi: Array) -> Array:
    """Return π found from coefficients without noise."""
    measurements = []
    for dynamics in tests:
        sigma = ACCURACY * np.array([max(abs(c.initial), c.prior_std) for c in dynamics.coefficients])
        values = dynamics.linear_map @ pi
        measurements.append(
            Measurement(coefficients=dynamics.coefficients, values=values, covariance=np.diag(sigma**2))
        )
    return consistent_links(device, measurements).pi


def main() -> None:
    """Print the errors of first guesses, of tests at home, and of the planned tests."""
    device, rng = load_device("freedom6s"), np.random.default_rng(0)
    plan = plan_postures(device, [stage.free for stage in locking_order(device).stages])
    home = [test.dynamics for test in plan.home]
    planned = home + [test.dynamics for test in plan.chosen]
    Y = regressor(device, *random_motion(device, MOTIONS * SAMPLES, 1))
    errors: dict[str, list[float]] = {"first guesses": [], "tests at home": [], "planned tests": []}
    for _ in range(DEVICES):
        pi = drawn(device, rng)
        torque = Y @ pi
        for name, found in zip(
            errors, (pi_prior(device)[0], fitted(device, home, pi), fitted(device, planned, pi)), strict=True
        ):
            wrong = np.sqrt(np.mean((Y @ found - torque) ** 2, axis=1) / np.mean(torque**2, axis=1))
            errors[name].append(float(wrong.max()))
    print(f"{len(plan.home)} tests at home, {len(plan.chosen)} more planned; torque error, rms over rms, worst joint")
    for name, values in errors.items():
        print(f"{name:14s} median {np.median(values):.2e}  largest {max(values):.2e}")


if __name__ == "__main__":
    main()
