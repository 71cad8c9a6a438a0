"""Base parameters: the identifiable combinations of inertial parameters, exactly and numerically.

A `Lagrangian` comes in, the base parameters of a set of equations of motion go out:

1. `equation_forms` selects the entries of M and φ of the free joints, linear in π.
2. `rows` splits each entry into one row over π per trigonometric monomial.
3. `Echelon.of` brings the rows into echelon form; its rank is the number of base parameters.
4. `base_parameters` reads them off the reduced row echelon form, β_k = π_k + Σ (rational)·π_c (Gautier & Khalil 1990;
   Khalil & Dombre 2002, section 9.4).

`numeric_rank` computes the rank a second time, in floating point, by Newton-Euler.
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
    """One identifiable combination of inertial parameters, Σ factors[k]·π_k.

    Parameters
    ----------
    leading
        Index into `pi_ids` of the parameter with factor 1, which no other base parameter contains.
    factors
        Index into `pi_ids` → factor.
    """

    leading: int
    factors: Row

    def text(self, ids: tuple[str, ...]) -> str:
        """Write the combination as a formula.

        Parameters
        ----------
        ids
            Names of π, shape (n_pi,), as from `pi_ids`.

        Returns
        -------
        str
            Formula such as ``link5_L33 + link6_L22``.
        """
        parts: list[str] = []
        for k, factor in sorted(self.factors.items()):
            sign = "+ " if parts else ""
            if factor < 0:
                sign = "- "
            size = "" if abs(factor) == 1 else f"{float(abs(factor)):.6g} "
            parts.append(f"{sign}{size}{ids[k]}")
        return " ".join(parts)


def full_lagrangian(device: Device) -> Lagrangian:
    """Derive the Lagrangian of a device with all joints free, as `derive` does.

    Parameters
    ----------
    device
        Device with n_q joints.

    Returns
    -------
    Lagrangian
        M and V as linear forms in π.
    """
    return derive(device, tuple(range(len(device.joints))), (0.0,) * len(device.joints))


def equation_forms(lagrangian: Lagrangian, free: tuple[int, ...]) -> list[LinearForm]:
    """Select the entries of the equation of motion that belong to the free joints.

    Parameters
    ----------
    lagrangian
        Lagrangian in which all joints are symbols.
    free
        Numbers of the free joints; the locked joints stay symbols, so that the entries hold at every lock posture.

    Returns
    -------
    list of LinearForm
        M_ij for i ≤ j, then φ_i.
    """
    at = [lagrangian.ring.free.index(j) for j in free]
    masses = [lagrangian.entry(i, j) for n, i in enumerate(at) for j in at[n:]]
    return masses + [lagrangian.gravity(i) for i in at]


def rows(forms: Iterable[LinearForm]) -> list[Row]:
    """Split linear forms into rows over π.

    Parameters
    ----------
    forms
        Entries of M or φ.

    Returns
    -------
    list of Row
        One row per entry and monomial: index into π → rational factor.
    """
    return [row for form in forms for row in rows_of(form).values()]


def base_parameters(echelon: Echelon) -> tuple[BaseParameter, ...]:
    """Choose base parameters for a span.

    Parameters
    ----------
    echelon
        Span of the rows of a set of equations.

    Returns
    -------
    tuple of BaseParameter
        As many base parameters as the span has rank, by ascending leading index. The leading parameter is a first
        moment or a product of inertia where possible, a mass only where nothing else can lead.
    """
    # a pivot is the first column of its row: the order of the columns decides which parameters lead
    column = {k: n for n, k in enumerate(sorted(echelon.columns, key=_preference))}
    original = {n: k for k, n in column.items()}
    sorted_span = Echelon.of({column[k]: factor for k, factor in row.items()} for row in echelon.reduced.values())
    return tuple(
        BaseParameter(leading=original[pivot], factors={original[n]: factor for n, factor in row.items()})
        for pivot, row in sorted(sorted_span.reduced.items(), key=lambda item: original[item[0]])
    )


def _preference(k: int) -> tuple[int, int]:
    """Order of columns: first moments and products, then L11, L22, L33, then masses; from the base to the tip."""
    return (9, 1, 1, 1, 2, 3, 4, 0, 0, 0)[k % 10], k


def numeric_rank(device: Device, free: tuple[int, ...], samples: int = 60, seed: int = 0) -> tuple[int, Array]:
    """Compute the rank of the free joints' regressor over random postures and motions, by SVD.

    The computation is independent of the exact rank: Newton-Euler in floating point instead of Lagrange in rational
    numbers.

    Parameters
    ----------
    device
        Device with n_q joints.
    free
        Numbers of the free joints; the locked joints have random positions and no motion.
    samples
        Number of random states.
    seed
        Seed of the random states.

    Returns
    -------
    rank : int
        Number of singular values above 1e-9 of the largest.
    singular : Array
        Singular values, descending.
    """
    rng = np.random.default_rng(seed)
    shape = (len(device.joints), samples)
    moving = np.isin(np.arange(shape[0]), free)[:, np.newaxis]
    v, a = (np.where(moving, rng.uniform(-3.0, 3.0, shape), 0.0) for _ in range(2))
    Y = regressor(device, rng.uniform(-2.0, 2.0, shape), v, a)[list(free)].reshape(len(free) * samples, -1)
    singular: Array = np.linalg.svd(Y, compute_uv=False).astype(np.float64)
    return int(np.sum(singular > 1e-9 * singular[0])), singular
