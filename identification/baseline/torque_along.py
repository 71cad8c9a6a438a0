"""Torque of a model along a measured motion: `Equations`, parameters and `FilteredMotion` in, torque out.

    τ = (rigid body + Ks·(q − epos) + friction(q̇))/Kp

The states of friction follow the filtered speed. The torque is that of the motion behind the filter: what is linear in
the motion has passed the filter with it, and dry friction passes it here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.baseline.regressor import Regressor
from haptid.identification.simulators.inverse_dynamics import torque_equations
from haptid.measurement.signals.filtered_motion import FilteredMotion
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel

NOT_FRICTION = {"inertia": 1.0, "gravity_cos": 0.0, "gravity_sin": 0.0, "Ks": 0.0, "epos": 0.0, "Kp": 1.0}
"""Values at which the torque of one joint is its acceleration plus friction: the equation divides by the inertia."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueAlong:
    """Inverse dynamics of a configuration.

    Parameters
    ----------
    equations
        Equations of the configuration.
    regressor
        Rigid-body columns of its free joints.
    prismatic
        Whether each free joint slides.
    friction
        Torque equation of each free joint alone, compiled.
    places
        Index of each parameter of the configuration by its id.
    """

    equations: Equations
    regressor: Regressor
    prismatic: tuple[bool, ...]
    friction: tuple[CompiledKernel, ...]
    places: Mapping[str, int]

    @classmethod
    def of(cls, equations: Equations, regressor: Regressor, prismatic: Sequence[bool]) -> TorqueAlong:
        """Compile the friction of every free joint.

        Parameters
        ----------
        equations
            Equations of the configuration.
        regressor
            Rigid-body columns of its free joints.
        prismatic
            Whether each free joint slides.

        Returns
        -------
        TorqueAlong
        """
        # Joint 0 stands for every joint, so that all of one law share one compiled kernel.
        alone = [
            torque_equations(joint_equations(0, prismatic=slides, friction=law))
            for law, slides in zip(equations.friction, prismatic, strict=True)
        ]
        return cls(
            equations=equations,
            regressor=regressor,
            prismatic=tuple(prismatic),
            friction=tuple(cached_kernel(one) for one in alone),
            places={q.id: place for place, q in enumerate(equations.parameters)},
        )

    def value(self, theta: Array, id: str, k: int) -> float:
        """Return a parameter of the free joint at index k.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        id
            Id without the joint's number, as ``Fc``.
        k
            Index of the joint among the free ones.

        Returns
        -------
        float
            Value in the parameter's unit; 0 where the equations have no such parameter.
        """
        full = id + id_suffixes(self.regressor.joints)[k]
        return float(theta[self.places[full]]) if full in self.places else 0.0

    def torque(self, theta: Array, motion: FilteredMotion) -> Array:
        """Compute the recorded torque that a motion needs.

        Parameters
        ----------
        theta
            Parameters in the order of ``equations.parameters``, shape (n_p,).
        motion
            Filtered motion of the free joints.

        Returns
        -------
        ndarray, shape (n, n_joints)
            Torque as it was commanded, over Kp [N m] ([N]).
        """
        rigid = self.regressor.ids[: self.regressor.n_rigid]
        known = np.array([theta[self.places[id]] if id in self.places else 0.0 for id in rigid])
        torque = self.regressor.rigid_columns(motion) @ known
        for k, slides in enumerate(self.prismatic):
            spring = self.value(theta, "Ks", k) * (motion.q[:, k] - self.value(theta, "epos", k))
            constant = self.value(theta, "gravity_cos", k) if slides and "gravity_cos" not in rigid else 0.0
            torque[:, k] += spring + constant + self.filtered_friction(theta, motion, k)
            torque[:, k] /= self.value(theta, "Kp", k)
        return np.asarray(torque)

    def filtered_friction(self, theta: Array, motion: FilteredMotion, k: int) -> Array:
        """Compute the friction of one joint as the filter leaves it.

        Viscous friction has passed the filter with the speed; the rest, which turns within a row, passes it here.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        motion
            Filtered motion.
        k
            Index of the joint among the free joints.

        Returns
        -------
        ndarray, shape (n,)
            Friction torque [N m] ([N]).
        """
        friction, _ = self.friction_along(theta, motion, k, slice(None), None)
        viscous = self.value(theta, law_named(self.equations.friction[k]).roles.viscous, k) * motion.v[:, k]
        return viscous + motion.through_filter(friction - viscous)

    def friction_along(
        self, theta: Array, motion: FilteredMotion, k: int, rows: slice, state: Array | None
    ) -> tuple[Array, Array]:
        """Compute the friction of one joint along a motion.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        motion
            Filtered motion.
        k
            Index of the joint among the free joints.
        rows
            Consecutive rows of the motion.
        state
            States of the friction law at the first of these rows; at rest where None.

        Returns
        -------
        torque : ndarray, shape (n_rows,)
            Friction torque, unfiltered.
        last : ndarray
            States of the friction law at the last row.
        """
        kernel = self.friction[k]
        quantities = kernel.equations.parameters
        values = [NOT_FRICTION.get(q.id, self.value(theta, q.id, k)) for q in quantities]
        inputs = np.column_stack([motion.q[rows, k], motion.v[rows, k], motion.a[rows, k]])
        start = np.zeros(len(kernel.equations.states)) if state is None else state
        y, last = kernel.simulate_through(motion.t[rows], inputs, np.array(values), start, linear=True)
        return y[:, 0] - inputs[:, 2], last
