"""Linear solution of the solid reference: block-tridiagonal LU, and PARDISO where it is installed.

The tangent of a bent rod is indefinite along Newton and unsymmetric under a couple: no Cholesky, no CG.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs
from scipy.sparse import csr_array, csr_matrix

Array = NDArray[np.float64]
SolverName = Literal["block", "pardiso", "auto"]

getrf, getrs = get_lapack_funcs(("getrf", "getrs"), dtype=np.float64)

REAL_UNSYMMETRIC = 11  # PARDISO's matrix type


class LinearSolver(Protocol):
    """Solver of one sequence of systems with a common pattern."""

    def solve(self, K: csr_array, right: Array) -> Array:
        """Solve K x = right (n,); raises `numpy.linalg.LinAlgError` when K is singular."""
        ...


def linear_solver(name: SolverName, starts: list[int]) -> LinearSolver:
    """Solver by name; "auto" takes PARDISO when pypardiso is installed, else the block solver.

    Raises
    ------
    ValueError
        For an unknown name, and for "pardiso" where pypardiso is not installed.
    """
    installed = find_spec("pypardiso") is not None
    if name == "pardiso" and not installed:
        raise ValueError(
            'linear_solver is "pardiso", but pypardiso is not installed. '
            'Install it (it brings Intel MKL, some hundred MB), or take "block" or "auto".'
        )
    if name == "block" or (name == "auto" and not installed):
        return BlockSolver(starts)
    if name in ("pardiso", "auto"):
        return PardisoSolver()
    raise ValueError(f'linear_solver is "{name}"; "block", "pardiso" and "auto" are known.')


class BlockSolver:
    """Block-tridiagonal LU with the blocks of `starts`."""

    def __init__(self, starts: list[int]) -> None:
        self.starts = starts

    def solve(self, K: csr_array, right: Array) -> Array:
        """Solve K x = right (n,)."""
        return solve_block_tridiagonal(K, right, self.starts)


class PardisoSolver:
    """PARDISO of Intel MKL: the pattern is analysed once, every system is factorised anew."""

    def __init__(self) -> None:
        self._pardiso = import_module("pypardiso").PyPardisoSolver(mtype=REAL_UNSYMMETRIC)
        self._error: type[Exception] = import_module("pypardiso.pardiso_wrapper").PyPardisoError
        self._analysed = False

    def solve(self, K: csr_array, right: Array) -> Array:
        """Solve K x = right (n,)."""
        matrix = csr_matrix(K)  # pypardiso knows no sparse arrays
        b = np.asfortranarray(right[:, None])
        x = b
        try:
            # `PyPardisoSolver.solve` would repeat the analysis for every matrix.
            for phase in (22, 33) if self._analysed else (11, 22, 33):
                self._pardiso.set_phase(phase)
                x = self._pardiso._call_pardiso(matrix, b)
        except self._error as error:
            raise np.linalg.LinAlgError(str(error)) from error
        self._analysed = True
        return np.asarray(x).ravel()


def solve_block_tridiagonal(K: csr_array, right: Array, starts: list[int]) -> Array:
    """Solve K x = right by dense LU of the blocks between `starts`, pivoting inside each block.

    Unsymmetric and indefinite K are allowed: the tangent of a bent rod is indefinite along Newton.
    Cost O(n b^2) for blocks of size b.

    Raises
    ------
    numpy.linalg.LinAlgError
        When a pivot block is singular.
    """
    b = right.astype(float)
    shared, y, Y = np.zeros(0, int), np.zeros(0), np.zeros((0, 0))
    kept = []
    for block, (start, stop) in enumerate(pairwise(starts)):
        strip, first = _dense_rows(K, start, stop)
        pivot, upper = strip[:, start - first : stop - first], strip[:, stop - first :]
        if block:
            # Only the plane between two slices couples them: skip the empty rows and columns.
            lower = strip[:, : start - first]
            rows = np.flatnonzero(lower.any(axis=1))
            pivot[np.ix_(rows, shared - start)] -= lower[rows] @ Y[len(Y) - lower.shape[1] :]
            b[start + rows] -= lower[rows] @ y[len(y) - lower.shape[1] :]
        lu, piv, info = getrf(pivot)
        if info != 0:
            raise np.linalg.LinAlgError(f"pivot block {block} of {len(starts) - 1} is singular")
        columns = np.flatnonzero(upper.any(axis=0))
        y = getrs(lu, piv, b[start:stop])[0]
        Y = getrs(lu, piv, upper[:, columns])[0]
        shared = stop + columns
        kept.append((start, stop, shared, y, Y))
    x = np.empty_like(b)
    for start, stop, shared, y, Y in reversed(kept):
        x[start:stop] = y - Y @ x[shared]
    return x


def _dense_rows(K: csr_array, start: int, stop: int) -> tuple[Array, int]:
    """Rows `start:stop` of K as a dense matrix over their occupied columns, and the first of these."""
    entries = slice(K.indptr[start], K.indptr[stop])
    columns = K.indices[entries]
    rows = np.repeat(np.arange(stop - start), np.diff(K.indptr[start : stop + 1]))
    first = min(int(columns.min()), start)
    strip = np.zeros((stop - start, max(int(columns.max()) + 1, stop) - first), order="F")
    strip[rows, columns - first] = K.data[entries]
    return strip, first
