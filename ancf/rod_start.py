r"""Equilibrium of a Kirchhoff rod with one held section under any load: where Newton's iteration starts.

The rod is a chain of intervals between nodes with section frames R_i. An interval turns by
theta = Log(R_i^T R_i+1), carries the moment m = R C (theta/h - k_0) and has the chord c = R h sinc(b/2) e_x,
b the bending part of theta and R the frame in its middle. With one held section the force n in an interval is
known, the sum of the forces beyond it. Moments balance at every free node between intervals a and b:

    m_b - m_a + 1/2 (c_a x n_a + c_b x n_b) + M_i = 0        (m' + r' x n + mu = 0).

Newton on the spins w of the frames, R <- Exp(w) R, needs three unknowns a node; with w in the middle the mean
of both ends,

    dm = R (C/h) R^T (w_i+1 - w_i) + w x m,    d(c x n) = (c n^T - (c . n) I) w:

tridiagonal blocks. They hold for a small theta, and follower forces are taken as they stand: this is only a
start value, the residual of the elements decides. Axial stretch enters at the end, shear not at all.
(Antman, Nonlinear Problems of Elasticity, ch. 8.)

Symbols
-------
h, C, k_0    length (m,), stiffness (m, 3, 3) [N m2] and stress-free curvature (3,) [1/m] of the intervals
R            frames (m + 1, 3, 3), columns the section axes x, y, z in SCS
F, M         force and moment (m + 1, 3) on the nodes
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from ancf.elements import R_Y, R_Z
from ancf.hyperelastic import Law
from ancf.rod_model import RodModel
from ancf.rotation import exp, hat, log
from ancf.scene import Scene
from ancf.sections import Section

Floats = NDArray[np.float64]

_pbtrf, _gbsv = get_lapack_funcs(("pbtrf", "gbsv"), dtype=np.float64)

MAX_ITERATIONS = 100  # linear solves; five are usual, and one costs a tenth of one of the elements'
MOST_DOWNHILL = 300  # the same with a potential: every step succeeds, but leaving an unstable shape is slow
CLOSE = 1e-6  # of E I/L and of the first residual: a start needs no more
NOTHING = 1e-12  # of E I/L: a first residual of rounding errors
LARGEST_SPIN = 1.0  # rad by which one step may turn neighbours against each other
EASED = 0.25  # share of the shift that the next step keeps
BAND = 5  # half bandwidth of a tridiagonal matrix of 3 x 3 blocks


class Loads(Protocol):
    """What the iteration asks of loads; the rest is between them and the residual of their chain."""

    @property
    def dead_forces_only(self) -> bool:
        """Whether all loads are dead forces, which have a potential."""
        ...


@dataclass(frozen=True)
class NodalLoads:
    """Loads on the nodes of a chain (m + 1, 3): fixed in space, and turning with the sections.

    The latter are given in the reference. `levers`: node, lever arm in the reference (3,) and force (3,) of
    dead forces off the axis.
    """

    force: Floats
    moment: Floats
    turning_force: Floats
    turning_moment: Floats
    levers: list[tuple[int, Floats, Floats]]

    @property
    def forces(self) -> bool:
        """Whether any force acts."""
        return bool(np.any(self.force) or np.any(self.turning_force))

    @property
    def dead_forces_only(self) -> bool:
        """Whether all loads are dead forces, which have a potential."""
        return not any(load.any() for load in (self.moment, self.turning_force, self.turning_moment))


def nodal_loads(scene: Scene, rod: RodModel) -> NodalLoads:
    """Loads of a scene on the nodes of one rod, each on the nearest node."""
    x, name, vectors = rod.mesh.node_x, rod.rod.name, rod.element.vectors
    force, moment, turning_force, turning_moment = np.zeros((4, len(x), 3))
    levers = []
    for load in scene.moments:
        if load.rod == name:
            target = moment if load.direction == "fixed" else turning_moment
            target[rod.node_at(load.at)] += load.value
    for load in scene.forces:
        if load.rod != name:
            continue
        node = rod.node_at(load.at)
        arm = np.zeros(3)
        if np.any(load.offset):
            arm = load.offset @ rod.q0[node, [vectors.index(R_Y), vectors.index(R_Z)]]
        if load.direction == "follower":
            turning_force[node] += load.value
            turning_moment[node] += np.cross(arm, load.value)
        else:
            force[node] += load.value
            if np.any(arm):
                levers.append((node, arm, load.value))
    half = 0.5 * np.diff(x)
    for load in scene.line_loads:
        if load.rod == name:
            target = force if load.direction == "fixed" else turning_force
            target += _at_nodes(half) * load.value
    for load in scene.line_moments:
        if load.rod == name:
            target = moment if load.direction == "fixed" else turning_moment
            target += _at_nodes(half) * load.value
    if scene.gravity is not None:
        weight = half * between_nodes(rod, lambda section, law: (law.density or 0.0) * section.area)
        force += _at_nodes(weight) * scene.gravity.acceleration
    return NodalLoads(force, moment, turning_force, turning_moment, levers)


def _at_nodes(halves: Floats) -> Floats:
    """Sums (m + 1, 1) at the nodes of what the intervals (m,) give to each of their ends."""
    total = np.zeros((len(halves) + 1, 1))
    total[:-1, 0] = halves
    total[1:, 0] += halves
    return total


def between_nodes(rod: RodModel, value: Callable[[Section, Law], float]) -> Floats:
    """A value of section and material in the middle between neighbouring nodes (n_nodes - 1,)."""
    edges = np.array(rod.element.node_xi)
    first, kind = rod.element_kinds
    found = [
        [
            value(rod.section_in(index, float(xi)), rod.material_of(index))
            for xi in 0.5 * (edges[:-1] + edges[1:])
        ]
        for index in first
    ]
    return np.array(found)[kind].ravel()


@dataclass(frozen=True)
class Chain:
    """A rod as intervals between nodes, held at one of them; `unit` is E I/L [N m]."""

    h: Floats
    C: Floats
    k_0: Floats
    R_0: Floats  # reference frames
    held: int
    unit: float

    def equilibrium(
        self, loads: Loads, start: Floats, deadline: float = np.inf
    ) -> tuple[Floats, Floats] | None:
        """Frames (m + 1, 3, 3) and axial forces (m,) [N] by Newton from the frames `start`; None: none found.

        Steps go downhill: the tangent is shifted until a step does positive work, by the trapezoidal rule
        over its ends. Loads need no potential for that; a large shift is a step of the overdamped motion.
        """
        R, shift, raised = self._state(start), 0.0, False
        g, parts = self._residual(R, loads)
        first = self._size(g)
        # Relative to the load as well: on a column, the smallest push aside decides where it buckles.
        close = CLOSE * min(first, self.unit) if first > NOTHING * self.unit else first
        for _ in range(MOST_DOWNHILL if loads.dead_forces_only else MAX_ITERATIONS):
            if time.perf_counter() > deadline:
                return None
            if self._size(g) <= close:
                return self._frames(R), self._axial_forces(parts)
            w = self._step(g, parts, loads, R, shift)
            # The comparison is false for a step that is not finite.
            if w is not None and self._size(w[1:] - w[:-1]) <= LARGEST_SPIN:
                turned = self._turned(R, w)
                g_new, parts_new = self._residual(turned, loads)
                if np.sum((g + g_new) * w) > 0.0:
                    R, g, parts = turned, g_new, parts_new
                    if not raised:
                        shift = EASED * shift if shift > 0.1 * self.unit / len(g) else 0.0
                    raised = False
                    continue
            shift, raised = max(shift / EASED, self.unit / len(g)), True
        return None

    @staticmethod
    def _size(vectors: Floats) -> float:
        """Length of the longest vector."""
        return math.sqrt(np.max(np.einsum("...i,...i->...", vectors, vectors), initial=0.0))

    def _state(self, frames: Floats) -> Floats:
        """What the iteration turns: the frames themselves."""
        return frames

    def _frames(self, state: Floats) -> Floats:
        """The frames of what the iteration turns."""
        return state

    def _turned(self, state: Floats, w: Floats) -> Floats:
        """The state after spins w."""
        return exp(w) @ state

    def _residual(self, R: Floats, loads: Any) -> tuple[Floats, tuple[Floats, ...]]:
        """Unbalanced moments (m + 1, 3), and of the intervals: middle frames, moments, chords, forces."""
        theta = log(np.swapaxes(R[:-1], -1, -2) @ R[1:])
        middle = R[:-1] @ exp(0.5 * theta)
        m = np.einsum("nij,njk,nk->ni", middle, self.C, theta / self.h[:, None] - self.k_0)
        half_angle = 0.5 * np.hypot(theta[:, 1], theta[:, 2])
        chord = (self.h * np.sinc(half_angle / np.pi))[:, None] * middle[:, :, 0]
        Q = R @ np.swapaxes(self.R_0, -1, -2)
        n = self._interval_forces(loads.force + np.einsum("nij,nj->ni", Q, loads.turning_force))
        g = loads.moment + np.einsum("nij,nj->ni", Q, loads.turning_moment)
        for node, arm, force in loads.levers:
            g[node] += np.cross(Q[node] @ arm, force)
        couple = 0.5 * (hat(chord) @ n[..., None])[..., 0]
        g[:-1] += m + couple
        g[1:] += couple - m
        g[self.held] = 0.0
        return g, (middle, m, chord, n)

    def _axial_forces(self, parts: tuple[Floats, ...]) -> Floats:
        """Axial force (m,) in the intervals."""
        _, _, chord, n = parts
        return np.sum(chord * n, axis=1) / np.linalg.norm(chord, axis=1)

    def _interval_forces(self, force: Floats) -> Floats:
        """Force n (m, 3) by which the free side pulls on each interval, from nodal forces (m + 1, 3)."""
        beyond = np.cumsum(force[::-1], axis=0)[::-1][1:]
        before = np.cumsum(force, axis=0)[:-1]
        return np.where((np.arange(len(self.h)) < self.held)[:, None], -before, beyond)

    def _step(
        self,
        g: Floats,
        parts: tuple[Floats, ...],
        loads: Any,
        R: Floats,
        shift: float,
    ) -> Floats | None:
        """Spins (m + 1, 3) of one Newton step; None where no step goes downhill."""
        middle, m, chord, n = parts
        count = len(g)
        stiff = middle @ (self.C / self.h[:, None, None]) @ np.swapaxes(middle, -1, -2)
        turn = -0.5 * hat(m)  # d(m)/dw at either end, by the middle spin
        force = chord[:, :, None] * n[:, None, :] - np.sum(chord * n, axis=1)[:, None, None] * np.eye(3)
        blocks = np.zeros((3, count, 3, 3))  # couplings of a node to the one before, itself, the one after
        # Row i of interval (i, i+1) has + m, row i+1 has - m; both have half of c x n.
        blocks[1, :-1] += -stiff + turn + 0.25 * force
        blocks[2, :-1] += stiff + turn + 0.25 * force
        blocks[0, 1:] += stiff - turn + 0.25 * force
        blocks[1, 1:] += -stiff - turn + 0.25 * force
        Q = R @ np.swapaxes(self.R_0, -1, -2)
        blocks[1] -= hat(np.einsum("nij,nj->ni", Q, loads.turning_moment))
        for node, arm, F in loads.levers:
            a = Q[node] @ arm
            blocks[1, node] += np.outer(a, F) - (a @ F) * np.eye(3)
        blocks[1] -= shift * np.eye(3)
        blocks[:, self.held] = 0.0
        blocks[2, max(self.held - 1, 0)] *= self.held == 0
        blocks[0, min(self.held + 1, count - 1)] *= self.held == count - 1
        blocks[1, self.held] = -self.unit * np.eye(3)
        slots, inside = _slots(count)
        flat = np.zeros((3 * BAND + 1) * 3 * count)
        flat[slots] = blocks.ravel()[inside]
        banded = flat.reshape(3 * count, 3 * BAND + 1).T
        if loads.dead_forces_only:  # no step towards a saddle of the potential: fails unless it is convex
            _, info = _pbtrf(-banded[2 * BAND :], lower=1, overwrite_ab=1)
            if info != 0:
                return None
        _, _, w, info = _gbsv(BAND, BAND, banded, -g.ravel(), overwrite_ab=1, overwrite_b=1)
        return w.reshape(count, 3) if info == 0 else None


@lru_cache(maxsize=16)
def _slots(count: int) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Places in band storage of the blocks (3, count, 3, 3) beside and on the diagonal, and which exist."""
    row = 3 * np.arange(count)[:, None, None] + np.arange(3)[:, None]
    column = 3 * (np.arange(count) + np.arange(-1, 2)[:, None])[..., None, None] + np.arange(3)
    inside = np.broadcast_to((column >= 0) & (column < 3 * count), (3, count, 3, 3))
    place = column * (3 * BAND + 1) + 2 * BAND + row - column  # columns of LAPACK's ab, as in band.py
    return place[inside], inside.ravel()
