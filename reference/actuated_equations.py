r"""Equations of a straight rod with wires, fields, springs and beds, dimensionless and in body axes.

With the total force N and moment M that a cut through rod, wires and chambers carries, in space,

    r' = R v,   R' = R hat(u),   N' = -f(s, r, R),   M' = -r' x N - l(s, R),   N = M = 0 beyond the tip,

and in section axes the rod itself carries what the wires leave it (Rucker, Webster, IEEE Trans. Robotics 27
(2011) 1033, eq. 1-4, 13-24; a chamber pulls with -p A along e_x):

    n(v, u) = R^T N - sum T_i t_i,   m(v, u) = R^T M - sum p_i x T_i t_i,   t_i ~ v + u x p_i + p_i'.

The strains follow by a fixed point, which contracts with T/(E A). Forces, couples and springs on a section
jump N and M at a node. Units L, EI/L^2, EI/L.

Symbols
-------
y         state (r, q, N, M), q the quaternion of R, 13 numbers
s         fraction of the length
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference import rotation as rot
from reference.rod import RodProperties
from reference.rod_actions import PointAction, RodActions
from reference.round_law import RoundLaw

Array = NDArray[np.float64]

LONGEST = 1.0 / 16.0  # segment between two nodes
ROUNDS = 60  # of the fixed point, at most
SETTLED = 1e-13
R_, Q_, N_, M_ = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
E_X = np.array([1.0, 0.0, 0.0])


class ActuatedEquations:
    """Nodes, what acts between them (`rate`) and on them (`before`), for some copies of a state at once."""

    def __init__(self, rod: RodProperties, actions: RodActions, law: RoundLaw) -> None:
        L, EI = rod.length, max(rod.EI_y, rod.EI_z)
        turn = np.asarray(rod.base_rotation, dtype=float)

        def into(value: ArrayLike, unit: float) -> Array:
            return turn.T @ np.asarray(value, dtype=float) / unit

        self.K_n = np.array([rod.EA, rod.GA_y, rod.GA_z]) * L**2 / EI
        self.K_m = np.array([rod.GJ, rod.EI_y, rod.EI_z]) / EI
        self.law = law.scaled(rod.EA * L**2 / EI, 4.0 * EI / rod.EA / L**2)  # R^2 = 4 I/A of a circle
        self.line = [into(actions.line_force, EI / L**3), into(actions.follower_line_force, EI / L**3)]
        self.couples = [into(actions.line_moment, EI / L**2), into(actions.follower_line_moment, EI / L**2)]
        self.magnets = [(np.asarray(p, float) * L**2 / EI, into(field, 1.0)) for p, field in actions.magnets]
        self.nodes = self._nodes(actions)
        self.h = np.diff(self.nodes)
        middles = self.nodes[:-1] + 0.5 * self.h
        self.bed = np.zeros((len(middles), 3, 3))
        for bed in actions.beds:
            k = turn.T @ np.asarray(bed.stiffness, float) @ turn * L**4 / EI
            self.bed[(middles > bed.start) & (middles < bed.end)] += k
        self._wires(actions, middles, L, EI / L**2)
        self.points = [
            (int(np.argmin(np.abs(self.nodes - point.at))), self._scaled(point, into, turn, L, EI))
            for point in actions.points
        ]

    def _nodes(self, actions: RodActions) -> Array:
        """Ends of segments: every place where something begins, ends or bends, and as many between."""
        places = {0.0, 1.0, *(point.at for point in actions.points)}
        places |= {end for bed in actions.beds for end in (bed.start, bed.end)}
        places |= {float(at) for wire in actions.wires for at in np.asarray(wire.path, float)[:, 0]}
        corners = np.unique(np.round(sorted(places), 12))
        parts = [
            np.linspace(a, b, int(np.ceil((b - a) / LONGEST - 1e-9)) + 1)[:-1] for a, b in pairwise(corners)
        ]
        return np.concatenate([*parts, [1.0]])

    def _wires(self, actions: RodActions, middles: Array, L: float, unit: float) -> None:
        """Pull (segments, wires), place and slope (segments, wires, 3) at the middle of each segment."""
        shape = (len(middles), len(actions.wires))
        self.pull, self.place, self.slope = np.zeros(shape), np.zeros((*shape, 3)), np.zeros((*shape, 3))
        self.middles = middles
        self.normal = np.array([wire.normal for wire in actions.wires], dtype=bool)
        for k, wire in enumerate(actions.wires):
            path = np.asarray(wire.path, float) / [1.0, L, L]
            inside = (middles > path[0, 0]) & (middles < path[-1, 0])
            piece = np.clip(np.searchsorted(path[:, 0], middles) - 1, 0, len(path) - 2)
            slopes = np.diff(path[:, 1:], axis=0) / np.diff(path[:, 0])[:, None]
            # A chamber grows by 1 - 2 nu of what it is stretched by.
            share = 1.0 - 2.0 * self.law.poisson_ratio if wire.normal else 1.0
            self.pull[:, k] = inside * share * wire.pull / unit
            self.slope[:, k, 1:] = slopes[piece]
            self.place[:, k, 1:] = path[piece, 1:] + (middles - path[piece, 0])[:, None] * slopes[piece]

    @staticmethod
    def _scaled(
        point: PointAction, into: Callable[[ArrayLike, float], Array], turn: Array, L: float, EI: float
    ) -> dict[str, Array]:
        return {
            "place": np.array([0.0, *np.asarray(point.offset, float)]) / L,
            "at": np.array(point.at),
            "force": into(point.force, EI / L**2),
            "follower_force": into(point.follower_force, EI / L**2),
            "moment": into(point.moment, EI / L),
            "follower_moment": into(point.follower_moment, EI / L),
            "spring": turn.T @ np.asarray(point.spring, float) @ turn * L**3 / EI,
        }

    def _strains(self, n: Array, m: Array, s: Array, share: float) -> tuple[Array, Array]:
        """v and u (segments, copies, 3) of the rod where the cut carries n and m in section axes."""
        pull = share * self.pull[:, None]  # (segments, 1, wires)
        place = (self.place + (s - self.middles)[:, None, None] * self.slope)[:, None]
        dp, moves = self.slope[:, None], self._moves(place)
        v, u = self.law.strains(n, m, self.K_n, self.K_m, E_X + np.zeros_like(n), np.zeros_like(m))
        for _ in range(ROUNDS if pull.shape[-1] else 0):
            w = u[..., None, :]
            strain = np.stack([v[..., 0] - 1.0, u[..., 1], u[..., 2]], axis=-1)
            p = place + np.einsum("...k,...wki->...wi", strain, moves)
            t = v[..., None, :] + rot.cross(w, p) + dp
            t = t / np.sqrt(np.sum(t * t, axis=-1, keepdims=True))
            t = pull[..., None] * np.where(self.normal[:, None], E_X, t)
            # What the wire does on the section's own contraction: t.(u x dp/d(e, u_y, u_z)).
            own = np.einsum("...wi,...wki->...k", rot.cross(t, w), moves)
            left_n = n - t.sum(axis=-2) - own[..., :1] * E_X
            left_m = m - rot.cross(p, t).sum(axis=-2) - own * [0.0, 1.0, 1.0]
            new_v, new_u = self.law.strains(left_n, left_m, self.K_n, self.K_m, v, u)
            change = max(float(np.abs(new_v - v).max()), float(np.abs(new_u - u).max()))
            v, u = new_v, new_u
            if change < SETTLED:
                break
        return v, u

    def _moves(self, place: Array) -> Array:
        """What e, u_y and u_z move a wire by in the section (..., wires, 3, 3): Saint-Venant's lateral field.

        v = -nu e y + nu u_z (y^2 - z^2)/2 - nu u_y y z,  w = -nu e z + nu u_z y z + nu u_y (y^2 - z^2)/2.
        """
        y, z = place[..., 1], place[..., 2]
        half, zero = 0.5 * (y * y - z * z), np.zeros_like(y)
        rows = [[zero, -y, -z], [zero, -y * z, half], [zero, half, y * z]]
        nu = np.where(self.normal, 0.0, self.law.poisson_ratio)
        return nu[:, None, None] * np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    def rate(self, s: Array, y: Array, share: float) -> Array:
        """y' (segments, copies, 13) at the places s (segments,)."""
        R = rot.matrix(y[..., Q_])
        N, M, q = y[..., N_], y[..., M_], y[..., Q_]

        def into(a: Array) -> Array:
            return np.einsum("...ji,...j->...i", R, a)

        def out(a: Array) -> Array:
            return np.einsum("...ij,...j->...i", R, a)

        v, u = self._strains(into(N), into(M), s, share)
        dr = out(v)
        place = s[:, None, None] * E_X
        f = share * (self.line[0] + out(self.line[1])) - np.einsum(
            "sij,scj->sci", self.bed, y[..., R_] - place
        )
        couple = share * (self.couples[0] + out(self.couples[1]))
        for p, field in self.magnets:
            couple = couple + share * rot.cross(out(p), field)
        w, x = q[..., :1], q[..., 1:]
        dq = 0.5 * np.concatenate([-np.sum(x * u, axis=-1, keepdims=True), w * u + rot.cross(x, u)], axis=-1)
        return np.concatenate([dr, dq, -f, -rot.cross(dr, N) - couple], axis=-1)

    def before(self, y: Array, share: float) -> Array:
        """States before what acts on the nodes, from those behind it; y (nodes, copies, 13)."""
        y = y.copy()
        for node, a in self.points:
            R = rot.matrix(y[node, :, Q_])
            arm = R @ a["place"]
            moved = y[node, :, R_] + arm - (a["at"] * E_X + a["place"])
            force = share * (a["force"] + R @ a["follower_force"]) - moved @ a["spring"].T
            y[node, :, N_] += force
            y[node, :, M_] += rot.cross(arm, force) + share * (a["moment"] + R @ a["follower_moment"])
        return y
