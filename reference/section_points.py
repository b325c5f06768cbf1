"""Shape functions of a section at any of its points: the inverse of the quadratic map of its quads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skfem import ElementQuad2

from reference.section_shapes import SectionShapes

Array = NDArray[np.float64]

INVERSIONS = 20  # Newton steps of the inverse map; 4 to 6 are needed inside a quad
OUTSIDE = 1e-6  # of a quad: a point this far beyond its edge still belongs to it


def shapes_at(shapes: SectionShapes, points: Array) -> tuple[NDArray[np.int64], Array, Array, Array]:
    """Quad (n,) of each point and its shape functions: value, slope along y and z (n, n_b).

    Parameters
    ----------
    shapes : SectionShapes
        The section.
    points : (n, 2)
        From the mean point, by the size of the section.

    Raises
    ------
    ValueError
        For a point outside the section.
    """
    nodes = shapes.mesh.doflocs.T[shapes.node_numbers()]  # (n_el, 9, 2)
    n, n_el = len(points), len(nodes)
    target = np.repeat(points[:, None], n_el, axis=1)
    xi: Array = np.full((n, n_el, 2), 0.5)
    for _ in range(INVERSIONS):  # every point in every quad: a few thousand 2 x 2 systems
        there, slope = _map(nodes, xi)
        step = np.linalg.solve(slope, (target - there)[..., None])[..., 0]
        xi = np.asarray(np.clip(xi + step, -0.5, 1.5), float)
    miss = np.linalg.norm(target - _map(nodes, xi)[0], axis=-1)
    beyond = np.max(np.abs(xi - 0.5), axis=-1) - 0.5
    beyond[miss > OUTSIDE] = np.inf
    quad = np.argmin(beyond, axis=1)
    lost = np.flatnonzero(beyond[np.arange(n), quad] > OUTSIDE)
    if lost.size:
        raise ValueError(f"point {lost[0]} of {n} lies outside the section; take points of the section.")
    X = xi[np.arange(n), quad].T
    tables = [shapes.element.lbasis(X, i) for i in range(shapes.elements.shape[1])]
    value = np.stack([np.broadcast_to(v, n) for v, _ in tables], axis=-1)
    local = np.stack([np.asarray(g) for _, g in tables], axis=-1)  # (2, n, n_b)
    inverse = np.linalg.inv(_map(nodes, xi)[1][np.arange(n), quad])
    slopes = np.einsum("nji,jnb->inb", inverse, local)
    signs = shapes.signs[quad]
    return quad, value * signs, slopes[0] * signs, slopes[1] * signs


def _map(nodes: Array, xi: Array) -> tuple[Array, Array]:
    """Images (n, n_el, 2) of local coordinates and their derivative (n, n_el, 2, 2), d(y, z)_i/dxi_j."""
    element, flat = ElementQuad2(), xi.reshape(-1, 2).T
    tables = [element.lbasis(flat, i) for i in range(9)]
    value = np.stack([np.asarray(v).reshape(xi.shape[:2]) for v, _ in tables], axis=-1)
    slope = np.stack([np.asarray(g).reshape(2, *xi.shape[:2]) for _, g in tables], axis=-1)
    return np.einsum("neb,ebi->nei", value, nodes), np.einsum("jneb,ebi->neij", slope, nodes)
