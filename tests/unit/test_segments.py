"""Rods of segments: records, mesh, elastic data, weight, symmetry of the two ends, output."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.failure import smallest_determinant
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.mesh import rod_breaks
from ancf.model import Model
from ancf.predictor import load_start
from ancf.rod_shape import node_rotations
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene, Support
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle
from ancf.segments import Segment, between, starts
from validation.random_rods import RngDraws, bent_state, random_rotation
from validation.solution_measures import solved

E = 1e6
SVK = SaintVenantKirchhoff(E, 0.3, 1000.0)
STIFF = SaintVenantKirchhoff(5.0 * E, 0.1, 2000.0)
RUBBER = NeoHookean(E, 0.4, 1200.0)
MOONEY = MooneyRivlin(1e5, 3e4, 1e7, 900.0)
ANGLE = Polygon(((0.0, 0.0), (0.05, 0.0), (0.05, 0.02), (0.02, 0.02), (0.02, 0.06), (0.0, 0.06)))
LEAN = Polygon(((0.0, 0.0), (0.03, 0.0), (0.03, 0.02), (0.01, 0.02), (0.01, 0.03), (0.0, 0.03)))

PROFILES = {
    "tapered": (Segment(1.0, 3, Circle(0.05), SVK, Circle(0.02)),),
    "stepped": (Segment(0.4, 2, Circle(0.05), SVK), Segment(0.6, 2, Rectangle(0.06, 0.04), STIFF)),
    "rubber": (
        Segment(0.3, 2, Ellipse(0.05, 0.03), RUBBER, Ellipse(0.02, 0.04)),
        Segment(0.7, 1, ANGLE, MOONEY),
    ),
    "mixed": (
        Segment(0.5, 2, ANGLE, SVK, LEAN),
        Segment(0.2, 1, Annulus(0.05, 0.03), MOONEY, Annulus(0.04, 0.01)),
        Segment(0.3, 1, Circle(0.04), STIFF),
    ),
}  # fmt: skip


def rod_of(profile, element="3333", **others):
    return Rod.of_segments("rod", PROFILES[profile], element=element, **others)


def mirrored_segments(segments):
    """The same body from its other end, z turned over: only polygons, not used here, would see it."""
    return tuple(replace(s, section=s.last_section, section_end=s.section) for s in reversed(segments))


# --- records -----------------------------------------------------------------------------------------------


def test_a_rod_is_the_sum_of_its_segments():
    rod = rod_of("mixed")
    assert (rod.length, rod.elements, rod.section, rod.material) == (1.0, 4, ANGLE, SVK)
    np.testing.assert_allclose(rod.ends, [0, 0.5, 0.7, 1.0], rtol=1e-15)
    assert rod.section_at(0.25) == between(ANGLE, LEAN, 0.5)
    assert rod.section_at(0.6) == Annulus(0.045, 0.02)


def test_dimensions_run_linearly():
    assert between(Circle(2.0), Circle(1.0), 0.25) == Circle(1.75)
    assert between(Ellipse(1.0, 4.0), Ellipse(3.0, 2.0), 0.5) == Ellipse(2.0, 3.0)
    assert between(Rectangle(1.0, 4.0), Rectangle(3.0, 2.0), 0.75) == Rectangle(2.5, 2.5)
    corners = between(Polygon(((0, 0), (1, 0), (0, 1))), Polygon(((0, 0), (3, 0), (2, 5))), 0.5)
    assert corners == Polygon(((0, 0), (2, 0), (1, 3)))


@pytest.mark.parametrize(
    "change", [{"length": 2.0}, {"elements": 9}, {"section": Circle(1)}, {"material": STIFF}]
)
def test_no_sum_can_be_changed_alone(change):
    with pytest.raises(ValueError, match="do not belong to its segments"):
        replace(rod_of("stepped"), **change)


def test_one_prismatic_segment_is_a_plain_rod():
    rod = Rod.of_segments("rod", (Segment(0.7, 3, ANGLE, SVK),))
    assert rod.segments == () and rod.parts == (Segment(0.7, 3, ANGLE, SVK),)
    assert rod.section_at(0.3) is rod.section


def test_at_a_joint_the_larger_section_counts_from_either_end():
    thick, thin = Segment(0.4, 1, Circle(0.05), SVK), Segment(0.6, 1, Circle(0.02), STIFF)
    there, back = Rod.of_segments("rod", (thick, thin)), Rod.of_segments("rod", (thin, thick))
    assert there.section_at(0.4) == Circle(0.05) == back.section_at(0.6)
    assert there.section_at(0.4 + 1e-6) == Circle(0.02) == back.section_at(0.6 - 1e-6)
    assert (there.part_at(0.0), there.part_at(0.4), there.part_at(1.0)) == (0, 0, 1)


def test_a_steep_taper_is_measured_by_its_skin():
    assert Segment(2.0, 1, Circle(0.5), SVK, Circle(0.1)).slope == pytest.approx(0.2)
    assert Segment(2.0, 1, Rectangle(0.5, 1.0), SVK, Rectangle(0.1, 0.1)).slope == pytest.approx(0.225)
    assert Segment(1.0, 1, Annulus(0.5, 0.4), SVK, Annulus(0.5, 0.1)).slope == pytest.approx(0.3)


# --- mesh --------------------------------------------------------------------------------------------------


def test_elements_stand_on_joints_supports_and_loads():
    """A load counts in its own segment: there one element is not enough for it, here two are."""
    segments = (Segment(0.4, 1, Circle(0.05), SVK), Segment(0.6, 3, Circle(0.03), SVK))
    rod = Rod.of_segments("rod", segments, supports=(Support(0.0), Support(0.55)))
    loads = tuple(Force("rod", at, np.ones(3)) for at in (0.2, 0.4, 0.7))
    np.testing.assert_allclose(
        rod_breaks(Scene((rod,), forces=loads), rod), [0, 0.4, 0.55, 0.7, 1.0], atol=1e-15
    )


def test_equal_elements_share_their_data_across_equal_segments():
    alike = Segment(0.25, 2, Circle(0.02), SVK)
    segments = (alike, replace(alike, section=Circle(0.03)), alike, replace(alike, material=STIFF))
    first, kind = Model(Scene((Rod.of_segments("rod", segments),))).rods[0].element_kinds
    assert len(first) == 3
    assert list(kind[[0, 1]]) == list(kind[[4, 5]]) and len(set(kind[[0, 2, 6]])) == 3
    tapers = (replace(alike, section_end=Circle(0.01)), replace(alike, section_end=Circle(0.03)), alike)
    first, _ = Model(Scene((Rod.of_segments("rod", tapers),))).rods[0].element_kinds
    assert len(first) == 5  # two of each taper and the prismatic ones, which begin with the same section


# --- elastic kernel ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("curved", [False, True])
def test_force_and_tangent_are_derivatives_and_rigid_motion_is_free(profile, element, curved):
    curvature = np.array([0.4, 0.8, -0.5]) if curved else np.zeros(3)
    rod = rod_of(
        profile,
        element,
        curvature=curvature,
        base=Frame(np.ones(3), random_rotation(RngDraws(np.random.default_rng(3)))),
    )
    model = Model(Scene((rod,), gravity=Gravity(np.array([1.0, -2.0, 3.0]))))
    source = np.random.default_rng(5)
    arrays = model.rods[0]
    # Small enough in every vector for positive volumes: 1 % strain by each of them.
    size = [0.04 ** (1 - sum(order)) for order in arrays.element.vectors]
    noise = 0.01 * source.uniform(-1, 1, arrays.q0.shape) * np.array(size)[:, None]
    q = (bent_state(arrays, np.array([0.3, -0.5, 0.8])) + noise).ravel()
    dq = source.uniform(-1, 1, len(q)) * model.unit * np.tile(np.repeat(size, 3), len(arrays.q0))
    step = 1e-4

    def energy(t):
        return model.potential(q + t * dq)

    work = (energy(-2 * step) - 8 * energy(-step) + 8 * energy(step) - energy(2 * step)) / (12 * step)
    assert model.residual(q).at(1.0) @ dq == pytest.approx(work, rel=2e-8)
    _, flat = model.residual_and_tangent(q, 1.0)
    difference = (model.residual(q + step * dq).at(1.0) - model.residual(q - step * dq).at(1.0)) / (2 * step)
    product = full(model, flat) @ dq
    scale = np.max(np.abs(product / model.force_unit))
    np.testing.assert_allclose(product / model.force_unit, difference / model.force_unit, atol=1e-6 * scale)
    # A rigid motion of the reference: no force against that of one percent of strain.
    R = random_rotation(RngDraws(np.random.default_rng(7)))
    moved = arrays.q0 @ R.T
    moved[:, 0] += np.array([0.3, 0.1, -0.2])
    free = np.abs(arrays.elastic.force(moved[arrays.mesh.nodes_of].reshape(arrays.e0.shape))).max()
    assert free < 1e-11 * np.abs(arrays.elastic.force(arrays.element_vectors(q))).max()


def full(model, flat):
    """The tangent (n, n) from flat band storage."""
    b, n = model.pattern.b, model.n
    K = np.zeros((n, n))
    for row, band in enumerate(model.pattern.banded(flat)[b:]):
        offset = b - row
        for j in range(max(offset, 0), min(n, n + offset)):
            K[j - offset, j] = band[j]
    return K


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
@pytest.mark.parametrize("material", [SVK, RUBBER, MOONEY])
def test_uniform_strain_has_the_energy_of_a_frustum(element, material):
    """U = Psi(F) V with V = pi L (R^2 + R r + r^2)/3, quadratic in x, which two Gauss points integrate."""
    from validation.energy_measures import solid_law

    segment = Segment(1.0, 2, Circle(0.05), material, Circle(0.02))
    rod = Rod.of_segments("rod", (segment,), element=element, formulation="continuum")
    arrays = Model(Scene((rod,))).rods[0]
    F = np.eye(3) + 0.02 * np.array([[1.0, 0.3, -0.2], [0.1, -0.6, 0.4], [0.2, -0.1, 0.5]])
    q = arrays.q0 @ F.T
    volume = np.pi * (0.05**2 + 0.05 * 0.02 + 0.02**2) / 3
    density = float(solid_law(material).energy(F[None])[0])
    assert arrays.elastic.energy(arrays.element_vectors(q.ravel())) == pytest.approx(
        density * volume, rel=1e-9
    )


@pytest.mark.parametrize("element", ELEMENTS)
def test_mixed_laws_are_the_sum_of_their_segments(element):
    """The energy of a rod of Saint Venant-Kirchhoff and rubber is that of its pieces as rods of their own."""
    rod = Rod.of_segments(
        "rod", (Segment(0.4, 2, ANGLE, SVK), Segment(0.6, 2, Circle(0.05), RUBBER)), element=element
    )
    arrays = Model(Scene((rod,))).rods[0]
    q = bent_state(arrays, np.array([0.5, -0.7, 0.9])).ravel() * 1.01
    e, total = arrays.element_vectors(q), 0.0
    for part, elements in zip(rod.parts, (slice(0, 2), slice(2, 4)), strict=True):
        alone = Rod("rod", part.length, 2, part.section, part.material, element)
        total += Model(Scene((alone,))).rods[0].elastic.energy(e[elements])
    assert arrays.elastic.energy(e) == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("profile", PROFILES)
def test_weight_and_its_lever_are_those_of_the_body(profile, element):
    """int rho A dx and int rho A x dx by scipy.integrate.quad over each segment."""
    rod, g = rod_of(profile, element), np.array([0.0, 0.0, -9.81])
    model = Model(Scene((rod,), gravity=Gravity(g)))
    Q = model.residual(model.q0).Q_ext.reshape(model.rods[0].q0.shape)
    mass = lever = 0.0
    for part, start in zip(rod.parts, starts(rod.parts)[:-1], strict=True):
        rho = part.material.density or 0.0

        def area(x, part=part):
            return part.section_at(x / part.length).area

        mass += rho * quad(area, 0, part.length)[0]
        lever += rho * quad(lambda x, a=area, s=start: a(x) * (s + x), 0, part.length)[0]
    np.testing.assert_allclose(Q[:, 0].sum(axis=0), mass * g, rtol=1e-12)
    moment = np.cross(model.rods[0].q0, Q).sum(axis=(0, 1))
    np.testing.assert_allclose(moment, np.cross([lever, 0, 0], g), rtol=1e-12, atol=1e-12 * lever)


# --- solutions ---------------------------------------------------------------------------------------------

LOADS = {
    "moments": (Moment("rod", 1.0, np.array([20.0, 30.0, -40.0]) * 1e-2, "follower"),),
    "forces": (Force("rod", 0.5, np.array([0.0, 0.6, 0.2]), np.array([0.01, 0.005])),),
    "line_loads": (LineLoad("rod", np.array([0.0, 0.4, 0.5]), "follower"),),
    "gravity": Gravity(np.array([0.0, 0.05, -0.1])),
}


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
@pytest.mark.parametrize("material", [SVK, RUBBER])
def test_two_equal_segments_are_the_plain_rod(element, material):
    plain = Rod("rod", 1.0, 8, Circle(0.02), material, element)
    pieces = (Segment(0.25, 2, Circle(0.02), material), Segment(0.75, 6, Circle(0.02), material))
    a, b = (solved(Scene((r,), **LOADS)) for r in (plain, Rod.of_segments("rod", pieces, element=element)))
    assert np.max(np.abs(a.q - a.model.q0)) > 0.1  # it is bent
    np.testing.assert_allclose(b.q, a.q, atol=1e-12)


@pytest.mark.parametrize("element", SECTION_ELEMENTS)
@pytest.mark.parametrize(
    "segments",
    [
        (Segment(0.4, 3, Circle(0.05), SVK, Circle(0.02)), Segment(0.6, 3, Rectangle(0.06, 0.03), STIFF)),
        (
            Segment(0.4, 2, Circle(0.05), SVK),
            Segment(0.6, 3, Ellipse(0.02, 0.03), RUBBER, Ellipse(0.03, 0.02)),
        ),
    ],
    ids=["taper", "rubber"],
)
def test_read_from_its_other_end_a_rod_is_the_same(element, segments):
    """x' = -x, y' = y, z' = -z: clamp at 1, loads at 1 - at, poses by B = diag(-1, 1, -1)."""
    B = np.diag([-1.0, 1.0, -1.0])
    value, at = np.array([0.2, 3.0, 2.0]), 0.4
    there = Rod.of_segments("rod", segments, element=element)
    back = Rod.of_segments(
        "rod", mirrored_segments(segments), element=element,
        base=Frame(np.array([1.0, 0.0, 0.0]), B), supports=(Support(1.0),),
    )  # fmt: skip
    loads = {"moments": (Moment("rod", 1.0, 0.1 * value),), "forces": (Force("rod", at, value),)}
    turned = {"moments": (Moment("rod", 0.0, 0.1 * value),), "forces": (Force("rod", 1.0 - at, value),)}
    gravity = Gravity(np.array([0.0, 0.5, 1.0]))
    a = solved(Scene((there,), gravity=gravity, **loads))
    b = solved(Scene((back,), gravity=gravity, **turned))
    assert np.linalg.norm(a.tip().position - [1.0, 0.0, 0.0]) > 0.02
    for place in (0.2, at, 0.7, 1.0):
        np.testing.assert_allclose(
            b.pose(None, 1.0 - place).position, a.pose(None, place).position, atol=1e-9
        )
        # both rotations are against the reference of the same body
        np.testing.assert_allclose(
            b.pose(None, 1.0 - place).rotation, a.pose(None, place).rotation, atol=1e-8
        )


@pytest.mark.parametrize("follower", [False, True])
def test_load_start_knows_the_stiffness_along_the_rod(follower):
    """Turn of the end by int M dx/(E I): scipy.integrate.quad; and the first node after the joint."""
    thin = Segment(0.5, 8, Circle(0.002), STIFF)
    segments = (Segment(0.5, 8, Circle(0.004), SVK, Circle(0.002)), thin)
    M = 5e-5
    moment = Moment("rod", 1.0, np.array([0.0, 0.0, M]), "follower" if follower else "fixed")
    model = Model(Scene((Rod.of_segments("rod", segments),), moments=(moment,)))
    q = load_start(model)
    assert q is not None
    turns = node_rotations(model.rods[0], model.rods[0].nodal(q))
    compliance = quad(lambda x: 4 / (E * np.pi * (0.004 - 0.004 * x) ** 4), 0, 0.5)[0]
    for node, expected in (
        (16, M * compliance),
        (32, M * compliance + M * 0.5 / (5 * E * np.pi * 0.002**4 / 4)),
    ):
        angle = np.arctan2(turns[node, 1, 0], turns[node, 0, 0])
        assert angle == pytest.approx(expected, rel=1e-6)
    assert 0.5 < expected < 3.0  # a large turn


def test_force_scale_turns_the_end_by_one_radian():
    """bending_stiffness/L is the couple M with int M dx/(E I) = 1."""
    rod = rod_of("tapered")
    compliance = quad(lambda x: 4 / (E * np.pi * (0.05 - 0.03 * x) ** 4), 0, 1)[0]
    assert Model(Scene((rod,))).rods[0].bending_stiffness == pytest.approx(1 / compliance, rel=1e-10)


def test_force_scale_of_a_stepped_rod():
    """L / (0.4/(E_1 I_1) + 0.6/(E_2 I_2)) with the weaker side of the rectangle 0.06 x 0.04."""
    EI_1, EI_2 = E * np.pi * 0.05**4 / 4, 5 * E * 0.06 * 0.04**3 / 12
    model = Model(Scene((rod_of("stepped"),)))
    assert model.rods[0].bending_stiffness == pytest.approx(1 / (0.4 / EI_1 + 0.6 / EI_2), rel=1e-12)


def test_section_weights_are_those_of_the_section_there():
    """W_y = I_z e_y, W_z = I_y e_z: of the rectangle at the tip, of the circle at the base and the joint."""
    arrays = Model(Scene((rod_of("stepped"),))).rods[0]
    disc, plate = np.pi * 0.05**4 / 4, np.diag([0.0, 0.04 * 0.06**3 / 12, 0.06 * 0.04**3 / 12])
    for node, expected in ((0, disc * np.diag([0, 1, 1])), (4, disc * np.diag([0, 1, 1])), (8, plate)):
        np.testing.assert_allclose(arrays.node_weights[node], expected, atol=1e-12 * disc)
    np.testing.assert_allclose(arrays.section_point(1.0).W, plate, atol=1e-12 * disc)


def test_load_start_contracts_by_the_ratio_of_each_material():
    """r_yy = nu k_z e_y of Saint-Venant bending, k_z = M/(E I), in the middle of either half."""
    pieces = Segment(0.5, 4, Circle(0.01), SVK), Segment(0.5, 4, Circle(0.01), STIFF)
    M = 0.1 * E * np.pi * 0.01**4 / 4
    moment = (Moment("rod", 1.0, np.array([0.0, 0.0, M])),)
    model = Model(Scene((Rod.of_segments("rod", pieces, element="3363"),), moments=moment))
    start = load_start(model)
    assert start is not None
    r_yy = model.rods[0].nodal(start)[:, 3]
    np.testing.assert_allclose(np.linalg.norm(r_yy[[3, 12]], axis=1), [0.3 * 0.1, 0.1 * 0.1 / 5], rtol=1e-6)


def test_an_element_turned_inside_out_is_found_beside_rubber():
    """r_y of the first element reversed: det [r_x r_y r_z] = -1 there, where rubber is not asked."""
    pieces = Segment(0.5, 2, Circle(0.05), SVK), Segment(0.5, 2, Circle(0.05), RUBBER)
    model = Model(Scene((Rod.of_segments("rod", pieces),)))
    q = model.rods[0].q0.copy()
    q[:3, 1] *= -1.0
    assert smallest_determinant(model, q.ravel()) == ("rod", 0, pytest.approx(-1.0))
    assert not model.inside_out(q.ravel())  # rubber alone is undefined there
