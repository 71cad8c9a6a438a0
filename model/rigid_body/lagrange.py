"""Lagrange: mass matrix, Christoffel symbols and gravity as exact regressors, linear in the inertial parameters π.

T = ½ Σ_links [m v·v + 2 h·(v × ω) + ωᵀ L ω] + ½ Σ_motors J (Σ ratio·q̇)²,   V = −Σ_links [m g·p + h·(Rᵀ g)]
M_ij = ∂²T/∂q̇_i∂q̇_j,   Γ_ijk = ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j − ∂M_jk/∂q_i),   C_ij = Σ_k Γ_ijk q̇_k,   φ_i = ∂V/∂q_i
(Spong, Hutchinson & Vidyasagar 2006, eqs. 7.60-7.64). A `LinearForm` maps the index of a π to its polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from haptid.model.algebra.rational_rotations import rational_vector
from haptid.model.algebra.trig_polynomials import Polynomial, TrigRing
from haptid.model.algebra.vectors import Scalar, add, apply, cross, dot, plus, times, transpose
from haptid.model.device.device import Device
from haptid.model.rigid_body.kinematics import Column, base_poses, body_jacobians, constant_vector

LinearForm = dict[int, Polynomial]
"""Index into π → coefficient; absent where it is zero."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lagrangian:
    """M (upper triangle) and V as linear forms in π, for the free joints of `ring`.

    Parameters
    ----------
    ring
        Trigonometric polynomials in the positions of the free joints.
    mass
        (i, j) with i ≤ j, positions in ``ring.free`` → M_ij [kg m²].
    potential
        V [J], without its constant.
    """

    ring: TrigRing
    mass: dict[tuple[int, int], LinearForm]
    potential: LinearForm

    def entry(self, i: int, j: int) -> LinearForm:
        """Return the entry M_ij of the mass matrix, for any order of i and j.

        Parameters
        ----------
        i, j
            Positions in ``ring.free``.

        Returns
        -------
        LinearForm
            M_ij [kg m²] of revolute joints, linear in π.
        """
        return self.mass[min(i, j), max(i, j)]

    def gravity(self, i: int) -> LinearForm:
        """Return the gravity term φ_i = ∂V/∂q_i of the i-th free joint.

        Parameters
        ----------
        i
            Position in ``ring.free``.

        Returns
        -------
        LinearForm
            φ_i [N m] or [N], linear in π.
        """
        return self.differentiate(self.potential, i)

    def differentiate(self, form: LinearForm, i: int) -> LinearForm:
        """Return the derivative of a linear form with respect to the position of the i-th free joint.

        Parameters
        ----------
        form
            Linear form in π with coefficients in ``ring``.
        i
            Position in ``ring.free``.

        Returns
        -------
        LinearForm
            ∂form/∂q, without coefficients that are 0.
        """
        joint = self.ring.free[i]
        return _nonzero({k: self.ring.derivative(value, joint) for k, value in form.items()})

    def christoffel(self) -> dict[tuple[int, int, int], LinearForm]:
        """Compute the Christoffel symbols of the mass matrix.

        Returns
        -------
        dict of (int, int, int) to LinearForm
            (i, j, k) with j ≤ k → Γ_ijk = ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j − ∂M_jk/∂q_i); Γ_ikj = Γ_ijk is not listed.
        """
        n = range(len(self.ring.free))
        slopes = {(i, j, k): self.differentiate(form, k) for (i, j), form in self.mass.items() for k in n}
        half = self.ring.ring.domain(1, 2)

        def slope(i: int, j: int, k: int) -> LinearForm:
            return slopes[min(i, j), max(i, j), k]

        symbols = {}
        for i, j, k in product(n, n, n):
            if j <= k:
                symbols[i, j, k] = _combine(half, (slope(i, j, k), 1), (slope(i, k, j), 1), (slope(j, k, i), -1))
        return symbols


def _combine(factor: Scalar, *terms: tuple[LinearForm, int]) -> LinearForm:
    keys = {key for form, _ in terms for key in form}
    return _nonzero({key: sum(form[key] * sign for form, sign in terms if key in form) * factor for key in keys})


def _nonzero(form: LinearForm) -> LinearForm:
    return {key: value for key, value in sorted(form.items()) if value}


def kinetic_terms(a: Column, b: Column) -> tuple[Scalar, ...]:
    """Compute the contribution of one link to M_ab as a linear form in its ten inertial parameters.

    Parameters
    ----------
    a, b
        Columns (w, v) of the link's body Jacobian.

    Returns
    -------
    tuple of Scalar
        ∂M_ab/∂π in the order m, mx, my, mz, L11, L22, L33, L12, L13, L23: v_a·v_b for m, v_a × w_b + v_b × w_a for h,
        and the products of w_a and w_b for L.
    """
    (wa, va), (wb, vb) = a, b
    h = add(cross(va, wb), cross(vb, wa))
    squares = tuple(times(wa[i], wb[i]) for i in range(3))
    products = tuple(plus(times(wa[i], wb[j]), times(wa[j], wb[i])) for i, j in ((0, 1), (0, 2), (1, 2)))
    return (dot(va, vb), *h, *squares, *products)


def derive(device: Device, free: tuple[int, ...], posture: tuple[float, ...]) -> Lagrangian:
    """Derive the mass matrix and the potential of the free joints, all others locked.

    Parameters
    ----------
    device
        Device with n_q joints.
    free
        Numbers of the free joints.
    posture
        Positions of all joints [rad] or [m], shape (n_q,); entries of free joints are ignored.

    Returns
    -------
    Lagrangian
        M and V as exact linear forms in π.
    """
    ring = TrigRing(device, free, posture)
    jacobians = body_jacobians(device, ring, free)
    mass: dict[tuple[int, int], LinearForm] = {}
    for i, a in enumerate(free):
        for j, b in enumerate(free[i:], start=i):
            form: LinearForm = {}
            for number, link in enumerate(device.massive):
                columns = jacobians[link.name]
                if a in columns and b in columns:
                    _collect(form, 10 * number, kinetic_terms(columns[a], columns[b]), ring)
            for number, motor in enumerate(device.motors, start=10 * len(device.massive)):
                _collect(form, number, (ring.constant(motor.ratios.get(a, 0) * motor.ratios.get(b, 0)),), ring)
            mass[i, j] = _nonzero(form)
    return Lagrangian(ring=ring, mass=mass, potential=_potential(device, ring))


def _collect(form: LinearForm, start: int, terms: tuple[Scalar, ...], ring: TrigRing) -> None:
    for k, term in enumerate(terms, start=start):
        form[k] = ring.tidy(ring.element(term))


def _potential(device: Device, ring: TrigRing) -> LinearForm:
    g = constant_vector(ring, rational_vector(device.gravity))
    placed = base_poses(device, ring)
    form: LinearForm = {}
    for number, link in enumerate(device.massive):
        R, p = placed[link.name]
        terms = (dot(g, p), *apply(transpose(R), g))
        for k, term in enumerate(terms, start=10 * number):
            value = ring.tidy(ring.element(term))
            # V = −(m g·p + h·Rᵀg); its constant part exerts no torque and is dropped
            form[k] = value.coeff(1) - value if value else value
    return _nonzero(form)
