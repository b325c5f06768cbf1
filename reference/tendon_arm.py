"""Arm of round sections with several tendons under its weight: rod equations, solved by shooting.

The cut through rod and tendons carries the weight beyond it and, where all tendons end at or before the tip,
nothing else at the tip; so with the total force N and moment M about the axis, in space,

    N(s) = sum of the weight beyond s,   M' = -r' x N,   M(L) = 0,   r' = R v,   R' = R hat(u),

and in section axes the rod itself carries what the tendons, pulled by T_i along t_i at p_i, leave it:

    K_n (v - e_x) = R^T N - sum T_i t_i,   K_m u = R^T M - sum p_i x T_i t_i,   t_i ~ v + u x p_i + p_i'

(Rucker, Webster, IEEE Trans. Robotics 27 (2011) 1033, eq. 1-4, 13-24). The strains are a fixed point that
contracts by T/(E A). The three components of M(0) are found by Newton's method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from reference.rotation import cross

Array = NDArray[np.float64]

ROUNDS = 40  # of the fixed point, at most
NEWTON_ROUNDS = 12
SHARES = (0.2, 0.4, 0.6, 0.8, 1.0)  # of the weight, one after the other
ON_THE_WAY = 1e-5  # tolerance: only a start for the next
E_X = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class ArmSection:
    """One prismatic section: length, radius [m], Young's modulus [Pa], Poisson's ratio, density [kg/m3]."""

    length: float
    radius: float
    young: float
    poisson: float
    density: float = 0.0

    @property
    def area(self) -> float:
        """Of the round section [m2]."""
        return float(np.pi * self.radius**2)

    @property
    def stiffness(self) -> tuple[Array, Array]:
        """K_n = (EA, GA, GA) [N] and K_m = (GJ, EI, EI) [N m2]."""
        second, shear = np.pi * self.radius**4 / 4.0, self.young / (2.0 * (1.0 + self.poisson))
        K_n = np.array([self.young, shear, shear]) * self.area
        return K_n, np.array([2.0 * shear, self.young, self.young]) * second


@dataclass(frozen=True)
class ArmTendon:
    """A tension [N] along a path (points, 3) of [fraction of the arm's length, y, z] [-, m, m]."""

    tension: float
    path: ArrayLike


def tendon_arm_tip(
    sections: Sequence[ArmSection],
    tendons: Sequence[ArmTendon],
    base: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    gravity: ArrayLike = (0.0, 0.0, 0.0),
    tolerance: float = 1e-9,
) -> tuple[Array, float]:
    """Tip (3,) [m], relative to the base, of an arm clamped with the axes `base` (columns); its error.

    Linear elastic, sections rigid in their plane. The error [m] is the difference to a run at ten times the
    tolerance. Raises RuntimeError where the shooting fails.
    """
    arm = _Arm(sections, tendons, np.asarray(base, float), np.asarray(gravity, float))
    for share in SHARES:
        arm.gravity = share * np.asarray(gravity, float)
        arm.tip(ON_THE_WAY)
    coarse, tip = (arm.tip(t) for t in (10.0 * tolerance, tolerance))
    return tip, float(np.linalg.norm(tip - coarse)) + tolerance * arm.length


class _Arm:
    def __init__(
        self, sections: Sequence[ArmSection], tendons: Sequence[ArmTendon], base: Array, gravity: Array
    ) -> None:
        self.sections, self.base, self.gravity = sections, base, gravity
        self.ends = np.concatenate([[0.0], np.cumsum([section.length for section in sections])])
        self.length = float(self.ends[-1])
        self.paths = [np.asarray(t.path, float) * [self.length, 1.0, 1.0] for t in tendons]
        self.tensions = [t.tension for t in tendons]
        corners = np.concatenate([self.ends, *(path[:, 0] for path in self.paths)])
        self.breaks = np.unique(np.round(corners, 12))
        self.moment = np.zeros(3)  # at the base

    def tip(self, tolerance: float) -> Array:
        """Tip (3,) [m]: Newton on the moment at the base, with differences, from the last one found."""
        unit = float(self.sections[0].stiffness[1][1]) / self.length
        left = np.inf
        for _ in range(NEWTON_ROUNDS):
            end = self._shoot(self.moment, tolerance)
            left = float(np.linalg.norm(end[12:])) / unit
            if left < 1e2 * tolerance:
                return end[:3]
            step = 1e-4 * unit
            moved = [self._shoot(self.moment + step * e, tolerance)[12:] for e in np.eye(3)]
            self.moment = self.moment - np.linalg.solve((np.array(moved) - end[12:]).T / step, end[12:])
        raise RuntimeError(f"shooting left a moment of {left:.2g} E I/L at the tip")

    def _shoot(self, moment: Array, tolerance: float) -> Array:
        """State at the tip: r (3,), R (9,), M (3,), from a total moment at the base."""
        state = np.concatenate([np.zeros(3), self.base.ravel(), moment])
        for start, end in zip(self.breaks[:-1], self.breaks[1:], strict=True):
            piece = int(np.searchsorted(self.ends, 0.5 * (start + end))) - 1
            rate = self._rate(piece, 0.5 * (start + end))
            done = solve_ivp(rate, (start, end), state, "DOP853", rtol=tolerance, atol=1e-3 * tolerance)
            state = np.asarray(done.y[:, -1], dtype=float)
        return state

    def _rate(self, piece: int, middle: float):
        """Right-hand side on an interval in which no section and no piece of a tendon ends."""
        section = self.sections[piece]
        K_n, K_m = section.stiffness
        beyond = sum((s.density * s.area * s.length for s in self.sections[piece + 1 :]), 0.0)
        pulling = [
            (tension, path, int(np.searchsorted(path[:, 0], middle)) - 1)
            for tension, path in zip(self.tensions, self.paths, strict=True)
            if path[0, 0] < middle < path[-1, 0]
        ]

        def rate(s: float, state: Array) -> Array:
            R, M = state[3:12].reshape(3, 3), state[12:]
            N = (beyond + section.density * section.area * (self.ends[piece + 1] - s)) * self.gravity
            places = []
            for tension, path, k in pulling:
                slope = np.diff(path[k : k + 2], axis=0)[0]
                slope = slope / slope[0]
                here = path[k] + (s - path[k, 0]) * slope
                places.append((tension, here * [0.0, 1.0, 1.0], slope * [0.0, 1.0, 1.0]))
            v, u = E_X, np.zeros(3)
            for _ in range(ROUNDS):
                n, m = R.T @ N, R.T @ M
                for tension, p, dp in places:
                    t = v + cross(u, p) + dp
                    pull = tension * t / np.sqrt(t @ t)
                    n, m = n - pull, m - cross(p, pull)
                new_v, new_u = E_X + n / K_n, m / K_m
                change = np.abs(new_v - v).max() + self.length * np.abs(new_u - u).max()
                v, u = new_v, new_u
                if change < 1e-13:
                    break
            dr = R @ v
            spin = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
            rates = [dr, (R @ spin).ravel(), -cross(dr, N)]
            return np.asarray(np.concatenate(rates), dtype=float)

        return rate
