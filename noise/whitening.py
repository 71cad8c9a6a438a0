"""Whitening of data whose error is white noise plus an Ornstein–Uhlenbeck process, and inner products of columns.

Both run in compiled C (``whitening.c``). A Kalman filter of the scalar Ornstein–Uhlenbeck state gives L⁻¹v row by row:
its cost grows with the number of rows, that of a Cholesky factorisation of S with their cube.
"""

from __future__ import annotations

import ctypes
from functools import lru_cache
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.values.run import Array
from haptid.model.kernel.compiler import compile_shared

_p, _long, _double = ctypes.c_void_p, ctypes.c_long, ctypes.c_double


@lru_cache(maxsize=1)  # compiled at the first call, so that an import needs no compiler
def _library() -> ctypes.CDLL:
    source = resources.files("haptid.noise").joinpath("whitening.c").read_text(encoding="utf-8")
    library = ctypes.CDLL(str(compile_shared({"whiten.c": source}, main=("whiten.c",))))
    library.uq_whiten.restype = _double
    library.uq_whiten.argtypes = (_long, _long, _p, _p, _double, _double, _double, _p)
    library.uq_gram.restype = None
    library.uq_gram.argtypes = (_long, _long, _p, _p)
    return library


def whiten(
    columns: Array, t: Array, *, noise: float, error: float, time: float, keep: NDArray[np.bool_]
) -> tuple[Array, float]:
    """Return L⁻¹v for every column v, and log det S, of S = L·Lᵀ = noise²·I + error²·exp(−|tᵢ − tⱼ|/time).

    Parameters
    ----------
    columns
        Data, shape (n_columns, n_t), each row one column of data.
    t
        Times [s], shape (n_t,).
    noise, error, time
        Standard deviations of the white and the correlated part; correlation time [s].
    keep
        Rows that were seen, shape (n_t,); the others come back as 0 and do not count.

    Returns
    -------
    whitened : ndarray, shape (n_columns, n_t)
        L⁻¹v of every column.
    logdet : float
        log det S over the rows that were seen.

    Raises
    ------
    ValueError
        Where the shapes of ``columns``, ``t`` and ``keep`` disagree.
    NumericalError
        Where the compiler is missing or fails.
    """
    out = np.array(columns, dtype=np.float64, order="C")
    times, seen = np.ascontiguousarray(t), np.ascontiguousarray(keep, dtype=np.int8)
    if out.ndim != 2 or out.shape[1] != times.size or seen.size != times.size:
        msg = f"columns need shape (n, {times.size}), got {out.shape}; keep {seen.shape}"
        raise ValueError(msg)
    logdet = _library().uq_whiten(
        out.shape[0], out.shape[1], times.ctypes.data, seen.ctypes.data, noise, error, time, out.ctypes.data
    )
    return out, float(logdet)


def gram(columns: Array) -> Array:
    """Return the inner products of columns, summed in a fixed order: the same input gives the same bits.

    Parameters
    ----------
    columns
        Each row one column of data, shape (n_columns, n_t).

    Returns
    -------
    ndarray, shape (n_columns, n_columns)
        Σ_t of the products, in the units of the columns.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    v = np.ascontiguousarray(columns, dtype=np.float64)
    out = np.empty((v.shape[0], v.shape[0]))
    _library().uq_gram(v.shape[0], v.shape[1], v.ctypes.data, out.ctypes.data)
    return out
