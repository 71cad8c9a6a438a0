"""Vectors and 3×3 matrices over any scalar: numbers, arrays, exact polynomials, tape nodes.

Vectors are tuples of three scalars, matrices tuples of three rows. Constant 0 and ±1 are plain ``int`` and fold away:
a formula needs no operations for zero offsets and coordinate axes.
"""

from __future__ import annotations

from typing import Any

Scalar = Any
"""A number, an array, a polynomial or a tape node: whatever has +, − and ×."""
Vec = tuple[Scalar, Scalar, Scalar]
Mat = tuple[Vec, Vec, Vec]
ZERO: Vec = (0, 0, 0)
IDENTITY: Mat = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def times(a: Scalar, b: Scalar) -> Scalar:
    """Return a·b; a constant 0 or ±1 needs no multiplication.

    Only a plain ``int`` counts as a constant.

    Parameters
    ----------
    a, b
        Scalars.

    Returns
    -------
    Scalar
        The product; the int 0 where a factor is the int 0.
    """
    for x, y in ((a, b), (b, a)):
        if isinstance(x, int):
            if x == 0:
                return 0
            if x == 1:
                return y
            if x == -1:
                return -y
    return a * b


def plus(*terms: Scalar) -> Scalar:
    """Add the terms that are not a constant 0.

    Parameters
    ----------
    *terms
        Scalars of one kind, and ints.

    Returns
    -------
    Scalar
        The sum; the integer 0 where nothing is left to add.
    """
    left = [term for term in terms if not (isinstance(term, int) and term == 0)]
    if not left:
        return 0
    total = left[0]
    for term in left[1:]:
        total = total + term
    return total


def minus(a: Scalar) -> Scalar:
    """Return −a.

    Parameters
    ----------
    a
        Scalar.

    Returns
    -------
    Scalar
        The negative.
    """
    return times(-1, a)


def dot(a: Vec, b: Vec) -> Scalar:
    """Return a·b.

    Parameters
    ----------
    a, b
        Vectors, shape (3,).

    Returns
    -------
    Scalar
        The scalar product.
    """
    return plus(*(times(x, y) for x, y in zip(a, b, strict=True)))


def add(*vectors: Vec) -> Vec:
    """Add vectors, component by component.

    Parameters
    ----------
    *vectors
        At least one vector.

    Returns
    -------
    Vec
        The sum, with the integer 0 where all components are constant 0.
    """
    x, y, z = zip(*vectors, strict=True)
    return plus(*x), plus(*y), plus(*z)


def scale(s: Scalar, a: Vec) -> Vec:
    """Return s·a.

    Parameters
    ----------
    s
        Factor.
    a
        Vector, shape (3,).

    Returns
    -------
    Vec
        The multiple, shape (3,).
    """
    return times(s, a[0]), times(s, a[1]), times(s, a[2])


def cross(a: Vec, b: Vec) -> Vec:
    """Return a × b.

    Parameters
    ----------
    a, b
        Vectors, shape (3,).

    Returns
    -------
    Vec
        The vector product, shape (3,).
    """
    return (
        plus(times(a[1], b[2]), minus(times(a[2], b[1]))),
        plus(times(a[2], b[0]), minus(times(a[0], b[2]))),
        plus(times(a[0], b[1]), minus(times(a[1], b[0]))),
    )


def transpose(A: Mat) -> Mat:
    """Return Aᵀ.

    Parameters
    ----------
    A
        Matrix, shape (3, 3).

    Returns
    -------
    Mat
        The transpose, shape (3, 3).
    """
    return ((A[0][0], A[1][0], A[2][0]), (A[0][1], A[1][1], A[2][1]), (A[0][2], A[1][2], A[2][2]))


def apply(A: Mat, b: Vec) -> Vec:
    """Return A·b.

    Parameters
    ----------
    A
        Matrix, shape (3, 3).
    b
        Vector, shape (3,).

    Returns
    -------
    Vec
        The product, shape (3,).
    """
    return dot(A[0], b), dot(A[1], b), dot(A[2], b)


def product(A: Mat, B: Mat) -> Mat:
    """Return A·B.

    Parameters
    ----------
    A, B
        Matrices, shape (3, 3).

    Returns
    -------
    Mat
        The product, shape (3, 3).
    """
    columns = transpose(B)
    first, second, third = (apply(A, column) for column in columns)
    return transpose((first, second, third))


def turn(R: Mat, L: Mat) -> Mat:
    """Return R·L·Rᵀ for a symmetric L.

    Parameters
    ----------
    R
        Rotation, shape (3, 3).
    L
        Symmetric matrix in the rotated coordinates, shape (3, 3).

    Returns
    -------
    Mat
        The same symmetric matrix in the coordinates that R leads to, shape (3, 3).
    """
    A = product(R, L)
    xx, yy, zz = (dot(A[i], R[i]) for i in range(3))
    xy, xz, yz = dot(A[0], R[1]), dot(A[0], R[2]), dot(A[1], R[2])
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def add_matrices(A: Mat, B: Mat) -> Mat:
    """Return A + B.

    Parameters
    ----------
    A, B
        Matrices, shape (3, 3).

    Returns
    -------
    Mat
        The sum, shape (3, 3).
    """
    return add(A[0], B[0]), add(A[1], B[1]), add(A[2], B[2])
