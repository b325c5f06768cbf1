"""Warnings where element or law leave their range, and silence inside it."""

from dataclasses import replace

import numpy as np
import pytest

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


def test_full_hooke_at_zero_poisson_ratio_does_not_lock():
    assert warnings(replace(ROD, formulation="continuum", material=SaintVenantKirchhoff(1e6, 0.0))) == []
