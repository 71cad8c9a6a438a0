"""Two nominal joints, random points around them, and the joint's equation once more by hand."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from haptid.model.equations.output_injection import with_observer
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel

JOINT = joint_equations(4)
IDS = tuple(q.id for q in JOINT.parameters)
KERNEL = CompiledKernel.of(JOINT)
OBSERVED = CompiledKernel.of(with_observer(JOINT))

TENDON = {
    "inertia": 2.2e-4, "gravity_cos": 5e-4, "gravity_sin": 1e-3, "Kp": 1.0, "Ks": 8.3e-3, "epos": 0.02,
    "sigma0": 0.4, "sigma1": 2e-3, "sigma2": 1e-3, "vs": 0.05, "Fs": 2e-3, "Fc": 1.5e-3,
}  # fmt: skip
BASE = {
    "inertia": 2e-2, "gravity_cos": 5e-3, "gravity_sin": 1e-2, "Kp": 1.0, "Ks": 5e-2, "epos": 0.02,
    "sigma0": 5.0, "sigma1": 5e-2, "sigma2": 2e-2, "vs": 0.02, "Fs": 3e-3, "Fc": 2.5e-3,
}  # fmt: skip
CASES = {"tendon": (TENDON, 5e-3), "base": (BASE, 2e-2)}
"""Parameters and torque amplitude [N m] of a tendon joint and of a base joint."""


def vector(parameters: dict[str, float]) -> np.ndarray:
    """Parameters in the kernel's order."""
    return np.array([parameters[i] for i in IDS])


def torque(t: np.ndarray, amplitude: float) -> np.ndarray:
    """Return a cosine and a slower one beside it, shape (n_t, 1) [N m]."""
    return amplitude * (0.8 * np.cos(1.75 * t) + 0.2 * np.cos(0.4 * t + 1.0))[:, None]


def draw(nominal: dict[str, float], n: int, seed: int, *, decades: float = 1.0, passive: bool = True) -> np.ndarray:
    """Draw n points log-uniformly within ± decades of the nominal one, Fs >= Fc, on either side of the passivity bound.

    Points that are not passive lie within a factor 3 of σ2 = σ1·(Fs − Fc)/Fc (Barabanov and Ortega 2000).
    """
    rng = np.random.default_rng(seed)
    P = vector(nominal) * 10.0 ** rng.uniform(-decades, decades, (n, len(IDS)))
    s1, s2, fs, fc = (IDS.index(i) for i in ("sigma1", "sigma2", "Fs", "Fc"))
    P[:, [fs, fc]] = np.sort(P[:, [fs, fc]], axis=1)[:, ::-1]
    bound = P[:, s1] * (P[:, fs] - P[:, fc]) / P[:, fc]
    P[:, s2] = np.maximum(P[:, s2], 1.01 * bound) if passive else bound * rng.uniform(1 / 3, 1, n)
    return P


def by_hand(p: dict[str, float], tau: Callable[[float], float]) -> Callable[[float, np.ndarray], list[float]]:
    """Return ẋ(t, x) of the joint, written without SymPy."""

    def derivative(t: float, x: np.ndarray) -> list[float]:
        q, v, z = x
        g = p["Fc"] + (p["Fs"] - p["Fc"]) * math.exp(-((v / p["vs"]) ** 2))
        dz = v - p["sigma0"] * abs(v) / g * z
        load = p["gravity_cos"] * math.cos(q) + p["gravity_sin"] * math.sin(q) + p["Ks"] * (q - p["epos"])
        friction = p["sigma0"] * z + p["sigma1"] * dz + p["sigma2"] * v
        return [v, (p["Kp"] * tau(t) - load - friction) / p["inertia"], dz]

    return derivative


def radau(p: dict[str, float], t: np.ndarray, u: np.ndarray, x0: list[float], *, hold: str) -> np.ndarray:
    """Positions at t by SciPy's Radau, started anew at every row, where the input bends or jumps."""
    y, x = [x0[0]], np.array(x0)
    for k in range(t.size - 1):
        rise = (u[k + 1] - u[k]) / (t[k + 1] - t[k]) if hold == "linear" else 0.0
        f = by_hand(p, lambda s, k=k, rise=rise: u[k] + rise * (s - t[k]))
        done = solve_ivp(f, (t[k], t[k + 1]), x, method="Radau", rtol=1e-10, atol=1e-14)
        x = done.y[:, -1]
        y.append(x[0])
    return np.array(y)
