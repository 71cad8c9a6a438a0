"""Base parameters: the combinations of inertial parameters that equations of motion can tell, exactly and numerically.

A set of equations, linear in π, determines the span of its rows: one row per entry of M or φ and trigonometric
monomial.
The reduced row echelon form of these rows gives the base parameters in closed form, β_k = π_k + Σ (rational) π_c
(Gautier & Khalil 1990; Khalil & Dombre 2002, section 9.4).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.model.algebra.echelon import Echelon, Row
from haptid.model.device.device import Device
from haptid.model.rigid_body.lagrange import Lagrangian, LinearForm, derive
from haptid.model.rigid_body.locked_dynamics import rows_of
from haptid.model.rigid_body.regressor import regressor

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseParameter:
    """One combination: factors by index into `pi_ids`, the leading one 1."""

    leading: int
    factors: Row

    def text(self, ids: tuple[str, ...]) -> str:
        """Return it as a formula: link5_L33 + link6_L22 − …."""
        parts: list[str] = []
        for k, factor in sorted(self.factors.items()):
            sign = "- " if factor < 0 else "+ " if parts else ""
            size = "" if abs(factor) == 1 else f"{float(abs(factor)):.6g} "
            parts.append(f"{sign}{size}{ids[k]}")
        return " ".join(parts)


def full_lagrangian(device: Device) -> Lagrangian:
    """Return the Lagrangian with every joint as a symbol."""
    return derive(device, tuple(range(len(device.joints))), (0.0,) * len(device.joints))


def equation_forms(lagrangian: Lagrangian, free: tuple[int, ...]) -> list[LinearForm]:
    """Return M_ij and φ_i of the free joints; all other joints stay symbols: any posture at all."""
    at = [lagrangian.ring.free.index(j) for j in free]
    masses = [lagrangian.entry(i, j) for n, i in enumerate(at) for j in at[n:]]
    return masses + [lagrangian.gravity(i) for i in at]


def rows(forms: Iterable[LinearForm]) -> list[Row]:
    """Return the rows of linear forms over π."""
    return [row for form in forms for row in rows_of(form).values()]


def span(*groups: Iterable[Row]) -> Echelon:
    """Return the span of the rows."""
    echelon = Echelon()
    for group in groups:
        for row in group:
            echelon.add(row)
    return echelon


def base_parameters(echelon: Echelon) -> tuple[BaseParameter, ...]:
    """Return the base parameters of a span.

    Combinations are led by first moments and products of inertia where they can be, and by masses only where they must.
    """
    column = {k: n for n, k in enumerate(sorted(echelon.columns, key=_preference))}
    original = {n: k for k, n in column.items()}
    sorted_span = span([{column[k]: factor for k, factor in row.items()} for row in echelon.reduced().values()])
    return tuple(
        BaseParameter(leading=original[pivot], factors={original[n]: factor for n, factor in row.items()})
        for pivot, row in sorted(sorted_span.reduced().items(), key=lambda item: original[item[0]])
    )


def _preference(k: int) -> tuple[int, int]:
    """Order of columns: first moments and products, then L11, L22, L33, then masses; from the base to the tip."""
    return (9, 1, 1, 1, 2, 3, 4, 0, 0, 0)[k % 10], k


def numeric_rank(device: Device, free: tuple[int, ...], samples: int = 60, seed: int = 0) -> tuple[int, Array]:
    """Return rank and singular values of the free joints' regressor over random postures and motions, by SVD.

    It is independent of the exact rank: Newton-Euler in floating point instead of Lagrange in rational numbers.
    """
    rng = np.random.default_rng(seed)
    shape = (len(device.joints), samples)
    moving = np.isin(np.arange(shape[0]), free)[:, np.newaxis]
    v, a = (np.where(moving, rng.uniform(-3.0, 3.0, shape), 0.0) for _ in range(2))
    Y = regressor(device, rng.uniform(-2.0, 2.0, shape), v, a)[list(free)].reshape(len(free) * samples, -1)
    singular: Array = np.linalg.svd(Y, compute_uv=False).astype(np.float64)
    return int(np.sum(singular > 1e-9 * singular[0])), singular
