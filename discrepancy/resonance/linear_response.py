"""Linearise a joint with an effect about rest: an `Effect` in, its response at each frequency out.

Dry friction has no linear part. Over a motion of many reversals viscous friction stands for it, so that the joint is
written with Coulomb friction of zero and free viscous friction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from haptid.discrepancy.resonance.frequency_response import ComplexArray
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.model.equations.equations import TIME
from haptid.model.equations.quantity import Quantity
from haptid.model.joint.locked_joint import joint_equations

LAW = "coulomb"
"""Friction law that is linear without its Coulomb friction."""
ABSENT = ("Fs", "Fc", "gravity_cos", "gravity_sin", "epos")
"""Parameters that are zero in the linear joint: a spring stands for the slope of the weight."""
JOINT = ("inertia", "Ks", "sigma2")
"""Parameters of the linear joint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearJoint:
    """A joint about rest, ẋ = A·x + B·τ, y = C·x + D·τ.

    Parameters
    ----------
    free
        Parameters: those of `JOINT`, then those of the effect that act.
    matrices
        Function from their values to A, B, C and D.
    """

    free: tuple[Quantity, ...]
    matrices: Callable[[Array], Sequence[Array]]

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the parameters."""
        return tuple(q.id for q in self.free)

    def mobility(self, values: Array, omega: Array) -> ComplexArray:
        """Compute the response of the speed to the torque, jω·(C·(jωI − A)⁻¹·B + D).

        Parameters
        ----------
        values
            Values of ``free``, shape (n,).
        omega
            Angular frequencies [rad/s], shape (n_omega,).

        Returns
        -------
        ndarray of complex, shape (n_omega,)
            In rad/(s N m), or m/(s N) of a prismatic joint.
        """
        A, B, C, D = (np.asarray(each, dtype=np.float64) for each in self.matrices(values))
        within = 1j * omega[:, None, None] * np.eye(A.shape[0]) - A
        states = np.linalg.solve(within, np.broadcast_to(B.astype(np.complex128), (omega.size, *B.shape)))
        return np.asarray(1j * omega * ((C @ states)[:, 0, 0] + D[0, 0]), dtype=np.complex128)


def linearise(effect: Effect | None, *, prismatic: bool) -> LinearJoint | None:
    """Linearise a joint about rest.

    Parameters
    ----------
    effect
        Effect in SI units; None for the joint alone.
    prismatic
        Whether the joint is prismatic.

    Returns
    -------
    LinearJoint or None
        None where the joint has no derivative there.
    """
    effects = () if effect is None else (effect,)
    e = joint_equations(0, effects=effects, prismatic=prismatic, friction=LAW).without_definitions()
    states, inputs = [s.symbol for s in e.states], [u.symbol for u in e.inputs]
    still: dict[sp.Symbol, float] = dict.fromkeys([*states, *inputs, TIME], 0.0)
    still |= {q.symbol: 0.0 if q.id in ABSENT else q.initial for q in e.parameters if q.fixed or q.id in ABSENT}
    right, out = sp.Matrix(e.rhs), sp.Matrix([e.outputs[0].expression])
    matrices = [m.jacobian(by).subs(still) for m in (right, out) for by in (states, inputs)]
    if any(m.has(sp.nan, sp.zoo, sp.Derivative, sp.Subs) for m in matrices):
        return None
    acting = set[sp.Symbol]().union(*(m.free_symbols for m in matrices))
    own = () if effect is None else tuple(q for q in effect.parameters if q.symbol in acting)
    free = (*(e.parameter(id) for id in JOINT), *own)
    return LinearJoint(free=free, matrices=sp.lambdify([[q.symbol for q in free]], matrices, "numpy"))
