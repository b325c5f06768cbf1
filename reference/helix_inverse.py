"""Inverse of the helix: the tip moment that brings a straight round rod to a given tip pose.

Symbols
-------
R, r     tip rotation relative to the reference section; tip position over the length, [-]
e        unit vector along the undeformed rod
v        M L/EI, [rad]; tau = v.e
nu       EI/GJ - 1 (Poisson's ratio, for a round section)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares, minimize_scalar

from reference import rotation as rot
from reference.helix import unit_axis
from reference.root import bracketed_root

Array = NDArray[np.float64]

# Points at which v.e - tau is sampled for brackets; touching roots between them are sought separately.
GRID_POINTS = 801


@dataclass(frozen=True, eq=False)
class HelixMoment:
    """Answer of the inverse: `moment` (3,) [N m] fixed in space, and what it leaves unexplained.

    rotation_mismatch [rad] and position_mismatch [-, of the length] are the distances between the given pose
    and the helix of `moment`: both zero when the pose is one that a tip moment can produce.
    """

    moment: Array
    rotation_mismatch: float
    position_mismatch: float


@dataclass(frozen=True, eq=False)
class _Branches:
    """Logarithms v(tau) of R Exp(-nu tau e), one continuous branch for each whole number of turns."""

    q: Array  # (4,) quaternion of R
    e: Array
    nu: float

    def v(self, tau: Array, turn: int) -> Array:
        """Return (n, 3): angle 2 atan2(|u|, w) in [0, 2 pi) plus whole turns, along u; quaternion (w, u)."""
        # A quaternion continuous in tau (never re-signed) keeps each branch continuous.
        w2, u2 = np.cos(self.nu * tau / 2), -np.sin(self.nu * tau / 2)[:, None] * self.e
        w = self.q[0] * w2 - u2 @ self.q[1:]
        u = self.q[0] * u2 + w2[:, None] * self.q[1:] + np.cross(self.q[1:], u2)
        size = np.linalg.norm(u, axis=1)
        direction = np.where(size[:, None] > 1e-14, u / np.maximum(size, 1e-300)[:, None], self.e)
        return (2 * np.arctan2(size, w) + 2 * np.pi * turn)[:, None] * direction

    def gap(self, tau: float, turn: int) -> float:
        """Return v.e - tau, zero at a solution."""
        return float(self.v(np.array([tau]), turn)[0] @ self.e) - tau

    def roots(self, grid: Array, turn: int) -> list[Array]:
        """Return every v of one branch with v.e = tau, from sign changes and from touching points."""
        g = self.v(grid, turn) @ self.e - grid
        brackets = [(grid[i], grid[i + 1]) for i in np.flatnonzero(g[:-1] * g[1:] <= 0)]
        size, same_sign = np.abs(g), g[:-1] * g[1:] > 0
        touching = (size[1:-1] < size[:-2]) & (size[1:-1] < size[2:]) & same_sign[:-1] & same_sign[1:]
        for i in np.flatnonzero(touching) + 1:
            # Two roots closer than the grid: find the extreme point between them.
            side = np.sign(g[i])
            extreme = minimize_scalar(
                lambda t, side=side: side * self.gap(t, turn),
                bounds=(grid[i - 1], grid[i + 1]),
                options={"xatol": 1e-12},
            )
            middle = float(extreme.x)  # pyright: ignore[reportAttributeAccessIssue]
            if side * self.gap(middle, turn) <= 0:
                brackets += [(grid[i - 1], middle), (middle, grid[i + 1])]
            elif side * self.gap(middle, turn) < 1e-9:
                brackets.append((middle, middle))
        found = []
        for low, high in brackets:
            tau = low if low == high else bracketed_root(lambda t: self.gap(t, turn), low, high, 1e-15)
            if abs(self.gap(tau, turn)) < 1e-7:  # otherwise a jump of the branch
                found.append(self.v(np.array([tau]), turn)[0])
        return found


def _full_turns(q: Array, e: Array, nu: float, r: Array, turns: int) -> list[Array]:
    """Return v of whole turns, |v| = 2 pi k, possible when R is a rotation about e: no axis of its own.

    R = Exp(nu tau e) gives tau up to 2 pi n/nu, then v = 2 pi k m with m.e = tau/(2 pi k), and m's other part
    along that of r = m (m.e).
    """
    if np.linalg.norm(np.cross(q[1:], e)) > 1e-7:
        return []
    angle = 2 * np.arctan2(q[1:] @ e, q[0])
    across = r - (r @ e) * e
    if np.linalg.norm(across) < 1e-9:  # the direction is free: any moment of this size closes the circle
        across = np.cross(e, np.eye(3)[np.argmin(np.abs(e))])
    across = across / np.linalg.norm(across)
    found = []
    for k in range(1, turns + 1):
        for n in range(-turns, turns + 1):
            tau = (angle + 2 * np.pi * n) / nu if nu != 0 else 0.0
            cosine = tau / (2 * np.pi * k)
            if abs(cosine) <= 1:
                side = np.sqrt(1 - cosine**2) * (1 if cosine >= 0 else -1)
                found.append(2 * np.pi * k * (cosine * e + side * across))
    return found


def helix_inverse(
    position: ArrayLike,
    rotation: ArrayLike,
    length: float,
    EI: float,
    GJ: float,
    axis: ArrayLike = (1.0, 0.0, 0.0),
    largest_angle: float = 4.0 * np.pi,
) -> HelixMoment:
    """Tip moment (fixed in space) that brings a straight round rod to a given tip pose.

    v = Log(R Exp(-nu tau e)) with tau = v.e and nu = EI/GJ - 1: for each branch of the logarithm one scalar
    equation in tau. Every root with |v| <= largest_angle is found by bracketing, and the one whose helix ends
    nearest to `position` is taken (the shortest v among equals: torsion alone does not move the tip).

    Parameters
    ----------
    position, rotation : (3,) [m] from the clamp, (3, 3) relative to the reference section
    length : [m]
    EI, GJ : [N m2]
    axis : (3,), along the undeformed rod
    largest_angle : [rad], bound of |M| L/EI

    Returns
    -------
    HelixMoment

    Raises
    ------
    ValueError when no v within the bound has this rotation.

    Notes
    -----
    Derived here. Some 20 ms. A pose that no tip moment reaches gives the v with the exact rotation
    and a large `position_mismatch`.
    """
    e, r, R = unit_axis(axis), np.asarray(position, dtype=float) / length, np.asarray(rotation, dtype=float)
    nu = EI / GJ - 1.0
    turns = int(np.ceil(largest_angle / (2 * np.pi)))
    branches = _Branches(rot.quaternion(R), e, nu)
    grid = np.linspace(-largest_angle, largest_angle, GRID_POINTS)
    found = [v for turn in range(-turns - 1, turns + 1) for v in branches.roots(grid, turn)]
    found += _full_turns(branches.q, e, nu, r, turns)
    found = [v for v in found if np.linalg.norm(v) <= largest_angle * (1 + 1e-12)]
    if not found:
        raise ValueError(f"no tip moment with |M| L/EI <= {largest_angle:.3g} turns the tip like this")

    def mismatch(v: Array) -> Array:
        turned = rot.exp(v) @ rot.exp(nu * (v @ e) * e)
        return np.concatenate([rot.exp_integral(v) @ e - r, rot.log(turned @ R.T)])

    misses = np.array([np.linalg.norm(mismatch(v)[:3]) for v in found])
    near = [v for v, miss in zip(found, misses, strict=True) if miss <= misses.min() + 1e-9]
    v = min(near, key=lambda w: float(np.linalg.norm(w)))
    if misses.min() < 1e-4:
        # Near a double root tau is known to sqrt(eps) only; the position determines it better.
        v = np.asarray(least_squares(mismatch, v, xtol=1e-15, ftol=1e-15, gtol=1e-15).x)
    miss = mismatch(v)
    return HelixMoment(v * EI / length, float(np.linalg.norm(miss[3:])), float(np.linalg.norm(miss[:3])))
