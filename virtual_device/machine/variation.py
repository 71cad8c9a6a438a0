"""Another machine of the same kind, drawn at random around a given one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.support.errors import NumericalError
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.machine.truth import DRIVE, Truth, inertia_tensor


def is_physical(truth: Truth) -> bool:
    """Return whether masses are positive, inertias are those of bodies, and stiction is at least Coulomb friction.

    Principal moments of a body are positive and obey the triangle inequality.

    Parameters
    ----------
    truth
        Numbers of the arm.

    Returns
    -------
    bool
        True where all links and drives are so.
    """
    moments = np.array([np.linalg.eigvalsh(inertia_tensor(row)) for row in truth.links])
    triangle = moments[:, 0] + moments[:, 1] > moments[:, 2]
    friction = truth.drives[:, DRIVE.index("Fs")] >= truth.drives[:, DRIVE.index("Fc")]
    return bool(np.all(truth.links[:, 0] > 0) and np.all(moments > 0) and np.all(triangle) and np.all(friction))


def vary(truth: Truth, width: float, rng: np.random.Generator) -> Truth:
    """Draw another machine, inertially within ± width; springs and friction times e^(±1.35 width); epos ± 0.3 width.

    Drawn again until it is physical and balanced like the first (see `is_usable`).

    Parameters
    ----------
    truth
        The given machine.
    width
        Relative width of the variation, as 0.2 for ± 20 %.
    rng
        Source of random numbers.

    Returns
    -------
    Truth
        Another machine with the same geometry.

    Raises
    ------
    NumericalError
        Where 10,000 draws give no usable machine.
    """
    for _ in range(10_000):
        links = np.array([_vary_link(row, width, rng) for row in truth.links])
        drawn = replace(truth, links=links, drives=_vary_drives(truth.drives, width, rng))
        if is_usable(drawn):
            return drawn
    msg = f"no balanced machine found within ±{100 * width:g} % of the given one"
    raise NumericalError(msg)


def _vary_drives(drives: Array, width: float, rng: np.random.Generator) -> Array:
    """Vary springs and friction by factors, epos by a shift, and the excess Fs − Fc rather than Fs; Kp stays."""
    drawn = drives * np.exp(1.35 * width * rng.uniform(-1, 1, drives.shape))
    Kp, epos, Fs, Fc = (DRIVE.index(key) for key in ("Kp", "epos", "Fs", "Fc"))
    drawn[:, Kp] = drives[:, Kp]
    drawn[:, epos] = drives[:, epos] + 0.3 * width * rng.uniform(-1, 1, len(drives))
    drawn[:, Fs] = drawn[:, Fc] + (drives[:, Fs] - drives[:, Fc]) * drawn[:, Fs] / drives[:, Fs]
    return drawn


def _vary_link(row: Array, width: float, rng: np.random.Generator) -> Array:
    """Vary mass, centroid (also by ±5 mm · width) and second moments S = ½ tr(I) 1 − I: I stays that of a body."""
    head = row[:4] * (1.0 + width * rng.uniform(-1, 1, 4))
    head[1:] += 0.005 * width * rng.uniform(-1, 1, 3)
    inertia = inertia_tensor(row)
    moments = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    size = np.sqrt(np.diag(moments))
    tilt = np.triu(0.3 * width * rng.uniform(-1, 1, (3, 3)), 1)
    moments *= np.outer(*[np.sqrt(1.0 + width * rng.uniform(-1, 1, 3))] * 2)
    moments += np.outer(size, size) * (tilt + tilt.T)
    drawn = np.trace(moments) * np.eye(3) - moments
    return np.array([*head, *np.diag(drawn), drawn[0, 1], drawn[0, 2], drawn[1, 2]])


def is_usable(truth: Truth) -> bool:
    """Return whether the machine is physical, balanced and stable at home, and moves at the torques of the tests.

    Parameters
    ----------
    truth
        Numbers of the arm.

    Returns
    -------
    bool
        True where it is.
    """
    if not is_physical(truth):
        return False
    arm, home = Arm(truth), np.zeros(6)
    mass, gravity = arm.dynamics(home, home)
    stiffness = arm.stiffness(home)
    modes = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
    drives = dict(zip(DRIVE, truth.drives.T, strict=True))
    frequencies = np.sqrt(np.maximum(np.diag(stiffness) / np.diag(mass), 0.0))
    return bool(
        np.all(np.abs(gravity) < 0.03)
        and np.all(modes > 3.0)
        and np.all(frequencies > (3.0, 2.4, 3.0, 6.0, 6.0, 6.0))
        and np.all(drives["Fs"] <= (5e-3, 4e-3, 5e-3, 2.4e-3, 1.7e-3, 2.4e-3))
        and np.all(drives["Fs"] >= 1.05 * drives["Fc"])
        and np.all(drives["sigma2"] > 1.1 * drives["sigma1"] * (drives["Fs"] / drives["Fc"] - 1.0))
    )
