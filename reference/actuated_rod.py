"""Rod with extension, shear, bending and torsion under all that acts on it at once: multiple shooting.

The states at the nodes are found by Newton's method, with differences for slopes; every segment between two
nodes is integrated at once, with all its perturbed copies. Equations and symbols: actuated_equations.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference import rotation as rot
from reference.actuated_equations import Q_, R_, ActuatedEquations
from reference.rod import RodNotSolved, RodProperties
from reference.rod_actions import RodActions
from reference.round_law import LINEAR, RoundLaw

Array = NDArray[np.float64]

SUBSTEPS = (3, 6)  # of the classical Runge-Kutta method on each; their difference is the error
NEWTON_ROUNDS = 14
CONVERGED = 1e-8  # Newton step; with differences for slopes the next would be some 1e-6 of it
ON_THE_WAY = 1e-5
FIRST_STEP, SMALLEST_STEP = 0.25, 1e-3
DIFFERENCE = 1e-7
SIZE = 13


@dataclass(frozen=True, eq=False)
class ActuatedTip:
    """Tip of a rod: position (3,) [m], rotation (3, 3) relative to the reference, their errors [m], [rad]."""

    position: Array
    rotation: Array
    position_error: float
    angle_error: float


def solve_actuated_rod(rod: RodProperties, actions: RodActions, law: RoundLaw = LINEAR) -> ActuatedTip:
    """Equilibrium of a straight clamped rod on the branch that starts without loads.

    Parameters
    ----------
    rod : straight, EI_y = EI_z where `law` is not linear
    actions : what acts on it
    law : what the section's stiffness changes by at finite strain

    Returns
    -------
    ActuatedTip

    Raises
    ------
    RodNotSolved where Newton fails at the smallest load step.

    Notes
    -----
    Some 0.2 to 1 s. Errors are the difference between two step sizes of a method of fourth order.
    """
    if np.any(rod.curvature):
        raise ValueError("a rod with wires and springs must be straight in its reference")
    if not law.linear and rod.EI_y != rod.EI_z:
        raise ValueError("a section law is known for round rods only")
    shooting = _Shooting(ActuatedEquations(rod, actions, law))
    y = shooting.continued()
    ends = []
    for substeps in SUBSTEPS:
        shooting.substeps = substeps
        y = shooting.newton(y, 1.0, CONVERGED)
        ends.append(y[-1])
    base = np.asarray(rod.base_rotation, dtype=float)
    R = [base @ rot.matrix(end[Q_]) @ base.T for end in ends]
    error = float(np.linalg.norm(ends[0][R_] - ends[1][R_])) * rod.length
    return ActuatedTip(
        np.asarray(rod.base_position, dtype=float) + rod.length * base @ ends[1][R_],
        R[1],
        error,
        float(np.linalg.norm(rot.log(R[0] @ R[1].T))),
    )


class _Shooting:
    """Newton's method on the states at the nodes."""

    def __init__(self, equations: ActuatedEquations) -> None:
        self.equations = equations
        self.nodes, self.h = equations.nodes, equations.h
        self.substeps = SUBSTEPS[0]

    def continued(self) -> Array:
        """States at full load on the coarse steps, followed from none; the load step adapts."""
        y = np.zeros((len(self.nodes), SIZE))
        y[:, 0], y[:, 3] = self.nodes, 1.0
        before, reached, step = y, 0.0, FIRST_STEP
        last = 0.0
        while reached < 1.0:
            share = min(1.0, reached + step)
            guess = y if reached == last else y + (y - before) * (share - reached) / (reached - last)
            try:
                found = self.newton(guess, share, ON_THE_WAY)
            except RodNotSolved as error:
                step *= 0.5
                if step < SMALLEST_STEP:
                    raise RodNotSolved(f"no equilibrium beyond load factor {reached:.4g}: {error}") from None
                continue
            before, y, last, reached, step = y, found, reached, share, 1.5 * step
        return y

    def newton(self, y: Array, share: float, tolerance: float) -> Array:
        """Node states at a share of the loads; raises `RodNotSolved`."""
        for _ in range(NEWTON_ROUNDS):
            dy = self._step(y, share)
            size = np.abs(dy) / (1.0 + np.abs(y).max(axis=0))
            if not np.all(np.isfinite(dy)) or size.max() > 3.0:
                raise RodNotSolved("Newton's method diverged")
            y = y + dy
            y[:, Q_] /= np.linalg.norm(y[:, Q_], axis=1, keepdims=True)
            if size.max() < tolerance:
                return y
        raise RodNotSolved(f"Newton's method left a step of {float(size.max()):.1e}")

    def _step(self, y: Array, share: float) -> Array:
        """Newton step (nodes, 13) with differences; first the clamp, then the segments, then the free end."""
        copies = y[:, None] + np.concatenate([np.zeros((1, SIZE)), DIFFERENCE * np.eye(SIZE)])
        carried = self._carried(copies[:-1], share)
        before = self.equations.before(copies, share)[1:]
        count = len(y)
        residual = np.zeros((count + 1, SIZE))
        J = np.zeros((count + 1, SIZE, count, SIZE))  # the first and last block rows are in part empty
        residual[0, :7] = y[0, :7] - np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        J[0, :7, 0, :7] = np.eye(7)
        segments = np.arange(count - 1)
        residual[1:-1] = carried[:, 0] - before[:, 0]
        J[segments + 1, :, segments] = np.swapaxes((carried[:, 1:] - carried[:, :1]) / DIFFERENCE, 1, 2)
        J[segments + 1, :, segments + 1] = -np.swapaxes((before[:, 1:] - before[:, :1]) / DIFFERENCE, 1, 2)
        residual[-1, :6] = y[-1, 7:]
        J[-1, :6, -1, 7:] = np.eye(6)
        rows = np.r_[0:7, SIZE : SIZE * count, SIZE * count : SIZE * count + 6]
        matrix = J.reshape((count + 1) * SIZE, count * SIZE)[rows]
        step = np.linalg.solve(matrix, -residual.ravel()[rows])
        return np.asarray(step, dtype=float).reshape(count, SIZE)

    def _carried(self, y: Array, share: float) -> Array:
        """States from each segment's begin to its end; y (segments, copies, 13)."""
        rate = self.equations.rate
        h = (self.h / self.substeps)[:, None, None]
        for step in range(self.substeps):
            s = self.nodes[:-1] + step * h[:, 0, 0]
            k1 = rate(s, y, share)
            k2 = rate(s + 0.5 * h[:, 0, 0], y + 0.5 * h * k1, share)
            k3 = rate(s + 0.5 * h[:, 0, 0], y + 0.5 * h * k2, share)
            k4 = rate(s + h[:, 0, 0], y + h * k3, share)
            y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return y
