r"""The chain of rod_start.py in a plane: one angle a node, and a tridiagonal symmetric matrix.

Vectors in the plane are complex numbers by its axes. With the angles a_i of the tangents at the nodes, b
their difference and m their mean, an interval carries the moment C (b/h - k_0) and has the chord
c = h sinc(b/2) exp(i m). Of z = conj(c) n the imaginary part is the couple c x n, which a spin w in the
middle changes by -w times the real part; that of a force F at a node on a lever a likewise with conj(a) F.
Steps, shifts and the end are those in space.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from ancf.rod_start import Chain, NodalLoads
from ancf.rotation import hat
from ancf.scene_plane import Plane

Floats = NDArray[np.float64]
Vectors = NDArray[np.complex128]

_gtsv, _ptsv = get_lapack_funcs(("gtsv", "ptsv"), dtype=np.float64)


@dataclass(frozen=True)
class PlanarLoads:
    """Loads on the nodes of a planar chain (m + 1,); vectors in the plane are complex.

    Couples across the plane are the same fixed in space and turning. `levers` as in `NodalLoads`.
    """

    force: Vectors
    turning_force: Vectors
    couple: Floats
    levers: list[tuple[int, complex, complex]]
    dead_forces_only: bool

    @cached_property
    def turns(self) -> bool:
        """Whether forces turn with the sections."""
        return bool(self.turning_force.any())


def in_plane(chain: Chain, loads: NodalLoads, plane: Plane) -> tuple[PlanarChain, PlanarLoads]:
    """A chain that turns about the normal of a plane only, and its loads by the axes of the plane."""
    along = plane.axes[:, 0] + 1j * plane.axes[:, 1]
    found = PlanarLoads(
        loads.force @ along,
        loads.turning_force @ along,
        (loads.moment + loads.turning_moment) @ plane.normal,
        [(node, complex(arm @ along), complex(force @ along)) for node, arm, force in loads.levers],
        loads.dead_forces_only,
    )
    values = {field.name: getattr(chain, field.name) for field in fields(chain)}
    return PlanarChain(**values, plane=plane), found


@dataclass(frozen=True)
class PlanarChain(Chain):
    """A chain in a plane, with angles (m + 1,) in the place of frames, and spins (m + 1,)."""

    plane: Plane

    @cached_property
    def _normal(self) -> Floats:
        """The normal in section axes (3,)."""
        return self.plane.normal @ self.R_0[0]

    @cached_property
    def _stiffness(self) -> Floats:
        """Bending stiffness in the plane (m,) by length [N m]."""
        return self.C @ self._normal @ self._normal / self.h

    @cached_property
    def _moment_0(self) -> Floats:
        """Moment (m,) that the stress-free curvature takes off."""
        return self._stiffness * self.h * (self.k_0 @ self._normal)

    @cached_property
    def _angles_0(self) -> Floats:
        return self._angles(self.R_0)

    @cached_property
    def _beyond(self) -> Floats:
        """1 for intervals (m,) that are pulled by what is beyond them, 0 for those before the held node."""
        return (np.arange(len(self.h)) >= self.held).astype(float)

    def _state(self, frames: Floats) -> Floats:
        """See `Chain._state`: the angles of the tangents."""
        return self._angles_0 if frames is self.R_0 else self._angles(frames)

    def _angles(self, frames: Floats) -> Floats:
        tangents = frames[:, :, 0] @ (self.plane.axes[:, 0] + 1j * self.plane.axes[:, 1])
        turns = np.angle(tangents[1:] * tangents[:-1].conj())
        return np.angle(tangents[0]) + np.concatenate([[0.0], turns.cumsum()])

    def _frames(self, state: Floats) -> Floats:
        """See `Chain._frames`; Rodrigues' formula about one axis."""
        normal, turn = self.plane.normal, (state - self._angles_0)[:, None, None]
        along = np.outer(normal, normal)
        return (along + np.cos(turn) * (np.eye(3) - along) + np.sin(turn) * hat(normal)) @ self.R_0

    def _turned(self, state: Floats, w: Floats) -> Floats:
        """See `Chain._turned`."""
        return state + w

    @staticmethod
    def _size(vectors: Floats) -> float:
        """See `Chain._size`."""
        return float(np.abs(vectors).max(initial=0.0))

    def _residual(self, R: Floats, loads: PlanarLoads) -> tuple[Floats, tuple[Floats, ...]]:
        """See `Chain._residual`; unbalanced moments (m + 1,), chords, and z = conj(c) n."""
        theta = R[1:] - R[:-1]
        chord = self.h * np.sinc(theta / (2.0 * np.pi)) * np.exp(0.5j * (R[1:] + R[:-1]))
        force = loads.force
        if loads.turns:
            force = force + np.exp(1j * (R - self._angles_0)) * loads.turning_force
        before = force.cumsum()
        z = chord.conj() * (self._beyond * before[-1] - before[:-1])
        m, couple = self._stiffness * theta - self._moment_0, 0.5 * z.imag
        g = loads.couple.copy()
        for node, on_lever in self._on_levers(R, loads):
            g[node] += on_lever.imag
        g[:-1] += couple + m
        g[1:] += couple - m
        g[self.held] = 0.0
        return g, (m, chord, z)

    def _on_levers(self, R: Floats, loads: PlanarLoads) -> list[tuple[int, complex]]:
        """Node, and conj(a) F of the dead forces off the axis, their arms a turned with the sections."""
        turn = R - self._angles_0
        return [(node, complex((a * np.exp(1j * turn[node])).conjugate() * F)) for node, a, F in loads.levers]

    def _axial_forces(self, parts: tuple[Floats, ...]) -> Floats:
        """See `Chain._axial_forces`."""
        _, chord, z = parts
        return z.real / np.abs(chord)

    def _step(
        self, g: Floats, parts: tuple[Floats, ...], loads: PlanarLoads, R: Floats, shift: float
    ) -> Floats | None:
        """See `Chain._step`; spins (m + 1,)."""
        pull = 0.25 * parts[2].real
        stiff, beside = pull + self._stiffness, pull - self._stiffness
        diagonal = np.full(len(g), shift)  # of minus the tangent
        diagonal[:-1] += stiff
        diagonal[1:] += stiff
        for node, on_lever in self._on_levers(R, loads):
            diagonal[node] += on_lever.real
        diagonal[self.held] = self.unit
        beside[max(self.held - 1, 0) : self.held + 1] = 0.0
        if loads.dead_forces_only:  # no step towards a saddle of the potential: fails unless it is convex
            _, _, w, info = _ptsv(diagonal, beside, g)
        else:
            *_, w, info = _gtsv(beside, diagonal, beside, g)
        return w if info == 0 else None
