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
from scipy.sparse.linalg import SuperLU, splu

from ancf.failure import smallest_determinant
from ancf.newton import Iteration
from ancf.solution import Solution

Floats = NDArray[np.float64]

EPS = float(np.finfo(float).eps)
# Residuals that tell an order: small enough to be near the answer, large enough to be above rounding.
NEAR, ABOVE_FLOOR, STEP_ABOVE_FLOOR = 1e-1, 100.0, 10.0
DENSE = 800  # unknowns up to which the inverse is formed: exact, and a quarter of a second at most


def last_run(history: Sequence[Iteration]) -> list[Iteration]:
    """The Newton run that ended the search: the entries after the last that is numbered 1."""
    begin = max((i for i, entry in enumerate(history) if entry.iteration == 1), default=0)
    return list(history[begin:])


def newton_order(residuals: Sequence[float], floor: float) -> float | None:
    """Observed order of the last three residuals in a row between 100 floors and 0.1; None without them.

    Parameters
    ----------
    residuals : of one Newton run, in order, the final one included
    floor : residual that rounding leaves
    """
    return _last_order([(r, ABOVE_FLOOR * floor <= r <= NEAR) for r in residuals])


def step_order(run: Sequence[Iteration], floor: float) -> float | None:
    """Observed order of the last three steps below 0.1 with residuals above 10 floors; None without them.

    A step is the error of the iterate before it up to the square of that error, so steps tell the order as
    residuals do, and are not hidden behind A L^2/I on slender rods.
    """
    return _last_order([(h.step, h.step <= NEAR and h.residual >= STEP_ABOVE_FLOOR * floor) for h in run])


def _last_order(values: Sequence[tuple[float, bool]]) -> float | None:
    """Order of the last three falling values in a row that count."""
    found = None
    for threes in zip(values[:-2], values[1:-1], values[2:], strict=True):
        (a, b, c), counts = zip(*threes, strict=True)
        if all(counts) and a > b > c > 0.0:
            found = math.log(c / b) / math.log(b / a)
    return found


def observed_orders(solution: Solution) -> tuple[float | None, float | None]:
    """Orders of the last Newton run by residuals and by steps; None where it was too quick to tell.

    A run without three numbers in a row between its start and its floor was faster than its order can show;
    linear convergence would have left many.
    """
    run, floor = last_run(solution.history), solution.residual_floor
    residuals = [*(entry.residual for entry in run), solution.residual]
    return newton_order(residuals, floor), step_order(run, floor)


def dimensionless_tangent(solution: Solution) -> sparse.csc_array:
    """Tangent on the free unknowns, scaled as in ancf/linear_system.py: unknowns by L^(1-k), energies E I/L.

    The columns of B_2 mix only unknowns of one unit, so a scale of the model becomes one of theirs.
    """
    model = solution.model
    basis = abs(model.boundary_matrix()).tocsc()
    owner = np.array([basis.indices[basis.indptr[k]] for k in range(model.unknowns)])
    rows = sparse.diags_array(1.0 / model.force_unit[owner])
    columns = sparse.diags_array(model.unit[owner])
    return sparse.csc_array(rows @ solution.tangent() @ columns)


def condition_number(matrix: sparse.csc_array) -> float:
    """|K|_1 |K^-1|_1: exact for small matrices, Hager's estimate for large ones."""
    size = float(np.max(abs(matrix).sum(axis=0)))
    n = len(matrix.indptr) - 1
    if n <= DENSE:
        try:
            return size * float(np.linalg.norm(np.linalg.inv(matrix.toarray()), 1))
        except np.linalg.LinAlgError:
            return math.inf
    return size * _inverse_norm(splu(matrix), n)


def _inverse_norm(lu: SuperLU, n: int) -> float:
    """Lower bound of |K^-1|_1, exact as a rule: Hager, SIAM J. Sci. Stat. Comput. 5 (1984) 311."""
    x, norm = np.full(n, 1.0 / n), 0.0
    for _ in range(5):  # Hager: two as a rule
        y = lu.solve(x)
        norm = max(norm, float(np.abs(y).sum()))
        z = lu.solve(np.where(y < 0.0, -1.0, 1.0), trans="T")
        worst = int(np.argmax(np.abs(z)))
        if abs(z[worst]) <= z @ x:
            break
        x = np.zeros(n)
        x[worst] = 1.0
    return norm


def load_amplification(solution: Solution) -> float:
    """Largest |d position / d ln(load factor)| over L: how a relative change of the load is magnified.

    Stiffness and radius enter through the same ratio load/(E I), so a rounding of any of them moves the rod
    by eps times a small multiple of this; at a bifurcation it is unbounded.
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
