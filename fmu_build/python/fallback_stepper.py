"""The kernel's stepper in plain Python, for platforms that the FMU carries no binary for.

Exponential Runge-Kutta of order four (Cox and Matthews 2002, eqs. 26-29) with diagonal linear part, as the C kernel's
`stepper.h` has it: row i of X is state i followed by its sensitivities. Generated functions stand behind this text in
the FMU: ``rates``, ``coupling``, ``evaluate``, ``outputs``, ``evaluate_tangent``, ``outputs_tangent``, and the layout.
"""

# A text that is put together with generated functions and checked as a whole by the tests, hence:
# mypy: ignore-errors
# ruff: noqa: ANN001, ANN201, ANN202, B905, F821, PLR0913, PLR0917 # untyped numbers and lists of them; names from the generated part

import math

MAX_SUBSTEPS = 64
COEFFICIENTS = [1.0 / math.factorial(k + 3) for k in range(14)]


def sign(x):
    """Return -1.0, 0.0 or 1.0.

    Parameters
    ----------
    x
        Number.

    Returns
    -------
    float
        The sign; 0.0 for 0.
    """
    return math.copysign(1.0, x) if x else 0.0


def step(x):
    """Return 1.0 where x > 0, else 0.0.

    Parameters
    ----------
    x
        Number.

    Returns
    -------
    float
        The unit step.
    """
    return 1.0 if x > 0.0 else 0.0


def phi(L):
    """Return exp(L), phi_1, phi_2, phi_3 at L <= 0.

    Parameters
    ----------
    L
        Relaxation rate times step, negative: L <= 0.

    Returns
    -------
    exp, phi_1, phi_2, phi_3
        phi_1 = (exp(L) - 1)/L, phi_k = (phi_(k-1) - 1/(k-1)!)/L; a power series near 0.
    """
    if L >= -1.0:
        p3 = 0.0
        for c in reversed(COEFFICIENTS):
            p3 = c + L * p3
        p2 = 0.5 + L * p3
        p1 = 1.0 + L * p2
        return 1.0 + L * p1, p1, p2, p3
    e = math.exp(max(L, -700.0))
    p1 = (e - 1.0) / L
    p2 = (p1 - 1.0) / L
    return e, p1, p2, (p2 - 0.5) / L


def weigh(a, h):
    """Return the weights half, half_phi, full, f1, f2, f3 of one state with relaxation rate ``a``.

    Parameters
    ----------
    a
        Relaxation rate of the state [1/s], at least 0.
    h
        Length of the sub-step [s].

    Returns
    -------
    half, half_phi, full, f1, f2, f3
        Two decays (half and full sub-step) and four weights [s].
    """
    e, z1, z2, z3 = phi(-0.5 * h * a)
    p1, p2, p3 = 0.5 * (e + 1.0) * z1, 0.25 * (z1 * z1 + 2.0 * z2), 0.125 * (z1 * z2 + 2.0 * z3 + z2)
    return e, 0.5 * h * z1, e * e, h * (p1 - 3.0 * p2 + 4.0 * p3), h * (2.0 * p2 - 4.0 * p3), h * (4.0 * p3 - p2)


def relax(t, X, u, p, F, h):
    """Return the larger of the relaxation rates at the start of a sub-step and at its predicted end.

    Parameters
    ----------
    t
        Time [s].
    X
        n_x rows: a state and its sensitivities, if any.
    u
        Inputs, n_u.
    p
        Parameters, n_p.
    F
        Right-hand side at X, as X is shaped.
    h
        Length of the sub-step [s].

    Returns
    -------
    list
        Relaxation rate of each state [1/s], n_x.
    """
    x = [row[0] for row in X]
    ahead = [x[i] + h * F[i][0] for i in range(len(x))]
    return [max(a, b) for a, b in zip(rates(t, x, u, p), rates(t + h, ahead, u, p))]


def substep(f, X, t, u, slope, p, h):
    """Return X one sub-step later.

    Parameters
    ----------
    f
        Right-hand side with as many columns as X has.
    X
        n_x rows: a state and its sensitivities, if any.
    t
        Time at the start [s].
    u, slope
        Inputs at the start, n_u, and their rates of change per second.
    p
        Parameters, n_p.
    h
        Length of the sub-step [s].

    Returns
    -------
    list
        Rows as those of X.
    """
    middle = [a + 0.5 * h * b for a, b in zip(u, slope)]
    last = [a + h * b for a, b in zip(u, slope)]
    F = f(t, X, u, p)
    a = relax(t, X, u, p, F, h)
    w = [weigh(rate, h) for rate in a]

    def rest(F, X):
        return [[y + rate * x for y, x in zip(Fi, Xi)] for Fi, Xi, rate in zip(F, X, a)]

    def half(X, N):
        return [[wi[0] * x + wi[1] * n for x, n in zip(Xi, Ni)] for Xi, Ni, wi in zip(X, N, w)]

    N0 = rest(F, X)
    Xa = half(X, N0)
    Na = rest(f(t + 0.5 * h, Xa, middle, p), Xa)
    Xs = half(X, Na)
    Nb = rest(f(t + 0.5 * h, Xs, middle, p), Xs)
    Xc = half(Xa, [[2.0 * b - n for b, n in zip(Bi, Ni)] for Bi, Ni in zip(Nb, N0)])
    Nc = rest(f(t + h, Xc, last, p), Xc)
    return [
        [wi[2] * x + (wi[3] * n0 + wi[4] * (na + nb) + wi[5] * nc) for x, n0, na, nb, nc in zip(*rows)]
        for wi, rows in zip(w, zip(X, N0, Na, Nb, Nc))
    ]


def parts_of(t, x, u, p, h):
    """Return the number of sub-steps such that h times the root of the coupling is at most about 1.

    Parameters
    ----------
    t
        Time [s].
    x
        States, n_x.
    u
        Inputs, n_u.
    p
        Parameters, n_p.
    h
        Length of the inner step [s].

    Returns
    -------
    int
        From 1 to `MAX_SUBSTEPS`.
    """
    c = coupling(t, x, u, p)
    n = min(math.sqrt(c if 0.0 <= c < 1e30 else 0.0) * h + 0.5, MAX_SUBSTEPS)
    return max(round(n), 1)


def advance(f, X, t, dt, u, slope, p, h):
    """Return X after ``dt`` in equal inner steps no longer than ``h``, each cut as its coupling asks on the way.

    Parameters
    ----------
    f
        Right-hand side with as many columns as X has.
    X
        n_x rows: a state and its sensitivities, if any.
    t, dt
        Start and length of the step [s].
    u, slope
        Inputs at the start, n_u, and their rates of change per second.
    p
        Parameters, n_p.
    h
        Longest inner step [s].

    Returns
    -------
    list
        Rows as those of X.
    """
    steps = int(dt / h - 1e-6) + 1
    inner = dt / steps
    for k in range(steps):
        past = 0.0
        for s in range(MAX_SUBSTEPS):
            left, since = inner - past, k * inner + past
            now = [a + since * b for a, b in zip(u, slope)]
            sub = inner / parts_of(t + since, [row[0] for row in X], now, p, inner)
            last = left - sub < 1e-9 * inner or s == MAX_SUBSTEPS - 1
            X = substep(f, X, t + since, now, slope, p, left if last else sub)
            if last:
                break
            past += sub
    return X


def finite(X):
    """Return whether all states and sensitivities are finite.

    Parameters
    ----------
    X
        n_x rows: a state and its sensitivities, if any.

    Returns
    -------
    bool
        Whether states lie below 1e12 and sensitivities below 1e150 in magnitude.
    """
    return all(abs(row[0]) < 1e12 and all(abs(s) < 1e150 for s in row[1:]) for row in X)


def solve(M, h):
    """Return v of M v = h for a symmetric positive definite M, by Cholesky.

    Parameters
    ----------
    M
        Rows of the matrix, n by n.
    h
        Right-hand side, n.

    Returns
    -------
    list
        v, n.

    Raises
    ------
    ZeroDivisionError, ValueError
        Where M is not positive definite.
    """
    n = len(h)
    L = [[0.0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            rest = M[i][j] - sum(L[i][k] * L[j][k] for k in range(j))
            L[i][j] = math.sqrt(rest) if i == j else rest / L[j][j]
    y = []
    for i in range(n):
        y.append((h[i] - sum(L[i][k] * y[k] for k in range(i))) / L[i][i])
    for i in reversed(range(n)):
        y[i] = (y[i] - sum(L[k][i] * y[k] for k in range(i + 1, n))) / L[i][i]
    return y
