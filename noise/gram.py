"""Gram matrices of [residual, random columns] under the inverse noise covariance: `Terms` and simulations in.

`marginal` takes the matrices. Under white noise the scatter columns of the cycles have no rows in common, so that sums
over cycles replace the columns themselves; correlated noise needs every column whitened.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.values.run import Array
from haptid.noise.noise_model import NoiseModel
from haptid.noise.terms import Terms
from haptid.noise.whitening import gram as inner
from haptid.noise.whitening import whiten


def white_products(terms: Terms, model: NoiseModel, residual: Array, motion: Array, keep: NDArray[np.bool_]) -> Array:
    """Build the inner products of [residual, random columns] from sums over cycles.

    A cycle's scatter column is ``motion`` on the rows of the cycle and 0 elsewhere.

    Parameters
    ----------
    terms
        The run, its cycles, and its fixed columns.
    model
        Random parts of the data.
    residual, motion
        Measured minus simulated, and simulated minus equilibrium [rad], shape (n_sets, n_t) each.
    keep
        Rows that count, shape (n_t,).

    Returns
    -------
    ndarray, shape (n_sets, 1 + k, 1 + k)
        The columns in the order of `column_scales`; in squares of the readings' unit where no column has another.
    """
    fixed = terms.fixed * keep
    n_fixed, sets = fixed.shape[0], residual.shape[0]
    moving = model.scatter == "reading"
    n_moving = terms.cycles + model.runs if moving else 0
    gram = np.zeros((sets, 1 + n_fixed + n_moving, 1 + n_fixed + n_moving))
    r = residual * keep
    gram[:, 0, 0] = np.einsum("wi,wi->w", r, r)
    gram[:, 0, 1 : 1 + n_fixed] = np.einsum("wi,ki->wk", r, fixed)
    gram[:, 1 : 1 + n_fixed, 1 : 1 + n_fixed] = inner(fixed)
    if moving:
        _add_motion(gram, terms, motion * keep, r, fixed, with_run=model.runs)
    lower = np.tril_indices(gram.shape[-1], -1)  # only the upper triangle is filled so far
    gram[:, lower[0], lower[1]] = gram[:, lower[1], lower[0]]
    return gram


def weigh_white(products: Array, noise: Array, keep: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Weigh inner products by white noise.

    Parameters
    ----------
    products
        As `white_products` returns them.
    noise
        Standard deviation [rad], shape (n_sets,).
    keep
        Rows that count, shape (n_t,).

    Returns
    -------
    gram
        Gram matrix G under the inverse noise covariance, shape (n_sets, 1 + k, 1 + k).
    logdet
        log det of the noise covariance, shape (n_sets,).
    """
    return products / noise[:, None, None] ** 2, 2 * np.log(noise) * int(keep.sum())


def _add_motion(gram: Array, terms: Terms, m: Array, r: Array, fixed: Array, *, with_run: bool) -> None:
    """Fill the upper triangle of the columns that follow the motion, cycle by cycle.

    The columns of two cycles are orthogonal; the column of the run is their sum.
    """
    first = 1 + fixed.shape[0]
    for c, rows in enumerate(terms.slices):
        part = m[:, rows]
        gram[:, 0, first + c] = np.einsum("wi,wi->w", r[:, rows], part)
        gram[:, 1:first, first + c] = np.einsum("wi,ki->wk", part, fixed[:, rows])
        gram[:, first + c, first + c] = np.einsum("wi,wi->w", part, part)
    if with_run:
        last = gram.shape[-1] - 1
        gram[:, :first, last] = gram[:, :first, first:last].sum(axis=-1)
        # The run's column is the sum of orthogonal ones: its product with a cycle's column is that cycle's own.
        diagonal = np.einsum("wii->wi", gram)[:, first:last]
        gram[:, first:last, last] = diagonal
        gram[:, last, last] = diagonal.sum(axis=-1)


def dense_columns(terms: Terms, model: NoiseModel, residual: Array, motion: Array) -> Array:
    """Return [residual, random columns] of one parameter set.

    Parameters
    ----------
    terms
        The run, its cycles, and its fixed columns.
    model
        Random parts of the data.
    residual, motion
        Measured minus simulated, and simulated minus equilibrium [rad], shape (n_t,) each.

    Returns
    -------
    ndarray, shape (1 + k, n_t)
        Residual, fixed columns, and with scatter on the reading one column per cycle and that of the run, in the order
        of `column_scales`.
    """
    columns = [residual, *terms.fixed]
    if model.scatter == "reading":
        moving = np.zeros((terms.cycles, motion.size))
        for column, rows in zip(moving, terms.slices, strict=True):
            column[rows] = motion[rows]
        columns += [*moving]
        columns += [motion] if model.runs else []
    return np.array(columns)


def correlated_gram(
    terms: Terms,
    model: NoiseModel,
    residual: Array,
    motion: Array,
    noise: Array,
    error: tuple[Array, Array],
    keep: NDArray[np.bool_],
) -> tuple[Array, Array]:
    """Build the Gram matrix G under white noise and an Ornstein–Uhlenbeck model error.

    Parameters
    ----------
    terms, model, residual, motion, keep
        As in `white_products`.
    noise
        Standard deviation of the white part [rad], shape (n_sets,).
    error
        Standard deviation [rad] and correlation time [s] of the model error, shape (n_sets,) each.

    Returns
    -------
    gram
        Shape (n_sets, 1 + k, 1 + k), the columns in the order of `column_scales`.
    logdet
        log det of the noise covariance, shape (n_sets,).
    """
    grams, logdets = [], []
    for r, m, sigma, a, time in zip(residual, motion, noise, *error, strict=True):
        columns, logdet = whiten(
            dense_columns(terms, model, r, m), terms.run.t, noise=sigma, error=a, time=time, keep=keep
        )
        grams.append(inner(columns))
        logdets.append(logdet)
    return np.array(grams), np.array(logdets)
