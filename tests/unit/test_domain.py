"""The domain of validity: regimes of scenes, what the cases that passed span, what lies outside."""

from __future__ import annotations

import math

import pytest

import ancf
from tests.regimes import HARD, REGIME
from validation.certificate import Certificate
from validation.domain import domain_of, outside
from validation.regime import flatness, loads_of, regime_of, regimes

EI = 1.0e6 * math.pi * 0.01**4 / 4.0


def arm(moment=None, nu=0.3, element="3333", rod=None, **tables):
    """The arm of the other cases, L = 0.4 m, R = 0.01 m, E = 1 MPa; the moment in E I/L."""
    table = {
        "length": 0.4, "elements": 24, "element": element, "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 1.0e6, "poisson_ratio": nu, "density": 1000.0},
    }  # fmt: skip
    if moment is not None:
        tables["moment"] = [{"value": [m * EI / 0.4 for m in moment], **tables.pop("how", {})}]
    return ancf.scene_from_dict({"rod": [{**table, **(rod or {})}], **tables})


def domain(*certified):
    return domain_of({**REGIME, **changes} for changes in certified)


def test_regimes_of_a_solved_scene():
    (found,) = regimes(ancf.solve(arm([0.0, 0.0, 1.2])))
    assert found["kappa_R"] == pytest.approx(1.2 * 0.01 / 0.4, rel=1e-4)  # |M| R/(E I), closed form
    assert found["turn"] == pytest.approx(1.2, rel=1e-4)  # |M| L/(E I)
    assert found["turn_per_element"] == pytest.approx(1.2 / 24, rel=1e-4)
    # Outermost fibre of the thin rod: E_xx = kappa R + (kappa R)^2/2.
    assert found["strain"] == pytest.approx(0.03 + 0.03**2 / 2, rel=3e-2)
    assert found["slenderness"] == pytest.approx(40.0)
    names = ("element", "formulation", "law", "section", "loads", "poisson_ratio", "elements", "known")
    assert [found[name] for name in names] == [
        "3333", "enhanced", "saint-venant-kirchhoff", "circle", ["bending"], 0.3, 24, True
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("scene", "loads"),
    [
        (arm([0, 0, 1]), ["bending"]),
        (arm([1, 0, 0]), ["torsion"]),
        (arm([1, 0, 1], how={"direction": "follower"}), ["follower bending", "follower torsion"]),
        (arm(force=[{"value": [0, 1e-3, 0]}], gravity={"acceleration": [0, 0, -9.81]}), ["force", "gravity"]),
        (arm(force=[{"value": [1e-3, 0, 0]}]), ["axial tension"]),
        (arm(force=[{"value": [-1e-3, 0, 0], "direction": "follower"}]), ["follower axial compression"]),
        (arm(line_load=[{"value": [0, 1e-3, 0], "direction": "follower"}]), ["follower line load"]),
        (arm(), []),
        (arm([0, 0, 0], force=[{"value": [0, 0, 0]}], line_load=[{"value": [0, 0, 0]}]), []),
    ],
)
def test_families_of_loads(scene, loads):
    assert loads_of(scene.rods[0], scene) == loads


def test_the_curvature_before_a_solution_is_that_of_the_moments():
    moment = {"value": [0.0, 0.0, 0.01]}
    bar = {"length": 0.4, "elements": 4, "section": {"shape": "rectangle", "height_y": 0.02, "width_z": 0.01},
           "material": {"young_modulus": 1.0e6, "poisson_ratio": 0.3, "density": 1000.0}}  # fmt: skip
    scene = ancf.scene_from_dict({"rod": [bar], "moment": [moment, moment]})
    found = regime_of(scene.rods[0], scene)
    weak = 1.0e6 * 0.02 * 0.01**3 / 12.0
    assert found["kappa_R"] == pytest.approx(0.02 * math.hypot(0.01, 0.005) / weak)
    assert found["known"]
    for table, known in [
        ({"gravity": {"acceleration": [0, 0, -9.81]}}, False),
        ({"force": [{"value": [0, 1e-3, 0]}]}, False),
        ({"force": [{"value": [0, 0, 0]}]}, True),
    ]:
        scene = ancf.scene_from_dict({"rod": [bar], "moment": [moment, moment], **table})
        assert regime_of(scene.rods[0], scene)["known"] is known
        assert regime_of(scene.rods[0], scene)["kappa_R"] == pytest.approx(found["kappa_R"])


@pytest.mark.parametrize(
    ("section", "expected"),
    [
        ({"shape": "circle", "radius": 0.01}, 1.0),
        ({"shape": "annulus", "radius": 0.01, "inner_radius": 0.008}, 0.2),
        ({"shape": "rectangle", "height_y": 0.02, "width_z": 0.004}, 0.2),
        ({"shape": "ellipse", "semi_axis_y": 0.002, "semi_axis_z": 0.004}, 0.5),
    ],
)
def test_flatness_is_the_thinnest_wall_or_side(section, expected):
    assert flatness(arm(rod={"section": section}).rods[0]) == pytest.approx(expected)


def test_ranges_are_those_of_the_cases_that_passed():
    (found,) = domain({}, {"slenderness": 400.0, "flatness": 0.5, "elements": 8})
    assert (found["slenderness"], found["elements"]) == ([40.0, 400.0], [8, 24])
    assert (found["section"], found["flatness"]) == ("circle", [0.5, 1.0])
    assert [entry["section"] for entry in domain({}, {"section": "annulus"})] == ["annulus", "circle"]
    assert len(domain({}, {"loads": ["bending", "torsion"]}, {"law": "neo-hookean"})) == 3


def test_a_hard_material_tried_gently_does_not_vouch_for_large_curvature():
    (found,) = domain(HARD, {"poisson_ratio": 0.49, "kappa_R": 0.01}, {"kappa_R": 0.05})
    assert [case[:2] for case in found["front"]] == [[0.3, 0.15], [0.49, 0.01]]
    inside = [found]
    assert outside(inside, arm([0, 0, 5.9], nu=0.3)) == []  # kappa R = 0.1475
    assert outside(inside, arm([0, 0, 0.39], nu=0.45)) == []
    assert "kappa R 0.0112 is above 0.01" in outside(inside, arm([0, 0, 0.45], nu=0.45))[0]
    assert "kappa R 0.155 is above 0.15" in outside(inside, arm([0, 0, 6.2], nu=0.3))[0]


def test_one_case_must_have_been_as_hard_in_everything():
    """A long turn on many elements and few elements hardly bent say nothing of both together."""
    inside = domain(HARD, {"elements": 4, "turn": 0.4, "turn_per_element": 0.1, "kappa_R": 0.15})
    assert outside(inside, arm([0, 0, 5.9])) == []
    (reason,) = outside(inside, arm([0, 0, 1.0], rod={"elements": 4}))
    assert "turn of an element [rad] 0.25 is above 0.246" in reason
    (reason,) = outside(domain({"turn": 9.0}, {"kappa_R": 0.15}), arm([0, 0, 5.9]))
    assert "turn [rad] 5.9 is above 1.2, the most tried with kappa R >= 0.147" in reason


def test_a_tried_poisson_ratio_is_inside_to_its_last_digit():
    """Mooney-Rivlin gives nu = 0.490019841...: rounded in the domain, it once was outside itself."""
    material = {"law": "mooney-rivlin", "c10": 134228.0, "c01": 33557.0, "bulk_modulus": 16.7e6}
    scene = arm([0, 0, 0.5], rod={"material": material})
    assert outside(domain_of(regimes(ancf.solve(scene))), scene) == []


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (arm([0, 0, 1], nu=0.31), "poisson_ratio 0.31 is outside 0.3 to 0.3"),
        (arm([0, 0, 1], element="3243"), "no case that passed has 3243, enhanced"),
        (arm([1, 0, 0]), "no case that passed has 3333, enhanced, saint-venant-kirchhoff, torsion"),
        (arm([0, 0, 1], how={"direction": "follower"}), "follower bending"),
        (arm([0, 0, 1], rod={"axial_rule": "full"}), "axial_rule full is not among default"),
        (arm([0, 0, 1], rod={"axial_rule": 1}), "axial_rule 1 is not among default"),
        (arm([0, 0, 1], rod={"curvature": [0, 0, 5.0]}), "reference curved is not among straight"),
        (arm([0, 0, 1], rod={"shear_factors": [1e-6, 1]}), "shear_factors 1e-06 1 is not among 1 1"),
        (arm([0, 0, 1], how={"definition": "vorticity"}), "saint-venant-kirchhoff, bending, vorticity"),
        (arm([0, 0, 1], how={"at": 0.37}), "saint-venant-kirchhoff, bending, between the ends"),
        (
            arm([0, 0, 1], rod={"supports": [{"at": 0, "kind": "clamp"}, {"at": 1, "kind": "pin"}]}),
            "supports clamp at 0, pin at 1 is not among clamp at 0",
        ),
        (arm([0, 0, 1], force=[{"value": [0, 1e-3, 0]}]), "is known only once it is solved"),
    ],
)
def test_scenes_outside(scene, reason):
    assert any(reason in text for text in outside(domain({}), scene))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"slenderness": 50.0}, "L/R 40 is outside 50 to 50"),
        ({"section": "rectangle"}, "section circle is not among rectangle"),
        ({"flatness": 0.5}, "flatness 1 is outside 0.5 to 0.5"),
        ({"elements": 30}, "24 elements are fewer than 30"),
    ],
)
def test_limits_of_an_entry(changes, reason):
    assert [reason in text for text in outside(domain(changes), arm([0, 0, 1]))] == [True]


def test_strain_is_judged_once_there_is_a_solution():
    scene = arm([0, 0, 1.19])
    shallow = domain({"strain": 0.01})
    assert outside(shallow, scene) == []
    (reason,) = outside(shallow, scene, ancf.solve(scene))
    assert "is above 0.01" in reason
    assert Certificate({"predicate": {"domain": shallow}}).outside(scene) == []


def test_nothing_vouches_for_what_is_no_stable_equilibrium():
    pushed = arm(rod={"elements": 4}, force=[{"value": [-3 * 2.467 * EI / 0.4**2, 0, 0]}])
    solution = ancf.solve(pushed)
    assert solution.stable is False
    assert "the equilibrium is unstable" in outside([], pushed, solution)
    far = arm([0, 0, 90.0], rod={"elements": 2}, solver={"max_steps": 2})
    assert any("no equilibrium to vouch for" in text for text in outside([], far, ancf.solve(far)))


def test_loads_on_another_rod_do_not_count():
    arm_table = {"name": "arm", "length": 0.4, "elements": 4, "section": {"shape": "circle", "radius": 0.01},
                 "material": {"young_modulus": 1.0e6, "poisson_ratio": 0.3}}  # fmt: skip
    tables = {
        "rod": [arm_table, {**arm_table, "name": "other"}],
        "moment": [{"rod": "other", "value": [0, 0, 0.01]}],
        "force": [{"rod": "other", "value": [0, 0.01, 0]}],
        "line_load": [{"rod": "other", "value": [0, 0.01, 0]}],
    }
    scene = ancf.scene_from_dict(tables)
    here = regime_of(scene.rods[0], scene)
    assert (here["loads"], here["kappa_R"], here["numbers"]) == ([], 0.0, {})
    assert loads_of(scene.rods[1], scene) == ["bending", "force", "line load"]


def test_no_case_vouches_for_joints():
    """Two rods that are joined lie outside, however gently they are loaded."""
    rod = {
        "length": 0.4, "elements": 24, "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 1.0e6, "poisson_ratio": 0.3},
    }  # fmt: skip
    second = {**rod, "name": "second", "base": {"position": [0.4, 0.0, 0.0]}}
    joint = {"kind": "rigid", "a": {"rod": "rod", "at": 1.0}, "b": {"rod": "second", "at": 0.0}}
    held = {**rod, "supports": [{"at": 0.0}]}  # a joint takes the default clamp away
    joined = ancf.scene_from_dict({"rod": [held, second], "joint": [joint]})
    assert any("joined" in reason for reason in outside(domain({}), joined))
