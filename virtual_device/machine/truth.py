"""The numbers of the virtual arm, as they stand in ``truth.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.machine.friction import LAWS, law_parameters

LINK = ("mass", "x", "y", "z", "xx", "yy", "zz", "xy", "xz", "yz")
"""Columns of `Truth.links`: mass [kg], centroid [m], inertia tensor about the centroid in link axes [kg m²]."""
DRIVE = ("Kp", "Ks", "epos", "sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")
"""Columns of `Truth.drives`."""
GEOMETRY = ("upper", "forearm", "crank", "handle", "gravity")
"""Entries of `Truth.geometry`: lengths [m] and gravity [m/s²]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """Arrays ``geometry`` (5,), ``links`` (7, 10), ``drives`` (6, 9), in the order of GEOMETRY, LINK, DRIVE.

    ``friction`` names the law of each joint that does not have the first of `friction.LAWS`. A law takes its own
    parameters from ``drives`` and leaves the others.
    """

    geometry: Array
    links: Array
    drives: Array
    friction: Mapping[int, str] = field(default_factory=dict)

    def law_parameters(self, joint: int) -> dict[str, float]:
        """Return `friction.OF_LAWS` of a joint."""
        return law_parameters(self.friction.get(joint, LAWS[0]), float(self.drives[joint, DRIVE.index("Fc")]))

    def packed(self) -> Array:
        """All numbers in the order of the C structure, shape (147,)."""
        laws = [list(self.law_parameters(joint).values()) for joint in range(len(self.drives))]
        return np.concatenate([self.geometry, self.links.ravel(), np.hstack([self.drives, laws]).ravel()])


def read_truth(path: Path | None = None) -> Truth:
    """Read ``path``, by default the device that made the embedded campaign."""
    data = tomllib.loads((path or Path(__file__).with_name("truth.toml")).read_text())
    links = [[row[key] for key in LINK] for row in data["link"]]
    drives = [[row[key] for key in DRIVE] for row in data["joint"]]
    geometry = [data["geometry"][key] for key in GEOMETRY]
    return Truth(geometry=np.array(geometry), links=np.array(links), drives=np.array(drives))


def inertia_tensor(row: Array) -> Array:
    """Inertia about the centroid, shape (3, 3), from one row of `Truth.links`."""
    xx, yy, zz, xy, xz, yz = row[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
