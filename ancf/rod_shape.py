r"""A rod's configuration as local measures between nodes, and back, for mild extrapolation.

Between neighbouring nodes i and i+1 with section rotations R_i (relative to the reference):

    theta_i = Log(R_i^T R_{i+1}),   c_i = (R_i Exp(theta_i / 2))^T (r_{i+1} - r_i),   u_i = R_i^T d_i,

d_i the nodal vectors.

Absolute positions and slopes change like cos and sin of the load; these measures change nearly linearly,
because bending moment and curvature are proportional. Extrapolating them and rebuilding the shape from a
clamp never stretches the rod, which linear extrapolation of coordinates does at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf import axis_frames
from ancf.elements import R
from ancf.rod_model import RodModel
from ancf.rotation import exp, log, section_rotation

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LocalShape:
    """Local measures of one rod; supports addition and scaling as a vector."""

    theta: Floats  # (n_nodes - 1, 3) rad
    chord: Floats  # (n_nodes - 1, 3) m
    vectors: Floats  # (n_nodes, vectors, 3), row of r unused

    def __add__(self, other: LocalShape) -> LocalShape:
        return LocalShape(self.theta + other.theta, self.chord + other.chord, self.vectors + other.vectors)

    def __mul__(self, factor: float) -> LocalShape:
        return LocalShape(self.theta * factor, self.chord * factor, self.vectors * factor)


def node_rotations(model: RodModel, q: Floats) -> Floats:
    """Section rotations (n_nodes, 3, 3) relative to the reference at the nodes of q (n_nodes, vectors, 3).

    Of a cable those of its transported frames.
    """
    element = model.element
    if not element.has_section:
        return axis_frames.node_rotations(model, q)
    columns = [element.vectors.index((0, j, k)) for j, k in element.directors]
    return section_rotation(q[:, columns], model.node_weights).R


def to_local(model: RodModel, q: Floats) -> LocalShape:
    """Local measures of the configuration q (n_nodes, vectors, 3)."""
    rotation = node_rotations(model, q)
    theta = log(np.swapaxes(rotation[:-1], -1, -2) @ rotation[1:])
    middle = rotation[:-1] @ exp(0.5 * theta)
    r = q[:, model.element.vectors.index(R)]
    chord = np.einsum("nji,nj->ni", middle, np.diff(r, axis=0))
    vectors = np.einsum("nji,nvj->nvi", rotation, q)
    vectors[:, model.element.vectors.index(R)] = 0.0
    return LocalShape(theta, chord, vectors)


def from_local(model: RodModel, shape: LocalShape, node: int, position: Floats, rotation: Floats) -> Floats:
    """Configuration (n_nodes, vectors, 3) with the given measures, held at one node (position, rotation)."""
    relative = exp(shape.theta)
    rotations = np.empty((len(shape.vectors), 3, 3))
    rotations[node] = rotation
    for i in range(node, len(relative)):
        rotations[i + 1] = rotations[i] @ relative[i]
    for i in range(node, 0, -1):
        rotations[i - 1] = rotations[i] @ relative[i - 1].T
    middle = rotations[:-1] @ exp(0.5 * shape.theta)
    r = np.concatenate([np.zeros((1, 3)), np.cumsum(np.einsum("nij,nj->ni", middle, shape.chord), axis=0)])
    q = np.einsum("nij,nvj->nvi", rotations, shape.vectors)
    q[:, model.element.vectors.index(R)] = r - r[node] + position
    return q
