r"""Eigenvalues of the tangent: how many are negative, which are lowest, and how the rod moves in them.

Unknowns of different kinds are compared as a mass matrix would do it: positions as they are, slopes along the
axis by the element's length, slopes across it by the radius of gyration. With D that diagonal,

    S = D B^T K B D / (E I/L^3)

on the free unknowns is dimensionless; its lowest eigenvalues belong to bending and twisting of the whole
rod, not to strains of a section.

Constraints leave only the motions with C phi = 0, C their linearised conditions: across these rows S is
looked at, as it is across held motions.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eig, eig_banded, eigh
from scipy.sparse.linalg import LinearOperator, eigs, eigsh, splu

from ancf.band import named_failure

if TYPE_CHECKING:
    from ancf.model import Model

Floats = NDArray[np.float64]

EXTRA = 6  # eigenvalues that Lanczos finds beyond those asked for
REAL = 1e-9  # relative imaginary part that rounding leaves of a real eigenvalue
TINY = 60  # unknowns up to which dense matrices serve where they are not symmetric or motions are held
SMALL = 600  # unknowns up to which direct solvers are faster than Lanczos


def _inverse_across(S: sparse.csr_array, basis: Floats) -> LinearOperator:
    """x -> S^-1 x across the columns of a basis (n, h), along which S may be singular: bordered by them."""
    n, held = basis.shape
    bordered: Any = sparse.block_array([[S, basis], [basis.T, None]]) if held else S
    lu = splu(bordered.tocsc())

    def solve(x: Floats) -> Floats:
        return lu.solve(np.append(x.ravel(), np.zeros(held)))[:n]

    operator: Any = LinearOperator  # its signature is that of a class it makes way for
    return operator((n, n), matvec=solve, dtype=float)


def _lower_band(S: sparse.csr_array) -> Floats:
    """Lower band (b + 1, n) of a symmetric matrix, as LAPACK has it.

    Band solvers hardly use threads: dense ones, on a busy machine, wait for theirs a hundred times longer.
    """
    entries: Any = sparse.tril(S, format="coo")
    rows, columns, values = entries.row, entries.col, entries.data
    band = np.zeros((int(np.max(rows - columns)) + 1, np.max(columns) + 1))
    band[rows - columns, columns] = values
    return band


class Spectrum:
    """Scaled eigenproblem of one model."""

    def __init__(self, model: Model) -> None:
        self.model = model
        first = model.rods[0]
        self._stiffness = first.bending_stiffness / first.rod.length**3
        parts = []
        for rod in model.rods:
            h, radius = float(np.mean(rod.mesh.h)), rod.rod.section.radius_of_gyration
            scale = [h ** -order[0] * radius ** -(order[1] + order[2]) for order in rod.element.vectors]
            parts.append(np.tile(np.repeat(scale, 3), len(rod.q0)))
        B: Any = model.boundary_matrix()
        # The multipliers of constraints are free, and the last; they are no motion.
        self._B: Any = B[:, : B.shape[1] - (model.n - model.motions)]
        parts.append(np.ones(model.n - model.motions))
        weight = np.abs(self._B)
        # A support mixes components of one vector or of vectors of one kind.
        self._D = (weight.T @ np.concatenate(parts)) / np.asarray(weight.sum(axis=0)).ravel()

    def matrix(self, q: Floats, load_factor: float) -> sparse.csr_array:
        """S (free, free); symmetric if the loads have a potential."""
        return self._matrix_and_rows(q, load_factor)[0]

    def _matrix_and_rows(self, q: Floats, load_factor: float) -> tuple[sparse.csr_array, Floats]:
        """S, and an orthonormal basis (free, conditions) of the rows of C, what constraints do not leave."""
        D: Any = sparse.diags_array(self._D / np.sqrt(self._stiffness))
        K: Any = self.model.supported_tangent(q, load_factor)
        n = self.size
        S = sparse.csr_array(D @ K[:n, :n] @ D)
        if K.shape[0] == n:
            return S, np.empty((n, 0))
        C_T = (D @ K[:n, n:]).toarray()
        return S, np.linalg.qr(C_T[:, np.any(C_T != 0.0, axis=0)])[0]  # a slack tendon is no condition

    def with_multipliers(self, q: Floats, load_factor: float, modes: Floats) -> Floats:
        """Left modes (k, n) [SI] with the changes of the multipliers that go with them.

        K^T dq + C^T dlambda vanishes for one of eigenvalue zero, in the least squares that it is not.
        """
        if self.model.constraints is None:
            return modes
        K: Any = self.model.supported_tangent(q, load_factor)
        n, full = self.size, modes.copy()
        scale = self._D[:, None]
        right = -(K[:n, :n].T @ (self._B.T @ modes.T)) * scale
        full[:, self.model.motions :] = np.linalg.lstsq(scale * K[:n, n:].toarray(), right, rcond=None)[0].T
        return full

    def motion(self, phi: Floats) -> Floats:
        """Coordinates (n,) or (n, k) [SI] of modes phi (free,) or (free, k)."""
        column = (slice(None),) + (None,) * (phi.ndim - 1)
        return self._B @ (self._D[column] * phi)

    @property
    def size(self) -> int:
        """Number of eigenvalues."""
        return len(self._D)

    @named_failure()
    def lowest(
        self, q: Floats, load_factor: float, count: int, held: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Lowest eigenvalues (k,), rising, and modes (n, k) [SI], across motions held (h, n) [SI].

        For scenes whose loads have a potential. Raises `SingularMatrixError` where they cannot be found.
        """
        S, basis = self._matrix_and_rows(q, load_factor)
        S = 0.5 * (S + S.T)
        n = self.size
        if held is not None:
            basis = np.linalg.qr(np.column_stack([basis, (self._B.T @ held.T) / self._D[:, None]]))[0]
        count = min(count, n - basis.shape[1] if self.model.constraints else n)
        if n <= SMALL and not basis.size:
            f, phi = eig_banded(_lower_band(S), lower=True, select="i", select_range=(0, count - 1))
        elif n <= TINY:
            # Held motions go to the top of the spectrum.
            across = np.eye(n) - basis @ basis.T
            dense = across @ S.toarray() @ across + np.abs(S).sum() * (basis @ basis.T)
            f, phi = eigh(dense, subset_by_index=(0, count - 1))
        else:
            # Around zero: all that matter here, a few negative ones and the softest positive ones.
            lanczos: Any = eigsh  # returns pairs here, which its signature does not say
            # The lowest of all are among them if all negative ones are.
            below = 0 if basis.size else self._negative(q, load_factor)
            near, most = _inverse_across(S, basis), min(below + count + EXTRA, n - 1)
            values, modes = lanczos(S, k=most, sigma=0.0, OPinv=near, v0=near @ np.ones(n))
            order = np.argsort(values)[:count]
            f, phi = values[order], modes[:, order]
        return f, self.motion(phi)

    def _negative(self, q: Floats, load_factor: float) -> int:
        _, flat = self.model.residual_and_tangent(q, load_factor)
        return self.model.system.negative_eigenvalues(flat)

    def negative_across(self, q: Floats, load_factor: float, held: Floats) -> int:
        """Number of negative eigenvalues across held motions (h, n), up to `EXTRA`."""
        return int(np.count_nonzero(self.lowest(q, load_factor, EXTRA, held)[0] < 0.0))

    @named_failure()
    def nearest_zero(self, q: Floats, load_factor: float, left: bool = False) -> tuple[float, Floats]:
        """Real eigenvalue of smallest magnitude and its mode, or left mode, (n,) [SI]; of any scene."""
        (S, rows), n = self._matrix_and_rows(q, load_factor), self.size
        S = sparse.csr_array(S.T) if left else S
        if n <= TINY:
            across = np.eye(n) - rows @ rows.T
            # What constraints do not leave goes to the top of the spectrum.
            dense = across @ S.toarray() @ across + abs(S).sum() * (rows @ rows.T)
            solver, arguments = eig, (dense,)
        else:
            near = _inverse_across(S, rows) if rows.size else None
            solver = partial(eigs, k=min(EXTRA, n - 2), sigma=0.0, v0=np.ones(n), OPinv=near)
            arguments = (S,)
        pairs: Any = solver(*arguments)
        values, modes = pairs
        real = np.abs(np.imag(values)) <= REAL * np.abs(values)
        if not real.any():
            return np.inf, np.zeros(len(q))
        best = int(np.argmin(np.where(real, np.abs(values), np.inf)))
        return float(np.real(values[best])), self.motion(np.real(modes[:, best]))
