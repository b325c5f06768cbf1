r"""The chain of rod_start.py in a plane: one angle a node, and a tridiagonal symmetric matrix.

With the angles a_i of the tangents at the nodes an interval carries the moment C ((a_i+1 - a_i)/h - k_0) and
has the chord c = h sinc(b/2) (cos, sin) of the mean angle, b their difference. A spin w in its middle changes
c x n by -(c . n) w, that at a node the couple of a lever a by -(a . F) w. Steps, shifts and the end are those
in space.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from ancf.rod_start import Chain, NodalLoads
from ancf.rotation import exp
from ancf.scene_plane import Plane

Floats = NDArray[np.float64]

_gtsv, _ptsv = get_lapack_funcs(("gtsv", "ptsv"), dtype=np.float64)


def in_plane(chain: Chain, loads: NodalLoads, plane: Plane) -> tuple[PlanarChain, NodalLoads]:
    """A chain that turns about the normal of a plane only, and its loads by the axes of the plane."""
    axes = plane.axes
    turned = NodalLoads(
        loads.force @ axes,
        loads.moment @ axes,
        loads.turning_force @ axes,
        loads.turning_moment @ axes,
        [(node, arm @ axes, force @ axes) for node, arm, force in loads.levers],
    )
    return PlanarChain(
        **{field.name: getattr(chain, field.name) for field in fields(chain)}, plane=plane
    ), turned


@dataclass(frozen=True)
class PlanarChain(Chain):
    """A chain in a plane, with angles (m + 1,) in the place of frames and loads by the axes of the plane."""

    plane: Plane

    @cached_property
    def _normal(self) -> Floats:
        """The normal in section axes (3,)."""
        return self.plane.normal @ self.R_0[0]

    @cached_property
    def _stiffness(self) -> Floats:
        """Bending stiffness in the plane (m,)."""
        return self.C @ self._normal @ self._normal

    @cached_property
    def _angles_0(self) -> Floats:
        return self._state(self.R_0)

    def _state(self, frames: Floats) -> Floats:
        """See `Chain._state`: the angles of the tangents."""
        along = frames[:, :, 0] @ self.plane.axes
        return np.unwrap(np.arctan2(along[:, 1], along[:, 0]))

    def _frames(self, state: Floats) -> Floats:
        """See `Chain._frames`."""
        return exp((state - self._angles_0)[:, None] * self.plane.normal) @ self.R_0

    def _turned(self, state: Floats, w: Floats) -> Floats:
        """See `Chain._turned`."""
        return state + w[:, 0]

    def _rotated(self, vectors: Floats, R: Floats) -> Floats:
        """Vectors (m + 1, 3) that turn with the sections, the components in the plane (m + 1, 2)."""
        turn = R - self._angles_0
        cosine, sine = np.cos(turn), np.sin(turn)
        x, y = vectors[:, 0], vectors[:, 1]
        return np.column_stack([cosine * x - sine * y, sine * x + cosine * y])

    def _residual(self, R: Floats, loads: NodalLoads) -> tuple[Floats, tuple[Floats, ...]]:
        """See `Chain._residual`; unbalanced moments (m + 1, 1), chords and forces (m, 2)."""
        theta = np.diff(R)
        middle = 0.5 * (R[:-1] + R[1:])
        m = self._stiffness * (theta / self.h - self.k_0 @ self._normal)
        chord = (self.h * np.sinc(theta / (2.0 * np.pi)))[:, None]
        chord = chord * np.column_stack([np.cos(middle), np.sin(middle)])
        force = loads.force[:, :2]
        if np.any(loads.turning_force):
            force = force + self._rotated(loads.turning_force, R)
        n = self._interval_forces(force)
        g = loads.moment[:, 2] + loads.turning_moment[:, 2]
        for node, lever, F in self._levers(R, loads):
            g[node] += lever[0] * F[1] - lever[1] * F[0]
        couple = 0.5 * (chord[:, 0] * n[:, 1] - chord[:, 1] * n[:, 0])
        g[:-1] += m + couple
        g[1:] += couple - m
        g[self.held] = 0.0
        return g[:, None], (middle, m, chord, n)

    def _levers(self, R: Floats, loads: NodalLoads) -> list[tuple[int, Floats, Floats]]:
        """Node, lever arm (2,) where it has turned to, and force of the dead forces off the axis."""
        turn = R - self._angles_0
        found = []
        for node, (x, y, _), F in loads.levers:
            cosine, sine = np.cos(turn[node]), np.sin(turn[node])
            found.append((node, np.array([cosine * x - sine * y, sine * x + cosine * y]), F))
        return found

    def _step(
        self, g: Floats, parts: tuple[Floats, ...], loads: NodalLoads, R: Floats, shift: float
    ) -> Floats | None:
        """See `Chain._step`; spins (m + 1, 1)."""
        _, _, chord, n = parts
        stiff = self._stiffness / self.h
        pull = 0.25 * np.sum(chord * n, axis=1)
        diagonal = np.full(len(g), shift)  # of minus the tangent
        diagonal[:-1] += stiff + pull
        diagonal[1:] += stiff + pull
        for node, arm, F in self._levers(R, loads):
            diagonal[node] += arm @ F[:2]
        beside = pull - stiff
        diagonal[self.held] = self.unit
        beside[max(self.held - 1, 0) : self.held + 1] = 0.0
        if loads.dead_forces_only:  # no step towards a saddle of the potential: fails unless it is convex
            _, _, w, info = _ptsv(diagonal, beside, g)
        else:
            *_, w, info = _gtsv(beside, diagonal, beside, g)
        return w if info == 0 else None
