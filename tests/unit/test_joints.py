# ruff: noqa: E501
"""Joints and moved sections: conditions, tangent, what they carry, and what a scene may not join."""

import math

import numpy as np
import pytest

import ancf
from ancf.coupled_system import CoupledSystem, _odd
from ancf.model import Model
from ancf.rotation import exp

E, NU, R = 1e6, 0.3, 0.01
EI = E * math.pi * R**4 / 4
GJ = E / (2 * (1 + NU)) * math.pi * R**4 / 2


UPRIGHT = np.eye(3)


def rod(name="arm", length=1.0, elements=6, radius=R, **more):
    return {
        "name": name, "length": length, "elements": elements,
        "section": {"shape": "circle", "radius": radius},
        "material": {"young_modulus": E, "poisson_ratio": NU}, **more,
    }  # fmt: skip


def joint(kind="rigid", a=("arm", 1.0), b="ground", **more):
    ends = {
        key: end if end == "ground" else dict(zip(("rod", "at"), end, strict=True))
        for key, end in (("a", a), ("b", b))
    }
    return {"kind": kind, **ends, **more}


def frame(load, kind="rigid", turn=UPRIGHT, shift=(0.0, 0.0, 0.0), **more):
    """Column along y, clamped at its foot, and a beam along x at its head; a force on the beam's tip."""
    x, y, _ = np.asarray(turn).T
    shift = np.asarray(shift, float)
    column = rod("column", base={"position": shift, "x_axis": y, "y_axis": -x}, supports=[{"at": 0.0}])
    beam = rod("beam", base={"position": shift + y, "x_axis": x, "y_axis": y})
    joints = [joint(kind, ("column", 1.0), ("beam", 0.0), **more)]
    forces = [{"rod": "beam", "value": turn @ np.array([0.0, -load, 0.3 * load]) * EI}]
    return {"rod": [column, beam], "joint": joints, "force": forces}


def solved(scene, start=None):
    solution = ancf.solve(ancf.scene_from_dict(scene), start=start)
    assert solution.status == "converged", solution.message
    return solution


# --- conditions and tangent --------------------------------------------------------------------------------


def joined(kind, element="3333", moved=True):
    """Two rods, one curved, at an angle, joined; the far end held and moved."""
    bent = rod(
        "b",
        0.8,
        3,
        element=element,
        curvature=[0, 0.4, 0.9],
        base={"position": [1, 0, 0], "x_axis": [1, 2, 2], "y_axis": [0, 1, 0]},
    )
    if not moved:
        bent["supports"] = [{"at": 1.0}]
    joints = [joint(kind, ("a", 1.0), ("b", 0.0), **({"axis": [1, 2, 2]} if kind == "hinge" else {}))]
    if moved:
        joints.append(joint("rigid", ("b", 1.0), displacement=[0.1, 0.2, 0.3], rotation=[1, 2, -1]))
    return Model(
        ancf.scene_from_dict(
            {"rod": [rod("a", 1.0, 3, element=element, supports=[{}]), bent], "joint": joints}
        )
    )


def state(model, seed=0, size=0.05):
    """Somewhere near the reference, with multipliers of one unit."""
    change = np.random.default_rng(seed).uniform(-1, 1, model.n)
    q = model.q0 + size * model.unit * change
    q[model.motions :] = (model.unit * change)[model.motions :]
    return q


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
@pytest.mark.parametrize("kind", ["rigid", "hinge", "ball"])
def test_tangent_and_rate_are_the_derivatives(kind, element):
    """Central differences err by h^2 f'''/6 + eps f/h = 1e-9 at h = 1e-5; the residual is of size 1."""
    model, at, h = joined(kind, element), 0.7, 1e-5
    assert model.constraints is not None
    q = state(model)
    for part in model.constraints.models:
        x, terms = q[part.dofs], part.terms(q[part.dofs], at)
        tangent = terms.tangent.reshape(len(x), -1)
        unit, force_unit = model.unit[part.dofs], part.energy / model.unit[part.dofs]
        for j, step in enumerate(h * unit):
            change = np.eye(len(x))[j] * step
            slope = (part.terms(x + change, at).g - part.terms(x - change, at).g) / (2 * step)
            np.testing.assert_allclose(
                tangent[:, j] * unit[j] / force_unit,
                slope * unit[j] / force_unit,
                atol=1e-7,
            )
        rate = (part.terms(x, at + h).g - part.terms(x, at - h).g) / (2 * h)
        np.testing.assert_allclose(terms.rate / force_unit, rate / force_unit, atol=1e-8)
        scaled = tangent * unit / force_unit[:, None]
        np.testing.assert_allclose(scaled, scaled.T, atol=1e-12 * np.abs(scaled).max())


def test_the_whole_residual_has_this_tangent_and_load():
    """A directional difference of the model's residual, multipliers and load factor included."""
    model, at, h = joined("hinge"), 0.7, 1e-6
    q, dq = state(model), model.unit * np.random.default_rng(3).uniform(-1, 1, model.n)
    forces, flat = model.residual_and_tangent(q, at)
    assert isinstance(model.system, CoupledSystem)
    slope = (model.residual(q + h * dq, at).at(at) - model.residual(q - h * dq, at).at(at)) / (2 * h)
    found = model.system.unsupported(flat) @ dq
    scale = np.max(np.abs(slope / model.force_unit))
    np.testing.assert_allclose(found / model.force_unit, slope / model.force_unit, atol=1e-8 * scale)
    rate = (model.residual(q, at + h).at(at + h) - model.residual(q, at - h).at(at - h)) / (2 * h)
    np.testing.assert_allclose(-forces.Q_ext / model.force_unit, rate / model.force_unit, atol=1e-7)


@pytest.mark.parametrize("kind", ["rigid", "hinge", "ball"])
def test_rigid_motions_do_no_work(kind):
    """A joint of two rods turned as a whole: the residual turns, sum of forces and of moments vanish."""
    model = joined(kind, moved=False)
    assert model.constraints is not None
    (part,) = model.constraints.models
    x = state(model)[part.dofs]
    force = part.terms(x, 1.0).g[: -part.conditions].reshape(-1, 3)
    vectors = x[: -part.conditions].reshape(-1, 3)
    half = len(vectors) // 2
    np.testing.assert_allclose(sum(force[i] for i in range(0, len(force), 3)), 0.0, atol=1e-12 * part.energy)
    # Positions are relative to the base of each rod: about the joint, the moment of either half is -+m.
    gap = part.terms(x, 1.0).g[-part.conditions :][:3]
    moments = [
        np.cross(v, f).sum(axis=0)
        for v, f in ((vectors[:half], force[:half]), (vectors[half:], force[half:]))
    ]
    lever = [
        np.cross(s.shape @ part_vectors, sign * x[-part.conditions :][:3])
        for s, part_vectors, sign in zip(
            part.sections, (vectors[:half], vectors[half:]), (1, -1), strict=True
        )
    ]
    np.testing.assert_allclose(moments[0] - lever[0], -(moments[1] - lever[1]), atol=1e-12 * part.energy)
    assert np.linalg.norm(gap) > 1e-3


def test_conditions_measure_gap_and_angle():
    """A section turned by 0.2 rad about z: sin(0.2) in the rigid joint, and in a hinge about x alone."""
    for kind, more, expected in (
        ("rigid", {}, [0.1, 0, 0, 0, 0, math.sin(0.2)]),
        ("hinge", {"axis": [1, 0, 0]}, None),
        ("hinge", {"axis": [0, 0, 1]}, [0.1, 0, 0, 0, 0]),
        ("ball", {}, [0.1, 0, 0]),
    ):
        model = Model(ancf.scene_from_dict({"rod": [rod(supports=[{}])], "joint": [joint(kind, **more)]}))
        assert model.constraints is not None
        (part,) = model.constraints.models
        vectors = model.q0[part.dofs[: -part.conditions]].reshape(-1, 3) @ exp(np.array([0, 0, 0.2])).T
        x = np.concatenate([vectors.ravel(), np.zeros(part.conditions)])
        x[: -part.conditions] += (
            part.sections[0].to_position.T
            @ (np.array([0.1, 0, 0]) + part.sections[0].r_0 - part.sections[0].shape @ vectors)
            / np.sum(part.sections[0].shape ** 2)
        )
        g = part.terms(x, 0.0).g[-part.conditions :]
        if expected is None:
            assert np.linalg.norm(g[3:]) == pytest.approx(math.sin(0.2), abs=1e-12)
        else:
            np.testing.assert_allclose(g, expected, atol=1e-12)
        assert part.closed(x, 0.0)


@pytest.mark.parametrize(
    "kind, more, fits",
    [
        ("rigid", {}, False),
        ("hinge", {"axis": [0, 1, 0]}, False),
        ("hinge", {"axis": [1, 0, 0]}, True),
        ("ball", {}, True),
    ],
)
def test_half_a_turn_meets_the_conditions_and_is_no_solution(kind, more, fits):
    model = Model(ancf.scene_from_dict({"rod": [rod(supports=[{}])], "joint": [joint(kind, **more)]}))
    assert model.constraints is not None
    (part,) = model.constraints.models
    vectors = model.q0[part.dofs[: -part.conditions]].reshape(-1, 3) @ exp(np.array([math.pi, 0, 0])).T
    x = np.concatenate([vectors.ravel(), np.zeros(part.conditions)])
    np.testing.assert_allclose(part.terms(x, 0.0).g[-part.conditions :], 0.0, atol=1e-12)
    assert part.closed(x, 0.0) is fits


# --- linear algebra ----------------------------------------------------------------------------------------


def test_parity_of_permutations():
    rng = np.random.default_rng(0)
    for n in (1, 2, 5, 12):
        p = rng.permutation(n)
        assert (-1) ** _odd(p) == round(np.linalg.det(np.eye(n)[p]))


@pytest.mark.parametrize("shift", [0.0, -2e4, 3e4])
def test_negative_eigenvalues_are_those_across_the_conditions(shift):
    """The tangent projected onto the null space of supports and conditions: `eigvalsh` is the reference.

    The stiffness is shifted by a share of the unit matrix so that there are some.
    """
    model = joined("hinge")
    assert isinstance(model.system, CoupledSystem) and model.constraints is not None
    _, flat = model.residual_and_tangent(state(model, size=0.02), 0.7)
    n, m = model.motions, model.n - model.motions
    diagonal = model.pattern.slots(np.arange(n), np.arange(n))
    flat[diagonal] -= shift * (model.force_unit / model.unit)[:n]
    K = model.boundary_matrix().T @ model.system.unsupported(flat) @ model.boundary_matrix()
    unit = np.abs(model.boundary_matrix()).T @ model.unit
    K = K.toarray() * unit * unit[:, None]
    C, free = K[-m:, :-m], K[:-m, :-m]
    across = np.linalg.svd(C)[2][m:].T
    expected = np.count_nonzero(np.linalg.eigvalsh(across.T @ free @ across) < 0.0)
    assert (expected > 0) == (shift >= 0.0)  # the random state compresses some elements
    assert model.system.negative_eigenvalues(flat) == expected
    assert model.system.is_positive_definite(flat) == (expected == 0)
    assert model.system.factorise(flat).determinant_sign == (-1) ** expected


def test_solve_and_row_sum():
    model = joined("rigid")
    _, flat = model.residual_and_tangent(state(model), 0.7)
    assert isinstance(model.system, CoupledSystem)
    dq = model.system.project(model.unit * np.random.default_rng(5).uniform(-1, 1, model.n))
    K = model.system.unsupported(flat)
    found = model.system.solve(model.system.factorise(flat), K @ dq)
    np.testing.assert_allclose(found / model.unit, dq / model.unit, atol=1e-7)
    dense = np.abs(K.toarray()) @ np.abs(dq) / model.force_unit
    assert model.system.row_sum(flat, dq) == pytest.approx(dense.max(), rel=1e-12)


# --- what joints carry -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "moment, tolerance", [([0, 0, 0.9], 1e-10), ([0.8, 0, 0], 1e-10), ([0.3, 0.4, 0.9], 2e-6)]
)
def test_two_rods_in_line_are_one(moment, tolerance):
    """In a uniform state even the sections are the same.

    Where it varies, sections at the joint stretch each by itself: of the order of the element's error, which
    is 3e-6 here (8 against 32 elements).
    """
    moment = EI * np.array(moment)
    held = [{"kind": "free_section_clamp"}]  # a clamp would hold the contraction of the section
    one = solved({"rod": [rod(elements=8, supports=held)], "moment": [{"value": moment}]})
    halves = [rod("a", 0.5, 4, supports=held), rod("b", 0.5, 4, base={"position": [0.5, 0, 0]})]
    joints = [joint("rigid", ("a", 1.0), ("b", 0.0))]
    two = solved({"rod": halves, "joint": joints, "moment": [{"rod": "b", "value": moment}]})
    np.testing.assert_allclose(two.tip("b").position, one.tip().position, atol=tolerance)
    np.testing.assert_allclose(two.tip("b").rotation, one.tip().rotation, atol=10 * tolerance)
    np.testing.assert_allclose(two.joints[0].moment, moment, atol=1e-9 * EI)


@pytest.mark.parametrize("load", [1.0, 8.0])
def test_the_joint_carries_what_balances_the_beam(load):
    """Free body of the beam: joint force = load, moment = lever x load; of the whole: the clamp's reaction."""
    solution = solved(frame(load))
    force = np.array([0.0, -load, 0.3 * load]) * EI
    lever = solution.tip("beam").position - solution.pose("beam", 0.0).position
    carried = solution.joints[0]
    np.testing.assert_allclose(carried.force, force, atol=1e-9 * EI)
    np.testing.assert_allclose(carried.moment, np.cross(lever, force), atol=1e-9 * EI)
    reaction = solution.reaction("column")
    np.testing.assert_allclose(reaction[0], -force, atol=1e-9 * EI)
    np.testing.assert_allclose(reaction[1], -np.cross(solution.tip("beam").position, force), atol=1e-9 * EI)
    np.testing.assert_allclose(solution.reaction("beam"), 0.0, atol=1e-9 * EI)
    a, b = solution.pose("column", 1.0), solution.pose("beam", 0.0)
    np.testing.assert_allclose(a.position, b.position, atol=1e-10)
    np.testing.assert_allclose(a.rotation, b.rotation, atol=1e-9)


def portal(kind, **more):
    """Column and beam as in `frame`, the far end of the beam clamped to the ground; a force on the corner."""
    scene = frame(0.0, kind, **more)
    scene["rod"][1]["supports"] = [{"at": 1.0}]
    scene["force"] = [{"rod": "column", "value": [3 * EI, -2 * EI, 1.0 * EI]}]
    return solved(scene)


def test_a_ball_carries_no_moment_and_a_hinge_none_about_its_axis():
    ball = portal("ball").joints[0]
    np.testing.assert_array_equal(ball.moment, 0.0)
    assert np.linalg.norm(ball.force) > 0.1 * EI
    hinge = portal("hinge", axis=[0, 0, 2])
    a, b = hinge.pose("column", 1.0).rotation, hinge.pose("beam", 0.0).rotation
    np.testing.assert_allclose(a[:, 2], b[:, 2], atol=1e-9)
    assert np.linalg.norm(a[:, 0] - b[:, 0]) > 0.01  # it does turn
    moment = hinge.joints[0].moment
    assert abs(moment @ a[:, 2]) < 1e-9 * EI
    assert np.linalg.norm(moment) > 0.01 * EI
    rigid = portal("rigid")
    np.testing.assert_allclose(
        rigid.pose("column", 1.0).rotation, rigid.pose("beam", 0.0).rotation, atol=1e-9
    )
    assert rigid.status == "converged" and abs(rigid.joints[0].moment[2]) > 0.01 * EI


@pytest.mark.parametrize("element", ["3333", "3243"])
def test_rigid_to_ground_is_a_clamp_with_free_section(element):
    """The same conditions on a circle: r and the polar rotation against r, r_y.x, r_z.x, r_y.z - r_z.y."""
    load = {"force": [{"value": [0.4 * EI, 2 * EI, 1 * EI]}]}
    held = solved({"rod": [rod(element=element, supports=[{"kind": "free_section_clamp"}])], **load})
    glued = solved({"rod": [rod(element=element)], "joint": [joint(a=("arm", 0.0))], **load})
    np.testing.assert_allclose(glued.nodes(), held.nodes(), atol=1e-10)
    np.testing.assert_allclose(glued.reaction()[0], held.reaction()[0], atol=1e-8 * EI)
    np.testing.assert_allclose(glued.reaction()[1], held.reaction()[1], atol=1e-8 * EI)
    np.testing.assert_allclose(glued.joints[0].force, [-0.4 * EI, -2 * EI, -EI], atol=1e-8 * EI)


def test_invariance_of_a_frame():
    """Turned, moved far away, with the ends of its joint exchanged: the same frame."""
    plain = solved(frame(2.0))
    turn, shift = exp(np.array([0.4, -1.1, 0.7])), np.array([1e4, -2e4, 5e3])
    moved = solved(frame(2.0, turn=turn, shift=shift))
    expected = plain.nodes("beam") @ turn.T + shift
    np.testing.assert_allclose(moved.nodes("beam"), expected, atol=1e-9)
    np.testing.assert_allclose(moved.joints[0].moment, turn @ plain.joints[0].moment, atol=1e-8 * EI)
    scene = frame(2.0)
    scene["joint"][0]["a"], scene["joint"][0]["b"] = scene["joint"][0]["b"], scene["joint"][0]["a"]
    scene["rod"].reverse()
    swapped = solved(scene)
    np.testing.assert_allclose(swapped.nodes("beam"), plain.nodes("beam"), atol=1e-9)
    np.testing.assert_allclose(swapped.joints[0].force, -plain.joints[0].force, atol=1e-9 * EI)


def test_newton_stays_quadratic():
    """Observed order from the last steps above rounding, log(s_2/s_1) / log(s_1/s_0)."""
    for scene in (frame(0.5), frame(1.0)):
        steps = [i.step for i in solved(scene).history]
        s = [step for step in steps if 1e-12 < step < 0.01][-3:]
        order = math.log(s[2] / s[1]) / math.log(s[1] / s[0])
        assert order >= 1.8, steps


# --- moved sections ----------------------------------------------------------------------------------------


def test_several_turns_of_an_end():
    """Twist by 2 turns: torque G J phi / L; an element turns by 0.39, and nothing moves aside."""
    phi, radius = 4 * math.pi, 0.0025
    scene = {
        "rod": [rod(elements=32, radius=radius, supports=[{}])],
        "joint": [joint(rotation=[phi, 0, 0])],
    }  # strain phi R / L = 0.03
    solution = solved(scene)
    torque = GJ * (radius / R) ** 4 * phi
    assert solution.joints[0].moment[0] == pytest.approx(torque, rel=1e-3)
    np.testing.assert_allclose(solution.nodes()[:, 1:], 0.0, atol=1e-12)
    moment = solution.section_forces().moment
    np.testing.assert_allclose(moment[:, 0], solution.joints[0].moment[0], rtol=1e-3)
    assert solution.reaction()[1][0] == pytest.approx(0.0, abs=1e-6 * torque)  # clamp and joint together


@pytest.mark.parametrize("kind", ["rigid", "hinge", "ball"])
def test_a_moved_section_is_where_it_was_sent(kind):
    more = {"axis": [0, 0, 1]} if kind == "hinge" else {}
    turn = {"rotation": [0.2, -0.3, 0.5]} if kind == "rigid" else {}
    shift = [-0.2, 0.3, 0.1]
    scene = {"rod": [rod(supports=[{}])], "joint": [joint(kind, displacement=shift, **more, **turn)]}
    solution = solved(scene)
    tip = solution.tip()
    np.testing.assert_allclose(tip.position, np.array([1.0, 0, 0]) + shift, atol=1e-10)
    if kind == "rigid":
        np.testing.assert_allclose(tip.rotation, exp(np.array(turn["rotation"])), atol=1e-9)
    elif kind == "hinge":
        np.testing.assert_allclose(tip.rotation[:, 2], [0, 0, 1], atol=1e-9)
    carried = solution.joints[0]
    total = solution.reaction()[0]
    np.testing.assert_allclose(total, 0.0, atol=1e-7 * EI)  # of clamp and joint: the rod is in equilibrium
    np.testing.assert_allclose(solution.section_forces().force[-1], carried.force, rtol=0.2, atol=0.2 * EI)
