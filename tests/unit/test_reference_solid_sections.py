"""Section meshes of the solid reference: shape, second moments, numbering, supports on them."""

import numpy as np
import pytest

from reference.solid import soft_clamp
from reference.solid_assembly import SolidAssembly
from reference.solid_mesh import (
    annular_section,
    circular_section,
    elliptic_section,
    rectangular_section,
    rod_mesh,
)

A, B = 0.01, 0.02

# section, exact area, exact int y^2 dA and int z^2 dA, error of the area left by the matched second moment
SHAPES = {
    "circle": (circular_section(A), np.pi * A**2, [np.pi * A**4 / 4] * 2, 1.4e-7),
    "ellipse": (elliptic_section(A, B), np.pi * A * B, [np.pi * A**3 * B / 4, np.pi * A * B**3 / 4], 1.4e-7),
    "annulus": (
        annular_section(A, 0.6 * A),
        np.pi * 0.64 * A**2,
        [np.pi * (1 - 0.6**4) * A**4 / 4] * 2,
        1.4e-7,
    ),
    "rectangle": (rectangular_section(A, B, 3, 2), A * B, [A**3 * B / 12, A * B**3 / 12], 1e-14),
}
HALF_SIZES = {"circle": (A, A), "ellipse": (A, B), "annulus": (A, A), "rectangle": (A / 2, B / 2)}


@pytest.mark.parametrize("name", SHAPES)
def test_section_has_the_exact_second_moments(name):
    section, area, moments, area_error = SHAPES[name]
    np.testing.assert_allclose(np.diag(section.second_moments), moments, rtol=1e-13)
    assert abs(section.second_moments[0, 1]) < 1e-13 * moments[0]
    assert section.area == pytest.approx(area, rel=area_error)


@pytest.mark.parametrize("name", SHAPES)
def test_rim_and_centre_are_where_they_are_said_to_be(name):
    section, (y, z) = SHAPES[name][0], HALF_SIZES[name]
    # matching the second moments moves the rim by 4e-4 of the radius at eight arcs
    np.testing.assert_allclose(
        section.nodes[section.rim], [[y, 0], [0, z], [-y, 0], [0, -z]], atol=5e-4 * max(y, z)
    )
    if name == "annulus":
        assert section.centre is None
    else:
        np.testing.assert_allclose(section.nodes[section.centre], 0, atol=1e-17)


@pytest.mark.parametrize("name", SHAPES)
def test_rod_of_the_section_has_its_volume_and_no_inverted_point(name):
    section = SHAPES[name][0]
    mesh = rod_mesh(section, 0.1, slices=2)
    volume = SolidAssembly(mesh, soft_clamp(mesh)).volume
    assert np.min(volume) > 0
    assert volume.sum() == pytest.approx(section.area * 0.1, rel=1e-13)


@pytest.mark.parametrize("name", SHAPES)
def test_elements_of_a_slice_lie_over_the_quads(name):
    # the stress of a section relies on it
    section = SHAPES[name][0]
    mesh = rod_mesh(section, 0.1, slices=3)
    ns = len(section.nodes)
    for k in range(3):
        for q, quad in enumerate(section.quads):
            element = mesh.elements[k * len(section.quads) + q]
            assert set(element % ns) == set(quad)
            assert set(element // ns) == {2 * k, 2 * k + 1, 2 * k + 2}


@pytest.mark.parametrize("name", SHAPES)
def test_soft_clamp_holds_the_six_rigid_motions_and_no_bending_strain(name):
    mesh = rod_mesh(SHAPES[name][0], 0.1, slices=1)
    fixed, x = soft_clamp(mesh), mesh.nodes
    rigid = [np.tile(e, (len(x), 1)) for e in np.eye(3)] + [np.cross(e, x) for e in np.eye(3)]
    held = np.array([field[fixed] for field in rigid])
    assert np.linalg.matrix_rank(held, tol=1e-6) == 6
    # lateral field of bending about z, up to a rigid shift along y
    start, (y, z) = mesh.plane(0), mesh.section.nodes.T
    lateral = np.column_stack([0 * y, (y**2 - z**2) / 2, y * z])
    in_y = lateral[fixed[start][:, 1], 1]
    assert np.ptp(in_y) < 1e-12 * np.ptp(lateral[:, 1])
    np.testing.assert_allclose(lateral[fixed[start][:, 2], 2], 0, atol=1e-20)
    assert np.sum(fixed[:, 1:]) == 3


def test_refined_annulus_keeps_its_hole():
    for quarter, rings in [(1, 2), (3, 1), (4, 2)]:
        section = annular_section(A, 0.5 * A, quarter, rings)
        assert len(section.quads) == 4 * quarter * rings
        radius = np.linalg.norm(section.nodes, axis=1)
        assert radius.min() == pytest.approx(0.5 * A, rel=1e-2)
        assert radius.max() == pytest.approx(A, rel=1e-2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: circular_section(0.0), "semi_axis_y is 0.0 m; it must be positive"),
        (lambda: elliptic_section(A, np.inf), "semi_axis_z is inf m"),
        (lambda: annular_section(A, A), "inner_radius is 0.01 m, radius 0.01 m: the wall has no thickness"),
        (lambda: annular_section(A, -A), "inner_radius is -0.01 m; it must be positive"),
        (lambda: rectangular_section(A, B, 0), "cells_y is 0; at least 1 is needed"),
        (lambda: rod_mesh(circular_section(A), np.nan, 1), "length is nan m"),
        (lambda: rod_mesh(circular_section(A), 1.0, 0), "slices is 0"),
    ],
)
def test_impossible_sections_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
