r"""Rods bent by what runs inside them: tendons, chambers under pressure, magnets; thin-rod theory.

Without other loads the section forces of a rod with a tendon of tension T, without friction, are known: the
cut through rod and tendon carries nothing, so the rod has n = -T t and m = p x n, with the place p of the
tendon in the section and its direction t. With strains v (of the axis) and u (curvature) in section axes,

    t ~ v + u x p + p',   K_n (v - e_x) = -T t,   K_m u = -T p x t,

nonlinear equations for u and v section by section, and then r' = R v, R' = R hat(u) (Rucker, Webster, IEEE
Trans. Robotics 27 (2011) 1033, eq. 1-4, 13-24). They are solved by fixed-point iteration, which contracts
with T/(E A), and integrated by exponential steps at the middle of equal intervals (second order,
extrapolated).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

from reference.root import bracketed_root

Array = NDArray[np.float64]

INTERVALS = 2000
ROUNDS = 60  # of the fixed point; it contracts by T/(E A), 1e-4 to 1e-2
MU_0 = 1.25663706127e-6  # N/A2, CODATA 2022


def tendon_rod(
    length: float,
    radius: float,
    young: float,
    poisson: float,
    tension: float,
    path: ArrayLike,
    friction: float = 0.0,
) -> tuple[Array, float]:
    """Tip (3,) [m] of a straight round rod along x, clamped at 0, with one tendon; and its own error [m].

    Parameters
    ----------
    path : (points, 3) of [fraction of the length, y, z] [-, m, m], straight in between
    friction : capstan coefficient mu; the tension at s is T exp(-mu theta(s)), theta the turning of the
        path from its first point
    """
    fine, coarse = (
        _tip(*_strains(length, radius, young, poisson, tension, path, n, friction)[:3])
        for n in (INTERVALS, INTERVALS // 2)
    )
    return fine + (fine - coarse) / 3.0, float(np.linalg.norm(fine - coarse)) / 3.0


def tendon_rod_of_length(
    length: float,
    radius: float,
    young: float,
    poisson: float,
    wanted: float,
    path: ArrayLike,
    friction: float = 0.0,
) -> tuple[Array, float, float]:
    """Tip (3,) [m] of the same rod, its own error [m], and the tension [N] that brings the path to a length.

    With friction it is the tension at the first point of the path.

    wanted : [m], shorter than the path in the straight rod
    """
    whole = np.pi * radius**2 * young

    def excess(tension: float) -> float:
        lengths = [
            _strains(length, radius, young, poisson, tension, path, n, friction)[3]
            for n in (INTERVALS, INTERVALS // 2)
        ]
        return lengths[0] + (lengths[0] - lengths[1]) / 3.0 - wanted

    tension = bracketed_root(excess, 0.0, 0.1 * whole)
    tip, error = tendon_rod(length, radius, young, poisson, tension, path, friction)
    return tip, error, tension


def _strains(
    length: float,
    radius: float,
    young: float,
    poisson: float,
    tension: float,
    path: ArrayLike,
    intervals: int,
    friction: float = 0.0,
) -> tuple[float, Array, Array, float]:
    """Interval h, strains v and u (intervals, 3) in their middles, and the length of the tendon's path."""
    area, second = np.pi * radius**2, np.pi * radius**4 / 4.0
    shear = young / (2.0 * (1.0 + poisson))
    K_n = np.array([young, shear, shear]) * area
    K_m = np.array([2.0 * shear, young, young]) * second
    points = np.asarray(path, float) * [length, 1.0, 1.0]
    h = length / intervals
    s = h * (np.arange(intervals) + 0.5)
    inside = (s > points[0, 0]) & (s < points[-1, 0])
    piece = np.clip(np.searchsorted(points[:, 0], s) - 1, 0, len(points) - 2)
    slope = np.diff(points, axis=0)[:, 1:] / np.diff(points[:, 0])[:, None]
    p = np.column_stack([np.zeros(intervals), *(np.interp(s, points[:, 0], points[:, k]) for k in (1, 2))])
    dp = np.column_stack([np.zeros(intervals), slope[piece]])
    v, u = np.tile([1.0, 0.0, 0.0], (intervals, 1)), np.zeros((intervals, 3))
    for _ in range(ROUNDS):
        t = v + np.cross(u, p) + dp
        t /= np.linalg.norm(t, axis=1, keepdims=True)
        left = tension * np.exp(-friction * _turning(t, u, h, inside)) if friction else tension
        n = -(left * inside)[:, None] * t
        v, u = np.array([1.0, 0.0, 0.0]) + n / K_n, np.cross(p, n) / K_m
    stretch = np.linalg.norm(v + np.cross(u, p) + dp, axis=1)
    return h, np.asarray(v, float), np.asarray(u, float), float(h * np.sum(stretch * inside))


def _turning(t: Array, u: Array, h: float, inside: Array) -> Array:
    """Angle (intervals,) by which the path has turned from its first point to the middle of each interval.

    The turn from one middle to the next is the angle of t there, seen from here; half of the first to begin.
    """
    ahead = Rotation.from_rotvec(0.5 * h * (u[:-1] + u[1:])).apply(t[1:])
    angle = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(ahead - t[:-1], axis=1), 0.0, 1.0))
    angle = angle * inside[:-1] * inside[1:]
    first = angle[np.argmax(inside)]
    return np.asarray(0.5 * first + np.concatenate([[0.0], np.cumsum(angle)]), dtype=float)


def frictional_arc(length: float, curvature: float, friction: float) -> Array:
    """Tip (3,) of an inextensible rod along x, bent by a straight tendon with friction off its axis.

    With the turning phi of the rod, kappa = kappa_0 exp(-mu phi): phi = ln(1 + mu kappa_0 s)/mu. The integral
    of exp(i phi) = (1 + mu kappa_0 s)^(i/mu) is elementary.
    """
    end, power = 1.0 + friction * curvature * length, 1.0 + 1.0j / friction
    r = (end**power - 1.0) / (power * friction * curvature)
    return np.array([r.real, r.imag, 0.0])


def frictional_curvature(length: float, wanted: float, offset: float, root: float, friction: float) -> float:
    """kappa_0 [1/m] of `frictional_arc` whose tendon has the length `wanted` [m], of a rod that is thin.

    The tendon shortens by its offset d times the turning phi, and the axis by int T/(E A) ds = i^2 phi/d with
    the radius of gyration i = `root`, T d = E I kappa; so phi = (L - l)/(d + i^2/d) at the tip, whatever the
    friction, and phi = ln(1 + mu kappa_0 L)/mu.
    """
    phi = (length - wanted) / (offset + root**2 / offset)
    return float(np.expm1(friction * phi)) / (friction * length)


def _tip(h: float, v: Array, u: Array) -> Array:
    R, r = Rotation.identity(), np.zeros(3)
    half, whole = Rotation.from_rotvec(0.5 * h * u), Rotation.from_rotvec(h * u)
    for i in range(len(v)):
        r = r + h * (R * half[i]).apply(v[i])
        R = R * whole[i]
    return np.asarray(r, dtype=float)


def chamber_arc(length: float, stiffness: float, couple: float) -> Array:
    """Tip (3,) of an inextensible rod along x, bent by a constant couple [N m] about z: an arc."""
    angle = couple * length / stiffness
    return length * np.array(
        [np.sinc(angle / np.pi), np.sin(0.5 * angle) * np.sinc(0.5 * angle / np.pi), 0.0]
    )


def closed_tube_strain(inner: float, outer: float, young: float, poisson: float, pressure: float) -> float:
    """Axial strain of a thick tube with end caps: p a^2 (1 - 2 nu)/(E (b^2 - a^2)) (Lame)."""
    return pressure * inner**2 * (1.0 - 2.0 * poisson) / (young * (outer**2 - inner**2))


def magnet_tip(
    length: float, stiffness: float, couple: float, angle: float, tolerance: float = 1e-10
) -> tuple[Array, float]:
    """Tip (3,) of an inextensible rod along x, magnetised along it, in a field at `angle` to x in the plane.

    E I theta'' = -c sin(angle - theta), theta(0) = 0, theta'(L) = 0, c = B_r B A/mu_0 [N]; by collocation.
    Also its own error [m].
    """
    mesh = np.linspace(0.0, length, 201)
    guess = np.linspace([0.0, angle / length], [angle, 0.0], len(mesh)).T
    found = solve_bvp(
        lambda x, y: np.array([y[1], -couple / stiffness * np.sin(angle - y[0])]),
        lambda a, b: np.array([a[0], b[1]]),
        mesh,
        guess,
        tol=tolerance,
        max_nodes=100_000,
    )
    if not found.success:
        raise RuntimeError(found.message)
    tips = []
    for points in (40000, 20000):
        theta = found.sol((np.arange(points) + 0.5) * length / points)[0]
        tips.append(length * np.array([np.mean(np.cos(theta)), np.mean(np.sin(theta)), 0.0]))
    return tips[0], float(np.linalg.norm(tips[0] - tips[1])) + tolerance * length
