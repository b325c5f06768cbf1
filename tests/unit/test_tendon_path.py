"""The path of a tendon: places, tangents, weights and pieces, against the sections that it runs through."""

from itertools import pairwise

import numpy as np
import pytest

import ancf
from ancf.model import Model
from ancf.quadrature import gauss
from ancf.tendon_path import TendonPath

L, R = 0.5, 0.01
# Ends and kinks inside elements and, at 0.4, on an element boundary; both offsets change, by unlike slopes.
POINTS = np.array([[0.07, 0.4, -0.1], [0.33, -0.2, 0.6], [0.4, 0.1, -0.5], [0.93, 0.5, 0.2]]) * [1, R, R]
ELEMENTS = ["3333", "3243", "3343", "3363"]


def bent(element="3333", points=POINTS, **keys):
    """A path and the nodal vectors of its pieces at a random state of a curved rod of 5 elements."""
    rod = {
        "length": L, "elements": 5, "element": element, "section": {"shape": "circle", "radius": R},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3}, "curvature": [0.4, 1.0, -0.7], **keys,
    }  # fmt: skip
    model = Model(ancf.scene_from_dict({"rod": [rod]}))
    q = model.q0 + 0.02 * np.random.default_rng(2).uniform(-1, 1, model.n) * model.unit
    path = TendonPath(model.rods[0], points)
    return model.rods[0], path, q, q[path.dofs].reshape(len(path.dofs), -1, 3)


def place(rod, q, points, x):
    """c(x) (3,): the point (y, z) of the path on the section at x, by the section's own vectors."""
    y, z = (np.interp([x], points[:, 0] * L, points[:, k]) for k in (1, 2))
    point = rod.section_point(x / L)
    phi, _, _ = rod.element.section_monomials(y, z)
    return phi[0] @ point.N @ q[point.dofs].reshape(-1, 3)


def marks(rod, points):
    """Where pieces begin and end [m]: points of the path, and element boundaries between its ends."""
    corners = points[:, 0] * L
    inside = rod.mesh.breaks[(rod.mesh.breaks > corners[0]) & (rod.mesh.breaks < corners[-1])]
    return np.unique(np.round(np.concatenate([corners, inside]), 12))


@pytest.mark.parametrize("element", ELEMENTS)
def test_tangents_are_slopes_of_places(element):
    """c' at the integration points and at both ends of each piece, by differences of the places (order 2)."""
    rod, path, q, e = bent(element)
    cuts, step = marks(rod, POINTS), 1e-6 * L
    xi, _ = gauss(rod.axial_points)
    assert len(path.a) == len(cuts) - 1 == 6 and path.a.shape[1] == rod.axial_points
    t, stretch = path.tangents(e)
    for piece, (a, b) in enumerate(pairwise(cuts)):
        for k, x in enumerate(0.5 * (a + b) + 0.5 * (b - a) * xi):
            ends = [place(rod, q, POINTS, x + s * step) for s in (1, -1)]
            slope = (ends[0] - ends[1]) / (2 * step)
            np.testing.assert_allclose(path.a[piece, k] @ e[piece], slope, rtol=0, atol=1e-7)
            np.testing.assert_allclose(stretch[piece, k] * t[piece, k], slope, rtol=0, atol=1e-7)
            assert np.linalg.norm(t[piece, k]) == pytest.approx(1.0, rel=1e-14)
        for k, (x, s) in enumerate(((a, 1), (b, -1))):  # one-sided, of second order
            c = [place(rod, q, POINTS, x + s * n * step) for n in (0.01, 1.01, 2.01)]
            slope = s * (-3 * c[0] + 4 * c[1] - c[2]) / (2 * step)
            np.testing.assert_allclose(path.ends[piece, k] @ e[piece], slope, rtol=0, atol=1e-6)


def test_pieces_cover_the_path_once():
    """Weights add up to the pieces; each lies in its element; points of the path are told."""
    rod, path, _, _ = bent()
    cuts = marks(rod, POINTS)
    np.testing.assert_allclose(path.weight.sum(axis=1), np.diff(cuts), rtol=1e-12)
    np.testing.assert_allclose(
        path.weight, 0.5 * np.diff(cuts)[:, None] * gauss(rod.axial_points)[1], rtol=1e-12
    )
    middle = 0.5 * (cuts[:-1] + cuts[1:])
    elements = np.searchsorted(rod.mesh.breaks, middle) - 1
    np.testing.assert_array_equal(path.dofs, rod.dofs[elements])
    corners = POINTS[:, 0] * L
    np.testing.assert_array_equal(path.starts, [np.any(np.isclose(corners, a)) for a in cuts[:-1]])


def test_the_points_are_those_of_the_strain_energy():
    """Of a rod without cuts by the path: the same places, so that tension and strain see the same states."""
    straight = np.array([[0.0, 0.3 * R, 0.0], [1.0, 0.3 * R, 0.0]])
    for rule in ("default", "full"):
        rod, path, q, e = bent(points=straight, axial_rule=rule)
        assert path.a.shape[1] == rod.axial_points
        np.testing.assert_allclose(path.weight, rod.axial_weights, rtol=1e-13)
        x = rod.axial_abscissae
        for piece, k in ((0, 0), (3, 1)):
            ends = [place(rod, q, straight, x[piece, k] + s * 1e-6 * L) for s in (1, -1)]
            slope = (ends[0] - ends[1]) / (2e-6 * L)
            np.testing.assert_allclose(path.a[piece, k] @ e[piece], slope, rtol=0, atol=1e-7)


@pytest.mark.parametrize("element", ELEMENTS)
def test_slope_and_bend_are_derivatives(element):
    """sum over points of share times weight times |c'|: first and second derivative by differences."""
    _, path, _, e = bent(element)
    rng = np.random.default_rng(3)
    share = rng.uniform(0.2, 1.0, path.weight.shape)
    way, h = rng.uniform(-1, 1, e.shape), 1e-6

    def measured(e):
        return np.sum(share * path.weight * np.linalg.norm(path.a @ e, axis=-1))

    found = np.sum(path.slope(e, share) * way)
    assert found == pytest.approx((measured(e + h * way) - measured(e - h * way)) / (2 * h), rel=1e-7)
    change = (path.slope(e + h * way, share) - path.slope(e - h * way, share)) / (2 * h)
    K = path.bend(e, share)
    got = np.einsum("mij,mj->mi", K, way.reshape(len(K), -1)).reshape(change.shape)
    np.testing.assert_allclose(got, change, rtol=0, atol=1e-7 * np.abs(change).max())
    np.testing.assert_allclose(K, np.swapaxes(K, 1, 2), rtol=0, atol=1e-13 * np.abs(K).max())
    assert path.length(e) == pytest.approx(
        np.sum(path.weight * np.linalg.norm(path.a @ e, axis=-1)), rel=1e-14
    )
    np.testing.assert_allclose(path.slope(e), path.slope(e, np.ones_like(share)), rtol=1e-14)
