"""Advice on scenes whose effects bring unknowns of their own, or touch."""

from __future__ import annotations

import numpy as np
import pytest

import ancf
from ancf.advice import advise
from ancf.solver import prepare

ROD = {
    "length": 0.4,
    "elements": 8,
    "section": {"shape": "circle", "radius": 0.01},
    "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
}


def advice(**tables):
    return advise(prepare(ancf.scene_from_dict({"rod": [ROD], **tables})).scene)


def test_a_tendon_of_given_length_may_be_left_out_of_a_scene():
    """Without it the rod is straight: its influence is the shift of the tip itself."""
    tables = {"tendon": [{"length": 0.39, "path": [[0, 0.008, 0], [1, 0.008, 0]]}]}
    tip = ancf.solve(ancf.scene_from_dict({"rod": [ROD], **tables})).tip().position
    (tendon,) = advice(**tables).listed
    assert (tendon.effect, tendon.verdict) == ("tendon", "matters")
    assert tendon.tip == pytest.approx(np.linalg.norm(tip - [0.4, 0, 0]) / 0.4, rel=1e-6)


@pytest.mark.parametrize(("height", "verdict"), [(-0.1, "negligible"), (-0.011, "matters")])
def test_obstacles_count_where_they_are_touched(height, verdict):
    """A tip force bends the rod down by P L^3/3EI = 0.027 m; the floor is 0.1 m away, or 1 mm."""
    floor = {"shape": "plane", "point": [0, 0, height], "normal": [0, 0, 1]}
    found = advice(force=[{"value": [0, 0, -0.01]}], contact=[{"with": floor}])
    contact = next(influence for influence in found.listed if influence.effect == "contact")
    assert contact.verdict == verdict
    distance = found.numbers["rod"]["contact_distance"]
    assert distance is not None
    if verdict == "matters":
        assert abs(distance) < 1e-6
    else:
        assert distance == pytest.approx((0.1 - 0.01 - 0.027) / 0.4, abs=0.01)
