"""The flat-buffer functions in plain Python; in the FMU they stand behind the stepper and the generated functions."""

# A text that is put together with generated functions and checked as a whole by the tests, hence:
# mypy: ignore-errors
# ruff: noqa: ANN001, ANN002, ANN201, B905, F821 # untyped numbers and lists of them; names from the generated part


def blocks(v):
    """Return the inputs, slopes, parameters and the state of the buffer.

    Parameters
    ----------
    v
        Flat buffer.

    Returns
    -------
    u, slope, p, x
        Lists of n_u inputs, n_u slopes per second, n_p parameters, n_x states.
    """
    return v[HF_U : HF_U + NU], v[HF_SLOPE : HF_SLOPE + NU], v[HF_P : HF_P + NP], v[HF_X : HF_X + NX]


def widened(v, x):
    """Return the states with their sensitivities.

    Parameters
    ----------
    v
        Flat buffer with the sensitivities.
    x
        States, n_x.

    Returns
    -------
    list
        n_x rows: a state and its n_c sensitivities.
    """
    return [[x[i], *v[HF_S + i * NC : HF_S + (i + 1) * NC]] for i in range(NX)]


def safely(function, v, *arguments):
    """Call a function on the buffer and return whether it worked; errors of arithmetic count as failure.

    Parameters
    ----------
    function
        Function that takes the buffer and returns whether it worked.
    v
        Flat buffer.
    arguments
        Its further arguments.

    Returns
    -------
    bool
        False also where a number left its range.
    """
    try:
        return function(v, *arguments)
    except (ArithmeticError, ValueError):
        return False


def put_outputs(v, t, X, u, p):
    """Write the outputs (and their sensitivities where X has columns) to the buffer.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t
        Time [s].
    X
        n_x rows: a state, with or without its sensitivities.
    u
        Inputs, n_u.
    p
        Parameters, n_p.
    """
    y = outputs(t, X, u, p) if len(X[0]) == 1 else outputs_tangent(t, X, u, p)
    for i, row in enumerate(y):
        v[HF_Y + i] = row[0]
        for c in range(len(row) - 1):
            v[HF_DY + i * NC + c] = row[1 + c]


def run(v, t, dt, f, X):
    """Advance X and write everything back, where it is finite.

    Parameters
    ----------
    v
        Flat buffer, which is changed where the new state is finite.
    t, dt
        Start and length of the step [s].
    f
        Right-hand side with as many columns as X has.
    X
        n_x rows: a state, with or without its sensitivities.

    Returns
    -------
    bool
        Whether the new state is finite.
    """
    u, slope, p, _ = blocks(v)
    X = advance(f, X, t, dt, u, slope, p, v[HF_H])
    if not finite(X):
        return False
    for i, row in enumerate(X):
        v[HF_X + i] = row[0]
        for c in range(len(row) - 1):
            v[HF_S + i * NC + c] = row[1 + c]
    put_outputs(v, t + dt, X, [a + dt * b for a, b in zip(u, slope)], p)
    return True


def plain_step(v, t, dt):
    """Advance the states.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t, dt
        Start and length of the step [s].

    Returns
    -------
    bool
        Whether the new state is finite.
    """
    return run(v, t, dt, evaluate, [[x] for x in blocks(v)[3]])


def tangent_step(v, t, dt):
    """Advance the states and their sensitivities.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t, dt
        Start and length of the step [s].

    Returns
    -------
    bool
        Whether the new state is finite.
    """
    return run(v, t, dt, evaluate_tangent, widened(v, blocks(v)[3]))


def plain_output(v, t):
    """Write the outputs.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t
        Time [s].

    Returns
    -------
    bool
        True.
    """
    u, _, p, x = blocks(v)
    put_outputs(v, t, [[value] for value in x], u, p)
    return True


def tangent_output(v, t):
    """Write the outputs and their sensitivities.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t
        Time [s].

    Returns
    -------
    bool
        True.
    """
    u, _, p, x = blocks(v)
    put_outputs(v, t, widened(v, x), u, p)
    return True


def hf_pivot(v, t):
    """Factor the mass matrix by Cholesky and return the first pivot that is not positive. See the C function.

    Parameters
    ----------
    v
        Flat buffer.
    t
        Time [s].

    Returns
    -------
    row, pivot
        Number of the row and its pivot; -1 and 0.0 where all are positive.
    """
    u, _, p, x = blocks(v)
    rows = mass_of(t, x, u, p)
    n = math.isqrt(len(rows))
    M = [rows[n * i : n * (i + 1)] for i in range(n)]
    for j in range(n):
        M[j][j] -= sum(M[j][k] ** 2 for k in range(j))
        if not M[j][j] > 0.0:
            return j, M[j][j]
        M[j][j] = math.sqrt(M[j][j])
        for i in range(j + 1, n):
            M[i][j] = (M[i][j] - sum(M[i][k] * M[j][k] for k in range(j))) / M[j][j]
    return -1, 0.0


def hf_step(v, t, dt):
    """See ``hf_step`` in flat.c.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t, dt
        Start and length of the step [s].

    Returns
    -------
    bool
        Whether it worked.
    """
    return safely(plain_step, v, t, dt)


def hf_output(v, t):
    """See ``hf_output`` in flat.c.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t
        Time [s].

    Returns
    -------
    bool
        Whether it worked.
    """
    return safely(plain_output, v, t)


def hf_step_tangent(v, t, dt):
    """See ``hf_step_tangent`` in flat.c.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t, dt
        Start and length of the step [s].

    Returns
    -------
    bool
        Whether it worked.
    """
    return safely(tangent_step, v, t, dt)


def hf_output_tangent(v, t):
    """See ``hf_output_tangent`` in flat.c.

    Parameters
    ----------
    v
        Flat buffer, which is changed.
    t
        Time [s].

    Returns
    -------
    bool
        Whether it worked.
    """
    return safely(tangent_output, v, t)
