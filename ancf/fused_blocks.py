"""Vectors (3,) and blocks (3, 3), row by row, as tuples of numbers: the words of the fused kernel.

Their entries are registers (lanes.py); as tuples they need no memory. `K` is a lane array, `at` the row of
the first entry. Every function is inlined.
"""

from __future__ import annotations

from typing import Any

from numba import njit

# Called from compiled code only: no wrappers, which take longer to compile than the functions.
_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
compiled: Any = njit(**_OPTIONS)
inlined: Any = njit(**_OPTIONS, forceinline=True)


@inlined
def vector(K, at):
    """Read a vector."""
    return K[at], K[at + 1], K[at + 2]


@inlined
def put_vector(K, at, a):
    """Write a vector."""
    K[at], K[at + 1], K[at + 2] = a


@inlined
def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a, b):
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def scaled(c, a):
    """c a."""
    return c * a[0], c * a[1], c * a[2]


@inlined
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def plus_scaled(a, c, b):
    """a + c b."""
    return a[0] + c * b[0], a[1] + c * b[1], a[2] + c * b[2]


@inlined
def block(K, at):
    """Read a block."""
    return (K[at], K[at + 1], K[at + 2], K[at + 3], K[at + 4], K[at + 5], K[at + 6], K[at + 7], K[at + 8])


@inlined
def put_block(K, at, A):
    """Write a block."""
    K[at], K[at + 1], K[at + 2], K[at + 3], K[at + 4], K[at + 5], K[at + 6], K[at + 7], K[at + 8] = A


@inlined
def transposed(A):
    """A^T."""
    return A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]


@inlined
def block_scaled(c, A):
    """c A with a number c."""
    return c * A[0], c * A[1], c * A[2], c * A[3], c * A[4], c * A[5], c * A[6], c * A[7], c * A[8]


@inlined
def block_plus(A, B):
    """A + B."""
    return (
        A[0] + B[0],
        A[1] + B[1],
        A[2] + B[2],
        A[3] + B[3],
        A[4] + B[4],
        A[5] + B[5],
        A[6] + B[6],
        A[7] + B[7],
        A[8] + B[8],
    )


@inlined
def block_plus_scaled(A, c, B):
    """A + c B with a number c."""
    return (
        A[0] + c * B[0],
        A[1] + c * B[1],
        A[2] + c * B[2],
        A[3] + c * B[3],
        A[4] + c * B[4],
        A[5] + c * B[5],
        A[6] + c * B[6],
        A[7] + c * B[7],
        A[8] + c * B[8],
    )


@inlined
def plus_outer(A, a, b):
    """A + a b^T."""
    return (
        A[0] + a[0] * b[0],
        A[1] + a[0] * b[1],
        A[2] + a[0] * b[2],
        A[3] + a[1] * b[0],
        A[4] + a[1] * b[1],
        A[5] + a[1] * b[2],
        A[6] + a[2] * b[0],
        A[7] + a[2] * b[1],
        A[8] + a[2] * b[2],
    )


@inlined
def minus_product(A, B, C):
    """A - B C."""
    return (
        A[0] - B[0] * C[0] - B[1] * C[3] - B[2] * C[6],
        A[1] - B[0] * C[1] - B[1] * C[4] - B[2] * C[7],
        A[2] - B[0] * C[2] - B[1] * C[5] - B[2] * C[8],
        A[3] - B[3] * C[0] - B[4] * C[3] - B[5] * C[6],
        A[4] - B[3] * C[1] - B[4] * C[4] - B[5] * C[7],
        A[5] - B[3] * C[2] - B[4] * C[5] - B[5] * C[8],
        A[6] - B[6] * C[0] - B[7] * C[3] - B[8] * C[6],
        A[7] - B[6] * C[1] - B[7] * C[4] - B[8] * C[7],
        A[8] - B[6] * C[2] - B[7] * C[5] - B[8] * C[8],
    )


@inlined
def product(B, C):
    """B C."""
    return (
        B[0] * C[0] + B[1] * C[3] + B[2] * C[6],
        B[0] * C[1] + B[1] * C[4] + B[2] * C[7],
        B[0] * C[2] + B[1] * C[5] + B[2] * C[8],
        B[3] * C[0] + B[4] * C[3] + B[5] * C[6],
        B[3] * C[1] + B[4] * C[4] + B[5] * C[7],
        B[3] * C[2] + B[4] * C[5] + B[5] * C[8],
        B[6] * C[0] + B[7] * C[3] + B[8] * C[6],
        B[6] * C[1] + B[7] * C[4] + B[8] * C[7],
        B[6] * C[2] + B[7] * C[5] + B[8] * C[8],
    )


@inlined
def times_vector(A, b):
    """A b."""
    return (
        A[0] * b[0] + A[1] * b[1] + A[2] * b[2],
        A[3] * b[0] + A[4] * b[1] + A[5] * b[2],
        A[6] * b[0] + A[7] * b[1] + A[8] * b[2],
    )


@inlined
def minus_times_vector(a, B, c):
    """a - B c."""
    return (
        a[0] - B[0] * c[0] - B[1] * c[1] - B[2] * c[2],
        a[1] - B[3] * c[0] - B[4] * c[1] - B[5] * c[2],
        a[2] - B[6] * c[0] - B[7] * c[1] - B[8] * c[2],
    )


@inlined
def inverse(A):
    """A^-1 by cofactors, not finite where A is singular, and det A."""
    c0 = A[4] * A[8] - A[5] * A[7]
    c1 = A[5] * A[6] - A[3] * A[8]
    c2 = A[3] * A[7] - A[4] * A[6]
    determinant = A[0] * c0 + A[1] * c1 + A[2] * c2
    d = 1.0 / determinant
    inverse = (
        d * c0,
        d * (A[2] * A[7] - A[1] * A[8]),
        d * (A[1] * A[5] - A[2] * A[4]),
        d * c1,
        d * (A[0] * A[8] - A[2] * A[6]),
        d * (A[2] * A[3] - A[0] * A[5]),
        d * c2,
        d * (A[1] * A[6] - A[0] * A[7]),
        d * (A[0] * A[4] - A[1] * A[3]),
    )
    return inverse, determinant
