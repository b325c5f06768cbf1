"""Exact sensitivities against differences of whole solves, and against closed forms where there are any."""

from dataclasses import replace

import numpy as np
import pytest

import ancf

L, RADIUS, YOUNG = 0.4, 0.01, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4


def scene(rod=None, **tables):
    data = {
        "length": L, "elements": 5, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
        "base": {"position": [1.0, 2.0, 3.0], "x_axis": [1.0, 0.2, 0.0], "y_axis": [0.0, 1.0, 1.0]},
        "curvature": [0.2, 0.5, -1.0],
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


FOLLOWER = {"value": [0.2 * EI / L, 0, EI / L], "frame": "body", "direction": "follower"}
LOADS = {
    "moment": [{"value": [0.0, 0.5 * EI / L, EI / L], "at": 0.6}, FOLLOWER],
    "force": [{"value": [0.0, EI / L**2, 0.0], "offset": [0.0, 0.005], "frame": "body"}],
    "line_load": [{"value": [0.0, 0.0, EI / L**3], "direction": "follower", "frame": "body"}],
    "gravity": {"acceleration": [0.0, 0.0, -1.0]},
}  # fmt: skip


def pose(solution):
    assert solution.status == "converged"
    tip = solution.tip()
    return np.concatenate([tip.position, tip.r_x, tip.r_y, tip.r_z])


def differences(at, step):
    """Fourth-order differences of whole solves."""
    return (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step)


def agrees(found, expected):
    """To what differences of solves to 1e-10 with a step of 1e-3 leave."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-7 * np.abs(expected).max())


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
@pytest.mark.parametrize(
    ("name", "index"), [("moment", 0), ("moment", 1), ("force", 0), ("line_load", 0), ("gravity", 0)]
)
def test_by_loads(element, name, index):
    if name == "gravity":
        given, axes = LOADS["gravity"]["acceleration"], np.eye(3)
    else:
        given, axes = LOADS[name][index]["value"], np.eye(3)
    solution = ancf.solve(scene({"element": element}, **LOADS))
    found = solution.sensitivity(name, index=index)
    size = np.linalg.norm(given)

    def at(value):
        if name == "gravity":
            tables = LOADS | {"gravity": {"acceleration": value.tolist()}}
        else:
            loads = list(LOADS[name])
            loads[index] = loads[index] | {"value": value.tolist()}
            tables = LOADS | {name: loads}
        return pose(ancf.solve(scene({"element": element}, **tables), start=solution.q))

    for axis in range(3):
        expected = differences(lambda s, axis=axis: at(np.array(given) + s * axes[axis]), 1e-2 * size)
        agrees(found[:, axis] * size, expected * size)


NUMBERS = ["young_modulus", "poisson_ratio", "density", "length", "radius"]


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize(
    "supports", [[{"at": 0.0}], [{"at": 1.0}], [{"at": 0.0}, {"at": 1.0, "kind": "pin"}]]
)
def test_by_numbers_of_the_rod(name, supports):
    """Also where a support at the far end moves with the length."""
    solution = ancf.solve(scene({"supports": supports}, **LOADS))
    (rod,) = solution.scene.rods
    where = "material" if hasattr(rod.material, name) else "section" if hasattr(rod.section, name) else None
    record = getattr(rod, where) if where else rod
    value = getattr(record, name)

    def at(s):
        changed = replace(record, **{name: value * (1 + s)})
        moved = replace(rod, **{where: changed}) if where else changed
        # The clamped pose is relative to a base that stays where it is.
        return pose(ancf.solve(replace(solution.scene, rods=(moved,)), start=solution.q))

    # Held at both ends the shape changes with (R/L)^2: a small step.
    agrees(solution.sensitivity(name) * value, differences(at, 3e-4))


def test_by_curvature():
    solution = ancf.solve(scene(**LOADS))
    (rod,) = solution.scene.rods

    def at(axis, s):
        moved = replace(rod, curvature=rod.curvature + s * np.eye(3)[axis])
        return pose(ancf.solve(replace(solution.scene, rods=(moved,)), start=solution.q))

    found = solution.sensitivity("curvature")
    for axis in range(3):
        agrees(found[:, axis], differences(lambda s, axis=axis: at(axis, s), 5e-3))


def test_the_linear_beam():
    """A straight thin rod: dw/dP = L^3/(3 E I), dw/dM = L^2/(2 E I), d theta/dM = L/(E I) (beam theory)."""
    straight = {
        "curvature": [0, 0, 0],
        "base": {"position": [0, 0, 0]},
        "section": {"shape": "circle", "radius": 1e-3},
    }
    stiffness = YOUNG * np.pi * 1e-12 / 4
    tables = {"moment": [{"value": [0.0, 0.0, 0.0]}], "force": [{"value": [0.0, 0.0, 0.0]}]}
    solution = ancf.solve(scene(straight, **tables))
    by_force, by_moment = solution.sensitivity("force"), solution.sensitivity()
    assert by_force[1, 1] == pytest.approx(L**3 / (3 * stiffness), rel=1e-4)
    assert by_moment[1, 2] == pytest.approx(L**2 / (2 * stiffness), rel=1e-4)
    assert by_moment[6, 2] == pytest.approx(-L / stiffness, rel=1e-4)  # r_y turns to -x
    assert by_moment.shape == (12, 3)


def test_rows_of_a_batch():
    tables = {"moment": [{"value": [0.0, 0.0, 1.0], "frame": "body"}]}
    rows = np.array([[0.1, 0.5, 1.0], [0.3, -1.0, 0.2]]) * EI / L
    batch = ancf.solve_batch(scene(**tables), rows)
    found = batch.sensitivity()
    assert found.shape == (2, 12, 3)
    for row in range(2):
        tables["moment"][0]["value"] = rows[row].tolist()
        alone = ancf.solve(scene(**tables)).sensitivity("moment")
        np.testing.assert_allclose(found[row], alone, rtol=0, atol=1e-7 * np.abs(alone).max())


def test_rods_beside_each_other():
    """The tip of one rod does not depend on the load of another; a missing rod is refused."""
    two = [scene().rods[0], replace(scene().rods[0], name="other")]
    loaded = replace(scene(moment=[{"value": [0, 0, EI / L]}]), rods=tuple(two))
    solution = ancf.solve(loaded)
    assert np.abs(solution.sensitivity("moment")).max() > 0.0
    assert not solution.sensitivity("moment", rod="other").any()
    on_the_other = replace(loaded.moments[0], rod="other")
    solution = ancf.solve(replace(loaded, moments=(on_the_other,)))
    assert solution.sensitivity("moment").any() and not solution.sensitivity("moment", rod="rod").any()
    with pytest.raises(ancf.InputError, match="no such rod"):
        solution.sensitivity("moment", rod="third")


@pytest.mark.parametrize(
    ("name", "index", "hint"),
    [
        ("moment", 2, "2 [[moment]]"),
        ("gravity", 0, "no [gravity]"),
        ("width", 0, "radius"),
        ("height_y", 0, "radius"),
    ],
)
def test_what_has_no_derivative_is_refused(name, index, hint):
    tables = {"moment": LOADS["moment"]}
    with pytest.raises(ancf.InputError) as refused:
        ancf.solve(scene(**tables)).sensitivity(name, index=index)
    assert hint in str(refused.value)
