"""Helix: the exact shape of a straight round rod under a tip moment (the inverse is in helix_inverse.py).

Symbols
-------
M        tip moment fixed in space, [N m]
e        unit vector along the undeformed rod
EI, GJ   bending (equal in both directions) and torsional stiffness, [N m2]
v        M L/EI, rotation vector of the tip tangent, [rad]
tau      v.e
psi      (M.e) L (1/GJ - 1/EI): the extra twist of the section about its own axis, [rad]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference import rotation as rot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RodShape:
    """Axis and sections of a deformed rod.

    s (n,) [m] reference arc length; position (n, 3) [m]; rotation (n, 3, 3), of each section relative to its
    own reference section (so identity where nothing has turned).
    """

    s: Array
    position: Array
    rotation: Array


def unit_axis(axis: ArrayLike) -> Array:
    """Return the axis at unit length; ValueError unless three finite numbers, not all zero."""
    e = np.asarray(axis, dtype=float)
    norm = float(np.linalg.norm(e))
    if e.shape != (3,) or not np.isfinite(norm) or norm == 0.0:
        raise ValueError(f"axis must be a non-zero vector of three numbers, got {axis!r}")
    return e / norm


def helix_tip_moment(
    moment: ArrayLike,
    length: float,
    EI: float,
    GJ: float,
    s: ArrayLike,
    axis: ArrayLike = (1.0, 0.0, 0.0),
    direction: str = "fixed",
) -> RodShape:
    """Shape of a clamped straight round rod under a tip moment, inextensible and shear-free.

    r(s) = [integral_0^s Exp(v x/L) dx] e,   R(s) = Exp(v s/L) Exp(psi (s/L) e),   v = M L/EI.

    Proof: without forces the internal moment is M everywhere. The spatial curvature of a round rod is
    M/EI + (1/GJ - 1/EI)(t.M) t, so t' = (M/EI) x t, hence t = Exp(v s/L) e, t.M = e.M, and R' R^T is the
    sum of v/L and (psi/L) t. The shape does not depend on GJ.

    A follower moment (its value turns with the tip section: M = R(L) M_ref) satisfies Exp(v) M = M, so
    M = Exp(psi e) M_ref with psi from M.e = M_ref.e: again a helix.

    Parameters
    ----------
    moment : (3,) [N m], in space; for a follower its value on the undeformed rod
    length : [m]
    EI, GJ : [N m2]
    s : (n,) or scalar [m], from 0 to length
    axis : (3,), along the undeformed rod from the clamp, which is the origin
    direction : "fixed" or "follower"

    Returns
    -------
    RodShape with position (n, 3) [m] and rotation (n, 3, 3) relative to the reference section.

    Notes
    -----
    Love, Mathematical Theory of Elasticity, art. 270 (helix under a terminal couple); this form derived here.
    Finite at zero moment (series in the angle). Extension and shear are absent because the force is zero.
    """
    M = space_moment(moment, length, EI, GJ, axis, direction)
    e = unit_axis(axis)
    s = np.atleast_1d(np.asarray(s, dtype=float))
    v = M[None, :] * (s / EI)[:, None]
    psi = (M @ e) * s * (1.0 / GJ - 1.0 / EI)
    position = s[:, None] * (rot.exp_integral(v) @ e)
    return RodShape(s, position, rot.exp(v) @ rot.exp(psi[:, None] * e))


def space_moment(
    moment: ArrayLike,
    length: float,
    EI: float,
    GJ: float,
    axis: ArrayLike = (1.0, 0.0, 0.0),
    direction: str = "follower",
) -> Array:
    """Moment in space that a fixed or follower tip moment amounts to on the deformed round rod.

    Follower: M = Exp(psi e) M_ref, psi = (M_ref.e) L (1/GJ - 1/EI); fixed: M itself. Returns (3,) [N m].
    """
    M = np.asarray(moment, dtype=float)
    if direction == "fixed":
        return M
    if direction != "follower":
        raise ValueError(f'direction must be "fixed" or "follower", got {direction!r}')
    e = unit_axis(axis)
    return rot.exp((M @ e) * length * (1.0 / GJ - 1.0 / EI) * e) @ M
