"""Banded matrices: assembly from dense blocks, LU with pivoting, Cholesky; cost linear in the elements.

A rod couples only unknowns of one element, so with the nodes in order the tangent has a fixed half bandwidth
and LAPACK's band LU (dgbtrf) solves it in O(n b^2).

Storage (LAPACK): entry (i, j) at ``ab[2 b + i - j, j]``; the first b rows are room for pivoting fill. It is
kept flat, column after column, as LAPACK wants it: nothing is copied or transposed on the way.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_gbtrf, _gbtrs, _pbtrf, _pbtrs = get_lapack_funcs(("gbtrf", "gbtrs", "pbtrf", "pbtrs"), dtype=np.float64)


@dataclass(frozen=True)
class BandPattern:
    """Size `n` and half bandwidth `b` of a square band matrix."""

    n: int
    b: int

    def slots(self, rows: Indices, columns: Indices) -> Indices:
        """Flat storage positions of the entries (rows, columns), broadcast against each other."""
        return columns * (3 * self.b + 1) + 2 * self.b + rows - columns

    def block_slots(self, dofs: Indices) -> Indices:
        """Flat storage positions (m, nd, nd) of dense blocks on the unknowns dofs (m, nd)."""
        return self.slots(dofs[:, :, None], dofs[:, None, :])

    def banded(self, flat: Floats) -> Floats:
        """The flat storage as LAPACK's ``ab`` (3 b + 1, n); a view."""
        return flat.reshape(self.n, 3 * self.b + 1).T

    def blocks(self, flat: Floats, first: int, step: int, size: int, count: int) -> Floats:
        """View (count, size, size) of the diagonal blocks at first, first + step, ... in the flat storage.

        Where step < size, neighbouring blocks share entries.
        """
        column, item = 3 * self.b + 1, flat.itemsize
        strides = (step * column * item, item, (column - 1) * item)
        begin = (first * column + 2 * self.b) * item
        return np.ndarray((count, size, size), flat.dtype, flat, begin, strides)

    def of_rows(self, values: Floats, outside: float = 0.0) -> Floats:
        """View (n, 3 b + 1), read only, of values (n,) of the rows by entries of the flat storage."""
        padded = np.full(self.n + 3 * self.b, outside)
        padded[2 * self.b : 2 * self.b + self.n] = values
        return np.ndarray((self.n, 3 * self.b + 1), padded.dtype, padded, 0, 2 * padded.strides)

    @property
    def entries(self) -> int:
        """Length of the flat storage."""
        return (3 * self.b + 1) * self.n


class SingularMatrixError(ArithmeticError):
    """The factorisation met an exactly zero pivot."""


class Factors(Protocol):
    """Factors of a tangent, band or sparse."""

    def solve(self, right: Floats, transposed: bool = False) -> Floats:
        """Solve for one right side (n,) or several (n, k), or with the transposed matrix."""
        ...

    @property
    def determinant_sign(self) -> int:
        """Sign of the determinant; it flips when a simple eigenvalue passes through zero."""
        ...

    @property
    def log_determinant(self) -> float:
        """Logarithm of the size of the determinant."""
        ...


@dataclass(frozen=True)
class BandLU:
    """LU factors of a band matrix."""

    pattern: BandPattern
    lu: Floats
    pivots: NDArray[np.int32]

    def solve(self, right: Floats, transposed: bool = False) -> Floats:
        """See `Factors`."""
        b = self.pattern.b
        x, info = _gbtrs(self.lu, b, b, right, self.pivots, trans=int(transposed))
        if info != 0:  # only an illegal argument: a bug of ours
            raise RuntimeError(f"dgbtrs: info = {info}")
        return x

    @property
    def log_determinant(self) -> float:
        """Logarithm of the size of the determinant."""
        return float(np.sum(np.log(np.abs(self.lu[2 * self.pattern.b]))))

    @property
    def determinant_sign(self) -> int:
        """Sign of the determinant; it flips when a simple eigenvalue passes through zero."""
        swaps = np.count_nonzero(self.pivots != np.arange(self.pattern.n))
        negative = np.count_nonzero(self.lu[2 * self.pattern.b] < 0.0)
        return 1 if (swaps + negative) % 2 == 0 else -1


@dataclass(frozen=True)
class BandCholesky:
    """Cholesky factor of a symmetric positive definite band matrix, the lower triangle (b + 1, n)."""

    lower: Floats

    def solve(self, right: Floats, transposed: bool = False) -> Floats:
        """See `Factors`."""
        x, info = _pbtrs(self.lower, right, lower=1)
        if info != 0:  # only an illegal argument: a bug of ours
            raise RuntimeError(f"dpbtrs: info = {info}")
        return x

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant."""
        return 2.0 * float(np.sum(np.log(self.lower[0])))

    @property
    def determinant_sign(self) -> int:
        """1: all eigenvalues are positive."""
        return 1


def cholesky(pattern: BandPattern, flat: Floats) -> BandCholesky | None:
    """Cholesky factor of the symmetric matrix in flat band storage; None if it is not positive definite."""
    lower, info = _pbtrf(pattern.banded(flat)[2 * pattern.b :], lower=1)
    return BandCholesky(lower) if info == 0 else None


def factorise(pattern: BandPattern, flat: Floats) -> BandLU:
    """LU factors of the matrix in flat band storage, which they overwrite.

    Raises `SingularMatrixError` for a zero pivot.
    """
    lu, pivots, info = _gbtrf(pattern.banded(flat), pattern.b, pattern.b, overwrite_ab=1)
    if info > 0:
        raise SingularMatrixError(f"zero pivot at unknown {info - 1}")
    return BandLU(pattern, lu, pivots)


def is_positive_definite(pattern: BandPattern, flat: Floats) -> bool:
    """Whether a symmetric matrix in flat band storage has positive eigenvalues only (Cholesky succeeds)."""
    return cholesky(pattern, flat) is not None


@contextmanager
def named_failure() -> Iterator[None]:
    """Turn every way in which LAPACK, SuperLU and ARPACK give up into `SingularMatrixError`."""
    try:
        yield
    except (np.linalg.LinAlgError, RuntimeError, ValueError) as error:
        raise SingularMatrixError(str(error)) from error


@named_failure()
def negative_eigenvalues(pattern: BandPattern, flat: Floats) -> int:
    """Number of negative eigenvalues of a symmetric matrix in flat band storage; cost O(n b^2).

    The inertia of a block tridiagonal matrix is the sum of that of its pivots
    P_i = A_ii - A_i,i-1 P_i-1^-1 A_i-1,i (Haynsworth 1968, Linear Algebra Appl. 1, 73-81).

    Raises `SingularMatrixError` where a block is singular.
    """
    n, b = pattern.n, max(pattern.b, 1)
    # Lower triangle by rows of blocks: the matrix is block tridiagonal in blocks of the half bandwidth.
    rows = np.arange(b)
    count, pivot = 0, np.empty((0, 0))
    for start in range(0, n, b):
        here = np.arange(start, min(start + b, n))
        block = _entries(pattern, flat, here, here)
        if start:
            before = start - b + rows
            coupling = _entries(pattern, flat, here, before)
            block = block - coupling @ np.linalg.solve(pivot, coupling.T)
        pivot = 0.5 * (block + block.T)
        count += int(np.count_nonzero(np.linalg.eigvalsh(pivot) < 0.0))
    return count


def _entries(pattern: BandPattern, flat: Floats, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Floats:
    """Dense block of a band matrix; zero outside the band."""
    near = np.abs(rows[:, None] - columns) <= pattern.b
    slots = pattern.slots(rows[:, None], columns)
    return np.where(near, flat[np.where(near, slots, 0)], 0.0)
