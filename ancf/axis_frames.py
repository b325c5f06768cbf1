r"""Section frames of a rod that has an axis and no section: parallel transport along the tangent.

A cable (r and r_x only) neither knows nor resists how its sections turn about its axis. What is shown as its
section is the frame that turns as little as the tangent allows: the base frame at the one clamp, or at x = 0
turned there by the smallest rotation onto the tangent, carried along the axis without spin about the tangent.
In the plane, and on straight axes, it is the only frame there is.

From point to point by two reflections (Wang, Juttler, Zheng, Liu, ACM Trans. Graph. 27 (2008) 2), which take
the tangent t_i exactly to t_i+1:

    f_i+1 = H_2 H_1 f_i,   H_1 across r_i+1 - r_i,   H_2 across t_i+1 - H_1 t_i,

with an error of fourth order in the distance of the points, here at the ends and Gauss points of elements.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R_X, R
from ancf.quadrature import gauss
from ancf.rotation import hat
from ancf.scene import SAME_PLACE

if TYPE_CHECKING:
    from ancf.rod_model import RodModel

Floats = NDArray[np.float64]

INNER_POINTS = 2  # between the ends of an element, besides the points asked for
OPPOSITE = 1e-9  # 1 + cosine below which two directions are opposite and any axis across them serves


def smallest_rotation(a: Floats, b: Floats, across: Floats) -> Floats:
    """The rotation (3, 3) by the smallest angle from unit vector a to b; about `across` where b = -a."""
    cosine = float(a @ b)
    if 1.0 + cosine < OPPOSITE:
        return 2.0 * np.outer(across, across) - np.eye(3)
    skew = hat(np.cross(a, b))
    return np.eye(3) + skew + skew @ skew / (1.0 + cosine)


def steps(r: Floats, t: Floats) -> Floats:
    """Rotations (n - 1, 3, 3) of the transported frame between neighbours, of points r and unit tangents t
    (n, 3).
    """
    first = _reflections(np.diff(r, axis=0))
    turned = np.einsum("nij,nj->ni", first, t[:-1])
    return _reflections(t[1:] - turned) @ first


def _reflections(normal: Floats) -> Floats:
    """Reflections (n, 3, 3) across the planes with these normals (n, 3); none where the normal is zero."""
    square = np.sum(normal**2, axis=-1)[:, None, None]
    outer = normal[:, :, None] * normal[:, None, :]
    return np.eye(3) - 2.0 * outer / np.where(square > 0.0, square, 1.0)


def rotations(rod: RodModel, q: Floats, xi: Floats) -> tuple[Floats, Floats]:
    """Rotations against the reference at the nodes (n_nodes, 3, 3) and at xi of each element.

    Parameters
    ----------
    q : nodal vectors (n_nodes, vectors, 3)
    xi : places (p,) on every element, from -1 to less than 1

    Returns
    -------
    At the nodes, which are the ends of the elements, and (n_el, p, 3, 3).
    """
    inner, _ = gauss(INNER_POINTS)
    grid, where = np.unique(np.concatenate([[-1.0], inner, xi]), return_inverse=True)
    e = q[rod.mesh.nodes_of].reshape(len(rod.mesh.nodes_of), -1, 3)
    last = q[-1, [rod.element.vectors.index(order) for order in (R, R_X)]]
    r, r_x = (
        np.concatenate([np.einsum("epn,enc->epc", N, e).reshape(-1, 3), end[None]])
        for N, end in zip(_axis_shape(rod, grid), last, strict=True)
    )
    turn = steps(r, r_x / np.linalg.norm(r_x, axis=-1, keepdims=True))
    count, A_o = len(grid), rod.rod.base.rotation
    held = 0 if rod.rod.clamp is None else rod.node_at(rod.rod.clamp.at) * count
    rotation = np.empty((len(r), 3, 3))
    rotation[held] = smallest_rotation(A_o[:, 0], r_x[held] / np.linalg.norm(r_x[held]), A_o[:, 2])
    for i in range(held, len(turn)):
        rotation[i + 1] = turn[i] @ rotation[i]
    for i in range(held, 0, -1):
        rotation[i - 1] = turn[i - 1].T @ rotation[i]
    inside = rotation[:-1].reshape(-1, count, 3, 3)[:, where[1 + INNER_POINTS :]]
    return rotation[::count], inside


def node_rotations(rod: RodModel, q: Floats) -> Floats:
    """Rotations (n_nodes, 3, 3) against the reference at the nodes of q (n_nodes, vectors, 3)."""
    return rotations(rod, q, np.empty(0))[0]


def rotation_at(rod: RodModel, q: Floats, at: float) -> Floats:
    """Rotation (3, 3) against the reference at a fraction of the length of q (n_nodes, vectors, 3)."""
    x = at * rod.rod.length
    node = rod.node_at(at)
    if abs(rod.mesh.node_x[node] - x) <= SAME_PLACE * rod.rod.length:
        return node_rotations(rod, q)[node]
    index = int(np.searchsorted(rod.mesh.breaks, x)) - 1
    xi = 2.0 * (x - rod.mesh.breaks[index]) / rod.mesh.h[index] - 1.0
    return rotations(rod, q, np.array([xi]))[1][index, 0]


def _axis_shape(rod: RodModel, xi: Floats) -> tuple[Floats, Floats]:
    """Shape functions of r and r_x (n_el, p, nodal vectors) at xi of every element."""
    first, kind = rod.element_kinds
    N, N_x = (
        np.array([rod.element.shape(xi, float(rod.mesh.h[i]), derivative)[:, 0] for i in first])[kind]
        for derivative in (0, 1)
    )
    return N, N_x
