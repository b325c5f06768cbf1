"""Equilibrium path of an arch by its arc length, with limit points, snap-back and crossings of other paths.

Symbols
-------
z, t    unknowns of `ArchEquations` and the unit tangent of the path, J t = 0
F, J    residual of the equilibrium and its derivative by z, one row less than columns
W       diagonal of the norm, |z|^2 = z.W z
P, w    load and displacement of the loaded point along it
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arch import Arch, ArchEquations
from reference.root import bracketed_root

Array = NDArray[np.float64]

NODES = (24, 36, 54)  # Chebyshev intervals of a part; the second is the answer unless it misses AGREED
AGREED = 1e-9  # relative difference of two meshes
MOST_ITERATIONS = 10
CONVERGED = 1e-8  # a Newton step this small, relative to 1 + |z|; the next would be at rounding
SMALLEST_STEP, FIRST_STEP, LARGEST_STEP = 1e-6, 0.01, 0.2  # arc length, in rad of theta
LARGEST_TURN = 0.15  # rad between two tangents: no pair of limit points is stepped over
MOST_POINTS = 2000


class PathLost(RuntimeError):
    """The path could not be followed further; the message says where."""


@dataclass(frozen=True, eq=False)
class PathPoint:
    """A state of the path: load P [N], displacement w [m] of the loaded point along P.

    `z`, `tangent`: unknowns and direction of the path. `crossing`: det [J; W t], of one scale and sign along
    the path, zero where another path crosses.
    """

    load: float
    displacement: float
    z: Array
    tangent: Array
    crossing: float


@dataclass(frozen=True)
class CriticalPoint:
    """A point of a path where something turns.

    kind: "load maximum", "load minimum" (limit points), "displacement maximum", "displacement minimum" (the
    loaded point turns back: snap-back between the two), "bifurcation" (another path crosses). load [N],
    displacement [m]; error: difference of two meshes, relative to the largest load or displacement so far.
    """

    kind: str
    load: float
    displacement: float
    error: float


class ArchPath:
    """Equilibrium path from the unloaded arch until `stop(load, displacement)`, [N] and [m].

    Predictor along the tangent, Newton in the plane normal to it (Riks 1979; Keller 1977). A symmetric arch
    keeps to its symmetric path, steps being taken among symmetric states: those equations stay regular where
    an unsymmetric path crosses.
    """

    def __init__(self, arch: Arch, intervals: int, stop: Callable[[float, float], bool]) -> None:
        self.arch = arch
        self.equations = ArchEquations(arch, intervals)
        self.W = self.equations.weight()
        self.unit_load = arch.EI / arch.length**2
        self._log_scale: float | None = None
        self.symmetric = self.equations.symmetric_states() if arch.symmetric else None
        z = self.equations.unstressed()
        up = np.zeros_like(z)
        up[-1] = 1.0
        self.points = [self._point(z, up)]
        self._follow(stop)

    def _bordered(self, z: Array, row: Array) -> tuple[Array, Array]:
        F, J = self.equations(z)
        return F, np.vstack([J, row * self.W])

    def _point(self, z: Array, along: Array) -> PathPoint:
        """State at z with the unit tangent that goes the way of `along`."""
        _, matrix = self._bordered(z, along)
        right = np.zeros_like(z)
        right[-1] = 1.0
        t = self._solve(matrix, right)
        t /= np.sqrt(t @ (self.W * t))
        sign, log = np.linalg.slogdet(self._bordered(z, t)[1])
        if self._log_scale is None:
            self._log_scale = float(log)
        return PathPoint(
            load=float(z[-1]) * self.unit_load,
            displacement=self.equations.displacement(z) * self.arch.length,
            z=z,
            tangent=t,
            crossing=float(sign * np.exp(log - self._log_scale)),
        )

    def _solve(self, matrix: Array, right: Array) -> Array:
        B = self.symmetric
        if B is None:
            return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
        # More rows than unknowns, but consistent: the mirrored rows say the same.
        return np.asarray(B @ np.linalg.lstsq(matrix @ B, right, rcond=None)[0], dtype=np.float64)

    def at(self, start: PathPoint, distance: float, guess: Array | None = None) -> PathPoint | None:
        """Point of the path in the plane t.W (z - z_start) = distance, None if Newton fails."""
        z = start.z + distance * start.tangent if guess is None else guess
        for _ in range(MOST_ITERATIONS):
            F, matrix = self._bordered(z, start.tangent)
            gap = start.tangent @ (self.W * (z - start.z)) - distance
            try:
                step = self._solve(matrix, -np.append(F, gap))
            except np.linalg.LinAlgError:
                return None
            z = z + step
            size, whole = (float(np.sqrt(v @ (self.W * v))) for v in (step, z))
            if not np.isfinite(size):
                return None
            if size < CONVERGED * (1 + whole):
                return self._point(z, start.tangent)
        return None

    def _follow(self, stop: Callable[[float, float], bool]) -> None:
        step = FIRST_STEP
        while not stop(self.points[-1].load, self.points[-1].displacement):
            last = self.points[-1]
            if step < SMALLEST_STEP or len(self.points) > MOST_POINTS:
                raise PathLost(
                    f"the path ends at load {last.load:.6g} N, displacement {last.displacement:.6g} m, after "
                    f"{len(self.points)} points with step {step:.1e}"
                )
            new = self.at(last, step)
            turn = np.inf if new is None else np.arccos(min(1.0, last.tangent @ (self.W * new.tangent)))
            if new is None or turn > LARGEST_TURN:
                step /= 2
                continue
            self.points.append(new)
            step = min(LARGEST_STEP, step * float(np.clip(0.6 * LARGEST_TURN / max(turn, 1e-9), 0.5, 1.6)))

    def critical_points(self) -> list[CriticalPoint]:
        """Limit points, turning points of the displacement and crossings, in the order of the path."""
        measures: tuple[tuple[str, Callable[[PathPoint], float]], ...] = (
            ("load", lambda p: float(p.tangent[-1])),
            ("displacement", lambda p: float(self.equations.displacement_gradient(p.z) @ p.tangent)),
            ("bifurcation", lambda p: p.crossing),
        )
        found = []
        for before, after in zip(self.points, self.points[1:], strict=False):
            here = []
            for name, measure in measures:
                if measure(before) * measure(after) < 0:
                    suffix = (
                        "" if name == "bifurcation" else " maximum" if measure(before) > 0 else " minimum"
                    )
                    distance, point = self._zero(before, after, measure)
                    here.append((distance, CriticalPoint(name + suffix, point.load, point.displacement, 0.0)))
            found += [point for _, point in sorted(here, key=lambda pair: pair[0])]
        return found

    def loads(self, displacement: float) -> list[float]:
        """Loads [N] of all states of the path with this displacement [m] of the loaded point."""

        def gap(p: PathPoint) -> float:
            return p.displacement - displacement

        pairs = zip(self.points, self.points[1:], strict=False)
        return [self._zero(a, b, gap)[1].load for a, b in pairs if gap(a) * gap(b) < 0]

    def _zero(
        self, before: PathPoint, after: PathPoint, measure: Callable[[PathPoint], float]
    ) -> tuple[float, PathPoint]:
        """Distance from `before` and point where the measure vanishes."""
        whole = float(before.tangent @ (self.W * (after.z - before.z)))

        def point(distance: float) -> PathPoint:
            if distance in (0.0, whole):
                return after if distance else before
            part = distance / whole
            found = self.at(before, distance, before.z + part * (after.z - before.z))
            if found is None:
                raise PathLost(f"Newton failed between loads {before.load:.6g} N and {after.load:.6g} N")
            return found

        root = bracketed_root(lambda x: measure(point(x)), 0.0, whole, absolute=1e-11 * whole)
        return root, point(root)


def critical_points(arch: Arch, stop: Callable[[float, float], bool] | None = None) -> list[CriticalPoint]:
    """Limit points, snap-back and crossings on the path of an arch from zero load.

    Parameters
    ----------
    arch : Arch
    stop : (load [N], displacement [m]) -> whether the path ends; default: displacement twice the height of
        the unloaded arch under the load

    Returns
    -------
    list of CriticalPoint in the order of the path, their `error` from two meshes of collocation

    Raises
    ------
    PathLost when Newton fails at the smallest step, or no two meshes agree to 1e-6.

    Notes
    -----
    Collocation is spectral: 36 intervals a part give some 1e-11 of the limit load, in 0.3 to 1 s with one
    thread. Clamped arches of 0.3 to 1 rad, length/radius 100 to 250, snap through: one maximum and one
    minimum of the load, for slender ones with two crossings in between. Neither they nor clamped arches of 2
    to 4 rad snap back at the loaded point. With the right end pinned, 1 to 3 rad, they do: load maximum,
    displacement maximum, load minimum, and the same once more. Pinned at both ends the symmetric path winds
    up for ever (give a `stop`); it is crossed before its first maximum.
    """
    end = default_stop(arch) if stop is None else stop
    before: list[CriticalPoint] | None = None
    found: list[CriticalPoint] = []
    for intervals in NODES:
        found = ArchPath(arch, intervals, end).critical_points()
        if before is not None and [p.kind for p in before] == [p.kind for p in found]:
            loads = np.array([[p.load for p in points] for points in (before, found)])
            moves = np.array([[p.displacement for p in points] for points in (before, found)])
            errors = [np.abs(v[1] - v[0]) / np.abs(v).max(initial=1e-300) for v in (loads, moves)]
            error = np.maximum(*errors)
            if error.max(initial=0.0) < AGREED or (intervals == NODES[-1] and error.max() < 1e-6):
                return [
                    CriticalPoint(p.kind, p.load, p.displacement, float(e))
                    for p, e in zip(found, error, strict=True)
                ]
        before = found
    raise PathLost(f"{NODES[-1]} intervals do not agree with {NODES[-2]}: {[p.kind for p in found]}")


def default_stop(arch: Arch) -> Callable[[float, float], bool]:
    """Stop at a displacement of twice the height of the loaded point above the chord."""
    half, at = arch.opening / 2, arch.opening * (arch.load_at - 0.5)
    height = arch.length / arch.opening * (np.cos(at) - np.cos(half))
    return lambda load, displacement: displacement > 2 * height
