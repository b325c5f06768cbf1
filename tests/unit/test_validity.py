"""Warnings where element or law leave their range, and silence inside it."""

from dataclasses import fields, replace

import numpy as np
import pytest

import ancf
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.rotation import log
from ancf.scene import Force, Moment, Rod, Scene, Support
from ancf.section_validity import ANTICLASTIC
from ancf.sections import Annulus, Circle, Ellipse, Rectangle
from reference.root import bracketed_root
from reference.section import bend
from reference.solid_materials import NeoHookean as SolidNeoHookean
from reference.solid_mesh import annular_section, rectangular_section
from validation.energy_measures import solid_law
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


@pytest.mark.parametrize("name", ["3243", "3333", "3363"])
@pytest.mark.parametrize("section", [Rectangle(0.04, 0.02), Circle(0.02)])
def test_stability_is_that_of_the_smallest_eigenvalue(name, section):
    """`stable` against the eigenvalues of the dense tangent, on both sides of the buckling load.

    A round strut buckles in two planes at once: the sign of the determinant would not see it.
    """
    rod = replace(ROD, section=section, element=name, formulation="")
    for share in (0.5, 1.5, 3.0):
        P = share * np.pi**2 / 4 * bending_stiffness(rod)
        solution = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([-P, 0.0, 0.0])),)))
        B = solution.model.boundary_matrix().toarray()
        unit = B.T @ solution.model.unit
        K = solution.tangent().toarray() * unit * unit[:, None]
        assert solution.stable == (np.linalg.eigvalsh(0.5 * (K + K.T))[0] > 0.0)
        assert solution.stable == (share < 1.0)


RUBBER = NeoHookean(1e6, 0.45)
MOONEY = MooneyRivlin(1e5, 5e4, 1e8)  # mu = 3e5 Pa, K/mu = 333
FREE = (Support(0.0, "free_section_clamp"),)


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
@pytest.mark.parametrize("material", [RUBBER, MOONEY, SaintVenantKirchhoff(1e6, 0.45)])
def test_a_slender_rubber_rod_is_silent(element, material):
    rod = Rod("rod", 1.0, 12, Circle(0.02), material, element)
    assert warnings(rod, (0.3, 0.5, 1.0)) == []


def stretched(material, stretch, element="3333"):
    """Warnings of a rod pulled to about this stretch, sections free to contract."""
    rod = Rod("rod", 1.0, 2, Circle(0.05), material, element, supports=FREE)
    law = solid_law(material)
    lateral = bracketed_root(lambda t: float(law.stress(np.diag([stretch, t, t]))[1, 1]), 0.5, 1.5)
    P = rod.section.area * float(law.stress(np.diag([stretch, lateral, lateral]))[0, 0])
    found = solved(Scene((rod,), forces=(Force("rod", 1.0, np.array([P, 0.0, 0.0])),))).warnings
    return [text for text in found if "unstable" not in text]  # a strut this short buckles, too


@pytest.mark.parametrize(
    ("material", "stretch", "words"),
    [
        (RUBBER, 1.45, None),  # Treloar: neo-Hookean up to 1.5
        (RUBBER, 1.6, ["principal stretches", "to 1.6,", "0.667 to 1.5", "neo-Hookean"]),
        (RUBBER, 0.6, ["principal stretches", "from 0.6 ", "0.667 to 1.5"]),
        (MOONEY, 1.6, None),  # Treloar: Mooney up to 2
        (MOONEY, 2.1, ["principal stretches", "to 2.1,", "0.5 to 2", "Mooney-Rivlin"]),
        # nu = 0: no lateral strain, so the volume changes by the stretch
        (NeoHookean(1e6, 0.0), 1.15, None),
        (NeoHookean(1e6, 0.0), 1.3, ["volume changes by 30%", "beyond 20%"]),
    ],
)
def test_rubbers_warn_of_stretch_and_volume(material, stretch, words):
    """A uniform state: the section has nothing to follow, so only the law speaks."""
    found = stretched(material, stretch)
    assert len(found) == (words is not None), found
    assert all(word in found[0] for word in words or ()), found


THICK = Rod("rod", 1.0, 12, Circle(0.08), RUBBER)


@pytest.mark.parametrize(
    ("changes", "kappa", "words"),
    [
        ({"element": "3333"}, 1.4, None),  # kappa R = 0.112
        ({"element": "3333"}, 2.6, ["varies by 0.2", "above 0.2", "linear section", "use 3363"]),
        ({"element": "3243", "elements": 24}, 2.6, ["linear section", "use 3363"]),
        ({"element": "3363"}, 1.4, None),
        ({"element": "3363"}, 2.6, ["varies by 0.2", "quadratic section of 3363", "0.17 only"]),
        ({"element": "3333", "material": MOONEY}, 1.4, ["above 0.1", "linear section", "use 3363"]),
        (
            {"element": "3363", "material": SaintVenantKirchhoff(1e6, 0.45)},
            1.4,
            ["Green-Lagrange strain 0.1", "Saint Venant-Kirchhoff departs", "use neo-hookean"],
        ),
    ],
)
def test_thick_rods_warn_of_what_their_section_or_law_lacks(changes, kappa, words):
    """M = E I kappa on a rod of R = 0.08 m: the strain on the skin is about kappa R."""
    rod = Rod(**{**{f.name: getattr(THICK, f.name) for f in fields(Rod)}, "formulation": "", **changes})
    found = warnings(rod, (0.0, 0.0, kappa))
    assert len(found) == (words is not None), found
    assert all(word in found[0] for word in words or ()), found


@pytest.mark.parametrize(
    ("section", "element", "words"),
    [
        (Rectangle(0.02, 0.02), "3333", ["50.0% of the squared", "cannot warp", "unless round"]),
        (Rectangle(0.02, 0.02), "3363", ["warp by y z", "up to 19 %"]),
        (Ellipse(0.02, 0.01), "3333", ["cannot warp"]),
        (Ellipse(0.02, 0.01), "3363", None),
        (Circle(0.02), "3333", None),
    ],
)
def test_torsion_warns_where_the_section_cannot_warp_as_it_should(section, element, words):
    """Warping is y z on an ellipse, which 3363 has; on a rectangle it is a series."""
    rod = Rod("rod", 1.0, 8, section, SaintVenantKirchhoff(1e6, 0.3), element)
    found = warnings(rod, (0.2, 0.0, 0.2))
    assert len(found) == (words is not None), found
    assert all(word in found[0] for word in words or ()), found


@pytest.mark.parametrize(
    ("section", "unit", "expected"),
    [
        (Rectangle(0.01, 0.01), 0.140577e-8, 1.18559),  # benchmarks.md TO: .166667 against .140577 a^4
        (Rectangle(0.02, 0.01), 0.228682 * 2e-8, 1.16610),  # .266667 against .228682 a b^3 (Timoshenko)
        (Ellipse(0.02, 0.01), np.pi * 0.02**3 * 0.01**3 / (0.02**2 + 0.01**2), 1.0),  # Saint-Venant
    ],
)
def test_torsion_stiffness_of_3363_is_what_its_warning_says(section, unit, expected):
    """Torsion constant between two sections far from the clamp, over the exact one."""
    rod = Rod("rod", 0.4, 12, section, SaintVenantKirchhoff(1e6, 0.3), "3363")
    torque, shear = 1e-9, 1e6 / 2.6
    solution = solved(Scene((rod,), moments=(Moment("rod", 1.0, np.array([torque, 0.0, 0.0])),)))
    angle = [log(solution.pose(None, at).rotation)[0] for at in (0.4, 0.8)]
    assert torque * 0.16 / (shear * (angle[1] - angle[0])) / unit == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("element", ["3333", "3363"])
def test_continuum_locks_with_linear_sections_only(element):
    """theory.md 3: (1 - nu)/((1 + nu)(1 - 2 nu)) = 3.7931 at nu = .45, for every law."""
    found = warnings(Rod("rod", 1.0, 8, Circle(0.02), RUBBER, element, "continuum"))
    assert len(found) == (element == "3333"), found
    assert all("3.793" in text and "every law" in text for text in found)


def test_warnings_are_recorded_in_the_result():
    rod = replace(THICK, section=Circle(0.08))
    scene = Scene((rod,), moments=(Moment("rod", 1.0, np.array([0, 0, 2.6 * bending_stiffness(rod)])),))
    solution = solved(scene)
    assert solution.as_dict()["warnings"] == solution.warnings != []


def test_full_hooke_at_zero_poisson_ratio_does_not_lock():
    assert warnings(replace(ROD, formulation="continuum", material=SaintVenantKirchhoff(1e6, 0.0))) == []


@pytest.mark.parametrize(
    ("section", "element", "kappa", "words"),
    [
        # Brazier: 1.5 (1 - .3^2)(kappa r^2/t)^2 = 5.46 % at kappa r^2/t = .2, .5 % at .06
        (Annulus(0.01, 0.009), "3333", 0.2 / 0.09025, ["flatten", "5.5%", "above 1%", "sections of 3333"]),
        (Annulus(0.01, 0.009), "3363", 0.2 / 0.09025, ["flatten", "sections of 3363"]),
        (Annulus(0.01, 0.009), "3333", 0.06 / 0.09025, None),
        # exact section problem, strips 1:10 at nu = .3: 2.9 % stiffer at w^2 kappa/h = 4
        (Rectangle(0.004, 0.04), "3333", 10.0, ["curves across", "3.2% stiffer", "use 3363"]),
        (Rectangle(0.04, 0.004), "3333", 10.0, None),  # bent the narrow way: no strip
        (Ellipse(0.002, 0.02), "3333", 10.0, ["curves across", "3.2% stiffer"]),
        (Rectangle(0.004, 0.04), "3333", 2.0, None),
        (Rectangle(0.004, 0.04), "3363", 10.0, None),
        (Rectangle(0.004, 0.04), "3363", 30.0, ["at its edges only", "= 12 (above 10)"]),
    ],
)
def test_sections_that_change_shape_in_bending(section, element, kappa, words):
    rod = Rod("rod", 0.1, 8, section, NeoHookean(1e6, 0.3), element, supports=FREE)
    EI = 1e6 * section.second_moments[0, 0]
    scene = Scene((rod,), moments=(Moment("rod", 1.0, np.array([0.0, 0.0, kappa * EI])),))
    found = [text for text in solved(scene).warnings if "strain varies" not in text]
    assert len(found) == (words is not None), found
    assert all(word in found[0] for word in words or ()), found


@pytest.mark.parametrize("nu", [0.3, 0.49])
def test_the_measure_of_flattening_is_that_of_the_exact_section_problem(nu):
    """Brazier (1927), long before any computer: loss of couple at a given curvature, r/t = 9.5."""
    tube, kappa = annular_section(0.01, 0.009, 4), 0.1 * 0.001 / 0.0095**2
    EI = 1e6 * np.pi * (0.01**4 - 0.009**4) / 4
    loss = 1.0 - bend(tube, SolidNeoHookean(1e6, nu), curvature=kappa).couple[2] / (EI * kappa)
    assert loss == pytest.approx(1.5 * (1 - nu**2) * 0.1**2, rel=0.05)


@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("beta", [1.0, 4.0])
def test_the_measure_of_anticlastic_bending_is_that_of_the_exact_section_problem(nu, beta):
    h, w = 0.004, 0.08
    strip, kappa = rectangular_section(h, w, 2, 16), beta * h / w**2
    gain = (
        bend(strip, SolidNeoHookean(1e6, nu), curvature=kappa).couple[2] / (1e6 * w * h**3 / 12 * kappa) - 1.0
    )
    x = beta**2 / ANTICLASTIC
    assert gain == pytest.approx(nu**2 * x / (1.0 + (1.0 - nu**2) * x), rel=0.12)


@pytest.mark.parametrize(("nu", "warned"), [(0.4999, False), (0.4999999995, True)])
def test_a_residual_without_digits_is_warned_of(nu, warned):
    rod = Rod("rod", 0.4, 24, Circle(0.01), SaintVenantKirchhoff(1e6, nu))
    M = 0.5 * bending_stiffness(rod)
    solution = ancf.solve(Scene((rod,), moments=(Moment("rod", 1.0, np.array([0.0, 0.0, M])),)))
    assert solution.status == "converged"
    assert any("rounding leaves a residual" in text for text in solution.warnings) is warned
