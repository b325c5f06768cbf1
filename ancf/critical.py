r"""Critical points of a path: where an eigenvalue of the tangent passes through zero, and branches there.

The count of negative eigenvalues tells between which points of the path a critical one lies. The eigenvalue
that changes its sign there (without a potential: the determinant), smooth along the path, is brought to zero
by the secant method. With the left mode psi, the mode itself where there is a potential, the point is a limit
point of the load factor if psi^T Q_ext != 0, else a bifurcation. (Wriggers, Nonlinear Finite Element Methods,
2008, ch. 7.) Flutter of follower loads is no static phenomenon: not seen.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ancf.arclength import Follower, PathPoint
from ancf.band import SingularMatrixError
from ancf.plane import Held

Floats = NDArray[np.float64]

MOST_LOOKS = 15
CLOSE = 1e-5  # share of a step of the path to which a critical point is located
MULTIPLE = 1e-6  # of the next eigenvalue: zero together with the one located
LIMIT = 1e-4  # cosine between mode and load above which the load works on the mode
TURN_OFF = (0.05, 0.02, 0.1, 0.2)  # rod lengths or radians by which a new branch is entered, in this order


@dataclass(frozen=True)
class CriticalPoint:
    """Where the tangent is singular: ``limit`` or ``bifurcation``, and the modes (k, n) of length 1 [SI]."""

    kind: str
    point: PathPoint
    modes: Floats

    @property
    def load_factor(self) -> float:
        """Load factor there."""
        return float(self.point.load_factor)


def critical_points(path: Follower) -> Iterator[CriticalPoint]:
    """Critical points between the last two points of the path, in their order along it."""
    a, b = path.points[-2:]
    low, high = sorted((a.negative, b.negative))
    found: list[CriticalPoint] = []
    met: set[int] = set()
    for index in range(low, high) if a.negative <= b.negative else range(high - 1, low - 1, -1):
        try:
            point = None if index in met else _locate(path, index)
            if point is None:
                continue
            critical, alike = _classified(path, point, index, high)
        except SingularMatrixError:  # no eigenvalues there: the point stays unknown
            continue
        met |= alike
        if np.isfinite(critical.modes).all():
            found.append(critical)
    yield from sorted(found, key=lambda c: c.point.arc)


def _zero_at_critical(path: Follower, point: PathPoint, index: int, scale: float) -> float:
    """The eigenvalue number `index`, or for loads without a potential the determinant over exp(scale)."""
    if path.model.conservative:
        f, _ = path.spectrum.lowest(point.q, point.load_factor, index + 1, path.held_motions)
        return float(f[index])
    size = math.exp(min(point.log_determinant - scale, 0.0))
    return -size if point.negative else size


def _locate(path: Follower, index: int) -> PathPoint | None:
    """Point between the last two where the eigenvalue number `index` is zero (Illinois secant method)."""
    a, b = path.points[-2:]
    scale = max(a.log_determinant, b.log_determinant)
    x = [0.0, 1.0]
    f = [_zero_at_critical(path, point, index, scale) for point in (a, b)]
    if not f[0] * f[1] < 0.0:
        return None
    best, side = (a if abs(f[0]) < abs(f[1]) else b), 0
    for _ in range(MOST_LOOKS):
        if time.perf_counter() > path.deadline:
            return best
        share = x[0] + (x[1] - x[0]) * f[0] / (f[0] - f[1])
        point = path.between(share)
        if point is None:
            return best
        best = point
        here = _zero_at_critical(path, point, index, scale)
        replaced = 0 if here * f[0] > 0.0 else 1
        moved = abs(share - x[replaced])
        x[replaced], f[replaced] = share, here
        if moved < CLOSE or x[1] - x[0] < CLOSE or here == 0.0:
            break
        if side == replaced + 1:
            f[1 - replaced] *= 0.5
        side = replaced + 1
    return best


def _classified(path: Follower, point: PathPoint, index: int, high: int) -> tuple[CriticalPoint, set[int]]:
    """The critical point, and the numbers of the eigenvalues that are zero there together."""
    model = path.model
    if model.conservative:
        f, modes = path.spectrum.lowest(point.q, point.load_factor, high + 2, path.held_motions)
        scale = float(np.abs(f[-1]))
        alike = [i for i in range(len(f)) if abs(f[i] - f[index]) <= MULTIPLE * scale]
        left = modes = modes[:, alike].T
    else:
        alike = [index]
        modes = path.spectrum.nearest_zero(point.q, point.load_factor)[1][None]
        left = path.spectrum.nearest_zero(point.q, point.load_factor, left=True)[1][None]
    modes = np.array([m / np.sqrt(path.metric.inner(m, m)) for m in modes])
    Q_ext = model.residual(point.q, point.load_factor).Q_ext
    load = model.system.project(Q_ext) * model.unit
    full = path.spectrum.with_multipliers(point.q, point.load_factor, left) / model.unit
    size = np.linalg.norm(load) * np.linalg.norm(full, axis=1)
    work = np.abs(full @ load) / np.where(size > 0.0, size, 1.0)
    kind = "limit" if np.max(work) > LIMIT else "bifurcation"
    return CriticalPoint(kind, point, _aligned(path, modes)), set(alike)


def _aligned(path: Follower, modes: Floats) -> Floats:
    """Modes with a definite sign; of a pair (the rod may buckle any way) the first is along y of its base."""
    rods = path.model.rods
    sizes = [max(float(np.linalg.norm(rod.nodal(m)[:, 0])) for m in modes) for rod in rods]
    rod = rods[int(np.argmax(sizes))]
    motions = np.array([rod.nodal(m)[:, 0] for m in modes])  # (k, nodes, 3)
    node = int(np.argmax(np.sum(motions**2, axis=(0, 2))))
    y = motions[:, node] @ rod.rod.base.rotation[:, 1]
    if len(modes) == 2 and np.linalg.norm(y) > 0.0:
        c, s = y / np.linalg.norm(y)
        modes = np.array([[c, s], [-s, c]]) @ modes
        motions = np.tensordot(np.array([[c, s], [-s, c]]), motions, 1)
    flat = (motions @ rod.rod.base.rotation).reshape(len(modes), -1)
    largest = flat[np.arange(len(modes)), np.argmax(np.abs(flat), axis=1)]
    return modes * np.where(largest < 0.0, -1.0, 1.0)[:, None]


def turn_off(path: Follower, critical: CriticalPoint) -> Follower | None:
    """The branch that leaves the path along the first mode of a bifurcation; None where it is not found.

    Other modes that are soft there are held, so that one of the solutions that differ by them is followed.
    """
    held = Held(critical.modes[1:], critical.point.q) if len(critical.modes) > 1 else None
    for size in TURN_OFF:
        branch = Follower(path.metric, path.spectrum, path.deadline, held)
        branch.begin(replace(critical.point, tangent=(critical.modes[0], 0.0)))
        found = branch.enter(size)
        path.history += branch.history
        if found is not None:
            branch.history = []
            return branch
    return None
