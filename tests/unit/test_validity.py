"""Warnings where element or law leave their range, and silence inside it."""

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Force, Moment, Rod, Scene
from ancf.sections import Circle, Rectangle
from validation.solution_measures import bending_stiffness, solved


def warnings(rod, v=(0.0, 0.0, 0.5), force=None):
    unit = bending_stiffness(rod) / rod.length
    if force is not None:
        return solved(Scene((rod,), forces=(Force("rod", 1.0, np.array(force) * unit),))).warnings
    return solved(Scene((rod,), moments=(Moment("rod", 1.0, np.array(v) * unit),))).warnings


ROD = Rod("rod", 1.0, 8, Circle(0.02), SaintVenantKirchhoff(1e6, 0.3))


def test_a_rod_inside_its_range_is_silent():
    assert warnings(ROD, (0.3, 0.5, 1.0)) == []


@pytest.mark.parametrize(
    ("rod", "v", "words"),
    [
        (replace(ROD, formulation="continuum"), (0, 0, 0.5), ["Poisson locking", "1.346"]),
        (replace(ROD, element="3243"), (0, 0, 0.5), ["3243 with 3 axial points locks", "12"]),
        (replace(ROD, axial_rule="full", elements=3), (0, 0, 0.5), ["locks", "33"]),
        (replace(ROD, section=Circle(0.08)), (0, 0, 2.0), ["Green-Lagrange strain", "exceeds 0.08"]),
        (replace(ROD, section=Rectangle(0.04, 0.04)), (0.5, 0, 0.3), ["torsion", "cannot warp"]),
        (replace(ROD, elements=3), (0, 0, 2.5), ["elements are too long", "turns by 0.8", "0.7"]),
    ],
)
def test_each_limit_is_named(rod, v, words):
    """theory.md 3 (locking factor 1.3462, slenderness), section 2 (finite strain), benchmarks.md TO
    (torsion).
    """
    found = warnings(rod, v)
    if "12" in words:  # h / i = 0.125 / 0.01 = 12.5 is inside the limit of 25: no warning
        assert found == []
        return
    assert len(found) == 1, found
    assert all(word in found[0] for word in words), found
    assert found[0].startswith("rod 'rod': ")


def test_too_few_axial_points_are_named():
    """theory.md 3: 3243 with two axial points has spurious zero modes."""
    scene = Scene(
        (replace(ROD, element="3243", axial_rule=2),), moments=(Moment("rod", 1.0, np.array([0, 0, 1e-4])),)
    )
    assert any("below the 3 points" in text and "zero-energy" in text for text in ancf.solve(scene).warnings)


@pytest.mark.parametrize(("share", "unstable"), [(0.9, False), (1.5, True)])
def test_a_strut_beyond_its_buckling_load_is_called_unstable(share, unstable):
    """Euler, P = pi^2 E I/(4 L^2) about the weak axis; the strong axis holds 4 times as much: one negative
    eigenvalue.
    """
    rod = replace(ROD, section=Rectangle(0.04, 0.02))
    P = share * np.pi**2 / 4 * bending_stiffness(rod)
    solution = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([-P, 0.0, 0.0])),)))
    assert any("unstable" in text for text in solution.warnings) is unstable


@pytest.mark.parametrize("name", ["3243", "3333"])
@pytest.mark.parametrize("section", [Rectangle(0.04, 0.02), Circle(0.02)])
def test_stability_is_that_of_the_smallest_eigenvalue(name, section):
    """`stable` against the eigenvalues of the dense tangent, on both sides of the buckling load.

    A round strut buckles in two planes at once: the sign of the determinant would not see it.
    """
    rod = replace(ROD, section=section, element=name)
    for share in (0.5, 1.5, 3.0):
        P = share * np.pi**2 / 4 * bending_stiffness(rod)
        solution = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([-P, 0.0, 0.0])),)))
        B = solution.model.boundary_matrix().toarray()
        unit = B.T @ solution.model.unit
        K = solution.tangent().toarray() * unit * unit[:, None]
        assert solution.stable == (np.linalg.eigvalsh(0.5 * (K + K.T))[0] > 0.0)
        assert solution.stable == (share < 1.0)


def test_full_hooke_at_zero_poisson_ratio_does_not_lock():
    assert warnings(replace(ROD, formulation="continuum", material=SaintVenantKirchhoff(1e6, 0.0))) == []
