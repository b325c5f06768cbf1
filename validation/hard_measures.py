"""What is measured on one hard case: Newton's order, conditioning, floor, det F, and how near to its answer.

Symbols
-------
r_k     dimensionless residual before iteration k, in units of E I/L^2 and E I/L
p       observed order, log(r_{k+1}/r_k)/log(r_k/r_{k-1}); 2 for Newton's method near the answer
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, onenormest, splu

from ancf.failure import smallest_determinant
from ancf.newton import Iteration
from ancf.solution import Solution

Floats = NDArray[np.float64]

EPS = float(np.finfo(float).eps)
# Residuals that tell an order: small enough to be near the answer, large enough to be above rounding.
NEAR, ABOVE_FLOOR = 1e-1, 100.0
DENSE = 800  # unknowns up to which the inverse is formed: exact, and a quarter of a second at most


def last_run(history: Sequence[Iteration]) -> list[Iteration]:
    """The Newton run that ended the search: the entries after the last that is numbered 1."""
    begin = max((i for i, entry in enumerate(history) if entry.iteration == 1), default=0)
    return list(history[begin:])


def newton_order(residuals: Sequence[float], floor: float) -> float | None:
    """Lowest observed order over all threes of residuals in a row between 100 floors and 0.1; None without one.

    Parameters
    ----------
    residuals : of one Newton run, in order, the final one included
    floor : residual that rounding leaves
    """
    found = []
    for a, b, c in zip(residuals[:-2], residuals[1:-1], residuals[2:], strict=True):
        if all(ABOVE_FLOOR * floor <= r <= NEAR for r in (a, b, c)) and b < a:
            found.append(math.log(c / b) / math.log(b / a))
    return min(found, default=None)


def observed_order(solution: Solution) -> float | None:
    """`newton_order` of the last run of a solution."""
    run = last_run(solution.history)
    return newton_order([*(entry.residual for entry in run), solution.residual], solution.residual_floor)


def dimensionless_tangent(solution: Solution) -> sparse.csc_array:
    """Tangent on the free unknowns, scaled as in ancf/linear_system.py: unknowns by L^(1-k), energies by E I/L.

    The columns of B_2 mix only unknowns of one unit, so a scale of the model becomes one of the free unknowns.
    """
    model = solution.model
    basis = abs(model.boundary_matrix())
    owner = np.asarray(basis.argmax(axis=0)).ravel()
    rows = sparse.dia_array((1.0 / model.force_unit[owner][None], [0]), shape=(len(owner),) * 2)
    columns = sparse.dia_array((model.unit[owner][None], [0]), shape=(len(owner),) * 2)
    return sparse.csc_array(rows @ solution.tangent() @ columns)


def condition_number(matrix: sparse.csc_array) -> float:
    """|K|_1 |K^-1|_1: exact for small matrices, Higham and Tisseur's estimate (a lower bound) for large ones."""
    size = float(abs(matrix).sum(axis=0).max())
    if matrix.shape[0] <= DENSE:
        try:
            return size * float(np.linalg.norm(np.linalg.inv(matrix.toarray()), 1))
        except np.linalg.LinAlgError:
            return math.inf
    lu = splu(matrix)
    inverse = LinearOperator(
        matrix.shape,
        matvec=lu.solve,
        rmatvec=lambda b: lu.solve(b, trans="T"),
        matmat=lu.solve,
        rmatmat=lambda b: lu.solve(b, trans="T"),
        dtype=np.dtype(float),
    )  # type: ignore[call-arg]
    return size * float(onenormest(inverse, t=1))  # t = 1 draws no random numbers


def load_amplification(solution: Solution) -> float:
    """Largest |d position / d ln(load factor)| over L: by how much a relative change of the load is magnified.

    Stiffness and radius enter through the same ratio load/(E I), so a rounding of any of them moves the rod by
    eps times a small multiple of this; at a bifurcation it is unbounded.
    """
    model = solution.model
    forces, flat = model.residual_and_tangent(solution.q, solution.load_factor)
    dq = model.system.solve(model.system.factorise(flat), solution.load_factor * forces.Q_ext)
    worst = 0.0
    for rod in model.rods:
        worst = max(worst, float(np.linalg.norm(rod.nodal(dq)[:, 0], axis=-1).max()) / rod.rod.length)
    return worst


def smallest_volume_ratio(solution: Solution) -> float:
    """Smallest det F over the axial points."""
    return smallest_determinant(solution.model, solution.q)[2]
