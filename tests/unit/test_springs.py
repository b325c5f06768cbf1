"""Springs and elastic foundations: closed forms, exact derivatives, balance, refusals."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancf
from ancf.effects.foundation import ElasticFoundation
from ancf.effects.spring import AnchoredSpring, ReferenceSpring
from ancf.model import Model
from ancf.rotation import exp
from reference.foundation import end_of_long_beam, middle_of_long_beam, propped_cantilever_tip
from tests.effect_checks import blocks, check_derivatives

L, RADIUS, YOUNG = 1.0, 0.0025, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4
GA = YOUNG / 2 * np.pi * RADIUS**2  # at nu = 0


def scene(rod=None, **tables):
    data = {
        "length": L, "elements": 16, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.0, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


def balance(solution, arm=1.0):
    """Sum of the forces on the rod: loads, reaction, springs."""
    result = solution.as_dict()
    held = [entry["force"] for key in ("springs", "foundations") for entry in result.get(key, [])]
    return solution.reaction()[0] + np.sum(held, axis=0) + sum(f.value for f in solution.scene.forces)


def test_a_cantilever_on_a_spring():
    """Tip of a propped cantilever, the prop between elements and elastic (reference/foundation.py)."""
    k, at, P = 20 * EI / L**3, 0.37, 1e-4 * EI / L**2
    solution = ancf.solve(
        scene(
            {"base": {"position": [3.0, -1.0, 2.0]}},
            force=[{"value": [0, P, 0]}],
            spring=[{"at": at, "stiffness": k}],
        )
    )
    exact = propped_cantilever_tip(L, EI, P, k, at * L)
    assert solution.tip().position[1] + 1.0 == pytest.approx(exact, rel=2e-4)  # shear: 3 E I/(G A L^2) = 1e-5
    (spring,) = solution.as_dict()["springs"]
    assert spring["force"][1] == pytest.approx(-k * (solution.pose(None, at).position[1] + 1.0), rel=1e-9)
    np.testing.assert_allclose(balance(solution), 0.0, atol=1e-10 * EI / L**2)


@pytest.mark.parametrize("element", ["3333", "3343", "3363"])
@pytest.mark.parametrize("load", ["force", "moment"])
def test_the_end_of_a_long_beam_on_a_bed(element, load):
    """Deflection and slope of the loaded end; beta L = 14 keeps the clamp out of sight (Hetenyi, shear)."""
    k = 4 * EI * (14 / L) ** 4
    P, M = (1e-8, 0.0) if load == "force" else (0.0, 1e-9)
    table = {"force": [{"value": [0, -P, 0]}]} if load == "force" else {"moment": [{"value": [0, 0, M]}]}
    bed = [{"stiffness": [0, k, 0.3 * k]}]
    solution = ancf.solve(scene({"elements": 48, "element": element}, foundation=bed, **table))
    # Seen from the end the beam goes on towards -x: deflection -y, so that its rotation is that about z.
    w, phi = end_of_long_beam([0.0, 0.1], k, EI, P, M, GA)
    ends = [solution.tip(), solution.pose(None, 0.9)]
    assert solution.stable is not False
    np.testing.assert_allclose([-end.position[1] for end in ends], w, rtol=0, atol=1e-3 * np.abs(w).max())
    np.testing.assert_allclose([end.rotation[1, 0] for end in ends], phi, rtol=0, atol=3e-3 * abs(phi[0]))


def test_the_middle_of_a_long_beam_on_a_bed():
    """Force on an infinite beam (Hetenyi 1946, eq. 5); shear adds (beta R)^2 (1 + nu)/2 = 3e-4."""
    k, P = 4 * EI * (14 / L) ** 4, 1e-8
    rod = {"elements": 64, "length": 2 * L}
    solution = ancf.solve(
        scene(rod, force=[{"at": 0.5, "value": [0, 0, P]}], foundation=[{"stiffness": [0, 0, k]}])
    )
    found = [solution.pose(None, 0.5 + x / (2 * L)).position[2] for x in (-0.1, 0.0, 0.05)]
    exact = middle_of_long_beam([-0.1, 0.0, 0.05], k, EI, P)
    assert found == pytest.approx(exact, rel=2e-3)


def test_part_of_a_rod_on_a_bed():
    """A bed from 0.4 to 0.7 under a rod that is moved rigidly carries k (0.7 - 0.4) L u."""
    model = Model(scene(foundation=[{"stiffness": [1.0, 2.0, 3.0], "from": 0.41, "to": 0.68}]))
    (bed,) = model.effects
    q = model.q0.reshape(-1, 3).copy()
    q[::3] += [0.1, 0.2, 0.3]
    force = bed.report(blocks(model, bed, q.ravel()))["force"]
    np.testing.assert_allclose(force, -0.27 * L * np.array([0.1, 0.4, 0.9]), rtol=1e-12)


def test_axes_of_a_stiffness():
    """In body axes the base turns the stiffness, in section axes the reference curvature does too."""
    base = {"x_axis": [0, 1, 0], "y_axis": [0, 0, 1]}
    curved = {"base": base, "curvature": [0, 0, 2.0]}
    found = []
    for frame in ("structure", "body", "section"):
        table = {"stiffness": [1.0, 2.0, 3.0], "frame": frame, "from": 0.999999}
        (bed,) = Model(scene(curved, foundation=[table])).effects
        assert isinstance(bed, ElasticFoundation)
        found.append(bed.k[0].sum(axis=0) / 1e-6)
    A = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float).T
    turned = A @ exp(np.array([0, 0, 2.0]))
    for k, axes in zip(found, (np.eye(3), A, turned), strict=True):
        np.testing.assert_allclose(k, axes @ np.diag([1.0, 2.0, 3.0]) @ axes.T, atol=1e-5)
    (spring,) = Model(scene(curved, spring=[{"stiffness": [1.0, 2.0, 3.0], "frame": "body"}])).effects
    assert isinstance(spring, ReferenceSpring)
    np.testing.assert_allclose(spring.k, A @ np.diag([1.0, 2.0, 3.0]) @ A.T, atol=1e-15)


CASES = {
    "reference": {"spring": [{"at": 0.3, "stiffness": [1.0, 2.0, 3.0], "offset": [0.001, -0.0005]}]},
    "anchor": {"spring": [{"at": 0.7, "stiffness": 2.0, "anchor": [0.2, 0.3, 0.1], "free_length": 0.2}]},
    "no free length": {"spring": [{"stiffness": 2.0, "anchor": [0.2, 0.3, 0.1], "free_length": 0.0}]},
    "bed": {"foundation": [{"stiffness": [1.0, 2.0, 3.0], "frame": "section", "from": 0.11, "to": 0.83}]},
}


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
@pytest.mark.parametrize("name", CASES)
def test_force_and_tangent_are_derivatives(name, element):
    model = Model(scene({"element": element, "elements": 5, "curvature": [1.0, 2.0, -1.0]}, **CASES[name]))
    check_derivatives(model, strain=0.05, step=1e-5)
    assert model.conservative and all(effect.passive for effect in model.effects)


@settings(deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_an_anchored_spring_pulls_along_its_line(numbers):
    """F = -k (l - l_0) along the line from the anchor to the point, wherever the rod is moved."""
    anchor, k, free = np.array([0.1, -0.2, 0.3]), 3.0, 0.5
    table = {"at": 0.6, "stiffness": k, "anchor": anchor.tolist(), "free_length": free}
    model = Model(scene({"base": {"position": [1.0, 2.0, 3.0]}}, spring=[table]))
    (spring,) = model.effects
    assert isinstance(spring, AnchoredSpring)
    q = model.q0.reshape(-1, 3) @ exp(np.array(numbers[:3])).T
    q[::3] += numbers[3:]
    e = blocks(model, spring, q.ravel())
    place = spring.S @ e[0] + [1.0, 2.0, 3.0]
    arm = place - anchor
    report = spring.report(e)
    size = np.linalg.norm(arm)
    assert report["length"] == pytest.approx(size, rel=1e-12)
    np.testing.assert_allclose(report["force"], -k * (size - free) * arm / size, atol=1e-12)
    assert spring.potential(e) == pytest.approx(0.5 * k * (size - free) ** 2, abs=1e-12)


def test_a_stretched_spring_pulls_without_load():
    """A spring 1 % short of its anchor bends the cantilever: two springs in a row, k and 3 E I/L^3."""
    k, short = 3 * EI / L**3, 1e-4
    table = {"stiffness": k, "anchor": [L, 0.05, 0.0], "free_length": 0.05 - short}
    solution = ancf.solve(scene(spring=[table]))
    assert solution.tip().position[1] == pytest.approx(short / 2, rel=1e-3)
    path = ancf.solve(scene(spring=[table], force=[{"value": [0, 1e-9, 0]}], solver={"method": "arclength"}))
    at_once = ancf.solve(scene(spring=[table], force=[{"value": [0, 1e-9, 0]}]))
    np.testing.assert_allclose(path.tip().position, at_once.tip().position, atol=1e-9)
    first = path.path[0]
    assert first.load_factor == 0.0
    assert first.q[path.model.rods[0].q0.size - 8] == pytest.approx(short / 2, rel=1e-3)  # y of the tip


def test_a_stiff_spring_is_a_support():
    """A large force on a rod whose end a stiff spring holds: the start knows nothing of it, Newton does."""
    force = [{"at": 0.5, "value": [0, 40 * EI / L**2, 0]}]
    held = ancf.solve(scene(force=force, spring=[{"stiffness": 1e9 * EI / L**3}]))
    pinned = ancf.solve(
        scene({"supports": [{"at": 0.0, "kind": "clamp"}, {"at": 1.0, "kind": "pin"}]}, force=force)
    )
    assert held.status == "converged"
    np.testing.assert_allclose(held.pose(None, 0.5).position, pinned.pose(None, 0.5).position, atol=1e-4)


def test_no_stiffness_changes_nothing():
    tables = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}]}
    nothing = {"spring": [{"at": 0.37, "stiffness": 0.0}], "foundation": [{"stiffness": 0.0}]}
    full = {"solver": {"reduction": "full"}}
    with_it = ancf.solve(scene(**tables, **nothing, **full))
    without = ancf.solve(scene(**tables, **full))
    np.testing.assert_array_equal(with_it.q, without.q)
    assert "spring" not in without.effects and with_it.effects["spring"]["calls"] > 0


def test_springs_do_not_grow_with_the_load():
    """Twice the load, twice the deflection: a passive effect is no part of the load."""
    k = 20 * EI / L**3
    tips = [
        ancf.solve(scene(force=[{"value": [0, P, 0]}], spring=[{"stiffness": k}])).tip().position[1]
        for P in (1e-4 * EI, 2e-4 * EI)
    ]
    assert tips[1] == pytest.approx(2 * tips[0], rel=1e-5)  # linear: stiffness k + 3 E I/L^3 in both
    assert tips[0] == pytest.approx(1e-4 * EI / (k + 3 * EI / L**3), rel=1e-3)


def test_batches_and_sensitivities():
    """A batch falls back to NumPy and agrees with `solve`; d tip/d force and d tip/d E by differences."""
    bed = {
        "foundation": [{"stiffness": 30 * EI / L**4}],
        "spring": [{"at": 0.5, "stiffness": 20 * EI / L**3}],
    }
    P = EI / L**2

    def solved(value, **rod):
        return ancf.solve(scene(rod, force=[{"value": value}], **bed))

    solution = solved([0, P, 0.2 * P])
    batch = ancf.solve_batch(solution.scene, forces=[[0, P, 0.2 * P], [0, 3 * P, 0]])
    assert batch.engine == "numpy" and all(status == "converged" for status in batch.status)
    np.testing.assert_allclose(batch.poses[0, :, 0], solution.tip().position, atol=1e-9)
    h = 1e-3 * P
    more, less = (solved([0, P + d, 0.2 * P]).tip().position for d in (h, -h))
    slope = (more - less) / (2 * h)
    np.testing.assert_allclose(solution.sensitivity("force")[:3, 1], slope, rtol=1e-5, atol=1e-9 * L / P)
    stiffer, softer = (
        solved([0, P, 0.2 * P], material={"young_modulus": YOUNG * f, "poisson_ratio": 0.0}).tip().position
        for f in (1.001, 0.999)
    )
    found = solution.sensitivity("young_modulus")[:3]
    np.testing.assert_allclose(found, (stiffer - softer) / (2e-3 * YOUNG), rtol=1e-4, atol=1e-9 * L / YOUNG)


def test_a_cable_on_a_bed_carries_its_share():
    """Section force of a stretched cable on an axial bed: it falls by k u along the rod (equilibrium)."""
    k, P = 50.0, 0.01
    rod = {"element": "cable", "elements": 128}  # a clamp takes 5 % of the stretch of its element
    solution = ancf.solve(scene(rod, force=[{"value": [P, 0, 0]}], foundation=[{"stiffness": k}]))
    forces = solution.section_forces()
    EA = YOUNG * np.pi * RADIUS**2
    root = np.sqrt(k / EA)
    exact = P * np.cosh(root * forces.x) / np.cosh(root * L)  # EA u'' = k u, u(0) = 0, EA u'(L) = P
    np.testing.assert_allclose(forces.force[:, 0], exact, rtol=2e-3)


BAD = {
    "negative": ({"spring": [{"stiffness": -1.0}]}, "stiffness"),
    "no stiffness": ({"spring": [{}]}, "stiffness"),
    "outside": ({"spring": [{"stiffness": 1.0, "offset": [0.01, 0.0]}]}, "no point of the section"),
    "anchor axes": ({"spring": [{"stiffness": 1.0, "anchor": [0, 0, 0], "frame": "body"}]}, "frame"),
    "three to an anchor": ({"spring": [{"stiffness": [1.0, 1.0, 1.0], "anchor": [0, 0, 0]}]}, "stiffness"),
    "free length": ({"spring": [{"stiffness": 1.0, "free_length": 0.1}]}, "free_length"),
    "no anchor": ({"spring": [{"stiffness": 1.0, "to": "anchor"}]}, "anchor"),
    "other rod": ({"spring": [{"rod": "leg", "stiffness": 1.0}]}, "leg"),
    "no length": ({"foundation": [{"stiffness": 1.0, "from": 0.5, "to": 0.5}]}, "no length"),
    "misspelt": ({"foundation": [{"stifness": 1.0}]}, "stiffness"),
    "axis of the section": ({"spring": [{"stiffness": 1.0, "frame": "section"}]}, "frame"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_springs_are_refused(name):
    tables, hint = BAD[name]
    with pytest.raises(ancf.SceneError) as refused:
        scene(**tables)
    assert hint in str(refused.value)


def test_a_cable_takes_no_lever():
    with pytest.raises(ancf.SceneError, match="axis only"):
        scene({"element": "cable"}, spring=[{"stiffness": 1.0, "offset": [0.001, 0.0]}])
