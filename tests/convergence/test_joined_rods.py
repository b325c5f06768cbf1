"""Rods with joints and moved sections against closed forms of thin rods."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import ancf

E, NU = 1e6, 0.3


def bending_stiffness(radius):
    return E * math.pi * radius**4 / 4


def rod(name="arm", elements=16, radius=0.005, **more):
    return {
        "name": name, "length": 1.0, "elements": elements,
        "section": {"shape": "circle", "radius": radius},
        "material": {"young_modulus": E, "poisson_ratio": NU}, **more,
    }  # fmt: skip


def ground(at=1.0, **more):
    return {"kind": "rigid", "a": {"rod": "arm", "at": at}, "b": "ground", **more}


def solved(scene, start=None):
    solution = ancf.solve(ancf.scene_from_dict(scene), start=start)
    assert solution.status == "converged", solution.message
    return solution


@pytest.mark.parametrize("load", [[0, -1, 0], [0, 0, 1]])
def test_right_angle_frame_under_a_small_force(load):
    """Euler-Bernoulli, column along y and beam along x of length L, force P on the tip.

    In the plane the column carries the couple P L: head moved by P L^3/(2 EI) and turned by P L^2/EI, tip by
    P L^3/(3 EI) more: (1/2, 4/3). Out of it both bend by P L^3/(3 EI) and the column twists by P L^2/GJ: 2/3
    + EI/GJ, EI/GJ = 1 + nu. Shear and stretch add (R/L)^2.
    """
    EI = bending_stiffness(0.005)
    column = rod("column", base={"x_axis": [0, 1, 0], "y_axis": [-1, 0, 0]}, supports=[{}])
    beam = rod("beam", base={"position": [0, 1, 0]})
    joint = {"kind": "rigid", "a": {"rod": "column", "at": 1}, "b": {"rod": "beam", "at": 0}}
    size = 1e-6
    force = {"rod": "beam", "value": (size * EI * np.array(load)).tolist()}
    tip = solved({"rod": [column, beam], "joint": [joint], "force": [force]}).tip("beam").position
    expected = [0.5, -4 / 3, 0] if load[1] else [0, 0, 2 / 3 + 1 + NU]
    np.testing.assert_allclose((tip - [1, 1, 0]) / size, expected, atol=1e-3)


@pytest.mark.parametrize("share, limit", [(0.3, 1e-3), (0.8, 3e-3)])
def test_ends_brought_together(share, limit):
    """Clamped-clamped elastica: P = 16 K^2 EI/L^2, shortening 2 - 2 E/K (Love, Elasticity, art. 263).

    The straight rod buckles at 4 pi^2 EI/L^2. At `share` = 1 its ends would meet at P/P_E = 2.18; there the
    closed curve may slide along itself, and the equilibrium is no longer isolated.
    """
    EI = bending_stiffness(0.005)
    joints = [ground(0.0), ground(displacement=[-share, 0, 0])]
    solution = solved({"rod": [rod()], "joint": joints, "stability": {"branch": "buckled"}})
    m = brentq(lambda m: 2 - 2 * ellipe(m) / ellipk(m) - share, 1e-6, 0.99)
    np.testing.assert_allclose(solution.joints[1].force / (16 * ellipk(m) ** 2 * EI), [-1, 0, 0], atol=limit)
    np.testing.assert_allclose(solution.joints[0].force, -solution.joints[1].force, atol=1e-6 * EI)
    assert solution.stability is not None
    first = solution.stability.critical_points[0]
    # The straight rod of area A carries P = E A u/L.
    P = first.load_factor * share * E * math.pi * 0.005**2
    assert first.kind == "bifurcation" and len(first.modes) == 2
    assert pytest.approx(4 * math.pi**2 * EI, rel=1e-3) == P


def test_a_rod_closed_to_a_ring():
    """Curvature 2 pi/L everywhere, moment 2 pi EI/L, no force: the end is turned once and moved to the base.

    A round rod has a neutral motion there, about the tangent at the joint; it keeps its plane.
    """
    EI = bending_stiffness(0.005)
    joint = ground(displacement=[-1, 0, 0], rotation=[0, 0, 2 * math.pi])
    solution = solved({"rod": [rod(supports=[{}])], "joint": [joint]})
    np.testing.assert_allclose(solution.joints[0].moment / (2 * math.pi * EI), [0, 0, 1], atol=2e-3)
    np.testing.assert_allclose(solution.joints[0].force / EI, 0.0, atol=2e-3)
    np.testing.assert_allclose(solution.section_forces().moment[:, 2] / (2 * math.pi * EI), 1.0, atol=3e-3)
    radii = np.linalg.norm(solution.nodes() - [0, 0.5 / math.pi, 0], axis=1)
    np.testing.assert_allclose(radii, 0.5 / math.pi, rtol=2e-3)
    assert solution.stable


def test_a_ring_under_twist_loses_stability_at_michells_angle():
    """Michell (1889): 2 pi sqrt(3) EI/GJ = 14.15 rad; up to it the ring is flat, its torque GJ phi/L."""
    GJ = bending_stiffness(0.005) / (1 + NU)
    critical = 2 * math.pi * math.sqrt(3) * (1 + NU)
    joint = ground(displacement=[-1, 0, 0], rotation=[0, 0, 2 * math.pi])
    scene = {"rod": [rod(supports=[{}])], "joint": [joint]}
    q, stable = solved(scene).q, {}
    for angle in [*np.linspace(0.5, 0.99 * critical, 24), 1.02 * critical]:
        # A full turn about z and none are one rotation: the ring itself is the start.
        scene["joint"] = [{**joint, "rotation": [angle, 0, 0]}]
        solution = solved(scene, start=q)
        q, stable[angle] = solution.q, solution.stable
        assert solution.joints[0].moment[0] == pytest.approx(GJ * angle, rel=2e-2)
    assert [*stable.values()] == [True] * 24 + [False]


def singular(N, T):
    """Smallest singular value of the clamped-clamped conditions of a straight rod, tension N and torque T.

    In units of EI and L, EI w'''' - i T w''' - N w'' = 0 for w = y + i z: w = 1, x, exp(i k x) with
    k = T/2 +- sqrt(T^2/4 - N) (Greenhill 1883; Love, art. 272).
    """
    root = np.sqrt(complex(T**2 / 4 - N))
    k = np.array([T / 2 + root, T / 2 - root])
    end = np.exp(1j * k)
    rows = [[1, 0, 1, 1], [0, 1, *(1j * k)], [1, 1, *end], [0, 1, *(1j * k * end)]]
    return np.linalg.svd(np.array(rows))[1][-1]


def test_a_twisted_and_pushed_rod_buckles_where_greenhill_says():
    """Force and torque at the critical point of the straight path; beyond it the path is unstable.

    Twist alone does not buckle this rod while its ends are held apart: see the next test.
    """
    radius, shortening, twist = 0.002, 1e-4, 6.0
    EI = bending_stiffness(radius)
    joints = [ground(0.0), ground(displacement=[-shortening, 0, 0], rotation=[twist, 0, 0])]
    scene = {"rod": [rod(elements=24, radius=radius)], "joint": joints, "stability": {}}
    solution = solved(scene)
    assert solution.stability is not None
    assert solution.stable is False and solution.stability.negative_pivots > 0
    np.testing.assert_allclose(solution.nodes()[:, 1:], 0.0, atol=1e-9)
    first = solution.stability.critical_points[0]
    assert 0.0 < first.load_factor < 1.0 and first.kind == "bifurcation"
    model = solution.model
    assert model.constraints is not None
    joint = model.constraints.models[1]
    force, moment = joint.forces(first.point.q[joint.dofs], first.load_factor)
    N, T = force[0] / EI, moment[0] / EI
    assert T > 1.5 and N < -30.0
    nearest = min(np.linspace(0.98, 1.02, 401), key=lambda f: singular(f * N, T))
    assert nearest == pytest.approx(1.0, abs=2e-3)


def test_twist_alone_keeps_a_held_rod_straight_and_stable():
    """Four turns: torque GJ phi/L, nothing aside, and no buckling at Greenhill's 8.99 EI/L.

    Ends held apart meet Poynting's tension, of the order of phi^2 EI/L^2 whatever the slenderness. By
    `reference.section.twist` (its stretch without force) it is 0.538 of that for Saint Venant-Kirchhoff at
    nu = 0.3, (1 - nu)/(1 + nu): more than T^2/(4 EI), below which a straight rod of any length is stable
    (Love, art. 272).
    """
    radius, phi = 0.001, 8 * math.pi
    EI = bending_stiffness(radius)
    scene = {"rod": [rod(elements=40, radius=radius, supports=[{}])], "joint": [ground(rotation=[phi, 0, 0])]}
    solution = solved(scene)
    carried = solution.joints[0]
    assert carried.moment[0] == pytest.approx(EI / (1 + NU) * phi, rel=2e-3)
    np.testing.assert_allclose(solution.nodes()[:, 1:], 0.0, atol=1e-12)
    assert carried.force[0] == pytest.approx(0.538 * phi**2 * EI, rel=5e-3)
    assert carried.force[0] > carried.moment[0] ** 2 / (4 * EI)
    assert solution.stable


def test_twist_alone_buckles_a_held_rod_of_rubber():
    """Neo-Hookean: Poynting's force is -0.231 phi^2 EI/L^2 (`reference.section.twist`, nu = 0.3), a push."""
    radius = 0.002
    EI = bending_stiffness(radius)
    rubber = rod(elements=16, radius=radius, element="3363")
    rubber["material"]["law"] = "neo-hookean"
    joints = [ground(0.0), ground(rotation=[3 * math.pi, 0, 0])]
    solution = solved({"rod": [rubber], "joint": joints, "stability": {}})
    assert solution.stability is not None and solution.model.constraints is not None
    assert solution.stability.negative_pivots > 0
    first = solution.stability.critical_points[0]
    joint, phi = solution.model.constraints.models[1], 3 * math.pi * first.load_factor
    force, moment = joint.forces(first.point.q[joint.dofs], first.load_factor)
    N, T = force[0] / EI, moment[0] / EI
    assert pytest.approx(-0.231 * phi**2, rel=5e-3) == N
    nearest = min(np.linspace(0.98, 1.02, 401), key=lambda f: singular(f * N, f * T))
    assert nearest == pytest.approx(1.0, abs=5e-3)


def test_lees_frame_snaps_through():
    """Right-angle frame on two hinges, force at a fifth of the beam: limit points at 18.552 and -9.4 EI/L^2.

    Legs of 120 cm, section 3 x 2 cm, any stiffness (Lee, Manuel, Rossow 1968, J. Eng. Mech. Div.
    94; Schweizerhof, Wriggers 1986, Comput. Methods Appl. Mech. Eng. 59). Shear adds (h/L)^2 = 3e-4.
    Out of its plane the frame branches between them; a planar model does not see that.
    """
    leg = {
        "length": 1.2, "elements": 12, "section": {"shape": "rectangle", "height_y": 0.02, "width_z": 0.03},
        "material": {"young_modulus": 7.2e8, "poisson_ratio": 0.3},
    }  # fmt: skip
    column = {"name": "column", "base": {"x_axis": [0, 1, 0], "y_axis": [-1, 0, 0]}, **leg}
    beam = {"name": "beam", "base": {"position": [0, 1.2, 0]}, **leg}

    def place(name, at):
        return {"rod": name, "at": at}

    hinge = {"kind": "hinge", "axis": [0, 0, 1], "b": "ground"}
    joints = [
        {**hinge, "a": place("column", 0.0)},
        {"kind": "rigid", "a": place("column", 1.0), "b": place("beam", 0.0)},
        {**hinge, "a": place("beam", 1.0)},
    ]
    full, unit = 30.0, 7.2e8 * 0.03 * 0.02**3 / 12 / 1.2**2
    scene = {
        "rod": [column, beam], "joint": joints,
        "force": [{"rod": "beam", "at": 0.2, "value": [0, -full * unit, 0]}],
        "solver": {"method": "arclength"},
    }  # fmt: skip
    solution = solved(scene)
    assert solution.stability is not None
    limits = [c.load_factor * full for c in solution.stability.critical_points if c.kind == "limit"]
    assert limits[0] == pytest.approx(18.552, rel=3e-3)
    assert limits[1] == pytest.approx(-9.4, rel=1e-2)
    assert len(limits) == 2 and solution.stable


def test_a_right_angle_frame_of_a_strip_buckles_out_of_its_plane():
    """Cantilever frame, in-plane force at the free end: 1.088 N (Argyris et al. 1979; Simo, Vu-Quoc 1986).

    Legs of 240 mm, section 30 x 0.6 mm, E = 71.24 GPa, nu = 0.31. The section of 3333 does not warp:
    `shear_factors` bring G (I_y + I_z) to the torsion constant 30 0.6^3/3 = 2.16 mm^4 of the strip.
    """
    factor = 2.16 / (30 * 0.6**3 / 12 + 0.6 * 30**3 / 12)
    leg = {
        "length": 0.24, "elements": 10, "shear_factors": [factor, factor],
        "section": {"shape": "rectangle", "height_y": 0.030, "width_z": 0.0006},
        "material": {"young_modulus": 71.24e9, "poisson_ratio": 0.31},
    }  # fmt: skip
    held = {"name": "held", "supports": [{"at": 0.0}], **leg}
    free = {
        "name": "free",
        "base": {"position": [0.24, 0, 0], "x_axis": [0, -1, 0], "y_axis": [1, 0, 0]},
        **leg,
    }
    joint = {"kind": "rigid", "a": {"rod": "held", "at": 1.0}, "b": {"rod": "free", "at": 0.0}}
    force = {"rod": "free", "value": [2.0, 0, 0]}
    solution = solved({"rod": [held, free], "joint": [joint], "force": [force], "stability": {}})
    assert solution.stability is not None and solution.stability.buckling_factor is not None
    assert 2.0 * solution.stability.buckling_factor == pytest.approx(1.088, rel=3e-3)
    assert solution.stability.negative_pivots == 1
