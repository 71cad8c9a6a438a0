"""The stepper over the whole bounds of the built-in device: blow-ups, and the error against a twentieth of the step.

10,002 random parameter sets, 8 s each, a sixth of them per joint; then 40 sets against SciPy's Radau at 1e-10.
"""

from __future__ import annotations

import math
import time

import numpy as np
from scipy.integrate import solve_ivp

from haptid.model.device.reader import load_device
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.rigid_body.locked_dynamics import locked_motion

SETS, TENTH, COMPARED, SECONDS = 10_002, 10, 40, 8.0


def drawn(joint: int, n: int, rng: np.random.Generator, ids: list[str]) -> np.ndarray:
    """Draw parameter sets over the bounds of one joint, logarithmically where a bound is positive; shape (n, n_p)."""
    device = load_device("freedom6s")
    inertia = next(c.initial for c in locked_motion(device, [joint]).coefficients if c.id == "inertia")
    values = {"inertia": inertia * 10 ** rng.uniform(-0.7, 0.7, n)}
    for name, guess in device.joints[joint].parameters.items():
        low, high = (guess.initial, guess.initial) if guess.fixed else (guess.lower, guess.upper)
        values[name] = np.exp(rng.uniform(math.log(low), math.log(high), n)) if low > 0 else rng.uniform(low, high, n)
    values["Fc"], values["Fs"] = np.sort([values["Fc"], values["Fs"]], axis=0)
    gravity = 0.2 * device.joints[joint].torque_limit
    return np.column_stack([values.get(i, rng.uniform(-gravity, gravity, n)) for i in ids])


def radau(kernel: CompiledKernel, t: np.ndarray, u: np.ndarray, p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Positions by Radau on the kernel's right-hand side, row by row where the torque jumps."""
    y = [x[0]]
    for k in range(t.size - 1):
        done = solve_ivp(
            lambda s, state, k=k: kernel.derivatives(s, state, u[k], p),
            (t[k], t[k + 1]), x, method="Radau", rtol=1e-10, atol=1e-14,
        )  # fmt: skip
        x = done.y[:, -1]
        y.append(x[0])
    return np.array(y)


def main() -> None:
    """Print both comparisons."""
    kernel = CompiledKernel.of(joint_equations(4))
    ids = [q.id for q in kernel.equations.parameters]
    rng = np.random.default_rng(0)
    t = np.arange(0.0, SECONDS, 0.005)
    errors, blown, start = [], 0, time.perf_counter()
    for joint in range(6):
        P = drawn(joint, SETS // 6, rng, ids)
        u = 0.2 * load_device("freedom6s").joints[joint].torque_limit * np.cos(1.75 * t)[:, None]
        x0 = np.tile([0.1, 0.0, 0.0], (len(P), 1))
        y = kernel.simulate_many(t, u, P, x0)
        blown += int(np.isnan(y).any(axis=(1, 2)).sum())
        fine = kernel.simulate_many(t, u, P[::TENTH], x0[::TENTH], step=2.5e-5)
        errors.append(np.sqrt(np.mean((y[::TENTH] - fine) ** 2, axis=(1, 2))))
    error = np.concatenate(errors)
    print(f"{SETS} sets over the bounds, {time.perf_counter() - start:.0f} s: {blown} blew up")
    print("error of every tenth against a twentieth of the step, rad: " + ", ".join(
        f"{share:.0%} below {np.nanquantile(error, share):.1e}" for share in (0.5, 0.9, 0.99, 1.0)
    ))  # fmt: skip
    rows = np.arange(0.0, 1.01, 0.1)
    worst = []
    for p in drawn(4, COMPARED, rng, ids):
        u, x = 5e-3 * np.cos(1.75 * rows)[:, None], np.array([0.1, 0.0, 0.0])
        worst.append(np.abs(kernel.simulate(rows, u, p, x)[:, 0] - radau(kernel, rows, u, p, x)).max())
    print(
        f"{COMPARED} sets against Radau, largest difference: median {np.median(worst):.1e}, of all {max(worst):.1e} rad"
    )


if __name__ == "__main__":
    main()
