"""Swelling of chambers against plane finite elements, and what it does to a rod."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.sparse import bmat
from scipy.sparse.linalg import spsolve
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, FacetBasis, LinearForm, MeshQuad
from skfem.helpers import ddot, div, dot, sym_grad, trace

import ancf
from ancf.advice import advise
from ancf.chamber_swelling import largest_swelling, swelling
from ancf.influence import MATTERS
from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Pressure
from ancf.sections import Annulus, Circle, Rectangle

FACTOR = 1.1  # 1.06 at a wall of a tenth of the radius, finite elements against the mean of both formulas


def chamber(radius: float, offset: float, value: float = 1.0, **ends: float) -> Pressure:
    return Pressure("finger", value, np.array([offset, 0.0]), radius, **ends)


def growth(a: float, b: float, offset: float, nu: float) -> float:
    """Half the relative growth of the area of a hole under p = E = 1, plane stress.

    By p dA = 2 U on a mesh of quadratic quadrilaterals between both circles; rigid motions are held by
    multipliers.
    """
    around, across = 48, 10
    s, turn = (
        values.ravel()
        for values in np.meshgrid(
            np.linspace(0, 1, across + 1), np.arange(around) / around * 2 * np.pi, indexing="ij"
        )
    )
    circle = np.array([np.cos(turn), np.sin(turn)])
    points = (1 - s) * (a * circle + [[offset], [0.0]]) + s * b * circle
    i, j = (v.ravel() for v in np.meshgrid(np.arange(across), np.arange(around), indexing="ij"))
    k = (j + 1) % around
    corners = [i * around + j, (i + 1) * around + j, (i + 1) * around + k, i * around + k]
    mesh = MeshQuad(points, np.array(corners))
    element = ElementVector(ElementQuad2())
    basis = Basis(mesh, element)
    mu, plane = 0.5 / (1 + nu), nu / (1 - nu**2)

    @BilinearForm
    def stiffness(u, v, _):
        return 2 * mu * ddot(sym_grad(u), sym_grad(v)) + plane * trace(sym_grad(u)) * div(v)

    @LinearForm
    def pressure(v, w):
        return -dot(w.n, v)

    facets = mesh.boundary_facets()
    assert mesh.facets is not None
    middle = points[:, mesh.facets[:, facets]].mean(axis=1)
    hole = FacetBasis(mesh, element, facets=facets[np.hypot(middle[0] - offset, middle[1]) < 1.01 * a])
    f = pressure.assemble(hole)

    def rigid(field: Any) -> Any:
        return basis.project(field)

    held = np.array(
        [
            rigid(lambda x: np.array([1 + 0 * x[0], 0 * x[0]])),
            rigid(lambda x: np.array([0 * x[0], 1 + 0 * x[0]])),
            rigid(lambda x: np.array([-x[1], x[0]])),
        ]
    )
    system = bmat([[stiffness.assemble(basis), held.T], [held, None]]).tocsc()
    u = np.asarray(spsolve(system, np.concatenate([f, np.zeros(3)])))[: len(f)]
    return float(f @ u) / (2 * np.pi * a**2)


@pytest.mark.parametrize(
    ("a", "offset", "nu"), [(4.0, 0.0, 0.3), (4.0, 3.0, 0.45), (4.0, 5.0, 0.3), (2.0, 7.0, 0.3)]
)
def test_against_plane_finite_elements(a, offset, nu):
    """In a disc of radius 10. What linear sections show is a widening of the whole disc,
    (1 - nu) p A_c/(E A) (equal stress in the plane)."""
    shown = (1 - nu) * a**2 / 100.0
    found = swelling(Circle(10.0), chamber(a, offset), SaintVenantKirchhoff(1.0, nu))
    true = growth(a, 10.0, offset, nu)
    assert found is not None
    assert found + shown == pytest.approx(true, rel=5e-3 if offset == 0.0 else FACTOR - 1.0)


def test_a_tube_under_pressure_in_its_bore():
    """Lame: less the widening that its sections show, (1 + nu) p/E b^2/(b^2 - a^2)."""
    law = SaintVenantKirchhoff(2.0, 0.4)
    found = swelling(Annulus(3.0, 2.0), chamber(2.0, 0.0, 0.01), law)
    assert found == pytest.approx(1.4 * 0.005 * 9.0 / 5.0)
    assert swelling(Annulus(3.0, 2.0), chamber(1.0, 0.5, 0.01), law) == pytest.approx(
        0.005 * (13.0 / 5.0 + 0.4 - 0.6 * 1.0 / 5.0)
    )


def test_what_has_no_wall_or_is_not_round():
    law = SaintVenantKirchhoff(1.0, 0.3)
    assert swelling(Circle(1.0), chamber(0.5, 0.5), law) == math.inf
    assert swelling(Rectangle(1.0, 1.0), chamber(0.1, 0.0), law) is None


def scene(value: float, scale: float = 1.0, **fields):
    """A finger of a radius of 1 cm with a chamber off its axis, whose radius may be another."""
    body = {
        "name": "finger",
        "length": 0.1,
        "elements": 8,
        "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 5e5, "poisson_ratio": 0.45},
        **fields,
    }
    hole = {"centre": [-0.005, 0.0], "radius": 0.003 * scale}
    return ancf.scene_from_dict({"rod": [body], "pressure": [{"value": value, "chamber": hole}]})


@pytest.mark.parametrize("value", [1e3, 5e3, 2e4])
def test_influence_of_swelling(value):
    """Against solving with the wider chamber: its radius as it has grown, within a factor of 1.5."""
    (found,) = [one for one in advise(scene(value)).missing if one.effect == "swelling of chambers"]
    plain = scene(value)
    share = largest_swelling(plain.rods[0], plain.pressures[0])
    assert share is not None and found.number == pytest.approx(share)
    wide = ancf.solve(scene(value, 1.0 + share))
    true = float(np.linalg.norm(wide.tip().position - ancf.solve(plain).tip().position)) / 0.1
    assert found.tip is not None and true / 1.5 <= found.tip <= 1.5 * true
    if found.verdict == MATTERS:
        assert true > 1e-3 and "fibres" in found.advice


def test_walls_that_balloon():
    (found,) = [one for one in advise(scene(1.5e5)).missing if one.effect == "swelling of chambers"]
    assert found.verdict == MATTERS and "balloon" in found.note


def test_the_weakest_place_along_a_chamber_counts():
    """A taper: where it is thinnest, at the end of the chamber, not of the rod."""
    thin = scene(1e3, section={"shape": "circle", "radius": 0.02})
    law, part = thin.rods[0].parts[0].material, chamber(0.003, -0.005, 1e3, end=0.5)
    data = {
        "name": "finger",
        "segments": [
            {
                "length": 0.1,
                "elements": 8,
                "section": {"shape": "circle", "radius": 0.02},
                "section_end": {"shape": "circle", "radius": 0.01},
                "material": {"young_modulus": 5e5, "poisson_ratio": 0.45},
            }
        ],
    }
    taper = ancf.scene_from_dict({"rod": [data], "force": [{"value": [0, 0, 0]}]}).rods[0]
    assert largest_swelling(taper, part) == pytest.approx(swelling(Circle(0.015), part, law))
