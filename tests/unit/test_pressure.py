"""Chambers under pressure: Lame's tube, thrust and bending, exact derivatives, balance, refusals."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancf
from ancf.effects.pressure import Chamber
from ancf.model import Model
from ancf.predictor import load_start
from tests.effect_checks import blocks, check_derivatives, check_rigid_motion

L, RADIUS, BORE, YOUNG = 0.1, 0.01, 0.006, 1e6
TUBE = {"shape": "annulus", "radius": RADIUS, "inner_radius": BORE}
WALL = np.pi * (RADIUS**2 - BORE**2)
EI = YOUNG * np.pi * RADIUS**4 / 4


def scene(rod=None, **tables):
    data = {
        "length": L, "elements": 6, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


def chamber(value=1e3, radius=0.003, centre=(0.0, 0.0), **keys):
    return {"pressure": [{"value": value, "chamber": {"centre": list(centre), "radius": radius}, **keys}]}


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
def test_a_closed_tube_follows_lame(element, nu):
    """Axial strain p a^2 (1 - 2 nu)/(E (b^2 - a^2)) of a thick tube with end caps (Lame)."""
    p = 1.0  # small: the law of Lame is linear
    free = [{"at": 0.0, "kind": "free_section_clamp"}]
    material = {"young_modulus": YOUNG, "poisson_ratio": nu}
    # Quadratic sections bend the end caps: fine elements keep that layer at the ends.
    elements = 24 if element == "3363" else 6
    tube = {"section": TUBE, "element": element, "elements": elements, "material": material, "supports": free}
    solution = ancf.solve(scene(tube, **chamber(p, BORE)))
    exact = p * BORE**2 * (1 - 2 * nu) / (YOUNG * (RADIUS**2 - BORE**2))
    way = solution.pose(None, 2 / 3).position - solution.pose(None, 1 / 3).position
    assert way[0] / (L / 3) - 1.0 == pytest.approx(exact, rel=1e-4, abs=1e-12)


def test_a_chamber_off_the_axis_bends_the_rod():
    """kappa = p A_c e/(E I), at nu = 0 and small strain (thin rod, closed form)."""
    p, e, a = 50.0, 0.005, 0.003
    material = {"young_modulus": YOUNG, "poisson_ratio": 0.0}
    solution = ancf.solve(scene({"material": material}, **chamber(p, a, (e, 0.0))))
    kappa = p * np.pi * a**2 * e / EI
    # The end cap pushes at +y: the rod bends away from it, to -y.
    assert solution.tip().position[1] == pytest.approx(-kappa * L**2 / 2, rel=2e-3)
    turned = ancf.solve(scene({"material": material}, **chamber(p, a, (0.0, e))))
    assert turned.tip().position[2] == pytest.approx(solution.tip().position[1], rel=1e-9)


@pytest.mark.parametrize("nu", [-0.2, 0.3, 0.45])
def test_the_wall_of_a_bare_chamber_pushes_back(nu):
    """kappa = p A_c e (1 - 2 nu)/(E I): the chamber gains A_c kappa e (1 - 2 nu) in bending (Betti).

    A linear section has one lateral strain and bends by p A_c e, which it says.
    """
    p, e, a = 50.0, 0.005, 0.003
    rod = {
        "material": {"young_modulus": YOUNG, "poisson_ratio": nu},
        "elements": 12,
        "supports": [{"kind": "free_section_clamp"}],
    }
    slopes = {}
    for element in ("3333", "3343", "3363"):
        solution = ancf.solve(scene({**rod, "element": element}, **chamber(p, a, (e, 0.0))))
        r_x = solution.pose(None, 2 / 3).r_x - solution.pose(None, 1 / 3).r_x  # away from the ends
        slopes[element] = -r_x[1] / (p * np.pi * a**2 * e / EI * L / 3)
        warned = [text for text in solution.warnings if "as if fibres held its wall" in text]
        assert len(warned) == (element != "3363"), element
        assert all(f"leaves 1 - 2 nu = {1 - 2 * nu:.3g} of that" in text for text in warned)
    assert slopes["3333"] == pytest.approx(1.0, rel=2e-3)
    assert slopes["3343"] == pytest.approx(1.0, rel=2e-3)
    assert slopes["3363"] == pytest.approx(1.0 - 2.0 * nu, rel=1e-2)


@pytest.mark.parametrize(("nu", "offset"), [(0.0, 0.005), (0.3, 0.0), (0.3, 1e-5)])
def test_chambers_that_a_linear_section_bends_rightly_are_not_warned_about(nu, offset):
    material = {"young_modulus": YOUNG, "poisson_ratio": nu}
    assert not ancf.solve(scene({"material": material}, **chamber(50.0, 0.003, (offset, 0.0)))).warnings


def test_part_of_the_rod():
    """Only the part with the chamber bends: the rest goes on straight, wherever elements end."""
    material = {"young_modulus": YOUNG, "poisson_ratio": 0.0}
    keys = {"from": 0.21, "to": 0.63}
    solution = ancf.solve(
        scene({"material": material, "elements": 60}, **chamber(500.0, 0.003, (0.005, 0.0), **keys))
    )
    kappa = 500.0 * np.pi * 0.003**2 * 0.005 / EI
    angle = np.arctan2(solution.tip().rotation[1, 0], solution.tip().rotation[0, 0])
    assert angle == pytest.approx(-kappa * 0.42 * L, rel=1e-2)


def test_each_element_has_its_share_of_the_chamber():
    """The work on the motion u = x^2 e_x, which the element contains, is p A_c (x_b^2 - x_a^2) (end caps)."""
    a, b = 0.21, 0.6
    model = Model(scene(None, **chamber(1e3, 0.003, (0.002, 0.001), **{"from": a, "to": b})))
    (effect,) = model.effects
    assert isinstance(effect, Chamber) and len(effect.groups) == 3  # cut, whole, and cut elsewhere
    motion = np.zeros(model.n)
    motion[::9] = model.rods[0].mesh.node_x ** 2
    work = np.sum(effect.force(blocks(model, effect)) * blocks(model, effect, motion))
    assert work == pytest.approx(1e3 * np.pi * 0.003**2 * (b**2 - a**2) * L**2, rel=1e-12)


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
def test_force_and_tangent_are_derivatives(element):
    """Q = -dV/de and K = dQ/de by central differences, at a random state."""
    tables = chamber(1e4, 0.003, (0.002, 0.004), **{"from": 0.1, "to": 0.77})
    model = Model(scene({"element": element, "curvature": [3.0, 5.0, -2.0]}, **tables))
    check_derivatives(model, strain=0.05, step=1e-5)
    assert model.conservative


@settings(deadline=None)
@given(st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_pressure_turns_with_the_rod(numbers):
    """A rigid motion changes no volume; forces turn with it and balance: the chamber is closed."""
    model = Model(scene({"curvature": [3.0, 5.0, -2.0]}, **chamber(1e4, 0.003, (0.002, 0.004))))
    (effect,) = model.effects
    size = np.abs(effect.force(blocks(model, effect))).max()
    check_rigid_motion(model, Chamber.volume, numbers, 1e-12, 1e-11 * size, 1e-12 * size)


def test_the_volume_of_a_bent_chamber():
    """Pappus: area times the way of its centre, (1 - kappa y_c) L, on the reference arc."""
    model = Model(scene({"curvature": [0, 0, 4.0], "elements": 12}, **chamber(0.0, 0.003, (0.005, 0.0))))
    (effect,) = model.effects
    volume = effect.volume(model.q0[effect.dofs].reshape(len(effect.dofs), -1, 3))
    assert volume == pytest.approx(np.pi * 0.003**2 * (1 - 4.0 * 0.005) * L, rel=1e-6)


@pytest.mark.parametrize("centre", [(0.005, 0.0), (0.0, -0.005)])
def test_the_start_is_near(centre):
    """A Kirchhoff chain bent by the couples of the chamber is nearer to the solution than the reference."""
    model = Model(scene({"section": {"shape": "circle", "radius": RADIUS}}, **chamber(8e4, 0.004, centre)))
    start, solution = load_start(model), ancf.solve(model.scene)
    (rod,) = model.rods
    tips = [rod.nodal(q)[-1, 0] for q in (start, solution.q)]
    assert np.linalg.norm(tips[1] - [L, 0, 0]) > 0.08 * L
    assert np.linalg.norm(tips[0] - tips[1]) < 0.3 * np.linalg.norm(tips[1] - [L, 0, 0])


def test_no_pressure_changes_nothing():
    tables = {"force": [{"value": [0, 0.5 * EI / L**2, 0]}]}
    with_it, without = ancf.solve(scene(**tables, **chamber(0.0))), ancf.solve(scene(**tables))
    np.testing.assert_array_equal(with_it.q, without.q)
    assert "pressure" not in without.effects and with_it.effects["pressure"]["calls"] > 0


def test_a_finger_of_rubber():
    """Large bending, from vacuum to pressure: converged, bent to either side, in one step each."""
    rubber = {"law": "neo-hookean", "young_modulus": YOUNG, "poisson_ratio": 0.45}
    tips = []
    for value in ("-60 kPa", "60 kPa"):
        solution = ancf.solve(scene({"material": rubber}, **chamber(value, 0.003, (0.005, 0.0))))
        assert solution.status == "converged" and solution.stable
        tips.append(solution.tip().position)
    assert tips[0][1] > 0.02 * L and tips[1][1] < -0.02 * L


BAD = {
    "too large": ({"radius": 0.0101}, "larger than the section"),
    "off the section": ({"centre": (0.008, 0.0)}, "larger than the section"),
    "no radius": ({"radius": 0.0}, "radius"),
    "no length": ({"from": 0.5, "to": 0.5}, "no length"),
    "beyond the rod": ({"to": 1.5}, "to"),
    "another rod": ({"rod": "leg"}, "leg"),
    "misspelt": ({"vlaue": 1.0}, "value"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_chambers_are_refused(name):
    keys, hint = BAD[name]
    with pytest.raises(ancf.SceneError) as refused:
        scene(**chamber(**keys))
    assert hint in str(refused.value)


def test_a_chamber_is_needed():
    with pytest.raises(ancf.SceneError, match="chamber"):
        scene(pressure=[{"value": 1.0}])
