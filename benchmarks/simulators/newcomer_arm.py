"""Raw tables of an arm that haptid has not seen: a folder in, CSV files and a URDF in it out.

Two links turn about horizontal axes. The tables are those of a logger: milliseconds, degrees and N mm, both joints in
every table, the held one with the noise of its encoder. Dynamics, LuGre friction and integrator (half-implicit Euler)
are written out here, apart from haptid's own. The masses and inertias of the URDF are rough.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
MASSES, INERTIAS = (0.45, 0.25), (0.0012, 0.0006)
"""Masses [kg] and inertias about the centres of mass [kg m²]."""
CENTRES, LENGTH = (0.09, 0.07), 0.2
"""Distance of the centre of mass from its joint, and of the second joint from the first [m]."""
FRICTION = (
    {"Fc": 0.04, "Fs": 0.05, "vs": 0.1, "sigma0": 30.0, "sigma1": 0.2, "sigma2": 0.02},
    {"Fc": 0.015, "Fs": 0.02, "vs": 0.1, "sigma0": 20.0, "sigma1": 0.1, "sigma2": 0.008},
)
RATE_HZ, SUBSTEPS, DURATION_S, NOISE_RAD = 500, 20, 4.0, 2e-4
RUNS: dict[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "j1_0": ((0.0, 0.0), (0.06, 2.0)),
    "j1_1": ((0.0, 0.0), (0.12, 4.0)),
    "j1_2": ((0.0, 0.0), (0.1, 6.5)),
    "val_j1": ((0.0, 0.0), (0.09, 3.0)),
    "j0_0": ((0.25, 2.0), (0.0, 0.0)),
    "j0_1": ((0.5, 3.3), (0.0, 0.0)),
    "j0_2": ((0.4, 5.0), (0.0, 0.0)),
    "val_j0": ((0.35, 2.6), (0.0, 0.0)),
    "both_0": ((0.3, 2.0), (0.07, 3.1)),
    "both_1": ((0.45, 3.1), (0.1, 4.3)),
    "val_both": ((0.35, 2.5), (0.08, 3.7)),
}
"""Amplitude [N m] and angular frequency [rad/s] of each joint's cosine torque; a joint without torque is held."""
LINK = """<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/><inertia ixx="{inertia}"
 iyy="{inertia}" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {z}"/>
 <axis xyz="0 1 0"/><limit lower="-3.1" upper="3.1" effort="5" velocity="20"/></joint>"""


def acceleration(q: Array, v: Array, torque: Array, free: list[int]) -> Array:
    """Return q̈ [rad/s²] of the free joints from M(q)·q̈ = τ − C(q, q̇) − G(q), shape (2,); 0 for a held joint."""
    coupled = MASSES[1] * LENGTH * CENTRES[1]
    second = INERTIAS[1] + MASSES[1] * CENTRES[1] ** 2
    both = INERTIAS[0] + MASSES[0] * CENTRES[0] ** 2 + MASSES[1] * LENGTH**2 + second + 2 * coupled * np.cos(q[1])
    beside = second + coupled * np.cos(q[1])
    M = np.array([[both, beside], [beside, second]])
    C = coupled * np.sin(q[1]) * np.array([-2 * v[0] * v[1] - v[1] ** 2, v[0] ** 2])
    end = MASSES[1] * CENTRES[1] * np.sin(q[0] + q[1])
    G = GRAVITY * np.array([(MASSES[0] * CENTRES[0] + MASSES[1] * LENGTH) * np.sin(q[0]) + end, end])
    found = np.zeros(2)
    found[free] = np.linalg.solve(M[np.ix_(free, free)], (torque - C - G)[free])
    return found


def _cosines(sizes: Array, speeds: Array) -> Callable[[float], Array]:
    """Return the torque of each joint [N m] over time [s]."""
    return lambda now: sizes * np.cos(speeds * now)


def simulate(torque: Callable[[float], Array], free: list[int]) -> tuple[Array, Array, Array]:
    """Simulate a run from rest: time [s] (n_t,), torques [N m] and positions [rad] (n_t, 2)."""
    step = 1.0 / (RATE_HZ * SUBSTEPS)
    t = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ
    u, y = np.array([torque(now) for now in t]), np.empty((t.size, 2))
    q, v, z, rub = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2)
    for k in range(t.size):
        y[k] = q
        for _ in range(SUBSTEPS):
            for j in free:
                p = FRICTION[j]
                limit = p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((v[j] / p["vs"]) ** 2))
                slip = v[j] - p["sigma0"] * abs(v[j]) / limit * z[j]
                rub[j] = p["sigma0"] * z[j] + p["sigma1"] * slip + p["sigma2"] * v[j]
                z[j] += step * slip
            v += step * acceleration(q, v, u[k] - rub, free)
            q += step * v
    return t, u, y


def write_tables(folder: Path, seed: int = 3) -> None:
    """Write the tables of all runs and the URDF.

    Parameters
    ----------
    folder
        Folder that exists.
    seed
        Seed of the encoders' noise.
    """
    rng = np.random.default_rng(seed)
    header = "time_ms,torque_0_Nmm,torque_1_Nmm,position_0_deg,position_1_deg"
    for name, drives in RUNS.items():
        sizes, speeds = np.array(drives).T
        t, u, y = simulate(_cosines(sizes, speeds), list(np.flatnonzero(sizes)))
        read = np.degrees(y + NOISE_RAD * rng.standard_normal(y.shape))
        rows = np.column_stack((1e3 * t, 1e3 * u, read))
        formats = ["%.1f", "%.3f", "%.3f", "%.5f", "%.5f"]
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=header, comments="", fmt=formats)
    parts = (
        '<link name="base"/>',
        LINK.format(name="upper", z=-0.1, mass=0.5, inertia=0.001),
        LINK.format(name="fore", z=-0.08, mass=0.2, inertia=0.0005),
        JOINT.format(name="shoulder", parent="base", child="upper", z=0),
        JOINT.format(name="elbow", parent="upper", child="fore", z=-LENGTH),
    )
    said = '<?xml version="1.0"?>\n<robot name="arm2">\n' + "\n".join(parts) + "\n</robot>\n"
    (folder / "arm.urdf").write_text(said, encoding="utf-8")
