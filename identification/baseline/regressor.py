"""Regressor of the plain model: free joints and `FilteredMotion` in, columns of the torque equation out.

For every free joint, τ = W·θ with

    rigid body   the coefficients of the locked motion (one joint: inertia, gravity_cos, gravity_sin),
    Fv, Fc       viscous and Coulomb friction: q̇ and sgn q̇,
    offset       a constant torque.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, cast

import numpy as np
import sympy as sp

from haptid.measurement.signals.filtered_motion import FilteredMotion
from haptid.measurement.values.run import Array
from haptid.measurement.values.units import unit_for
from haptid.model.algebra.trig_polynomials import position_symbol, velocity_symbol
from haptid.model.device.device import Device
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.rigid_body.locked_dynamics import locked_motion

FRICTION = ("Fv", "Fc", "offset")
"""Ids of the parameters that every joint has beside its rigid body."""
UNITS = {
    "inertia": "kg m^2",
    "gravity_cos": "N m",
    "gravity_sin": "N m",
    "Fv": "N m s/rad",
    "Fc": "N m",
    "offset": "N m",
}
"""Units for revolute joints."""
REGRESSORS_KEPT = 16
"""Regressors whose compiled columns are kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Regressor:
    """Columns of the plain model of some free joints.

    Parameters
    ----------
    joints
        Numbers of the free joints.
    ids, units
        Parameters in the order of the columns; those of several joints end in the joint's number (``Fc_1``).
    rigid
        Torques (n_joints) by rigid-body coefficient, as SymPy expressions in q<j>, v<j> and a<j>.
    """

    joints: tuple[int, ...]
    ids: tuple[str, ...]
    units: tuple[str, ...]
    rigid: tuple[tuple[sp.Expr, ...], ...]

    @classmethod
    def of(
        cls, device: Device | None, joints: Sequence[int], posture: Sequence[float], prismatic: Sequence[bool]
    ) -> Regressor:
        """Build the regressor of a configuration.

        Parameters
        ----------
        device
            Device whose locked motion gives the rigid-body columns; None for a single joint.
        joints
            Numbers of the free joints.
        posture
            Positions of the locked joints [rad], shape (n_q,); may be empty without a device.
        prismatic
            Whether each free joint slides.

        Returns
        -------
        Regressor
        """
        if device is None:
            rigid = _single_joint(joints[0], slides=prismatic[0])
            units = {id: unit_for(UNITS[id], prismatic) for id in rigid}
        else:
            rigid, units = _build_locked_columns(device, joints, posture)
        ids, all_units = [*rigid], [units[id] for id in rigid]
        for k, suffix in enumerate(id_suffixes(joints)):
            ids += [f"{id}{suffix}" for id in FRICTION]
            all_units += [unit_for(UNITS[id], [prismatic[k]]) for id in FRICTION]
        return cls(joints=tuple(joints), ids=tuple(ids), units=tuple(all_units), rigid=tuple(rigid.values()))

    @property
    def nonnegative(self) -> Array:
        """Whether physics forbids a negative value, by id: of a single joint's inertia and of friction."""
        return np.array([id.partition("_")[0] in ("inertia", "Fv", "Fc") for id in self.ids])

    @property
    def n_rigid(self) -> int:
        """Number of rigid-body columns, which come first."""
        return len(self.rigid)

    def rigid_columns(self, motion: FilteredMotion) -> Array:
        """Evaluate the rigid-body columns.

        Parameters
        ----------
        motion
            Filtered motion of the free joints.

        Returns
        -------
        ndarray, shape (n, n_joints, n_rigid)
            Torque [N m] ([N]) for a unit of each parameter.
        """
        values = [*motion.q.T, *motion.v.T, *motion.a.T]
        W = np.zeros((motion.t.size, len(self.joints), self.n_rigid))
        for column, torques in enumerate(_functions(self.joints, self.rigid)(*values)):
            for k, torque in enumerate(torques):
                W[:, k, column] = torque
        return W

    def columns(self, motion: FilteredMotion) -> Array:
        """Evaluate all columns.

        Parameters
        ----------
        motion
            Filtered motion of the free joints.

        Returns
        -------
        ndarray, shape (n, n_joints, n_ids)
            Torque [N m] ([N]) for a unit of each parameter: rigid body, then viscous, Coulomb and constant of every
            joint.
        """
        n, joints = motion.t.size, len(self.joints)
        W = np.concatenate([self.rigid_columns(motion), np.zeros((n, joints, len(FRICTION) * joints))], axis=2)
        # Dry friction turns within a row: it has not passed the filter with the motion.
        sign = motion.through_filter(np.sign(motion.v))
        for k in range(joints):
            first = self.n_rigid + len(FRICTION) * k
            W[:, k, first : first + len(FRICTION)] = np.column_stack([motion.v[:, k], sign[:, k], np.ones(n)])
        return W


@lru_cache(maxsize=REGRESSORS_KEPT)
def _functions(joints: tuple[int, ...], rigid: tuple[tuple[sp.Expr, ...], ...]) -> Callable[..., Any]:
    """Compile the rigid-body columns: SymPy takes longer for that than NumPy for a run."""
    symbols = [symbol(j) for symbol in (position_symbol, velocity_symbol, acceleration_symbol) for j in joints]
    return cast("Callable[..., Any]", sp.lambdify(symbols, rigid, "numpy"))


def acceleration_symbol(joint: int) -> sp.Symbol:
    """Return the symbol of a joint's acceleration.

    Parameters
    ----------
    joint
        Number j of the joint.

    Returns
    -------
    sympy.Symbol
        Real symbol ``a<j>`` [rad/s²] or [m/s²].
    """
    return sp.Symbol(f"a{joint}", real=True)


def _single_joint(joint: int, *, slides: bool) -> dict[str, tuple[sp.Expr, ...]]:
    """Return the rigid-body columns of any one joint; a constant force on a slide is its offset."""
    a, q = acceleration_symbol(joint), position_symbol(joint)
    columns: dict[str, tuple[sp.Expr, ...]] = {"inertia": (a,)}
    return columns if slides else columns | {"gravity_cos": (sp.cos(q),), "gravity_sin": (sp.sin(q),)}


def _build_locked_columns(
    device: Device, joints: Sequence[int], posture: Sequence[float]
) -> tuple[dict[str, tuple[sp.Expr, ...]], dict[str, str]]:
    """Return the rigid-body columns of a device's locked motion, and their units by id."""
    motion = locked_motion(device, joints, posture)
    a = sp.Matrix([acceleration_symbol(j) for j in motion.joints])
    torques = sp.Matrix(motion.mass_matrix) * a + sp.Matrix(motion.christoffel_force) + sp.Matrix(motion.gravity_force)
    columns = {c.id: tuple(sp.expand(torque).diff(c.symbol) for torque in torques) for c in motion.coefficients}
    return columns, {c.id: c.unit for c in motion.coefficients}
