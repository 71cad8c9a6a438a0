"""The elementary functions of real.h against mpmath, through a small compiled library."""

from __future__ import annotations

import ctypes

import mpmath as mp
import numpy as np
import pytest

from haptid.model.kernel.compiler import compile_shared
from haptid.model.kernel.generate import template

NAMES = ("exp", "log", "sin", "cos", "tanh", "sqrt", "abs", "sign", "step")
SHIM = (
    '#include "real.h"\n#define API __attribute__((visibility("default")))\n'
    + "".join(
        f"API void v_{n}(long n, const double *x, double *y) {{ for (long i = 0; i < n; i++) y[i] = hk_{n}(x[i]); }}\n"
        for n in NAMES
    )
    + "API void v_phi(long n, const double *x, double *y) {\n"
    "  for (long i = 0; i < n; i++) { hk_phi_t p = hk_phi(x[i]);\n"
    "    y[4*i] = p.e; y[4*i+1] = p.p1; y[4*i+2] = p.p2; y[4*i+3] = p.p3; } }\n"
)


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    return ctypes.CDLL(str(compile_shared({"real.h": template("real.h"), "shim.c": SHIM}, main=("shim.c",))))


def call(library: ctypes.CDLL, name: str, x: np.ndarray, width: int = 1) -> np.ndarray:
    x = np.ascontiguousarray(x, dtype=float)
    y = np.empty(x.size * width)
    function = getattr(library, f"v_{name}")
    function.argtypes = (ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p)
    function.restype = None
    function(x.size, x.ctypes.data, y.ctypes.data)
    return y.reshape(x.size, width) if width > 1 else y


def exactly(function, x: np.ndarray) -> np.ndarray:
    with mp.workdps(40):
        return np.array([float(function(mp.mpf(float(v)))) for v in x])


def ulps(y: np.ndarray, exact: np.ndarray) -> float:
    return float(np.max(np.abs(y - exact) / np.spacing(np.abs(exact))))


RNG = np.random.default_rng(0)
NEAR = np.concatenate((RNG.uniform(-1, 1, 400), RNG.normal(size=400) * 10.0 ** RNG.uniform(-12, 0, 400)))


def test_exp_to_two_ulps(library: ctypes.CDLL):
    x = np.concatenate((NEAR, RNG.uniform(-690, 690, 800)))
    assert ulps(call(library, "exp", x), exactly(mp.exp, x)) <= 2


def test_exp_of_extreme_arguments_stays_finite_and_positive(library: ctypes.CDLL):
    y = call(library, "exp", np.array([-1e300, -1000.0, 1000.0, 1e300]))
    assert np.isfinite(y).all()
    assert (y > 0).all()


def test_log_to_two_ulps(library: ctypes.CDLL):
    around_one = 1 + RNG.normal(size=800) * 10.0 ** RNG.uniform(-15, -1, 800)
    x = np.concatenate((np.abs(around_one), np.exp(RNG.uniform(-700, 700, 800)), 2.0 ** np.arange(-1022, 1024)))
    exact = exactly(mp.log, x)
    y = call(library, "log", x)
    assert ulps(y[exact != 0], exact[exact != 0]) <= 2
    assert (y[exact == 0] == 0).all()


def test_log_of_zero_and_below_stays_finite(library: ctypes.CDLL):
    y = call(library, "log", np.array([0.0, -0.0, -1.0, 5e-324]))
    np.testing.assert_allclose(y, -1022 * np.log(2))


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine(library: ctypes.CDLL, name: str):
    x = np.concatenate((NEAR, RNG.uniform(-1e5, 1e5, 800), np.arange(-16, 17) * np.pi / 4))
    exact = exactly(getattr(mp, name), x)
    assert np.abs(call(library, name, x) - exact).max() < 3e-16
    assert ulps(call(library, name, NEAR), exactly(getattr(mp, name), NEAR)) <= 2


def test_tanh(library: ctypes.CDLL):
    x = np.concatenate((NEAR, RNG.uniform(-400, 400, 400)))
    np.testing.assert_allclose(call(library, "tanh", x), exactly(mp.tanh, x), rtol=0, atol=3e-16)


@pytest.mark.parametrize("name", ["sqrt", "abs", "sign", "step"])
def test_exact_functions(library: ctypes.CDLL, name: str):
    x = np.concatenate((np.abs(NEAR) if name == "sqrt" else NEAR, [0.0]))
    reference = {"sqrt": np.sqrt, "abs": np.abs, "sign": np.sign, "step": lambda x: np.heaviside(x, 0.0)}[name](x)
    np.testing.assert_array_equal(call(library, name, x), reference)


def phi(k: int, L: mp.mpf) -> mp.mpf:
    """φ_k(L) = Σ L^j/(j + k)!, by its series or by recurrence from exp (Cox and Matthews 2002)."""
    if abs(L) < 2:
        return mp.nsum(lambda j: L**j / mp.factorial(j + k), [0, mp.inf])
    value = mp.exp(L)
    for j in range(k):
        value = (value - 1 / mp.factorial(j)) / L
    return value


def test_phi_functions(library: ctypes.CDLL):
    L = -np.concatenate(([0.0, 1.0, 0.999999, 1.000001], 10.0 ** RNG.uniform(-8, 5, 150)))
    y = call(library, "phi", L, 4)
    for k in range(4):
        np.testing.assert_allclose(
            y[:, k], exactly(lambda x, k=k: phi(k, x), L), rtol=3e-14, atol=1e-300
        )  # 1/17! is cut off
