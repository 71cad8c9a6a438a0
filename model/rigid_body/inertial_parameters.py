"""The inertial parameters π in which the energy is linear, and their conversion from and to standard parameters.

Standard parameters of a link: mass m, centroid c, inertia I about the centroid.

π of a massive link, about the origin of its own frame: m; h = m·c (mx, my, mz); L = I + m(cᵀc·1 − c cᵀ) (L11 … L23);
then one rotor inertia per motor. n_pi = 10·n_links + n_motors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from haptid.model.algebra.vectors import Scalar, plus, times
from haptid.model.device.device import STANDARD, Device

Array = NDArray[np.float64]
BARYCENTRIC = ("m", "mx", "my", "mz", "L11", "L22", "L33", "L12", "L13", "L23")
UNITS = ("kg", "kg m", "kg m", "kg m", *("kg m^2",) * 6)


def pi_ids(device: Device) -> tuple[str, ...]:
    """Return the names of π: ``link4_m``, ``link4_mx``, …, ``link4_L23``, …, ``motor_elbow_J``.

    Parameters
    ----------
    device
        Device with its links and motors.

    Returns
    -------
    tuple of str
        The n_pi names: ten for each massive link, then one for each motor.
    """
    return _ids(device, BARYCENTRIC)


def standard_ids(device: Device) -> tuple[str, ...]:
    """Return the names of the standard parameters: ``link4_m``, ``link4_x``, …, ``link4_I11``, …, ``motor_elbow_J``.

    Parameters
    ----------
    device
        Device with its links and motors.

    Returns
    -------
    tuple of str
        The n_pi names: ten for each massive link, then one for each motor.
    """
    return _ids(device, STANDARD)


def _ids(device: Device, keys: Sequence[str]) -> tuple[str, ...]:
    links = tuple(f"link{link.name}_{key}" for link in device.massive for key in keys)
    return links + tuple(f"motor_{motor.name}_J" for motor in device.motors)


def barycentric(standard: Sequence[Scalar]) -> tuple[Scalar, ...]:
    """Convert standard parameters of one link to barycentric ones.

    Parameters
    ----------
    standard
        (m, x, y, z, I11, I22, I33, I12, I13, I23) [kg, m, kg m²] over any scalar.

    Returns
    -------
    tuple of Scalar
        (m, h, L) in the order of `BARYCENTRIC` [kg, kg m, kg m²]: h = m·c, L = I + m·(cᵀc·1 − c cᵀ).
    """
    m, x, y, z, I11, I22, I33, I12, I13, I23 = standard
    hx, hy, hz = times(m, x), times(m, y), times(m, z)
    xx, yy, zz = times(hx, x), times(hy, y), times(hz, z)
    products = (plus(I12, -times(hx, y)), plus(I13, -times(hx, z)), plus(I23, -times(hy, z)))
    return (m, hx, hy, hz, plus(I11, yy, zz), plus(I22, xx, zz), plus(I33, xx, yy), *products)


def standard_initial(device: Device) -> Array:
    """Return the first guesses of the standard parameters.

    Parameters
    ----------
    device
        Device with its links and motors.

    Returns
    -------
    Array
        Mass [kg], centroid [m] and inertia [kg m²] in the order of `standard_ids`, shape (n_pi,).
    """
    links = [value for link in device.massive for value in link.inertial.initial]  # type: ignore[union-attr]  # massive
    return np.array([*links, *(motor.inertia.initial for motor in device.motors)])


def standard_std(device: Device) -> Array:
    """Return the prior standard deviations of the standard parameters.

    Parameters
    ----------
    device
        Device with its links and motors.

    Returns
    -------
    Array
        In the order and units of `standard_initial`, shape (n_pi,); 0 where a guess has none, as a fixed one.
    """
    links = [guess for link in device.massive for guess in link.inertial.guesses]  # type: ignore[union-attr]  # massive
    return np.array([guess.std or 0.0 for guess in (*links, *(motor.inertia for motor in device.motors))])


def to_pi(device: Device, standard: Array) -> Array:
    """Convert standard parameters to π.

    Parameters
    ----------
    device
        Device, which gives the number of massive links.
    standard
        Standard parameters in the order of `standard_ids`, shape (n_pi,).

    Returns
    -------
    Array
        π in the order of `pi_ids`, shape (n_pi,).
    """
    n = 10 * len(device.massive)
    links = [barycentric(tuple(standard[i : i + 10])) for i in range(0, n, 10)]
    return np.array([*(value for link in links for value in link), *standard[n:]])


def to_standard(device: Device, pi: Array) -> Array:
    """Convert π to standard parameters.

    Parameters
    ----------
    device
        Device, which gives the number of massive links.
    pi
        π in the order of `pi_ids`, shape (n_pi,); masses must not be zero.

    Returns
    -------
    Array
        Standard parameters in the order of `standard_ids`, shape (n_pi,): c = h/m, I = L − m·(cᵀc·1 − c cᵀ).
    """
    n = 10 * len(device.massive)
    result = pi.copy()
    for i in range(0, n, 10):
        m, h, L = pi[i], pi[i + 1 : i + 4], pi[i + 4 : i + 10]
        c = h / m
        shift = barycentric((m, *c, 0, 0, 0, 0, 0, 0))[4:]
        result[i : i + 10] = m, *c, *(L - np.array(shift))
    return result


def pi_jacobian(device: Device, standard: Array) -> Array:
    """Compute the Jacobian of π with respect to the standard parameters, in closed form.

    Parameters
    ----------
    device
        Device, which gives the number of massive links.
    standard
        Standard parameters in the order of `standard_ids`, shape (n_pi,).

    Returns
    -------
    Array
        ∂π/∂(standard parameters), shape (n_pi, n_pi), block diagonal by link.
    """
    result = np.eye(standard.size)
    for i in range(0, 10 * len(device.massive), 10):
        m, c = standard[i], standard[i + 1 : i + 4]
        result[i + 1 : i + 4, i] = c
        result[i + 1 : i + 4, i + 1 : i + 4] = m * np.eye(3)
        x, y, z = c
        result[i + 4 : i + 10, i] = y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z
        result[i + 4 : i + 10, i + 1 : i + 4] = m * np.array(
            [
                [0, 2 * y, 2 * z],
                [2 * x, 0, 2 * z],
                [2 * x, 2 * y, 0],
                [-y, -x, 0],
                [-z, 0, -x],
                [0, -z, -y],
            ]
        )
    return result


def pi_prior(device: Device) -> tuple[Array, Array]:
    """Compute the Gaussian prior of π by linear error propagation at the first guesses.

    Parameters
    ----------
    device
        Device with first guesses and prior standard deviations of its standard parameters.

    Returns
    -------
    mean : Array
        π at the first guesses, shape (n_pi,).
    covariance : Array
        J·diag(σ²)·Jᵀ with J = ∂π/∂(standard parameters), shape (n_pi, n_pi).
    """
    standard = standard_initial(device)
    jacobian = pi_jacobian(device, standard) * standard_std(device)
    return to_pi(device, standard), jacobian @ jacobian.T
