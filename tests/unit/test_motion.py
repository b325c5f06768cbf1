"""Prescribed motion of a section: the joint with the ground that it stands for, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancf
from ancf.model import Model
from ancf.rotation import exp, log
from reference.elastica import elastica_tip_force

L, RADIUS, YOUNG = 0.5, 2.5e-3, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4
MOVE, TURN = [-0.1, 0.15, 0.02], [0.0, 0.0, 0.6]


def scene(motion, elements=8, **tables):
    rod = {
        "length": L, "elements": elements, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3},
    }  # fmt: skip
    return ancf.scene_from_dict({"rod": [rod], "motion": motion, **tables})


def test_a_tip_goes_where_it_is_sent():
    """Position and rotation as prescribed; the clamp at the base stays, and both carry the same force."""
    solution = ancf.solve(scene([{"displacement": MOVE, "rotation": TURN}]))
    assert solution.status == "converged"
    tip = solution.tip()
    np.testing.assert_allclose(tip.position, np.array([L, 0, 0]) + MOVE, rtol=0, atol=1e-9 * L)
    c, s = np.cos(0.6), np.sin(0.6)
    np.testing.assert_allclose(tip.rotation, [[c, -s, 0], [s, c, 0], [0, 0, 1]], rtol=0, atol=1e-9)
    force, _ = solution.reaction()
    np.testing.assert_allclose(force, 0.0, atol=1e-8 * EI / L**2)


def test_a_position_alone_leaves_the_rotation_free():
    """No moment is carried; a small deflection w at the tip takes 3 E I w/L^3 (Euler-Bernoulli)."""
    w = 1e-3 * L
    solution = ancf.solve(scene([{"hold": "position", "displacement": [0.0, w, 0.0]}]))
    (carried,) = solution.joints
    np.testing.assert_array_equal(carried.moment, 0.0)
    stretch = 0.6 * w**2 / L * YOUNG * np.pi * RADIUS**2 / L  # the tip may not come nearer: it is pulled too
    assert carried.force[1] == pytest.approx(3 * EI * w / L**3 + carried.force[0] * 1.2 * w / L, rel=5e-3)
    assert 0.0 < carried.force[0] < 1.1 * stretch


def test_it_is_the_joint_with_the_ground():
    """The same unknowns and answer as `[[joint]]` with a clamp written out."""
    moved = ancf.solve(scene([{"at": 0.5, "displacement": [0, 0.05, 0], "rotation": TURN}]))
    data = {"kind": "rigid", "a": {"at": 0.5}, "b": "ground", "displacement": [0, 0.05, 0], "rotation": TURN}
    rod = {
        "length": L,
        "elements": 8,
        "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3},
        "supports": [{"at": 0.0}],
    }
    joined = ancf.solve(ancf.scene_from_dict({"rod": [rod], "joint": [data]}))
    np.testing.assert_array_equal(moved.q, joined.q)


@pytest.mark.parametrize(
    ("keys", "hint"),
    [
        ({}, "neither displacement nor rotation"),
        ({"displacement": MOVE, "hold": "position", "rotation": TURN}, "left free"),
        ({"displacement": MOVE, "hold": "all"}, "pose"),
        ({"displacement": [0.0, 1.0]}, "exactly 3"),
        ({"displacement": [0.0, float("nan"), 0.0]}, "displacement"),
        ({"displacement": MOVE, "at": 1.5}, "at"),
        ({"displacement": MOVE, "at": 0.0}, "held already"),
        ({"displacement": MOVE, "rod": "leg"}, "leg"),
        ({"displacment": MOVE}, "displacement"),
    ],
)
def test_bad_motions_are_refused(keys, hint):
    with pytest.raises(ancf.SceneError) as refused:
        scene([keys])
    assert hint in str(refused.value) and "motion[0]" in str(refused.value)


def held(**keys):
    return scene([keys])


@pytest.mark.parametrize("load", [0.5, 3.0, 10.0])
def test_a_roller_carries_the_force_of_the_elastica(load):
    """Only y of the tip is moved, to where the elastica has it under P: force P, all else is free."""
    exact = elastica_tip_force(load)
    moved = {"hold": ["y"], "displacement": [0.0, exact.w * L, 0.0]}
    solution = ancf.solve(scene([moved], elements=24))
    assert solution.status == "converged" and solution.stable
    (carried,) = solution.joints
    P = load * EI / L**2
    assert carried.force[0] == carried.force[2] == 0.0
    np.testing.assert_array_equal(carried.moment, 0.0)
    # Finite strain: 1.4 (kappa R)^2 = 7e-4 at P L^2/E I = 10, kappa L = 4.4 at the clamp; measured 8e-4.
    assert carried.force[1] == pytest.approx(P, rel=1.2e-3)
    tip = solution.tip()
    np.testing.assert_allclose(tip.position, L * np.array([1 - exact.u, exact.w, 0.0]), rtol=0, atol=2e-4 * L)
    assert tip.position[1] == pytest.approx(exact.w * L, abs=1e-9 * L)
    force, _ = solution.reaction()  # with that of the roller, which is on the ground
    np.testing.assert_allclose(force, 0.0, atol=1e-9 * EI / L**2)
    assert solution.balance().relative < 1e-10


def test_a_propped_cantilever_on_a_roller():
    """3/8 q L of a line load on the roller, no thrust; a fixed prop would pull (Euler and Bernoulli)."""
    q = 1e-2 * EI / L**3
    solution = ancf.solve(scene([{"hold": ["y"]}], line_load=[{"value": [0.0, -q, 0.0]}]))
    (carried,) = solution.joints
    assert carried.force[1] == pytest.approx(3 * q * L / 8, rel=1e-4)
    assert carried.force[0] == 0.0
    entry = solution.as_dict()["joints"][0]
    assert entry["hold"] == ["y"] and entry["force"][1] == carried.force[1]


@pytest.mark.parametrize(("name", "axis"), [("rx", 0), ("ry", 1), ("rz", 2)])
def test_a_rotation_alone_takes_a_couple(name, axis):
    """The tip is turned by 2 rad about one axis and free otherwise: an arc, or a twist, of M = S phi/L."""
    phi = 2.0
    solution = ancf.solve(held(hold=[name], rotation=(phi * np.eye(3)[axis]).tolist()))
    (carried,) = solution.joints
    stiffness = EI / 1.3 if name == "rx" else EI  # GJ at nu = 0.3
    exact = stiffness * phi / L * np.eye(3)[axis]
    np.testing.assert_allclose(carried.moment, exact, rtol=0, atol=1e-3 * EI / L)  # 3333's clamp: 2.5e-4
    np.testing.assert_array_equal(carried.force, 0.0)
    np.testing.assert_allclose(log(solution.tip().rotation), phi * np.eye(3)[axis], rtol=0, atol=1e-9)
    straight = [L, 0, 0] if name == "rx" else L / phi * np.array([np.sin(phi), 0, 0])
    assert solution.tip().position[0] == pytest.approx(straight[0], abs=1e-3 * L)


def test_a_sliding_clamp():
    """Moved by w without turning, free to slide: 12 E I w/L^3 and 6 E I w/L^2 (Euler and Bernoulli)."""
    w = 1e-3 * L
    solution = ancf.solve(held(hold=["rz", "y"], displacement=[0.0, w, 0.0]))
    (carried,) = solution.joints
    assert carried.force[1] == pytest.approx(12 * EI * w / L**3, rel=1e-3)
    assert carried.moment[2] == pytest.approx(-6 * EI * w / L**2, rel=1e-3)
    assert carried.force[0] == carried.force[2] == 0.0
    np.testing.assert_allclose(carried.moment[:2], 0.0, atol=1e-12 * EI / L)
    assert solution.tip().rotation[1, 0] == pytest.approx(0.0, abs=1e-10)


def test_a_twist_is_held_while_the_section_swings():
    """v . n = w tan(phi/2) of the quaternion of R; the couple is about n half turned with the swing."""
    phi = 0.7
    forces = [{"value": [0.0, 1.5 * EI / L**2, EI / L**2]}]
    solution = ancf.solve(scene([{"hold": ["rx"], "rotation": [phi, 0.0, 0.0]}], force=forces))
    theta = log(solution.tip().rotation)
    angle = np.linalg.norm(theta)
    assert angle > 1.0
    assert 2 * np.arctan2(np.sin(angle / 2) * theta[0] / angle, np.cos(angle / 2)) == pytest.approx(
        phi, abs=1e-9
    )
    swing = log(solution.tip().rotation @ exp([-phi, 0.0, 0.0]))
    assert swing[0] == pytest.approx(0.0, abs=1e-9)
    (carried,) = solution.joints
    about = exp(0.5 * swing) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(np.cross(carried.moment, about), 0.0, atol=1e-9 * EI / L)
    assert abs(carried.moment @ about) > 0.1 * EI / L
    assert solution.balance().relative < 1e-10


def test_two_rotations_are_a_hinge():
    """All positions and rx, ry held: the joint with the ground that is hinged about z."""
    tables = {"force": [{"at": 0.5, "value": [0.0, 0.0, EI / L**2]}]}
    hold = ["x", "y", "z", "rx", "ry"]
    moved = ancf.solve(scene([{"hold": hold, "displacement": MOVE}], **tables))
    data = scene([{"displacement": MOVE}]).rods[0]
    rod = {
        "length": L, "elements": 8, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3}, "supports": [{"at": 0.0}],
    }  # fmt: skip
    hinge = {
        "kind": "hinge",
        "axis": [0, 0, 1],
        "a": {"at": data.length / L},
        "b": "ground",
        "displacement": MOVE,
    }
    hinged = ancf.solve(ancf.scene_from_dict({"rod": [rod], "joint": [hinge], **tables}))
    np.testing.assert_array_equal(moved.q, hinged.q)


@pytest.mark.parametrize(
    ("hold", "word", "keys"),
    [
        (["x", "y", "z", "rx", "ry", "rz"], "pose", {"displacement": MOVE, "rotation": TURN}),
        (["z", "y", "x"], "position", {"displacement": MOVE}),
    ],
)
def test_all_components_are_the_word(hold, word, keys):
    listed, named = (ancf.solve(held(hold=one, **keys)) for one in (hold, word))
    np.testing.assert_array_equal(listed.q, named.q)


def test_a_beam_on_a_pin_and_a_roller():
    """P L/4 in the middle, P/2 on the roller: supports that a motion completes; without rx it could spin."""
    P = 1e-2 * EI / L**2
    rod = {
        "length": L, "elements": 8, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3}, "supports": [{"at": 0.0, "kind": "pin"}],
    }  # fmt: skip
    tables = {"rod": [rod], "force": [{"at": 0.5, "value": [0.0, -P, 0.0]}]}
    solution = ancf.solve(ancf.scene_from_dict(tables | {"motion": [{"hold": ["y", "z", "rx"]}]}))
    assert solution.joints[0].force[1] == pytest.approx(P / 2, rel=1e-6)
    assert -solution.pose(None, 0.5).position[1] == pytest.approx(P * L**3 / (48 * EI), rel=1e-3)
    with pytest.raises(ancf.SceneError, match="mechanism"):
        ancf.scene_from_dict(tables | {"motion": [{"hold": ["y", "z"]}]})
    unsupported = tables | {"rod": [rod | {"supports": []}], "motion": [{"hold": ["y"]}]}
    with pytest.raises(ancf.SceneError, match="mechanism"):
        ancf.scene_from_dict(unsupported)


@settings(deadline=None, max_examples=10)
@given(
    st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3), st.sampled_from([["y"], ["x", "rz"], ["rx", "z"]])
)
def test_axes_of_the_body_turn_with_it(numbers, hold):
    """A turned rod with the motion in its own axes has the turned answer."""
    motion = {"hold": hold, "frame": "body"}
    motion |= {"displacement": [0.1 * L * (c in hold) for c in "xyz"]}
    motion["rotation"] = [0.5 * (c in hold) for c in ("rx", "ry", "rz")]
    if motion["rotation"] == [0.0] * 3:
        del motion["rotation"]
    turn, found = exp(np.array(numbers)), []
    for A in (np.eye(3), turn):
        base = {"x_axis": A[:, 0].tolist(), "y_axis": A[:, 1].tolist()}
        rod = {
            "length": L, "elements": 6, "section": {"shape": "circle", "radius": RADIUS}, "base": base,
            "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3},
        }  # fmt: skip
        motion["displacement"][0] = -abs(motion["displacement"][0])
        force = (A @ [0.0, 0.4 * EI / L**2, EI / L**2]).tolist()
        data = {"rod": [rod], "motion": [motion], "force": [{"value": force}]}
        solution = ancf.solve(ancf.scene_from_dict(data))
        assert solution.status == "converged"
        (carried,) = solution.joints
        found.append([A.T @ v for v in (solution.tip().position, carried.force, carried.moment)])
    for one, other, unit in zip(*found, (L, EI / L**2, EI / L), strict=True):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-7 * unit)


@pytest.mark.parametrize(
    "hold", [["y"], ["x", "z", "rx"], ["rz"], ["y", "rx", "rz"], ["x", "y", "rx", "ry", "rz"]]
)
def test_tangent_and_rate_are_the_derivatives(hold):
    """dg/dq and dg/dl of the whole residual at a random state, by central differences; symmetric."""
    displacement = [0.2 * L * (c in hold) for c in "xyz"]
    rotation = [0.8 * (c in hold) for c in ("rx", "ry", "rz")]
    motion = {"hold": hold, "displacement": displacement, "at": 0.5}
    motion |= {"rotation": rotation} if any(rotation) else {}
    model = Model(scene([motion]))
    assert model.n - model.motions == len(hold)
    rng = np.random.default_rng(7)
    q = model.q0 + 0.05 * rng.uniform(-1, 1, model.n) * model.unit
    q[model.motions :] = rng.uniform(-2, 2, len(hold)) * model.unit[model.motions :]
    way, step = rng.uniform(-1, 1, model.n) * model.unit, 1e-6
    forces, flat = model.residual_and_tangent(q, 0.6)
    ends = [model.residual(q + s * step * way, 0.6).at(0.6) for s in (1, -1)]
    change = (ends[0] - ends[1]) / (2 * step)
    K = model.system.unsupported(flat)
    own = slice(model.motions, None)
    for part in (np.s_[: model.motions], own):
        scaled = (K @ way / model.force_unit)[part], (change / model.force_unit)[part]
        np.testing.assert_allclose(*scaled, rtol=0, atol=1e-6 * np.abs(scaled[1]).max())
    assert abs(K - K.T).max() <= 1e-12 * abs(K).max()
    ends = [model.residual(q, 0.6 + s).at(0.6 + s) for s in (1e-4, -1e-4)]
    rate = -(ends[0] - ends[1]) / 2e-4 / model.force_unit
    np.testing.assert_allclose(forces.Q_ext / model.force_unit, rate, rtol=0, atol=1e-6 * np.abs(rate).max())


def test_states_and_sensitivities(tmp_path):
    """A state goes back where the same components are held only; the slope by a force is that of solves."""
    motion, P = [{"hold": ["y", "rx"], "displacement": [0.0, 0.1 * L, 0.0]}], EI / L**2

    def solved(value):
        return ancf.solve(scene(motion, force=[{"value": value}]))

    solution = solved([0.1 * P, 0.0, P])
    solution.save(tmp_path / "state.npz")
    assert ancf.resume(solution.scene, tmp_path / "state.npz").iterations <= 2
    other = scene([{"hold": ["z", "rx"], "displacement": [0.0, 0.0, 0.1 * L]}])
    with pytest.raises(ancf.InputError, match="does not belong"):
        ancf.resume(other, tmp_path / "state.npz")
    h = 1e-3 * P
    ends = [solved([0.1 * P, 0.0, P + s * h]).tip().position for s in (1, -1)]
    slope = (ends[0] - ends[1]) / (2 * h)
    np.testing.assert_allclose(solution.sensitivity("force")[:3, 2], slope, rtol=0, atol=1e-5 * L / P)
    assert solution.sensitivity("force")[1, 2] == pytest.approx(0.0, abs=1e-9 * L / P)


def test_a_swing_of_half_a_turn_has_no_twist():
    """rx is held and a couple bends the tip round by 1.2 pi: a reason in place of an answer."""
    couple = [{"value": [0.0, 0.0, 1.2 * np.pi * EI / L]}]
    solution = ancf.solve(scene([{"hold": ["rx"]}], moment=couple))
    assert solution.status == "not_converged" and "half a turn off" in solution.reason
    below = [{"value": [0.0, 0.0, 0.8 * np.pi * EI / L]}]
    assert ancf.solve(scene([{"hold": ["rx"]}], moment=below)).status == "converged"


@pytest.mark.parametrize(
    ("keys", "hint"),
    [
        ({"hold": []}, "holds nothing"),
        ({"hold": ["y", "y"]}, "twice"),
        ({"hold": ["ry", "yy"]}, "yy"),
        ({"hold": [3]}, "Unknown component 3"),
        ({"hold": {"y": 1}}, "list"),
        ({"hold": ["y"], "displacement": [0.1, 0.1, 0.0]}, "leaves free"),
        ({"hold": ["y", "rx"], "rotation": [0.1, 0.0, 0.2]}, '"rz" is not among'),
        ({"hold": ["y"], "rotation": [0.0, 0.0, 0.0]}, "left free"),
        ({"hold": ["y"], "frame": "section"}, "frame"),
        ({"hold": ["y"], "at": 0.0}, "held already"),
        ({"hold": ["y"], "free": ["x"]}, "free"),
    ],
)
def test_bad_components_are_refused(keys, hint):
    with pytest.raises(ancf.SceneError) as refused:
        scene([keys])
    message = str(refused.value)
    assert hint in message and "motion[0]" in message and "try:" in message


def test_a_component_is_not_held_twice():
    with pytest.raises(ancf.SceneError, match="held already"):
        scene([{"hold": ["y", "z"]}, {"hold": ["y"]}])
    assert len(scene([{"hold": ["y"]}, {"hold": ["z"]}]).joints) == 2
