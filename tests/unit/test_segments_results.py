"""Results and warnings of rods of segments: stress, skin, and what they cannot follow."""

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.elements import SECTION_ELEMENTS
from ancf.hyperelastic import NeoHookean
from ancf.model import Model
from ancf.scene import Moment, Rod, Scene
from ancf.section_stress import section_strain
from ancf.sections import Annulus, Circle, Rectangle
from ancf.segments import Segment
from ancf.surface import rod_surface
from tests.unit.test_segments import RUBBER, STIFF, SVK, E, rod_of
from validation.random_rods import bent_state
from validation.solution_measures import solved


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
def test_stress_of_a_tapered_stepped_rod_is_that_of_its_section(element):
    """sigma = M y / I(x) (Navier) at a small moment; where it jumps, that of the larger section's side."""
    taper = Segment(0.5, 16, Circle(0.01), SVK, Circle(0.005))
    rod = Rod.of_segments("rod", (taper, Segment(0.5, 16, Circle(0.003), STIFF)), element=element)
    M = 1e-6 * E * np.pi * 0.003**4 / 4
    solution = solved(Scene((rod,), moments=(Moment("rod", 1.0, np.array([0.0, 0.0, M])),)))
    for at, R in ((0.2, 0.008), (0.43, 0.0057), (0.5, 0.005), (0.8, 0.003)):
        y = np.array([0.9 * R, -R])
        sigma = solution.section_stress(None, at, y, np.zeros(2))
        # An element of 3243 has one curvature: at its ends 2 dR/R, 12 % on these 16, at its middle right.
        limit = 0.13 if element == "3243" else 4e-3
        np.testing.assert_allclose(sigma[:, 0, 0], -M * y / (np.pi * R**4 / 4), rtol=limit)
    with pytest.raises(ancf.InputError, match="outside the section"):
        solution.section_stress(None, 0.43, np.array([0.006]), np.zeros(1))


def test_skin_follows_the_section():
    rod = rod_of("stepped")
    tapered = rod_of("tapered")
    straight = solved(Scene((tapered,)))
    surface = rod_surface(straight, "rod")
    radius = np.hypot(surface.position[..., 1], surface.position[..., 2])
    np.testing.assert_allclose(
        radius, np.broadcast_to((0.05 - 0.03 * surface.at)[:, None], radius.shape), rtol=1e-12
    )
    parts = [rod_surface(solved(Scene((rod,))), "rod", part) for part in (0, 1)]
    assert parts[0].at[-1] == parts[1].at[0] == pytest.approx(0.4)
    assert parts[0].position.shape[1] == 24 and parts[1].position.shape[1] == 4
    np.testing.assert_allclose(np.abs(parts[1].position[0, :, 1:]), [[0.03, 0.02]] * 4, atol=1e-15)


def test_strain_on_the_skin_of_a_taper():
    """Uniform curvature k, rigid sections: E_xx = -k y + (k y)^2/2 at y = R(x)."""
    arrays = Model(Scene((rod_of("tapered"),))).rods[0]
    q = bent_state(arrays, np.array([0.0, 0.0, 1e-4])).ravel()
    x = arrays.axial_abscissae.ravel()
    R = 0.05 - 0.03 * x
    strain = section_strain(arrays, q, R[:, None], np.zeros((len(x), 1)))
    np.testing.assert_allclose(strain[:, 0, 0], -1e-4 * R, rtol=1e-3)
    np.testing.assert_array_equal(section_strain(arrays, q, np.zeros(1), np.zeros(1)).shape, (len(x), 1, 6))


# --- known limits: the worst along the rod -----------------------------------------------------------------


def warnings(segments, M=0.0, element="3333", **others):
    moment = (Moment("rod", 1.0, np.array([0.0, 0.0, M])),) if M else ()
    return solved(
        Scene((Rod.of_segments("rod", segments, element=element, **others),), moments=moment)
    ).warnings


def test_a_steep_taper_is_warned_about():
    """Too stiff by slope^2 (wedge: segments.py): 4 % here; a slope of 0.09 is below the limit."""
    steep, mild = (Segment(0.2, 4, Circle(0.05), SVK, Circle(0.05 - 0.2 * slope)) for slope in (0.2, 0.09))
    assert any("inclined by 0.2 (above 0.1)" in text and "4.0%" in text for text in warnings((mild, steep)))
    assert warnings((mild, replace(mild, section=Circle(0.03), section_end=Circle(0.02)))) == []


def test_only_nodal_r_x_is_warned_about_a_jump():
    pieces = (Segment(0.5, 4, Circle(0.02), SVK), Segment(0.5, 4, Circle(0.02), STIFF))
    assert any("jumps by a factor of 5 where" in text for text in warnings(pieces, element="3243"))
    assert warnings(pieces) == []
    alike = replace(pieces[0], section=Circle(0.04), section_end=Circle(0.02)), pieces[0]
    assert not any("jumps" in text for text in warnings(alike, element="3243"))


def test_poisson_locking_names_the_worst_material():
    """(1 - nu)/((1 + nu)(1 - 2 nu)) = 2.1429 at nu = 0.4 (theory.md 3), wherever it stands."""
    pieces = tuple(Segment(0.5, 2, Circle(0.02), law) for law in (RUBBER, SVK))
    for order in (pieces, pieces[::-1]):
        assert any(
            "2.143 times its value at nu = 0.4 " in text for text in warnings(order, formulation="continuum")
        )


def test_locking_names_the_most_slender_element():
    """Longest element 0.25 m over the radius of gyration 0.004/2 at the thin end: 125."""
    pieces = (Segment(0.5, 2, Circle(0.02), SVK, Circle(0.004)), Segment(0.1, 4, Circle(0.004), SVK))
    assert any("radius of gyration = 125 " in text for text in warnings(pieces, axial_rule="full"))


def test_a_tube_is_judged_where_it_is_a_tube():
    """Brazier's loss 1.5 (1 - nu^2)(kappa r^2/t)^2 with kappa = M/(E I) in the tube alone."""
    tube = Segment(0.5, 8, Annulus(0.02, 0.018), SVK)
    I = np.pi / 4 * (0.02**4 - 0.018**4)  # noqa: E741
    M = 1.0 * E * I
    loss = 1.5 * (1 - 0.09) * (0.019**2 / 0.002) ** 2
    rod = Segment(0.5, 8, Circle(0.03), SVK)
    expected = f"costs it about {loss:.1%}"
    for pieces in ((tube, rod), (rod, tube)):
        assert any(expected in text for text in warnings(pieces, M))
    assert warnings((rod, replace(rod, section=Rectangle(0.05, 0.05))), M) == []


def test_each_law_is_judged_by_the_strain_in_its_own_segments():
    """kappa R = 0.1 in a soft half, 1e-3 in a stiff one; Saint Venant-Kirchhoff serves to 0.08."""
    soft, stiff = Segment(0.5, 12, Circle(0.05), SVK), Segment(0.5, 2, Circle(0.05), NeoHookean(100 * E, 0.3))
    M = 2.0 * E * np.pi * 0.05**4 / 4
    found = warnings((stiff, soft), M)
    assert len(found) == 1 and "strain 0.1" in found[0] and "exceeds 0.08" in found[0]
    other = (
        replace(soft, material=NeoHookean(E, 0.3)),
        replace(stiff, material=replace(SVK, young_modulus=100 * E)),
    )
    assert warnings(other, M) == []
