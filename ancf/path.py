r"""Extrapolation of a path of equilibria in local measures (rod_shape.py), which change mildly along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R
from ancf.model import Model
from ancf.rod_shape import LocalShape, from_local, node_rotations, to_local
from ancf.rotation import exp, log

Floats = NDArray[np.float64]

# Largest change of a local measure [rad] in the difference quotient that turns dq into rates.
_RATE_ANGLE = 1e-5


class Path:
    """The last equilibria of a path by load factor or arc, for extrapolating the next start."""

    def __init__(self, model: Model, q: Floats, at: float = 0.0) -> None:
        self.model = model
        self.points: list[tuple[float, list[LocalShape], Floats]] = []
        self.add(at, q)

    def add(self, at: float, q: Floats) -> None:
        """Append an equilibrium; only the last four are kept."""
        local = [to_local(rod, rod.nodal(q)) for rod in self.model.rods]
        self.points = [*self.points[-3:], (at, local, q)]

    def take_back(self) -> None:
        """Forget the last equilibrium."""
        self.points.pop()

    def weights(self, at: float) -> list[float]:
        """Lagrange weights of the points kept."""
        known = np.array([point[0] for point in self.points[-3:]])
        return [
            float(np.prod([(at - b) / (a - b) for b in np.delete(known, i)])) for i, a in enumerate(known)
        ]

    def from_tangent(self, dq: Floats) -> Floats:
        """Start after the increment dq (n,) of the linear problem, taken in local measures."""
        _, now, q = self.points[-1]
        small = _RATE_ANGLE / max(float(np.max(np.abs(dq / self.model.unit))), _RATE_ANGLE)
        rates = [
            (to_local(rod, rod.nodal(q + small * dq)) + here * -1.0) * (1.0 / small)
            for rod, here in zip(self.model.rods, now, strict=True)
        ]
        shapes = [here + rate for here, rate in zip(now, rates, strict=True)]
        return self._rebuild(shapes, q + dq, q + small * dq, 1.0 / small)

    def extrapolate(self, at: float) -> Floats:
        """Start at a parameter by the polynomial through the last two or three equilibria."""
        weights, recent = self.weights(at), self.points[-3:]
        shapes = []
        for index in range(len(self.model.rods)):
            parts = [point[1][index] * w for point, w in zip(recent, weights, strict=True)]
            total = parts[0]
            for part in parts[1:]:
                total = total + part
            shapes.append(total)
        linear = sum((point[2] * w for point, w in zip(recent, weights, strict=True)), np.zeros(self.model.n))
        (before, _, other), (last, _, _) = self.points[-2:]
        return self._rebuild(shapes, linear, other, (at - last) / (before - last))

    def _rebuild(self, shapes: list[LocalShape], linear: Floats, other: Floats, share: float) -> Floats:
        """Rods with one orienting support are rebuilt from it; the others take the linear extrapolation.

        With joints: joint_path.py. Rotations go on from the last equilibrium by `share` of the way that leads
        to `other` (n,).
        """
        if self.model.scene.joints:
            return self._placed(shapes, linear, other, share)
        q = linear.copy()
        for rod, shape in zip(self.model.rods, shapes, strict=True):
            if rod.rod.clamp is None:
                continue
            node = rod.node_at(rod.rod.clamp.at)
            now = rod.nodal(self.points[-1][2])
            rotation = node_rotations(rod, now)[node]
            position = now[node, rod.element.vectors.index(R)]
            q[rod.first_dof : rod.first_dof + rod.size] = from_local(
                rod, shape, node, position, rotation
            ).ravel()
        return q

    def _placed(self, shapes: list[LocalShape], linear: Floats, other: Floats, share: float) -> Floats:
        from ancf.joint_path import placed

        turned = []
        for rod in self.model.rods:
            now = node_rotations(rod, rod.nodal(self.points[-1][2]))
            there = node_rotations(rod, rod.nodal(other))
            turned.append(exp(share * log(there @ np.swapaxes(now, -1, -2))) @ now)
        return placed(self.model, shapes, linear, turned)
