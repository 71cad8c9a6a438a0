"""The joint as a CasADi step over one row, torque held: exponential Runge–Kutta of order four, exact in the bristle.

With plain RK4 the bristle needs steps below 2.8·g/(σ0·|v|): 0.15 ms, 33 to a row, where σ0 and Fc are threefold off, at
4 rad/s. So the tool is given the better integrator that its users would have to write.
"""

from __future__ import annotations

import casadi as ca


def _rates(x: ca.SX, u: ca.SX, p: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return ẋ (3,) and the bristle's relaxation rate."""
    inertia, Ks, epos, sigma0, sigma1, sigma2, vs, Fs, Fc = ca.vertsplit(p)
    q, v, z = ca.vertsplit(x)
    rate = sigma0 * ca.fabs(v) / (Fc + (Fs - Fc) * ca.exp(-((v / vs) ** 2)))
    dz = v - rate * z
    return ca.vertcat(v, (u - Ks * (q - epos) - sigma0 * z - sigma1 * dz - sigma2 * v) / inertia, dz), rate


def _phi(k: int, x: ca.SX) -> ca.SX:
    """φ_k(x): φ1 = (eˣ − 1)/x, φ_{k+1} = (φ_k − 1/k!)/x, by their series near 0."""
    series, term = 0, 1.0
    for i in range(1, k + 1):
        term /= i
    for i in range(8):
        series = series + term * x**i
        term /= i + k + 1
    safe = ca.if_else(ca.fabs(x) < 0.3, 1.0, x)
    value, factorial = ca.exp(safe), 1.0
    for i in range(k):
        factorial = factorial * i if i else 1.0
        value = (value - 1.0 / factorial) / safe
    return ca.if_else(ca.fabs(x) < 0.3, series, value)


def _weights(a: ca.SX, h: float) -> tuple[ca.SX, ...]:
    """Weights (3,) of Cox and Matthews (2002, eqs. 26-29), rates (0, 0, a): e^{-ah/2}, φ1·h/2, e^{-ah}, f1, f2, f3."""
    full, half = -a * h, -a * h / 2
    p1, p2, p3 = _phi(1, full), _phi(2, full), _phi(3, full)
    stages = (h * (p1 - 3 * p2 + 4 * p3), h * (2 * p2 - 4 * p3), h * (4 * p3 - p2))
    bristle = (ca.exp(half), h / 2 * _phi(1, half), ca.exp(full), *stages)
    plain = (1.0, h / 2, 1.0, h / 6, h / 3, h / 6)
    return tuple(ca.vertcat(k, k, b) for k, b in zip(plain, bristle, strict=True))


def _substep(x: ca.SX, u: ca.SX, p: ca.SX, h: float) -> ca.SX:
    f, rate = _rates(x, u, p)
    a = ca.vertcat(0, 0, rate)
    half, half_phi, full, f1, f2, f3 = _weights(rate, h)
    N0 = f + a * x
    xa = half * x + half_phi * N0
    Na = _rates(xa, u, p)[0] + a * xa
    xb = half * x + half_phi * Na
    Nb = _rates(xb, u, p)[0] + a * xb
    xc = half * xa + half_phi * (2 * Nb - N0)
    Nc = _rates(xc, u, p)[0] + a * xc
    return full * x + f1 * N0 + f2 * (Na + Nb) + f3 * Nc


def row_step(spacing: float, substeps: int) -> ca.Function:
    """Return (x (3,), u, ln p (9,)) → x one row later."""
    x, u, s = ca.SX.sym("x", 3), ca.SX.sym("u"), ca.SX.sym("s", 9)
    end, p = x, ca.exp(s)
    for _ in range(substeps):
        end = _substep(end, u, p, spacing / substeps)
    return ca.Function("row", [x, u, s], [end])
