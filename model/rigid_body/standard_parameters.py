"""The standard parameters (m, x, y, z, I11 … I23 of a link) that an equation of motion contains.

The rows are linear in π = (m, h, L); with h = m·c and L = I + m(cᵀc·1 − c cᵀ) each row is a polynomial in the standard
parameters, and a parameter is contained where a coefficient that carries it is not zero, exactly.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from haptid.model.algebra.echelon import Row
from haptid.model.device.device import Device
from haptid.model.rigid_body.inertial_parameters import standard_ids

_DIAGONAL = {"x": ("L22", "L33"), "y": ("L11", "L33"), "z": ("L11", "L22")}
_PRODUCTS = {"L12": "xy", "L13": "xz", "L23": "yz"}
_NAMES = ("m", "mx", "my", "mz", "L11", "L22", "L33", "L12", "L13", "L23")


def find_contained(device: Device, rows: Iterable[Row]) -> frozenset[str]:
    """Find the standard parameters that rows over π contain.

    Parameters
    ----------
    device
        Device with its massive links and motors.
    rows
        Rows of an equation of motion: index into π → factor.

    Returns
    -------
    frozenset of str
        Ids of `standard_ids`.
    """
    ids = standard_ids(device)
    n = 10 * len(device.massive)
    found: set[str] = set()
    for row in rows:
        found |= {ids[k] for k in row if k >= n}
        for first in sorted({k - k % 10 for k in row if k < n}):
            stem = ids[first].removesuffix("m")
            found |= {
                stem + name
                for name in _of_link({name: row.get(first + i, Fraction(0)) for i, name in enumerate(_NAMES)})
            }
    return frozenset(found)


def _of_link(row: dict[str, Fraction]) -> set[str]:
    found = {f"I{name[1:]}" for name in _NAMES[4:] if row[name]}
    if row["m"]:
        found.add("m")
    # mx gives m·x; L22 and L33 both contain m·x², so that only their sum decides whether x² is present
    for axis, (first, second) in _DIAGONAL.items():
        if row[f"m{axis}"] or row[first] + row[second]:
            found |= {"m", axis}
    # L12 contains −m·x·y
    for name, axes in _PRODUCTS.items():
        if row[name]:
            found |= {"m", *axes}
    return found
