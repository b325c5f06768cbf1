"""Prescribed motion of a section: the joint with the ground that it stands for, and what is refused."""

import numpy as np
import pytest

import ancf

L, RADIUS, YOUNG = 0.5, 2.5e-3, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4
MOVE, TURN = [-0.1, 0.15, 0.02], [0.0, 0.0, 0.6]


def scene(motion, **tables):
    rod = {
        "length": L, "elements": 8, "section": {"shape": "circle", "radius": RADIUS},
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
