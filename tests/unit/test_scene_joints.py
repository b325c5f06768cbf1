# ruff: noqa: E501
"""Joints in a scene: what is read, and what may not be joined."""

import copy
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancf
from tests.unit.test_joints import EI, frame, joint, rod, solved


def scene_of(*joints, **second):
    """A clamped arm and a finger in line behind it."""
    return {
        "rod": [rod(supports=[{}]), rod("finger", base={"position": [1, 0, 0]}, **second)],
        "joint": list(joints),
    }


LINE = joint("rigid", ("arm", 1.0), ("finger", 0.0))
HINGED = scene_of(joint("hinge", ("arm", 1.0), ("finger", 0.0), axis=[0, 0, 1]))
REFUSED = [
    (scene_of(joint("glue")), "joint[0].kind", "Unknown kind 'glue'", "rigid"),
    (scene_of({"kind": "rigid", "a": {"rod": "arm", "at": 1}}), "joint[0].b", "missing", "only"),
    (scene_of(joint(b=("fingr", 0))), "joint[0].b.rod", "There is no rod named 'fingr'", "arm, finger"),
    (scene_of(joint(a=("arm", 1.5))), "joint[0].a.at", "out of range", "between 0 and 1"),
    (scene_of(joint(a="ground")), "joint[0].a", "holds nothing", "ground"),
    (scene_of(joint(b=("arm", 1.0))), "joint[0].b", "to itself", "at 1"),
    (scene_of(joint(b=("finger", 0.5))), "joint[0].b", "are apart", "0.5 m, must be <= 1e-06"),
    (scene_of(joint("hinge", b=("finger", 0.0))), "joint[0].axis", "missing", "only"),
    (scene_of(joint("hinge", b=("finger", 0.0), axis=[0, 0, 0])), "joint[0].axis", "no direction", "[0, 0, 0]"),
    (scene_of(joint("ball", b=("finger", 0.0), axis=[0, 0, 1])), "joint[0].axis", "does not belong to a ball", "axis"),
    (scene_of({**LINE, "displacement": [0, 0, 1]}), "joint[0].displacement", "does not belong", "displacement"),
    (scene_of(LINE, joint("ball", ("finger", 1.0), rotation=[1, 0, 0])), "joint[1].rotation", "does not belong", "rotation"),
    (scene_of(LINE, LINE), "joint[1]", "held already", "'finger' at 0: 6"),
    (scene_of(LINE, joint(a=("arm", 0.0))), "joint[1]", "held already", "'arm' at 0: 6"),
    (scene_of(joint("ball", ("arm", 1.0), ("finger", 0.0))), "rod[1].supports", "mechanism", "3 of its motions"),
    (scene_of(joint("hinge", ("arm", 1.0), ("finger", 0.0), axis=[0, 1, 0])), "rod[1].supports", "mechanism", "1 of its motions"),
    (scene_of(joint("ball", ("arm", 1.0), ("finger", 0.0)), supports=[{"at": 1.0, "kind": "pin"}]), "rod[1].supports", "mechanism", "'finger'"),
    ({**HINGED, "spring": [{"rod": "finger", "stiffness": 0}]}, "rod[1].supports", "mechanism", "1 of its motions strain neither rod nor spring"),
    ({**HINGED, "spring": [{"rod": "finger", "stiffness": [1, 0, 1]}]}, "rod[1].supports", "mechanism", "1 of its motions"),
    ({**HINGED, "spring": [{"rod": "finger", "stiffness": 1, "anchor": [3, 0, 0]}]}, "rod[1].supports", "mechanism", "1 of its motions"),
    ({**HINGED, "foundation": [{"rod": "finger", "stiffness": [1, 0, 1]}]}, "rod[1].supports", "mechanism", "1 of its motions"),
    # Springs at the ball hold its point once more, one about the rod its spin: two rotations are left.
    ({"rod": [rod(supports=[])], "joint": [joint("ball", ("arm", 1.0), "ground")], "spring": [{"stiffness": 1, "rotational_stiffness": [1, 0, 0]}]}, "rod[0].supports", "mechanism", "2 of its motions"),
    ({"rod": [rod(elements=2, supports=[])], "joint": [joint(a=("arm", at)) for at in (0.0, 0.2, 0.4, 1.0)]}, "rod[0].elements", "fewer elements", "pieces = 3"),
    ({"rod": [rod(supports=[])]}, "rod[0].supports", "no support", "supports = []"),
]  # fmt: skip


@pytest.mark.parametrize("data, where, what, value", REFUSED)
def test_refusals_say_what_where_and_value(data, where, what, value):
    with pytest.raises(ancf.SceneError) as caught:
        ancf.scene_from_dict(data)
    message = caught.value.message
    assert message.where.endswith(f": {where}"), message
    assert what in message.what and value in message.value, message


@pytest.mark.parametrize(
    "elastic",
    [
        {"spring": [{"rod": "finger", "stiffness": 1}]},
        {"spring": [{"rod": "finger", "stiffness": [0, 1, 0], "at": 0.5}]},
        {"spring": [{"rod": "finger", "rotational_stiffness": [0, 0, 1]}]},
        {"foundation": [{"rod": "finger", "rotational_stiffness": [0, 0, 1]}]},
        {"spring": [{"rod": "finger", "stiffness": [1, 0, 0], "at": 0.0, "offset": [0.01, 0]}]},
        {"spring": [{"rod": "finger", "stiffness": 1, "anchor": [2, 1, 0]}]},
        {"spring": [{"rod": "finger", "stiffness": 1, "anchor": [3, 0, 0], "free_length": 0.5}]},
        {"foundation": [{"rod": "finger", "stiffness": [0, 1, 0], "from": 0.8}]},
        {"foundation": [{"rod": "finger", "stiffness": [0, 1, 0], "frame": "section"}]},
    ],
)
def test_springs_and_beds_hold_what_a_hinge_leaves_free(elastic):
    assert solved({**HINGED, **elastic, "force": [{"rod": "finger", "value": [0, -1e-6, 0]}]}).stable


def test_a_rod_on_a_hinge_and_a_spring_turns_as_a_lever():
    """Force F on the tip against a spring k to the reference: k L sin(t) = F cos(t), hence tan(t) = F/(k L).

    The rod stays straight; the rest of force and spring, k L (1 - cos(t)) ..., compresses it by 1e-5.
    """
    k = 1e-2 * EI
    solution = solved(
        {
            "rod": [rod(supports=[])],
            "joint": [joint("hinge", ("arm", 0.0), "ground", axis=[0, 0, 1])],
            "spring": [{"stiffness": k}],
            "force": [{"value": [0, -k, 0]}],  # L = 1 m: 45 degrees
        }
    )
    np.testing.assert_allclose(solution.tip().position, [math.sqrt(0.5), -math.sqrt(0.5), 0.0], atol=1e-5)
    assert solution.stable


def test_what_holds_is_accepted():
    """A ring of pins that is no mechanism, and rods without supports of their own."""
    three = [
        rod(name, base={"x_axis": x, "y_axis": y, "position": p})
        for name, x, y, p in (
            ("a", [1, 0, 0], [0, 1, 0], [0, 0, 0]),
            ("b", [0, 1, 0], [-1, 0, 0], [1, 0, 0]),
            ("c", [-1, 0, 0], [0, -1, 0], [1, 1, 0]),
        )
    ]
    hinge = {"axis": [0, 0, 1]}
    joints = [
        joint(a=("a", 0.0)),
        joint("hinge", ("a", 1.0), ("b", 0.0), **hinge),
        joint("hinge", ("b", 1.0), ("c", 0.0), **hinge),
        joint(a="ground", b=("c", 1.0)),
    ]
    scene = ancf.scene_from_dict({"rod": three, "joint": joints})
    assert [r.supports for r in scene.rods] == [(), (), ()]
    assert scene.joints[3].a.rod == "c" and scene.joints[3].b is None


JUNK = [None, 3, -1, 1e308, math.nan, "ground", "x", [], {}, [1], [0, 0, 0], [1e300] * 3, True, "1 m", {"rod": 3}, {"at": 1}, {"rod": "finger", "at": 0.5}, [{}], np.ones(3)]  # fmt: skip


@given(data=st.data())
@settings(deadline=None, max_examples=100)
def test_a_spoilt_joint_is_read_or_refused(data):
    """Any value in the place of a joint or of one of its keys; nothing but a SceneError may come of it."""
    second = joint("hinge", ("finger", 1.0), axis=[0, 0, 1], displacement=[0, 0.1, 0])
    scene = copy.deepcopy(scene_of(LINE, second))
    table = data.draw(st.sampled_from([*scene["joint"], *(j["a"] for j in scene["joint"]), scene["joint"]]))
    key = data.draw(st.sampled_from([*table] if isinstance(table, dict) else [0, 1]))
    table[key] = copy.deepcopy(data.draw(st.sampled_from(JUNK)))
    try:
        scene = ancf.scene_from_dict(scene)
    except ancf.SceneError as error:
        assert error.message.advice
    else:
        assert len(scene.joints) == 2


def test_a_scene_without_joints_has_none():
    solution = solved({"rod": [rod()], "force": [{"value": [0, EI, 0]}]})
    assert solution.joints == [] and "joints" not in solution.as_dict()
    assert solution.model.n == solution.model.motions and solution.model.longest_step == math.inf


def test_json_state_and_check(tmp_path):
    solution = solved(frame(1.0))
    (entry,) = json.loads(json.dumps(solution.as_dict()))["joints"]
    assert entry["kind"] == "rigid" and entry["a"] == {"rod": "column", "at": 1.0}
    assert entry["b"] == {"rod": "beam", "at": 0.0}
    np.testing.assert_allclose(entry["moment"], solution.joints[0].moment)
    assert solution.as_dict()["effects"]["joint"]["calls"] > 0
    solution.save(tmp_path / "state.npz")
    again = ancf.resume(ancf.scene_from_dict(frame(1.0)), tmp_path / "state.npz")
    assert again.iterations <= 2
    with pytest.raises(ancf.InputError, match="does not belong"):
        ancf.resume(ancf.scene_from_dict(portal_scene()), tmp_path / "state.npz")


def portal_scene():
    scene = frame(1.0, "hinge", axis=[0, 0, 1])
    scene["rod"][1]["supports"] = [{"at": 1.0}]
    return scene
