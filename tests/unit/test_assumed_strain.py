"""Assumed strains: where products are sampled, and what the axial points see of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ancf.elements
from ancf.assumed_strain import kind_of, sampling
from ancf.elements import ELEMENTS, R_X, R_Y, R_YZ, R_Z
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Rod, Scene
from ancf.section_energy import pairs
from ancf.sections import Circle

GAUSS_2 = 1.0 / np.sqrt(3.0)
EVERY_KIND = (("axial", (0.0,)), ("shear", (-1.0, 1.0)), ("section", (-1.0, 0.0, 1.0)), ("curvature", (0.5,)))


def test_kinds_of_products():
    """r_x . r_x, r_x . d, d . d, and everything with a derivative of a director."""
    assert kind_of(R_X, R_X) == "axial"
    assert kind_of(R_X, R_Z) == kind_of(R_YZ, R_X) == "shear"
    assert kind_of(R_Y, R_Y) == kind_of(R_Y, R_YZ) == "section"
    assert {kind_of(R_X, (1, 1, 0)), kind_of((1, 1, 0), R_Y), kind_of((1, 1, 0), (1, 0, 1))} == {"curvature"}
    assert kind_of(R_X, (2, 0, 0)) == kind_of((2, 0, 0), (2, 0, 0)) == "curvature"


@pytest.mark.parametrize("points", [1, 2, 4])
def test_polynomials_through_the_sampled_places_are_exact(points):
    """A of s places reproduces polynomials of degree s - 1 at the axial points; unnamed kinds stay there."""
    element = replace(ELEMENTS["3333"], assumed=EVERY_KIND)
    places, A = sampling(element, points)
    axial = np.polynomial.legendre.leggauss(points)[0]
    np.testing.assert_array_equal(places[:points], axial)
    assert len(places) == len(np.unique(np.round(places, 12)))
    for p, (i, j) in enumerate(zip(*pairs(5), strict=True)):
        kind = kind_of(element.generalised[i], element.generalised[j])
        for degree in range(len(dict(EVERY_KIND)[kind])):
            np.testing.assert_allclose(A[:, :, p] @ places**degree, axial**degree, atol=1e-14)
    _, plain = sampling(replace(element, assumed=EVERY_KIND[:1]), points)
    rows = [p for p, (i, j) in enumerate(zip(*pairs(5), strict=True)) if (i, j) != (0, 0)]
    for p in rows:
        np.testing.assert_array_equal(plain[:, :points, p], np.eye(points))
        assert not plain[:, points:, p].any()


def test_places_that_are_axial_points_are_not_taken_twice():
    element = replace(ELEMENTS["3333"], assumed=(("section", (-GAUSS_2, GAUSS_2)),))
    places, A = sampling(element, 2)
    assert len(places) == 2
    np.testing.assert_allclose(A, np.broadcast_to(np.eye(2)[:, :, None], A.shape), atol=1e-14)


def test_strains_sampled_at_the_axial_points_are_the_plain_ones(monkeypatch):
    """Energy, force and tangent through A = identity and through no A at all, in a random state."""
    assumed = tuple((kind, (-GAUSS_2, GAUSS_2)) for kind, _ in EVERY_KIND)
    monkeypatch.setitem(ancf.elements.ELEMENTS, "3333a", replace(ELEMENTS["3333"], assumed=assumed))
    rng = np.random.default_rng(5)
    rods = [
        Model(Scene((Rod("arm", 1.0, 3, Circle(0.05), SaintVenantKirchhoff(1e6, 0.3), name),))).rods[0]
        for name in ("3333", "3333a")
    ]
    e, e_previous = (rods[0].e0 + 0.1 * rng.normal(size=rods[0].e0.shape) for _ in range(2))
    plain, through = (rod.elastic for rod in rods)
    assert through.assumed is not None
    assert through.energy(e) == pytest.approx(plain.energy(e), rel=1e-13)
    for found, expected in zip(
        through.force_and_tangent(e, e_previous), plain.force_and_tangent(e, e_previous), strict=True
    ):
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.max(np.abs(expected)))
    v = plain.generalised(e)
    np.testing.assert_allclose(through.material_tangent(v), plain.material_tangent(v), rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(through.section_force(v), plain.vector_force(v), rtol=1e-9)
