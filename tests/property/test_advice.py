"""Advice is held against solving with and without each effect."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings

import ancf
from ancf.advice import Advice, advise, without_each
from ancf.advice_state import SMALL
from ancf.influence import CLOSE, MATTERS, NEGLIGIBLE, Influence
from ancf.model import Model
from ancf.scene import Gravity, Scene
from ancf.scene_effects import EFFECT_MODULES
from ancf.scene_numbers import STANDARD_GRAVITY
from ancf.solution import Solution
from tests.property import test_random_balance
from tests.strategies import fewer

ROOT = Path(__file__).parents[2]
SCENES = sorted([*(ROOT / "examples").glob("*.toml"), *(ROOT / "validation/contract_scenes").glob("*.toml")])
NOISE = 1e-9  # of solving: 10 times the tolerance of a step


def on_its_mesh(solution: Solution) -> Scene:
    """The scene of a solution with the mesh that it has, which effects then cannot move."""
    rods = tuple(replace(r.rod, breaks=tuple(r.mesh.breaks / r.rod.length)) for r in solution.model.rods)
    return replace(solution.scene, rods=rods)


def largest_shift(one: Solution, other: Solution) -> float:
    return max(
        float(np.linalg.norm(other.nodes(rod.name) - one.nodes(rod.name), axis=1).max()) / rod.length
        for rod in one.scene.rods
    )


def check_verdict(found: Influence, true: float, limit: float) -> None:
    assert found.largest is not None
    if true < SMALL or not found.first_order:
        assert true / 2.0 - NOISE <= found.largest <= 2.0 * true + NOISE, found
    if found.verdict == NEGLIGIBLE:
        assert true <= limit
    elif found.verdict == MATTERS:
        assert true >= limit
    else:
        assert found.verdict == CLOSE and limit / 4 <= true <= 4 * limit


def check_listed(scene: Scene, limit: float) -> Advice | None:
    """Every listed effect: advice against the scene solved again without it."""
    advice = advise(scene, limit)
    json.dumps(advice.as_dict(), allow_nan=False)
    solution = ancf.solve(scene)
    if solution.status != "converged":
        return None
    assert advice.state == "equilibrium"
    names = [name for name, _ in without_each(scene)]
    listed = [influence for influence in advice.listed if influence.effect != "tendon friction"]
    assert [influence.effect for influence in listed] == names
    for influence, (_, less) in zip(listed, without_each(on_its_mesh(solution)), strict=True):
        found = [ancf.solve(less)]
        # Where there are several equilibria without it the nearest counts; a cable between hinges brought
        # together arches either way.
        if found[0].model.n == solution.model.n:
            found.append(ancf.solve(less, start=solution.q))
        shifts = [largest_shift(solution, one) for one in found if one.status == "converged"]
        if shifts:
            true = min(shifts)
            check_verdict(influence, true, limit)
    return advice


@pytest.mark.parametrize("limit", [1e-3, 0.1])
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_advice_on_the_examples(path, limit):
    """At 0.1 of the length too, where some effects of these scenes could be left out."""
    check_listed(ancf.load_scene(path), limit)


def scaled(scene: dict[str, Any], share: float) -> dict[str, Any]:
    """The scene with the loads of its second effect weakened: influences of every size."""
    weak = sorted(set(scene) - {"rod", "joint"})[-1]
    sizes = ("tension", "acceleration", "field", "value", "stiffness", "rotational_stiffness")
    records = scene[weak] if isinstance(scene[weak], list) else [scene[weak]]
    lighter = [
        {key: (share * np.array(one)).tolist() if key in sizes else one for key, one in record.items()}
        for record in records
    ]
    return {**scene, weak: lighter if isinstance(scene[weak], list) else lighter[0]}


# A moment of value zero once hid that the first equilibrium found is unstable: two shapes, 0.4 lengths apart.
TWO_SHAPES: dict[str, Any] = {
    "rod": [
        {
            "name": "a",
            "base": {"x_axis": [0.0, 0.6, 0.8], "y_axis": [1.0, 0.0, 0.0]},
            "length": 0.5,
            "elements": 4,
            "section": {"shape": "circle", "radius": 0.01},
            "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
            "curvature": [0.0, -2.0, 0.0],
        }
    ],
    "magnet": [{"rod": "a", "remanence": [-0.1, 0.0, 0.0], "field": [0.0, 0.02, 0.0]}],
    "moment": [{"rod": "a", "value": [0.0, 0.0, 0.0], "at": 0.3}],
}


@settings(max_examples=fewer(2), deadline=None)
@example(TWO_SHAPES)
@given(test_random_balance.scenes())
def test_advice_on_random_scenes(data):
    for share in (1e-3, 3e-2):
        check_listed(ancf.scene_from_dict(scaled(data, share)), 1e-3)


def missing(advice: Advice, effect: str) -> Influence:
    (found,) = [one for one in advice.missing if one.effect == effect]
    return found


@pytest.mark.parametrize("density", [0.4, 20.0, 1000.0])
def test_missing_weight(density, monkeypatch):
    """Against solving with the weight in many directions: small ones, whose shift is linear, in the largest
    singular value of three; others in the worst of 26 directions, which the advice has to find within a
    factor of 2."""
    rod = {
        "length": 0.4,
        "elements": 6,
        "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": density},
    }
    scene = ancf.scene_from_dict({"rod": [rod], "moment": [{"value": [0, 0, 0.02], "direction": "follower"}]})
    monkeypatch.setattr("ancf.advice.SECONDS", 120.0)  # on a busy machine
    found = missing(advise(scene), "gravity")
    plain = ancf.solve(scene)

    def shift(direction):
        weighed = ancf.solve(replace(scene, gravity=Gravity(STANDARD_GRAVITY * direction)))
        assert weighed.status == "converged"
        return (weighed.nodes() - plain.nodes()) / 0.4

    if density < 1000.0:
        columns = [shift(axis) for axis in np.eye(3)]
        true = float(np.linalg.norm(np.stack(columns, axis=-1), 2, axis=(1, 2)).max())
        assert true < SMALL or density == 20.0
        assert found.largest == pytest.approx(true, rel=0.1)
    else:
        around = [np.array(d) for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)]
        sizes = [np.linalg.norm(shift(d / np.linalg.norm(d)), axis=1).max() for d in around]
        true = max(sizes)
        assert not found.first_order and true / 2.0 <= (found.largest or 0.0) <= 1.2 * true
    check_verdict(found, true, 1e-3)
    assert found.verdict == {0.4: CLOSE, 20.0: MATTERS, 1000.0: MATTERS}[density]
    number = density * STANDARD_GRAVITY * 0.4**3 / (1e6 * 0.01**2 / 4)  # rho g A L^3/EI of a circle
    assert found.number == pytest.approx(number)


def test_weight_without_a_density():
    """Water's is taken, and said so."""
    rod = {"length": 0.4, "elements": 4, "section": {"shape": "circle", "radius": 0.01},
           "material": {"young_modulus": 1e6, "poisson_ratio": 0.3}}  # fmt: skip
    heavy = {**rod, "material": {**rod["material"], "density": 1000.0}}
    force = [{"value": [0, 0.01, 0]}]
    found, given = (
        missing(advise(ancf.scene_from_dict({"rod": [one], "force": force})), "gravity")
        for one in (rod, heavy)
    )
    assert (found.verdict, found.largest) == (MATTERS, given.largest)
    assert "1000 kg/m3" in found.note and "density" in found.advice
    assert "1000 kg/m3" not in given.note and "density" not in given.advice


def test_numbers_of_a_rod():
    """Their definitions (scene_numbers.py) for a circle of L/R = 40, written out."""
    L, R, E, nu, rho = 0.4, 0.01, 1e6, 0.3, 1000.0
    rod = {"length": L, "elements": 8, "section": {"shape": "circle", "radius": R},
           "material": {"young_modulus": E, "poisson_ratio": nu, "density": rho}}  # fmt: skip
    EI, A = E * np.pi * R**4 / 4, np.pi * R**2
    force, moment = 1.5 * EI / L**2, 0.5 * EI / L
    scene = ancf.scene_from_dict(
        {"rod": [rod], "force": [{"value": [0, force, 0]}], "moment": [{"value": [0, 0, moment]}]}
    )
    numbers = advise(scene).numbers["rod"]
    assert numbers["gravity"] == pytest.approx(rho * STANDARD_GRAVITY * A * L**3 / EI)
    assert numbers["slenderness"] == pytest.approx(L / R)
    assert numbers["shear"] == pytest.approx(EI / (E / (2 * (1 + nu)) * A * L**2))
    assert numbers["extension"] == pytest.approx(R**2 / 4 / L**2)
    assert numbers["force"] == pytest.approx(1.5) and numbers["moment"] == pytest.approx(0.5)
    assert numbers["section_force"] == pytest.approx(1.5, rel=0.01)
    # Statics: at the clamp M + P x_tip, x_tip < L; the outermost fibre is strained by R times its curvature.
    tip = ancf.solve(scene).tip().position[0] / L
    assert numbers["section_moment"] == pytest.approx(0.5 + 1.5 * tip, rel=0.03)
    assert numbers["section_strain"] == pytest.approx((0.5 + 1.5 * tip) * R / L, rel=0.1)


def test_advice_from_the_reference_where_there_is_no_equilibrium():
    """A tube that overflows its law: the first order of small loads, P L^3/(3 E I) (Euler-Bernoulli)."""
    rod = {"length": 1.0, "elements": 8, "section": {"shape": "circle", "radius": 0.01},
           "material": {"young_modulus": 1e6, "poisson_ratio": 0.0}}  # fmt: skip
    EI = 1e6 * np.pi * 0.01**4 / 4
    scene = ancf.scene_from_dict(
        {
            "rod": [rod],
            "force": [{"value": [-3e8 * EI, 0, 0]}, {"value": [0, 0.003 * EI, 0], "at": 1.0}],
            "line_load": [{"value": [0, 0.008 * EI, 0]}],
            "solver": {"max_steps": 3},
        }
    )
    advice = advise(scene)
    assert advice.state == "reference" and advice.numbers["rod"]["section_strain"] is None
    (found,) = [influence for influence in advice.listed if influence.effect == "line_load"]
    assert found.tip == pytest.approx(0.008 / 8, rel=0.01)  # q L^4/(8 E I)


@pytest.mark.parametrize("size", [1e200, 1e300, 1e308])
def test_loads_at_the_end_of_the_number_range(size):
    """No number that is not finite; an effect without an estimate matters."""
    rod = {"length": 0.4, "elements": 4, "section": {"shape": "circle", "radius": 0.01},
           "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}}  # fmt: skip
    advice = advise(ancf.scene_from_dict({"rod": [rod], "force": [{"value": [0, size, 0]}]}))
    json.dumps(advice.as_dict(), allow_nan=False)
    assert [influence.verdict for influence in advice.listed] == [MATTERS]


def test_every_effect_is_asked_about():
    """Generic over EFFECT_MODULES: whatever a scene lists is left out once, by the name of its module."""
    scene = ancf.load_scene(ROOT / "examples/tendon-arm.toml")
    listed = {EFFECT_MODULES[field] for field in EFFECT_MODULES if getattr(scene, field)}
    assert {name for name, _ in without_each(scene)} == listed
    for name, less in without_each(scene):
        assert {effect.name for effect in Model(less).effects} == listed - {name}
