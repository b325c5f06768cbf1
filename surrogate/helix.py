r"""Closed form of the thin arm under a tip moment, forwards and backwards, in body axes and over the length.

Symbols
-------
v        M L/(E I) [rad], e the x axis, tau = v.e, phi = |v|, m = v/phi
R, r     rotation of the tip section; tip position over the length
nu       E I/(G J) - 1
w, u     unit quaternion of R; p = |(u_y, u_z)|, (w, u_x) = rho (cos alpha, sin alpha)

Forwards (theory: the internal moment is constant in space, the axis a helix)

    r = m (m.e) + (sin phi/phi)(e - m (m.e)) + ((1 - cos phi)/phi) m x e,   R = Exp(v) Exp(nu tau e).

Backwards v = Log(R Exp(-nu tau e)). The factor turns (w, u_x) by -nu tau/2 and leaves p, so with
a = alpha - nu tau/2 and half the angle theta = phi/2, cos theta = rho cos a,

    tau/2 = f(a) = theta rho sin a/sin theta,    a + nu f(a) = alpha,
    f' = (rho sin a)^2/s^2 + theta rho cos a p^2/s^3,

s = sin theta: one scalar equation, with one root in (-pi, pi] for each of the two quaternions of R, and more
at large torsion. The position tells which root is meant. Plain floats: a pose takes some twenty microseconds,
less than array calls would.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf.rotation import exp

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

NEWTON_STEPS = 30  # bracketed, so this is never reached in practice; some four are needed
SETTLED = 1e-14  # [rad]
ROUNDING = 1e-9  # [rad] of a root, which may lie at pi itself
# A moment longer by a radian must bring the tip nearer by this, of the length. A nearly straight arm may as
# well have been twisted by a turn, and without this, noise of 1e-3 in a pose would decide.
LENGTH_COST = 1e-3
STRAIGHT = 1e-9  # sine of half the angle below which its series is exact


@dataclass(frozen=True)
class HelixAnswer:
    """`v` (3,) of a pose, the unwrapped logarithm `log` (3,) of its rotation, |r(v) - r| over the length."""

    v: Vector
    log: Vector
    mismatch: float


def helix_pose(v: Floats, nu: float) -> tuple[Floats, Floats]:
    """Tip position (..., 3) over the length and rotation (..., 3, 3) of moments v (..., 3) [rad]."""
    v = np.asarray(v, dtype=float)
    phi = np.linalg.norm(v, axis=-1)[..., None]
    e = np.array([1.0, 0.0, 0.0])
    # sin(phi)/phi, (1 - cos(phi))/phi^2 and (phi - sin(phi))/phi^3, the last by its series where it cancels.
    a, b = np.sinc(phi / np.pi), 0.5 * np.sinc(0.5 * phi / np.pi) ** 2
    small = phi < 1e-2
    c = np.where(small, 1 / 6 - phi**2 / 120 + phi**4 / 5040, (1.0 - a) / np.where(small, 1.0, phi) ** 2)
    r = a * e + b * np.cross(v, e) + c * v[..., :1] * v
    return r, exp(v) @ exp(nu * v[..., :1] * e)


def section_axes(d_y: Vector, d_z: Vector) -> tuple[Vector, Vector, Vector]:
    """Axes x, y, z of the section nearest to the gradients r_y, r_z: columns of the polar rotation.

    B = [r_y r_z], S^2 = B^T B: with d = |r_y x r_z| and t^2 = tr(S^2) + 2 d, S = (S^2 + d I)/t and B S^-1.
    """
    yy, yz, zz = _dot(d_y, d_y), _dot(d_y, d_z), _dot(d_z, d_z)
    n = _cross(d_y, d_z)
    d = math.sqrt(_dot(n, n))
    scale = 1.0 / (math.sqrt(yy + zz + 2.0 * d) * d)
    a, b, c = (zz + d) * scale, yz * scale, (yy + d) * scale
    return (
        (n[0] / d, n[1] / d, n[2] / d),
        (a * d_y[0] - b * d_z[0], a * d_y[1] - b * d_z[1], a * d_y[2] - b * d_z[2]),
        (c * d_z[0] - b * d_y[0], c * d_z[1] - b * d_y[1], c * d_z[2] - b * d_y[2]),
    )


def helix_inverse(r: Vector, d_y: Vector, d_z: Vector, nu: float) -> HelixAnswer:
    """Moment v of the thin arm whose tip section has the gradients d_y, d_z and is nearest to r.

    Parameters
    ----------
    r : position over the length, from the base, in body axes
    d_y, d_z : gradients of position in the section, need not be unit vectors; not parallel

    Notes
    -----
    Holds for |v| < 0.99 (2 pi), except that of torsions by half a turn and more with next to no bending the
    shorter moment to nearly the same pose is taken. A pose that no tip moment reaches gives a v of its
    rotation and a large `mismatch`.
    """
    w, x, y, z = _quaternion(*section_axes(d_y, d_z))
    found = _of_quaternion(w, x, y, z, nu, r) + _of_quaternion(-w, -x, -y, -z, nu, r)
    return min(found, key=_cost)


def helix_inverses(body_poses: Floats, nu: float) -> tuple[Floats, Floats, Floats]:
    """`helix_inverse` of poses (B, 3, 4) in body axes (`Arm.body_poses`): v, log (B, 3), mismatch (B,)."""
    answers = [helix_inverse(r, d_y, d_z, nu) for r, _, d_y, d_z in np.swapaxes(body_poses, 1, 2).tolist()]
    return (
        np.array([a.v for a in answers]).reshape(-1, 3),
        np.array([a.log for a in answers]).reshape(-1, 3),
        np.array([a.mismatch for a in answers]),
    )


def _of_quaternion(w: float, x: float, y: float, z: float, nu: float, r: Vector) -> list[HelixAnswer]:
    """The roots of one of the two quaternions, and how far their helices end from r."""
    rho, alpha, p2 = math.hypot(w, x), math.atan2(x, w), y * y + z * z
    log_factor = _angle_by_sine(math.sqrt(x * x + p2), w)
    log = (log_factor * x, log_factor * y, log_factor * z)
    found = []
    for a, target in _roots(rho, p2, alpha, nu):
        turn = target - a
        c, s = math.cos(turn), math.sin(turn)
        along = rho * math.sin(a)
        factor = _angle_by_sine(math.sqrt(along * along + p2), rho * math.cos(a))
        v = (factor * along, factor * (y * c - z * s), factor * (z * c + y * s))
        found.append(HelixAnswer(v, log, _distance(v, r)))
    return found


def _roots(rho: float, p2: float, alpha: float, nu: float) -> list[tuple[float, float]]:
    """Roots a of a + nu f(a) = target in [-pi, pi], each with its target, alpha or a whole turn from it."""
    found = [(_newton(rho, p2, alpha, nu, alpha / (1.0 + nu), True), alpha)]
    # Where the left side falls near +-pi it passes them before: more roots, at large torsion.
    if 1.0 + nu * _half_torsion(rho, p2, math.pi)[1] < 0.0:
        side = math.copysign(math.pi, -alpha)
        target = alpha + 2.0 * side
        for start in (target / (1.0 + nu), 0.999 * side):
            a = _newton(rho, p2, target, nu, start, False)
            if (
                abs(a) <= math.pi + ROUNDING
                and abs(a + nu * _half_torsion(rho, p2, a)[0] - target) < ROUNDING
            ):
                found.append((a, target))
    return found


def _newton(rho: float, p2: float, target: float, nu: float, a: float, bracketed: bool) -> float:
    """Newton for a + nu f(a) = target; inside [-pi, pi], where the left side passes it, or anywhere."""
    low, high = (-math.pi, math.pi) if bracketed else (-math.inf, math.inf)
    for _ in range(NEWTON_STEPS):
        f, slope = _half_torsion(rho, p2, a)
        gap, rate = a + nu * f - target, 1.0 + nu * slope
        if bracketed:
            low, high = (low, a) if gap > 0.0 else (a, high)
        nearer = a - gap / rate if rate else math.inf
        if not low <= nearer <= high:
            nearer = 0.5 * (low + high)
        a, moved = nearer, abs(nearer - a)
        if not moved > SETTLED:
            break
    return a


def _half_torsion(rho: float, p2: float, a: float) -> tuple[float, float]:
    """f(a) and f'(a)."""
    c, s = rho * math.cos(a), rho * math.sin(a)
    sine2 = s * s + p2
    sine = math.sqrt(sine2)
    if sine < STRAIGHT:
        return a, 1.0
    theta = math.atan2(sine, c)
    return theta * s / sine, s * s / sine2 + theta * c * p2 / (sine2 * sine)


def _angle_by_sine(sine: float, cosine: float) -> float:
    """2 theta/sin theta: a rotation vector over the vector part of its quaternion."""
    return 2.0 * math.atan2(sine, cosine) / sine if sine > STRAIGHT else 2.0


def _distance(v: Vector, r: Vector) -> float:
    """|r(v) - r|, over the length."""
    x, y, z = v
    phi2 = x * x + y * y + z * z
    phi = math.sqrt(phi2)
    if phi < 1e-4:
        a, b, c = 1.0 - phi2 / 6.0, 0.5 - phi2 / 24.0, 1.0 / 6.0
    else:
        a, b = math.sin(phi) / phi, 2.0 * (math.sin(0.5 * phi) / phi) ** 2
        c = (1.0 - a) / phi2
    return math.sqrt(
        (a + c * x * x - r[0]) ** 2 + (b * z + c * x * y - r[1]) ** 2 + (c * x * z - b * y - r[2]) ** 2
    )


def _quaternion(a: Vector, b: Vector, c: Vector) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of the rotation with columns a, b, c, by its largest component."""
    trace = a[0] + b[1] + c[2]
    if trace > 0.0:
        k = 2.0 * math.sqrt(1.0 + trace)
        return 0.25 * k, (b[2] - c[1]) / k, (c[0] - a[2]) / k, (a[1] - b[0]) / k
    if a[0] >= b[1] and a[0] >= c[2]:
        k = 2.0 * math.sqrt(1.0 + a[0] - b[1] - c[2])
        return (b[2] - c[1]) / k, 0.25 * k, (b[0] + a[1]) / k, (c[0] + a[2]) / k
    if b[1] >= c[2]:
        k = 2.0 * math.sqrt(1.0 - a[0] + b[1] - c[2])
        return (c[0] - a[2]) / k, (b[0] + a[1]) / k, 0.25 * k, (c[1] + b[2]) / k
    k = 2.0 * math.sqrt(1.0 - a[0] - b[1] + c[2])
    return (a[1] - b[0]) / k, (c[0] + a[2]) / k, (c[1] + b[2]) / k, 0.25 * k


def _cost(answer: HelixAnswer) -> float:
    x, y, z = answer.v
    return answer.mismatch + LENGTH_COST * math.sqrt(x * x + y * y + z * z)


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
