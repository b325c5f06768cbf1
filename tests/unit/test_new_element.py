"""An element is one descriptor: 3343, which no module names, runs through the whole solver.

It adds the section vector r_yz, so that a rectangle may warp. Its torsion constant is then 4 I_y I_z /
(I_y + I_z): .266667 a b^3 on a 2:1 rectangle against .416667 of a linear section (benchmarks, row TO).
"""

from __future__ import annotations

import numpy as np
import pytest

import ancf.elements
from ancf.elements import R_Y, R_Z, Element, R
from ancf.materials import SaintVenantKirchhoff
from ancf.rotation import log
from ancf.scene import Moment, Rod, Scene, Support
from ancf.sections import Rectangle
from ancf.solver import solve

R_YZ = (0, 1, 1)


@pytest.fixture(autouse=True)
def descriptor(monkeypatch):
    element = Element(
        "3343", (-1.0, 0.0, 1.0), (R, R_Y, R_Z, R_YZ), axial_points=2, full_points=5, locks_from=3
    )
    monkeypatch.setitem(ancf.elements.ELEMENTS, "3343", element)


def twist(element: str, supports: tuple[Support, ...]) -> float:
    """Torsion constant over a b^3 of a 2:1 rectangle, from the tip angle under a small torque."""
    young, length, b = 1e6, 0.4, 0.01
    rod = Rod(
        "arm", length, 8, Rectangle(2 * b, b), SaintVenantKirchhoff(young, 0.0), element, supports=supports
    )
    shear, torque = young / 2, 1e-9
    solution = solve(Scene((rod,), moments=(Moment("arm", 1.0, np.array([torque, 0.0, 0.0])),)))
    assert solution.status == "converged"
    angle = log(solution.tip().rotation)[0]
    return torque * length / (shear * angle) / (2 * b * b**3)


def test_bilinear_section_warps():
    """The clamp restrains warping, so the rod is a little stiffer than the limit."""
    assert twist("3333", (Support(),)) == pytest.approx(5 / 12, rel=1e-6)  # (I_y + I_z) / a b^3
    assert twist("3343", (Support(),)) == pytest.approx(4 / 15, rel=2e-2)


def test_bending_is_that_of_3333():
    """nu = 0, plane bending: warping does not take part."""
    young, length = 1e6, 0.4
    tips = []
    for element in ("3333", "3343"):
        rod = Rod("arm", length, 8, Rectangle(0.01, 0.01), SaintVenantKirchhoff(young, 0.0), element)
        moment = np.array([0.0, 0.0, young * 1e-8 / 12 / length])
        tips.append(solve(Scene((rod,), moments=(Moment("arm", 1.0, moment),))).tip().position)
    assert tips[0] == pytest.approx(tips[1], abs=1e-10)
