"""Advice on contacts that a scene does not list, against solving with them listed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ancf
from ancf.advice import advise
from ancf.advice_state import State
from ancf.influence import MATTERS, NEGLIGIBLE, Influence
from ancf.missing_contacts import ITSELF, OBSTACLES, RODS, candidate_contacts
from ancf.scene import Contact, Scene
from tests.property.test_advice import largest_shift

L, R, E = 0.4, 0.01, 1e6
EI = E * np.pi * R**4 / 4


@pytest.fixture(autouse=True, scope="module")
def patient():
    """On a busy machine what is not found in time would only be estimated."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ancf.advice.SECONDS", 120.0)
        yield


def rod(name: str, height: float = 0.0, **fields: Any) -> dict[str, Any]:
    return {
        "name": name,
        "length": L,
        "elements": 10,
        "section": {"shape": "circle", "radius": R},
        "material": {"young_modulus": E, "poisson_ratio": 0.3},
        "base": {"position": [0.0, 0.0, height]},
        **fields,
    }


def of(scene: Scene, effect: str) -> Influence | None:
    found = [one for one in advise(scene).missing if one.effect == effect]
    return found[0] if found else None


def true_shift(scene: Scene, *contacts: Contact) -> float:
    plain = ancf.solve(scene)
    touching = ancf.solve(replace(scene, contacts=(*scene.contacts, *contacts)))
    assert touching.status == "converged"
    return largest_shift(plain, touching)


def pressed(gap: float, force: float) -> Scene:
    """An arm that is pressed down on another one across it, the axes gap radii apart."""
    across = rod("high", elements=6)
    across["base"] = {"position": [0.25, -0.2, gap * R], "x_axis": [0, 1, 0], "y_axis": [-1, 0, 0]}
    return ancf.scene_from_dict(
        {
            "rod": [rod("low", elements=6), across],
            "force": [{"rod": "high", "value": [0, 0, -force * EI / L**2]}],
        }
    )


@pytest.mark.parametrize(("gap", "force"), [(2.5, 0.1), (3.0, 0.7), (8.0, 0.5)])
def test_rods(gap, force):
    """P x^2 (3 L - x)/(6 E I) says how far the upper one comes down where they cross, in its middle."""
    scene = pressed(gap, force)
    found = of(scene, RODS)
    assert found is not None and found.number is not None and found.largest is not None
    drop = force * 5.0 / 48.0  # of L, to first order
    assert found.number == pytest.approx((gap - 2.0) * R / L - drop, abs=0.05 * drop)
    if found.number > 0.0:
        assert (found.largest, found.verdict, found.advice) == (0.0, NEGLIGIBLE, "nothing touches")
        assert true_shift(scene, Contact("high", other="low")) < 1e-9
    else:
        true = true_shift(scene, Contact("low", other="high"))
        assert found.verdict == MATTERS and found.largest == pytest.approx(true, rel=1e-3)
        assert '[[contact]] rod = "low", with = { shape = "rod", name = "high" }' in found.advice


def test_bound_where_no_equilibrium_is_found(monkeypatch):
    """Half the depth of two rods, which is less than what the contact moves them by."""
    scene = pressed(2.5, 0.5)
    known = of(scene, RODS)
    monkeypatch.setattr(State, "neighbour", lambda *_, **__: None)
    found = of(scene, RODS)
    assert known is not None and found is not None and known.largest and found.largest and found.number
    assert found.tip is None and found.verdict == MATTERS
    assert found.largest == pytest.approx(-found.number / 2.0)
    assert known.largest >= found.largest
    assert "at least" in found.note


def test_bound_at_an_obstacle(monkeypatch):
    """The whole depth, which is less than what the obstacle moves the rod by."""
    scene = floored(-0.03)
    known = of(scene, OBSTACLES)
    monkeypatch.setattr(State, "neighbour", lambda *_, **__: None)
    found = of(scene, OBSTACLES)
    assert known is not None and found is not None and known.largest and found.largest and found.number
    assert found.largest == pytest.approx(-found.number) and known.largest >= found.largest


def curled(turns: float) -> Scene:
    """An arm that a couple rolls up in a plane."""
    moment = [{"value": [0, 0, 2.0 * np.pi * turns * EI / L], "direction": "follower"}]
    return ancf.scene_from_dict({"rod": [rod("arm", elements=16)], "moment": moment})


@pytest.mark.parametrize("turns", [0.8, 1.3])
def test_an_arm_that_rolls_up(turns):
    """Beyond a whole turn the circle passes through itself: the tip over the base."""
    found = of(curled(turns), ITSELF)
    assert found is not None and found.number is not None
    if turns < 1.0:
        # The tip comes back towards the base: chord of the open part of a circle of radius L/(2 pi turns),
        # less the diameter of the rod. Saint Venant-Kirchhoff bends by (kappa R)^2 = 1.6 % more.
        radius = L / (2 * np.pi * turns)
        chord = 2 * radius * np.sin(np.pi * turns)
        assert found.number == pytest.approx((chord - 2 * R) / L, rel=0.1)
        assert found.verdict == NEGLIGIBLE and found.largest == 0.0
    else:
        assert found.number == pytest.approx(-2 * R / L, rel=0.02)
        assert found.verdict == MATTERS
        true = true_shift(curled(turns), Contact("arm", other="arm"))
        assert (found.largest or 0.0) == pytest.approx(true, rel=0.05)


def test_a_bent_arm_is_not_near_itself():
    """Neighbours along the rod are near each other, which is no contact: there is no number."""
    found = of(curled(0.4), ITSELF)
    assert found is not None and (found.number, found.largest, found.verdict) == (None, 0.0, NEGLIGIBLE)


def floored(height: float) -> Scene:
    """Two arms that bend down towards a floor, which is listed for one of them."""
    floor = {"shape": "plane", "point": [0, 0, height], "normal": [0, 0, 1]}
    return ancf.scene_from_dict(
        {
            "rod": [rod("a"), rod("b", base={"position": [0, 0.1, 0]})],
            "force": [{"rod": name, "value": [0, 0, -1.0 * EI / L**2]} for name in ("a", "b")],
            "contact": [{"rod": "a", "with": floor}],
        }
    )


@pytest.mark.parametrize("height", [-0.03, -0.2])
def test_obstacles_of_other_rods(height):
    """A floor that is listed for one of two arms is there for the other, too."""
    scene = floored(height)
    found = of(scene, OBSTACLES)
    assert found is not None and found.number is not None
    tip = ancf.solve(scene).tip("b").position[2]
    assert found.number == pytest.approx((tip - height - R) / L, abs=1e-6)
    if height < -0.1:
        assert found.verdict == NEGLIGIBLE
    else:
        true = true_shift(scene, Contact("b", scene.contacts[0].obstacle))
        assert found.verdict == MATTERS and found.largest == pytest.approx(true, rel=1e-3)
        assert '[[contact]] rod = "b", with = the plane' in found.advice


def test_what_is_not_looked_at():
    """Listed contacts, pairs that a joint holds, bodies in one another from the beginning, other sections."""
    rods = [rod("a"), rod("b", 0.1), rod("c", 0.2), rod("d", 0.2, section={"shape": "rectangle",
            "height_y": 0.01, "width_z": 0.01})]  # fmt: skip
    ball = {"shape": "sphere", "centre": [1.0, 0.0, 0.0], "radius": 0.1}
    scene = ancf.scene_from_dict(
        {
            "rod": rods,
            "joint": [{"kind": "rigid", "a": {"rod": "b", "at": 1.0}, "b": "ground"}],
            "contact": [
                {"rod": "b", "with": {"shape": "rod", "name": "a"}},
                {"rod": "c", "with": {"shape": "rod", "name": "c"}},
                *({"rod": name, "with": dict(ball)} for name in ("a", "b")),
            ],
        }
    )
    found = candidate_contacts(scene)
    assert [one.rod for one in found[ITSELF]] == ["a", "b"]
    assert [(one.rod, one.other) for one in found[RODS]] == [("a", "c"), ("b", "c")]
    assert [one.rod for one in found[OBSTACLES]] == ["c"]
    a, b = ({"rod": name, "at": 1.0} for name in ("a", "b"))
    joint = {"kind": "rigid", "a": a, "b": b, "reference": "apart"}
    held = [{**one, "supports": [{"at": 0.0}]} for one in rods[:2]]
    joined = ancf.scene_from_dict({"rod": held, "joint": [joint]})
    assert candidate_contacts(joined)[RODS] == []
    within = ancf.scene_from_dict(
        {"rod": [rod("a"), rod("b", 0.5 * R)], "force": [{"rod": "a", "value": [0, 0.01, 0]}]}
    )
    assert of(within, RODS) is None
