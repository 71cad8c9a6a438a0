"""A joint under each friction law, and the laws once more by hand."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

Rates = Callable[[dict[str, float], float, np.ndarray], tuple[float, list[float]]]
JOINT = {
    "inertia": 1.1e-4, "gravity_cos": 5e-4, "gravity_sin": -8e-4, "Kp": 1.0, "Ks": 0.0151, "epos": -0.0305,
    "sigma0": 0.523, "sigma1": 2.2e-3, "sigma2": 1.9e-3, "vs": 0.0666, "Fs": 1.33e-3, "Fc": 1.05e-3,
    "C": 0.05, "spread": 2.0, "unevenness": 0.8, "n": 1.4, "vc": 2e-3,
}  # fmt: skip
"""Parameters of all laws together; each takes its own."""
AMPLITUDE = 5e-3
ELEMENTS, EDGE, MEMORY, NEAR = 6, 0.02, 1000.0, 1e-3


def level(p: dict[str, float], v: float) -> float:
    """Return the Stribeck curve."""
    return p["Fc"] + (p["Fs"] - p["Fc"]) * math.exp(-((v / p["vs"]) ** 2))


def lugre(p: dict[str, float], v: float, x: np.ndarray) -> tuple[float, list[float]]:
    dz = v - p["sigma0"] * abs(v) / level(p, v) * x[0]
    return p["sigma0"] * x[0] + p["sigma1"] * dz + p["sigma2"] * v, [dz]


def dahl(p: dict[str, float], v: float, x: np.ndarray) -> tuple[float, list[float]]:
    left = 1 - p["sigma0"] * x[0] / p["Fc"] * math.copysign(1, v)
    return p["sigma0"] * x[0] + p["sigma2"] * v, [v * left * math.hypot(left, NEAR) ** (p["n"] - 1)]


def coulomb(p: dict[str, float], v: float, _: np.ndarray) -> tuple[float, list[float]]:
    return level(p, v) * math.tanh(v / p["vc"]) + p["sigma2"] * v, []


def maxwell_slip(p: dict[str, float], v: float, x: np.ndarray) -> tuple[float, list[float]]:
    s, way = level(p, v), float(np.sign(v))
    falling, strong = (np.array([p[id] ** -i for i in range(ELEMENTS)]) for id in ("spread", "unevenness"))
    limits = s * strong / strong.sum()
    forces, slips, memories = x[:ELEMENTS], [], []
    for k, limit, F, m in zip(p["sigma0"] * falling / falling.sum(), limits, forces, x[ELEMENTS:], strict=True):
        share = min(max((F * way / limit - 1 + EDGE) / EDGE, 0.0), 1.0)
        g = share + (1 - share) * (m if F * v > 0 else 0.0)
        slips.append((1 - g) * k * v + g * p["C"] * (way * limit - F) / s)
        memories.append(MEMORY * (share * (1 - m) - (m if F * v < 0 else 0.0)))
    return float(forces.sum()) + p["sigma2"] * v, [*slips, *memories]


LAWS: dict[str, tuple[Rates, int]] = {
    "lugre": (lugre, 1), "dahl": (dahl, 1), "coulomb": (coulomb, 0), "maxwell_slip": (maxwell_slip, 12),
}  # fmt: skip
"""Torque and rates of each law, and how many states it has."""


def radau(law: str, p: dict[str, float], t: np.ndarray, u: np.ndarray, *, rtol: float = 1e-9) -> np.ndarray:
    """Positions at t by SciPy's Radau from rest at 0, started anew at every row, where the torque jumps."""
    friction, n = LAWS[law]

    def rates(x: np.ndarray, torque: float) -> list[float]:
        q, v = x[:2]
        rubbing, inner = friction(p, v, x[2:])
        load = p["gravity_cos"] * math.cos(q) + p["gravity_sin"] * math.sin(q) + p["Ks"] * (q - p["epos"])
        return [v, (p["Kp"] * torque - load - rubbing) / p["inertia"], *inner]

    x = np.zeros(2 + n)
    found = [0.0]
    for k in range(t.size - 1):
        done = solve_ivp(
            lambda _, y, k=k: rates(y, u[k]), (t[k], t[k + 1]), x, "Radau", rtol=rtol, atol=1e-13, max_step=1e-3
        )
        x = done.y[:, -1]
        found.append(x[0])
    return np.array(found)
