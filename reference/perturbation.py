"""Small perturbations of a deformed rod: what a change at its start does at its end.

All in one system of units; a straight unstressed rod with extension and shear, free of distributed load.

Symbols
-------
R, n, m       section frame (columns d1 d2 d3), internal force and moment in space
r'            tangent of the deformed axis, d1 + C n
C, K          compliances in space, R diag(1/EA, 1/GA_y, 1/GA_z) R^T and R diag(1/GJ, 1/EI_y, 1/EI_z) R^T
u, w, nu, mu  perturbations of position, frame (rotation vector in space), force, moment
T             transfer matrix, (u, w, nu, mu) at the end by those at the start, (12, 12)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from reference import rotation as rot

Array = NDArray[np.float64]

TOLERANCE = 3e-12  # of DOP853, relative; absolute a tenth of it, on quantities of order 1 to 10
MOST_ITERATIONS = 25
CONVERGED = 10  # a Newton step, in units of the integration's tolerance

U, W, NU, MU = (slice(3 * i, 3 * i + 3) for i in range(4))


@dataclass(frozen=True, eq=False)
class Leg:
    """A straight rod: length, compliances of force (1/EA, 1/GA_y, 1/GA_z) and moment (1/GJ, 1/EI_y, 1/EI_z).

    `turn` (3, 3): frame of its start relative to the end of the leg before (rigid joint), R_start = R turn.
    """

    length: float
    compliance_n: Array
    compliance_m: Array
    turn: Array


@dataclass(frozen=True, eq=False)
class LegState:
    """Position, frame, force and moment of a section, in space."""

    position: Array
    frame: Array
    force: Array
    moment: Array


def perturbation_matrix(state: LegState, compliance_n: Array, compliance_m: Array) -> Array:
    """Matrix (12, 12) of d/ds (u, w, nu, mu), in space axes.

    w' = K (mu + m x w),  u' = w x r' + C (nu + n x w),  nu' = 0,  mu' = n x u' - r' x nu: the variation of
    R^T R' = hat(kappa), r' = R gamma, n' = 0, m' = -r' x n. Simo and Vu-Quoc 1986; Antman, ch. 8.
    """
    R, n, m = state.frame, state.force, state.moment
    C, K = (R * compliance_n) @ R.T, (R * compliance_m) @ R.T
    dr, n_hat = rot.hat(R[:, 0] + C @ n), rot.hat(n)
    A = np.zeros((12, 12))
    A[U, W], A[U, NU] = C @ n_hat - dr, C
    A[W, W], A[W, MU] = K @ rot.hat(m), K
    A[MU, W], A[MU, NU] = n_hat @ A[U, W], n_hat @ C - dr
    return A


def transfer(legs: list[Leg], start: LegState, tolerance: float = TOLERANCE) -> tuple[LegState, Array]:
    """State and transfer matrix T (12, 12) at the end of rigidly joined legs."""
    state, T = start, np.eye(12)
    for leg in legs:
        joined = LegState(state.position, state.frame @ leg.turn, state.force, state.moment)
        state, step = _along(leg, joined, tolerance)
        T = step @ T
    return state, T


def _along(leg: Leg, start: LegState, tolerance: float) -> tuple[LegState, Array]:
    n = start.force

    def unpacked(y: Array) -> tuple[LegState, Array]:
        return LegState(y[:3], y[3:12].reshape(3, 3), n, y[12:15]), y[15:].reshape(12, 12)

    def slope(_: float, y: Array) -> Array:
        state, T = unpacked(y)
        R = state.frame
        dr = R[:, 0] + R @ (leg.compliance_n * (R.T @ n))
        curvature = R @ (leg.compliance_m * (R.T @ state.moment))
        A = perturbation_matrix(state, leg.compliance_n, leg.compliance_m)
        return np.concatenate([dr, (rot.hat(curvature) @ R).ravel(), -rot.cross(dr, n), (A @ T).ravel()])

    y = np.concatenate([start.position, start.frame.ravel(), start.moment, np.eye(12).ravel()])
    run = solve_ivp(slope, (0.0, leg.length), y, "DOP853", rtol=tolerance, atol=tolerance / 10)
    return unpacked(run.y[:, -1])


def cantilever(
    legs: list[Leg], tip_force: Array, guess: Array | None = None, tolerance: float = TOLERANCE
) -> tuple[LegState, LegState, Array]:
    """Equilibrium of joined legs clamped at the origin along x under a dead tip force: start, end, T.

    Shooting from the clamp, n = tip force; Newton for the clamp moment with T[mu, mu] as the Jacobian.

    Raises
    ------
    ArithmeticError when Newton does not converge from `guess` (default: the moment of the unstressed legs).
    """
    if guess is None:
        arm, frame = np.zeros(3), np.eye(3)
        for leg in legs:
            frame = frame @ leg.turn
            arm = arm + leg.length * frame[:, 0]
        guess = rot.cross(arm, tip_force)
    m = np.asarray(guess, dtype=float)
    for _ in range(MOST_ITERATIONS):
        start = LegState(np.zeros(3), np.eye(3), tip_force, m)
        end, T = transfer(legs, start, tolerance)
        step = np.asarray(np.linalg.solve(T[MU, MU], -end.moment), dtype=np.float64)
        if float(np.abs(step).max()) < CONVERGED * tolerance * (1 + float(np.abs(m).max())):
            return start, end, T
        m = m + step
    raise ArithmeticError(f"no equilibrium found for the tip force {tip_force} from the moment {guess}")
