"""Suggest a closed form for a missing torque: torque over one variable in, formula or None out.

1. Fit one function of `LIBRARY`, then two, by forward regression with orthogonal least squares.
2. Return the first set of terms that follows the torque within its standard errors, or within
   `least_std_over_largest_torque` of its maximum.

This is a suggestion only: a curve over one variable cannot tell a law from another with the same bends. PySINDy is an
optional dependency (``haptid[suggest]``).

References
----------
Billings 2013, chapter 3; `pysindy.FROLS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec

import numpy as np
from scipy.stats import chi2

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

Function = Callable[[Array], Array]


def _bell(centre: float) -> Function:
    return lambda x: np.asarray(np.exp(-(((x - centre) / 0.3) ** 2)))


def _wave(wave: Function, number: int) -> Function:
    return lambda x: wave(number * np.pi * x)


LIBRARY: Mapping[str, Function] = {
    "x²": np.square,
    "x³": lambda x: x**3,
    "x⁴": lambda x: x**4,
    "|x|": np.abs,
    "tanh(5·x)": lambda x: np.tanh(5 * x),
    **{f"exp(−((x − {c:.1f})/0.3)²)": _bell(c) for c in (-0.5, 0.0, 0.5)},
    **{f"sin({k}·π·x)": _wave(np.sin, k) for k in (1, 2, 3)},
    **{f"cos({k}·π·x)": _wave(np.cos, k) for k in (1, 2, 3)},
}
"""Functions of x, the variable over half its range about the middle: −1 ≤ x ≤ 1."""


def suggestion(knots: Array, torque: Array, std: Array, bend: Array, unit: str = "N m") -> str | None:
    """Return a formula for a torque over one variable.

    Parameters
    ----------
    knots
        Values of the variable, shape (n,).
    torque
        Torque at the knots in ``unit``, shape (n,).
    std
        Standard error of the torque at every knot, shape (n,).
    bend
        Projector that removes constant and slope, which the torque does not hold, shape (n, n).
    unit
        Unit of the torque.

    Returns
    -------
    str or None
        Formula of x = (variable − middle)/half range; None where at most `most_terms_of_formula` functions do not
        follow the torque, or where PySINDy is not installed.
    """
    if find_spec("pysindy") is None:
        return None
    middle, half = float(knots[0] + knots[-1]) / 2, float(knots[-1] - knots[0]) / 2
    x = (knots - middle) / half
    weight = 1.0 / np.maximum(std, THRESHOLDS.unnamed.least_std_over_largest_torque * np.abs(torque).max() + 1e-300)
    terms = np.column_stack([bend @ f(x) for f in LIBRARY.values()])
    target = weight * torque
    for count in range(1, THRESHOLDS.unnamed.most_terms_of_formula + 1):
        coefficients = _sparse(weight[:, None] * terms, target, count)
        left = target - weight * (terms @ coefficients)
        gain = float(target @ target - left @ left)
        dof = knots.size - 2 - np.count_nonzero(coefficients)
        if (
            gain > THRESHOLDS.unnamed.least_chi2_gain_of_formula
            and chi2.sf(float(left @ left), dof) > THRESHOLDS.unnamed.least_p_value_of_formula
        ):
            pairs = zip(coefficients, LIBRARY, strict=True)
            said = " ".join(f"{c:+.3g}·{name}" for c, name in pairs if c)
            return f"{said.lstrip('+')} {unit}, x = (variable − {middle:.3g})/{half:.3g}, up to a straight line"
    return None


def _sparse(terms: Array, target: Array, count: int) -> Array:
    """Return coefficients (n_terms,) of which at most ``count`` are not zero."""
    from pysindy import FROLS  # noqa: PLC0415 (optional, and slow to import)

    found = FROLS(max_iter=count, normalize_columns=True, alpha=0.0, kappa=None)
    found.fit(terms, target[:, None])
    chosen = np.argsort(-np.abs(found.coef_[0] * np.linalg.norm(terms, axis=0)))[:count]
    chosen = chosen[found.coef_[0][chosen] != 0]
    coefficients = np.zeros(terms.shape[1])
    coefficients[chosen] = np.linalg.lstsq(terms[:, chosen], target, rcond=None)[0]
    return coefficients
