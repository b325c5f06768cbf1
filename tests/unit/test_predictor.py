"""Start values: the rod under its moments, and extrapolation of a path."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ancf.elements import SECTION_ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.mesh import reference_axis
from ancf.model import Model
from ancf.path import Path
from ancf.predictor import load_start
from ancf.scene import Frame, Moment, Rod, Scene, Support
from ancf.sections import Circle, Polygon, Rectangle
from reference.analytic import helix_tip_moment
from reference.rod import RodLoads, RodProperties, solve_rod
from tests.strategies import rotations, vectors

MATERIAL = SaintVenantKirchhoff(1e6, 0.3)
EI = 1e6 * np.pi * 0.01**4 / 4


def rod(name="3333", elements=12, **changes):
    return replace(Rod("rod", 1.0, elements, Circle(0.01), MATERIAL, element=name), **changes)


def start(scene):
    model = Model(scene)
    q = load_start(model)
    assert q is not None
    return model.rods[0], q.reshape(model.rods[0].q0.shape)


@pytest.mark.parametrize("direction", ["fixed", "follower"])
@pytest.mark.parametrize("name", SECTION_ELEMENTS)
@given(base=rotations(), v=vectors(1.0), share=st.floats(0.1, 1.0))
def test_a_tip_moment_gives_the_helix(name, direction, base, v, share):
    """Closed form (reference.helix, theory.md 1); the start is promised within 1e-3 for a turn on 12
    elements.
    """
    v = v + np.array([0.0, 0.0, 2.5])  # a moment of zero magnitude has no start of its own
    GJ = EI / 1.3
    scene = Scene(
        (rod(name, base=Frame(rotation=base)),),
        moments=(Moment("rod", 1.0, share * base @ v * EI, direction),),
    )
    model, q = start(scene)
    x = model.mesh.node_x
    exact = helix_tip_moment(share * base @ v * EI, 1.0, EI, GJ, x, base[:, 0], direction)
    # second order: the step that is promised good to 1e-3 at |v| = pi/2 errs in proportion to |v|^2
    size = np.linalg.norm(share * v) ** 2 + 1e-9
    np.testing.assert_allclose(q[:, 0], exact.position, atol=5e-4 * size)
    y = model.element.vectors.index((0, 1, 0))
    np.testing.assert_allclose(q[:, y], exact.rotation @ base[:, 1], atol=5e-4 * size)


@pytest.mark.parametrize("direction", ["fixed", "follower"])
def test_plane_bending_starts_on_the_circle(direction):
    """The midpoint rule is exact for constant curvature in a plane, and chords are shorter than arcs."""
    model, q = start(Scene((rod(),), moments=(Moment("rod", 1.0, np.array([0, 0, 1.7]) * EI, direction),)))
    x = model.mesh.node_x
    circle = np.column_stack([np.sin(1.7 * x), 1 - np.cos(1.7 * x), 0 * x]) / 1.7
    np.testing.assert_allclose(q[:, 0], circle, atol=1e-13)


def test_curved_rods_of_any_section_start_near_the_rod_solution():
    """Reissner rod by collocation (reference.rod): a curved rod, I_y unlike I_z, moments about all axes."""
    section, k = Rectangle(0.03, 0.02), np.array([0.5, -0.6, 0.8])
    I_z, I_y = 0.03**3 * 0.02 / 12, 0.03 * 0.02**3 / 12
    for direction in ("fixed", "follower"):
        M = 1e6 * I_y * np.array([0.5, -0.8, 1.0])
        model, q = start(
            Scene((rod(section=section, curvature=k),), moments=(Moment("rod", 1.0, M, direction),))
        )
        properties = RodProperties.from_section(1.0, 1e6, 0.3, 6e-4, I_y, I_z, curvature=k)
        loads = RodLoads(tip_moment=M) if direction == "fixed" else RodLoads(follower_tip_moment=M)
        exact = solve_rod(properties, loads, model.mesh.node_x, tolerance=1e-8)
        np.testing.assert_allclose(q[:, 0], exact.position, atol=2e-3)


def test_an_oblique_section_couples_the_bending_axes():
    """I_yz bends a Z-like section out of the plane of its moment: curvature (y, z) = E^-1 [[I_y, -I_yz],
    [-I_yz, I_z]]^-1 M.
    """
    section = Polygon(((0.0, 0.0), (0.03, 0.0), (0.03, 0.01), (0.01, 0.01), (0.01, 0.03), (0.0, 0.03)))
    y, z, w = section.quadrature(2)
    I_z, I_y, I_yz = np.sum(w * y * y), np.sum(w * z * z), np.sum(w * y * z)
    M = np.array([0.0, 0.2, 0.1]) * 1e6 * I_y
    model, q = start(Scene((rod(section=section),), moments=(Moment("rod", 1.0, M),)))
    # E int (z k_y - y k_z) (z, -y) dA: M_y = E (I_y k_y - I_yz k_z), M_z = E (I_z k_z - I_yz k_y)
    kappa = np.linalg.solve(1e6 * np.array([[I_y, -I_yz], [-I_yz, I_z]]), M[1:])
    position, _ = reference_axis(model.mesh.node_x, np.array([0.0, *kappa]))
    np.testing.assert_allclose(q[:, 0], position, atol=2e-2 * np.abs(position[:, 1:]).max())


def test_moments_inside_the_span_add_up():
    """Two dead moments: beyond the inner one only the outer one bends; both on 0..0.5."""
    moments = (Moment("rod", 0.5, np.array([0, 0, 1.0]) * EI), Moment("rod", 1.0, np.array([0, 0, 0.5]) * EI))
    model, q = start(Scene((rod(),), moments=moments))
    x = model.mesh.node_x
    angle = np.where(x < 0.5, 1.5 * x, 0.75 + 0.5 * (x - 0.5))
    y = model.element.vectors.index((0, 1, 0))
    np.testing.assert_allclose(q[:, y], np.column_stack([-np.sin(angle), np.cos(angle), 0 * x]), atol=1e-9)
    follower = replace(moments[0], direction="follower")
    model, q = start(Scene((rod(),), moments=(follower,)))
    angle = np.minimum(x, 0.5)
    np.testing.assert_allclose(q[:, y], np.column_stack([-np.sin(angle), np.cos(angle), 0 * x]), atol=1e-9)


@pytest.mark.parametrize(
    ("supports", "directions", "known"),
    [
        (("clamp",), ("fixed",), True),
        (("free_section_clamp",), ("fixed", "fixed"), True),
        (("clamp",), ("follower",), True),
        (("clamp",), ("follower", "fixed"), True),
        (("pin",), ("fixed",), False),
        (("clamp", "pin"), ("fixed",), False),
        (("clamp",), (), False),
    ],
)
def test_where_a_start_is_known(supports, directions, known):
    held = tuple(Support(0.5 * i, kind) for i, kind in enumerate(supports))
    moments = tuple(Moment("rod", 1.0, np.array([0.0, 0.0, EI]), d) for d in directions)
    assert (load_start(Model(Scene((rod(supports=held),), moments=moments))) is not None) is known


def bent(model, amount):
    """A rod bent into a circular arc with its sections stretched: local measures linear in `amount`."""
    arrays = model.rods[0]
    position, frame = reference_axis(arrays.mesh.node_x, amount * np.array([0.3, -0.5, 0.8]))
    q = np.einsum("nij,nvj->nvi", frame, arrays.q0 * (1.0 + 0.1 * amount))
    q[:, 0] = position
    return q.ravel()


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
def test_extrapolation_reproduces_its_points_and_polynomials(name):
    """The start at a known load factor is that state; measures linear in the load are continued."""
    model = Model(Scene((rod(name),)))
    path = Path(model, bent(model, 0.0))
    for factor in (0.2, 0.5):
        path.add(factor, bent(model, factor))
    np.testing.assert_allclose(path.extrapolate(0.5), bent(model, 0.5), atol=1e-13)
    np.testing.assert_allclose(path.extrapolate(0.2), bent(model, 0.2), atol=1e-13)
    # chord of the arc: sin(a/2)/(a/2), quadratic in the load up to (a/12)^4
    np.testing.assert_allclose(path.extrapolate(1.0), bent(model, 1.0), atol=1e-5)


@pytest.mark.parametrize("name", SECTION_ELEMENTS)
def test_the_tangent_start_moves_along_the_increment(name):
    """For a small increment it is q + dq; for a large one the sections keep their size."""
    model = Model(Scene((rod(name),)))
    dq = (bent(model, 1e-7) - model.q0) / 1e-7  # rate at the reference
    path = Path(model, model.q0)
    np.testing.assert_allclose(path.from_tangent(1e-4 * dq), model.q0 + 1e-4 * dq, atol=1e-7)
    np.testing.assert_allclose(path.from_tangent(dq), bent(model, 1.0), atol=3e-3)
