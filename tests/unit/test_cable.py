"""The cable element: an axis that stretches and bends, without shear, torsion or section."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ancf import cable as cable_measures
from ancf.axis_frames import smallest_rotation, steps
from ancf.cable_law import CableSection
from ancf.failure import largest_wave
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, Frame, Gravity, LineLoad, Rod, Scene, StabilityOptions, Support
from ancf.sections import Annulus, Circle
from ancf.segments import Segment
from ancf.solver import solve
from reference.elastica import elastica_tip_force
from reference.rod import RodLoads, RodProperties, solve_rod

YOUNG, LENGTH = 1e6, 1.0
SVK = SaintVenantKirchhoff(YOUNG, 0.3, 1000.0)


def cable(slenderness: float, elements: int, **fields) -> Rod:
    return Rod("line", LENGTH, elements, Circle(LENGTH / slenderness), SVK, "cable", **fields)


def stiffness(rod: Rod) -> float:
    return YOUNG * rod.section.weaker_second_moment


def test_the_law_is_that_of_fibres_on_a_circle():
    """A circle of curvature k, stretched by s: eps = (s^2 - 1)/2, K = k s turns per reference length."""
    k, s = 0.7, 1.3
    r_x, r_xx = np.array([s, 0.0, 0.0]), np.array([0.2, k * s**2, 0.0])  # r' = s t, r'' = s' t + s^2 k n
    gamma = np.array([[[r_x @ r_x - 1.0, r_x @ r_xx, r_xx @ r_xx]]])
    found = CableSection(np.array([[3.0]]), np.array([[2.0]])).energy(gamma)
    assert found == pytest.approx(0.5 * 3.0 * (0.5 * (s**2 - 1.0)) ** 2 + 0.5 * 2.0 * (k * s) ** 2, rel=1e-14)


def test_resultants_and_tangent_are_derivatives_of_the_energy():
    """Central differences of U and T, error of second order in the step; H is symmetric."""
    rng = np.random.default_rng(2)
    law = CableSection(np.array([[3.0, 1.0]]), np.array([[2.0, 5.0]]))
    gamma = np.concatenate([rng.uniform(-0.3, 0.3, (4, 2, 2)), rng.uniform(0.5, 2.0, (4, 2, 1))], axis=-1)
    T, H = law.response(gamma)
    step = 1e-5
    for p in range(3):
        d = np.zeros(3)
        d[p] = step
        U = (law.energy(gamma + d) - law.energy(gamma - d)) / (2 * step)
        assert pytest.approx(np.sum(T[..., p]), rel=1e-8) == U
        dT = (law.resultants(gamma + d) - law.resultants(gamma - d)) / (2 * step)
        np.testing.assert_allclose(dT, H[..., p], rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(H, np.swapaxes(H, -1, -2))
    np.testing.assert_allclose(law.predicted(gamma, gamma), T, rtol=1e-14)


@pytest.mark.parametrize("elements", [1, 2, 3])
def test_zero_modes(elements):
    """Straight: three translations and two rotations, for spin about its axis moves no cable. Bent: six."""
    rod = Model(Scene((cable(20.0, elements),))).rods[0]

    def count(q: np.ndarray) -> int:
        K = np.zeros((q.size, q.size))
        e = q[rod.mesh.nodes_of].reshape(elements, -1, 3)
        for dofs, K_e in zip(rod.dofs, rod.elastic.force_and_tangent(e)[1], strict=True):
            K[np.ix_(dofs, dofs)] += K_e
        values = np.abs(np.linalg.eigvalsh(K))
        return int(np.sum(values < 1e-11 * values.max()))

    assert count(rod.q0) == 5
    x = rod.mesh.node_x
    arc = np.zeros_like(rod.q0)
    arc[:, 0] = np.column_stack([np.sin(x), 1.0 - np.cos(x), 0.0 * x])
    arc[:, 1] = np.column_stack([np.cos(x), np.sin(x), 0.0 * x])
    assert count(arc) <= 6


@pytest.mark.parametrize("slenderness", [200.0, 500.0, 4000.0])
def test_elastica_does_not_lock(slenderness):
    """Issue 5, NUMBERS: P L^2/EI = 10 at most 5e-4 with 12 elements and 1e-4 with 24; the elastica does not
    stretch, the cable does, by some 2.5 (R/L)^2.
    """
    exact = elastica_tip_force(10.0)
    for elements, bound in ((12, 5e-4), (24, 1e-4)):
        rod = cable(slenderness, elements)
        load = Force("line", 1.0, np.array([0.0, 10.0 * stiffness(rod), 0.0]))
        found = solve(Scene((rod,), forces=(load,)))
        assert found.status == "converged" and not found.warnings
        assert np.linalg.norm(found.tip().position - [1 - exact.u, exact.w, 0.0]) <= bound
        assert np.arctan2(*found.tip().r_x[1::-1]) == pytest.approx(exact.angle, abs=2 * bound)


def test_order_four_whatever_the_slenderness():
    errors = {}
    for slenderness in (50.0, 4000.0):
        rod = cable(slenderness, 64)
        load = (Force("line", 1.0, np.array([0.0, 10.0 * stiffness(rod), 0.0])),)
        tips = [solve(Scene((replace(rod, elements=n),), forces=load)).tip().position for n in (6, 24, 64)]
        errors[slenderness] = [float(np.linalg.norm(tip - tips[-1])) for tip in tips[:-1]]
        assert np.log(errors[slenderness][0] / errors[slenderness][1]) / np.log(4.0) > 3.8
    assert errors[4000.0][0] < 2.0 * errors[50.0][0]


def test_loads_in_space_with_frames_forces_and_moments():
    """Weight and a tip force across it, against the rod integrated in reference/: a straight rod that bends
    alike about all axes has no torsion, so its sections turn as the transported frames do.
    """
    rod = cable(400.0, 24)
    EI = stiffness(rod)
    weight = 1000.0 * rod.section.area
    scene = Scene(
        (rod,),
        forces=(Force("line", 1.0, np.array([0.5 * EI, 3.0 * EI, 0.0])),),
        line_loads=(LineLoad("line", np.array([0.0, 0.0, 2.0 * EI])),),
        gravity=Gravity(np.array([0.0, 0.0, -8.0 * EI / weight])),
    )
    found = solve(scene)
    properties = RodProperties.from_section(
        LENGTH, YOUNG, 0.3, rod.section.area, *2 * (rod.section.weaker_second_moment,)
    )
    loads = RodLoads(tip_force=np.array([0.5 * EI, 3.0 * EI, 0.0]), line_load=np.array([0.0, 0.0, -6.0 * EI]))
    exact = solve_rod(properties, loads)
    assert np.linalg.norm(found.tip().position - exact.position[0]) < 5e-5  # shear of the rod: 2 (R/L)^2
    np.testing.assert_allclose(found.tip().rotation, exact.rotation[0], atol=5e-5)
    assert abs(found.tip().r_y @ found.tip().r_x) < 1e-12
    forces = found.section_forces()
    # Statics: force and moment of everything beyond the section.
    expected = np.array([0.5, 3.0, 0.0]) + np.outer(LENGTH - forces.x, [0.0, 0.0, -6.0])
    np.testing.assert_allclose(forces.force / EI, expected, atol=1e-5)
    tip = found.tip().position
    for i in (0, 20, 50):
        here = found.displaced(None, forces.at[i], 0.0, 0.0)
        s = np.linspace(forces.at[i], 1.0, 2001)
        arms = found.displaced(None, s, 0.0, 0.0) - here
        weight_moment = np.trapezoid(np.cross(arms, [0.0, 0.0, -6.0]), s, axis=0)
        moment = np.cross(tip - here, [0.5, 3.0, 0.0]) + weight_moment
        np.testing.assert_allclose(forces.moment[i] / EI, moment, atol=5e-3)
    reaction, _ = found.reaction()
    np.testing.assert_allclose(reaction / EI, [-0.5, -3.0, 6.0], atol=1e-6)


def test_stress_is_that_of_fibres():
    """Navier: sigma = N/A - m_z y/I + m_y z/I at the axial points, nothing else (small strain)."""
    rod = cable(100.0, 16)
    EI = stiffness(rod)
    found = solve(Scene((rod,), forces=(Force("line", 1.0, np.array([2.0, 1.0, 0.5]) * EI),)))
    forces, axes = found.section_forces(), found.section_axes()
    R = rod.section.outer_radius
    y, z = np.array([R, 0.0, 0.6 * R]), np.array([0.0, -R, 0.6 * R])
    for i in (4, 30):
        stress = found.section_stress(None, float(forces.at[i]), y, z)
        N, _, _ = axes[i].T @ forces.force[i]
        _, m_y, m_z = axes[i].T @ forces.moment[i]
        navier = N / rod.section.area + YOUNG * (z * m_y - y * m_z) / EI
        np.testing.assert_allclose(stress[:, 0, 0], navier, atol=0.05 * np.max(np.abs(navier)))
        assert np.max(np.abs(stress[:, 1:, 1:])) < 1e-3 * np.max(np.abs(stress))


def test_frames_follow_a_known_curve():
    """Along a helix the transported frame turns about the tangent against the Frenet frame by -torsion times
    arc length; the double reflection errs with the fourth order of the step.
    """
    a, b = 1.0, 0.5
    c = np.hypot(a, b)
    errors = []
    for n in (40, 80):
        s = np.linspace(0.0, 6.0, n + 1)
        r = np.column_stack([a * np.cos(s / c), a * np.sin(s / c), b * s / c])
        t = np.column_stack([-a * np.sin(s / c), a * np.cos(s / c), np.full_like(s, b)]) / c
        normal = np.column_stack([-np.cos(s / c), -np.sin(s / c), 0.0 * s])
        moved = normal[0]
        for turn in steps(r, t):
            moved = turn @ moved
        angle = -b / c**2 * 6.0
        expected = np.cos(angle) * normal[-1] + np.sin(angle) * np.cross(t[-1], normal[-1])
        errors.append(float(np.linalg.norm(moved - expected)))
    assert errors[0] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("turn", [0.0, 1.0, np.pi - 1e-3, np.pi])
def test_the_smallest_rotation(turn):
    a, b = np.array([1.0, 0.0, 0.0]), np.array([np.cos(turn), np.sin(turn), 0.0])
    R = smallest_rotation(a, b, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(R @ a, b, atol=1e-7)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-7)
    np.testing.assert_allclose(R[:, 2], [0.0, 0.0, 1.0], atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_frames_begin_at_the_clamp():
    """Clamped at its end, a cable in space has the identity there, and at its start what the way brings."""
    rod = cable(100.0, 8, supports=(Support(1.0),), base=Frame(np.zeros(3), np.eye(3)))
    EI = stiffness(rod)
    places = ((0.0, (0, 2, 0)), (0.5, (0, 0, 3)))
    loads = tuple(Force("line", at, EI * np.array(v)) for at, v in places)
    found = solve(Scene((rod,), forces=loads))
    np.testing.assert_allclose(found.pose(None, 1.0).rotation, np.eye(3), atol=1e-12)
    start = found.pose(None, 0.0)
    np.testing.assert_allclose(start.rotation[:, 0], start.r_x / np.linalg.norm(start.r_x), atol=1e-12)


def test_a_free_section_clamp_lets_the_cable_stretch():
    """A clamp holds r and r_x, so nothing stretches at it; the other kind holds the direction of r_x, and a
    uniform pull P = E A (s^3 - s)/2 is a uniform stretch, to rounding.
    """
    s, A = 1.05, np.pi * 0.01**2
    P = YOUNG * A * (s**3 - s) / 2
    errors = {}
    for kind in ("clamp", "free_section_clamp"):
        rod = cable(100.0, 4, supports=(Support(0.0, kind),))
        found = solve(Scene((rod,), forces=(Force("line", 1.0, np.array([P, 0.0, 0.0])),)))
        errors[kind] = abs(found.tip().position[0] - s)
        assert any("holds r_x of the cable" in text for text in found.warnings) == (kind == "clamp")
        axis = found.pose(None, 0.0).r_x
        np.testing.assert_allclose(axis[1:], 0.0, atol=1e-12)
        assert axis[0] == pytest.approx(1.0 if kind == "clamp" else s, abs=1e-9)
    assert errors["free_section_clamp"] < 1e-9 < 1e-4 < errors["clamp"]


def test_hanging_between_two_pins():
    """Two pins hold a cable and share its weight; sag of a shallow string w L^2/(8 H), force H along it."""
    supports = (Support(0.0, "pin"), Support(1.0, "pin"))
    rod = cable(2000.0, 24, supports=supports)
    weight = 1000.0 * rod.section.area
    found = solve(Scene((rod,), gravity=Gravity(np.array([0.0, 0.0, -0.5]))))
    assert found.status == "converged"
    H = abs(found.section_forces().force[36, 0])
    assert found.pose(None, 0.5).position[2] == pytest.approx(-0.5 * weight / (8.0 * H), rel=1e-2)
    np.testing.assert_allclose(found.reaction()[0], [0.0, 0.0, 0.5 * weight], atol=1e-6 * weight)


def test_euler_column():
    """pi^2 E I/(4 L^2), to the strain P/(E A)."""
    rod = cable(200.0, 8)
    load = (Force("line", 1.0, np.array([-4.0 * stiffness(rod), 0.0, 0.0])),)
    found = solve(Scene((rod,), forces=load, stability=StabilityOptions()))
    assert found.stability is not None
    assert found.stability.buckling_factor == pytest.approx(np.pi**2 / 16.0, rel=1e-3)


def test_segments_and_tapers():
    """A cone under a small tip force: w = int P (L - x)^2/(E I(x)) dx, by the trapezoidal rule."""
    first, last, P = 0.01, 0.005, 1e-6
    parts = (
        Segment(0.6, 12, Circle(first), SVK, Circle(last)),
        Segment(0.4, 6, Annulus(last, 0.5 * last), SVK),
    )
    rod = Rod.of_segments("line", parts, element="cable")
    found = solve(Scene((rod,), forces=(Force("line", 1.0, np.array([0.0, P, 0.0])),)))
    x = np.linspace(0.0, 1.0, 20001)
    radius = np.where(x < 0.6, first + (last - first) * x / 0.6, last)
    I = np.pi / 4 * (radius**4 - np.where(x < 0.6, 0.0, (0.5 * last) ** 4))  # noqa: E741
    assert found.tip().position[1] == pytest.approx(np.trapezoid(P * (1 - x) ** 2 / (YOUNG * I), x), rel=1e-3)


def test_a_thick_cable_is_warned_about():
    """The strain limit of the law holds for fibres too; slender ones are silent (test_elastica_...)."""
    rod = cable(12.0, 8)
    found = solve(Scene((rod,), forces=(Force("line", 1.0, np.array([0.0, 5.0 * stiffness(rod), 0.0])),)))
    assert any("largest Green-Lagrange strain" in text for text in found.warnings)


def test_measures_of_a_stretched_arc():
    """Nodes on a circle of curvature c, tangents s long: eps = (s^2 - 1)/2, k = s c about z, E_xx = eps - y k
    F e_x = (s - y k) t, the force E A eps s. An element turns by 0.01: the cubic is the circle to 1e-9.
    """
    s, c = 1.2, 0.1 / 1.2
    rod = cable(50.0, 10)
    model = Model(Scene((rod,)))
    (part,) = model.rods
    angle = s * c * part.mesh.node_x
    q = np.zeros_like(part.q0)
    q[:, 0] = np.column_stack([np.sin(angle), 1.0 - np.cos(angle), 0.0 * angle]) / c
    q[:, 1] = s * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    eps, y, R = 0.5 * (s**2 - 1.0), np.array([0.015, -0.004]), rod.section.outer_radius
    k = cable_measures.curvature(part, q.ravel())
    np.testing.assert_allclose(k, np.broadcast_to([0.0, 0.0, s * c], k.shape), atol=1e-6)
    strain = cable_measures.fibre_strain(part, q.ravel(), y, 0.0 * y, 0)
    np.testing.assert_allclose(strain[..., 0], np.broadcast_to(eps - y * s * c, strain.shape[:2]), rtol=1e-5)
    F = cable_measures.fibre_gradient(part, q.ravel(), y, 0.0 * y, 0)
    np.testing.assert_allclose(np.linalg.det(F), np.broadcast_to(s - y * s * c, F.shape[:2]), rtol=1e-5)
    np.testing.assert_allclose(
        cable_measures.axial_forces(part, q.ravel()), YOUNG * np.pi * R**2 * eps * s, rtol=1e-6
    )


def test_the_moment_of_the_elastica_is_that_of_statics():
    """m = P (x_tip - x) at every axial point: linear between the two places where the curvature is best."""
    rod = cable(500.0, 24)
    EI = stiffness(rod)
    found = solve(Scene((rod,), forces=(Force("line", 1.0, np.array([0.0, 10.0 * EI, 0.0])),)))
    forces = found.section_forces()
    x = found.displaced(None, forces.at, 0.0, 0.0)[:, 0]
    expected = 10.0 * (found.tip().position[0] - x)
    assert (
        np.max(np.abs(forces.moment[:, 2] / EI - expected)) < 2e-3
    )  # of 4.4; at the axial points themselves 5e-3


def test_a_pressed_cable_is_measured_in_waves():
    """h sqrt(-N/E I) with N = E A eps s of a straight cable pressed to s: failure.largest_wave."""
    s, rod = 0.999, cable(100.0, 5)
    model = Model(Scene((rod,)))
    q = s * model.rods[0].q0
    N = YOUNG * rod.section.area * 0.5 * (s**2 - 1.0) * s
    assert largest_wave(model, q.ravel()) == pytest.approx(0.2 * np.sqrt(-N / stiffness(rod)), rel=1e-9)
