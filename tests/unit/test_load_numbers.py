"""Loads as families with dimensionless numbers, and scenes whose loads are given as such numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

import ancf
from ancf.scene import Foundation, Scene
from validation.load_numbers import families_of, in_units

L, R, E, RHO = 0.4, 0.01, 1.0e6, 1070.0
A, EI = math.pi * R**2, E * math.pi * R**4 / 4.0
ROD = {
    "length": L, "elements": 4, "section": {"shape": "circle", "radius": R},
    "material": {"young_modulus": E, "poisson_ratio": 0.3, "density": RHO},
    "base": {"x_axis": [0, 0, -1], "y_axis": [0, 1, 0]},
}  # fmt: skip
CHAMBER = {"centre": [0.003, 0.004], "radius": 0.002}


def families(**tables):
    scene = ancf.scene_from_dict({"rod": [ROD], **tables})
    return families_of(scene.rods[0], scene)


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        (  # the axis points down: 3 along it, 4 across
            {"force": [{"value": [0, 4.0, -3.0], "offset": [0, 0.005]}]},
            {
                "force, off the axis": {
                    "F L2/EI along the axis": 3.0 * L**2 / EI, "F L2/EI against the axis": 0.0,
                    "F L2/EI across the axis": 4.0 * L**2 / EI, "offset/R": 0.5,
                }
            },
        ),
        (
            {"force": [{"value": [0, 0, 2.0], "direction": "follower"}]},
            {
                "follower axial compression": {
                    "F L2/EI along the axis": 0.0, "F L2/EI against the axis": 2.0 * L**2 / EI,
                    "F L2/EI across the axis": 0.0, "offset/R": 0.0,
                }
            },
        ),
        (  # two moments of one family add up
            {"moment": [{"value": [0.3, 0.4, 0.0]}, {"value": [0, 1.0, 0]}]},
            {"bending": {"M L/EI": 1.5 * L / EI}},
        ),
        (
            {"moment": [{"value": [0, 0.1, 0], "at": 0.5, "definition": "vorticity"}]},
            {"bending, vorticity, between the ends": {"M L/EI": 0.1 * L / EI}},
        ),
        (
            {"gravity": {"acceleration": [0, 0, -9.81]}},
            {
                "gravity": {
                    "rho A g L3/EI along the axis": RHO * A * 9.81 * L**3 / EI,
                    "rho A g L3/EI against the axis": 0.0, "rho A g L3/EI across the axis": 0.0,
                }
            },
        ),
        (
            {"tendon": [{"tension": 2.0, "path": [[0, 0.008, 0], [1, 0.0, 0.006]]},
                        {"tension": 1.0, "path": [[0, 0.004, 0], [1, 0.002, 0]]}]},
            {
                "tendon": {
                    "offset/R": 0.8, "slope": 0.01 / L, "number of tendons": 2.0, "T L2/EI": 3.0 * L**2 / EI
                }
            },
        ),
        (
            {"tendon": [{"length": 0.396, "path": [[0, 0.008, 0], [1, 0.008, 0]]}]},
            {
                "tendon, of given length": {
                    "offset/R": 0.8, "slope": 0.0, "number of tendons": 1.0, "shortening": 0.01
                }
            },
        ),
        (
            {"tendon": [{"tension": 1.0, "friction": 0.2, "path": [[0, 0.008, 0], [0.5, 0.008, 0]]}]},
            {
                "tendon, with friction, along a part": {
                    "offset/R": 0.8, "slope": 0.0, "number of tendons": 1.0, "T L2/EI": L**2 / EI,
                    "friction": 0.2,
                }
            },
        ),
        (
            {"pressure": [{"value": -2.0e3, "from": 0.1, "chamber": CHAMBER}]},
            {
                "suction, along a part": {
                    "p A L2/EI": 2.0e3 * math.pi * 0.002**2 * L**2 / EI, "offset/R": 0.5, "radius/R": 0.2,
                    "number of chambers": 1.0,
                }
            },
        ),
        (
            {"magnet": [{"remanence": [0.03, 0.04, 0], "field": [0, 0, 0.02]}]},
            {"magnet": {"(B_r A/mu_0) B L2/EI": 0.05 * 0.02 * A / 1.25663706127e-6 * L**2 / EI}},
        ),
        (
            {"spring": [{"at": 0.5, "stiffness": [1.0, 3.0, 2.0]}]},
            {"spring, between the ends": {"k L3/EI": 3.0 * L**3 / EI, "offset/R": 0.0}},
        ),
        (
            {"foundation": [{"stiffness": [0.0, 3.0, 2.0], "to": 0.5}]},
            {"foundation, along a part": {"k L4/EI": 3.0 * L**4 / EI}},
        ),
        (
            {"contact": [{"with": {"shape": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]}}]},
            {"contact": {"number of contacts": 1.0}},
        ),
        (
            {"contact": [{"with": {"shape": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]},
                          "friction": 0.3}]},
            {"contact, with friction": {"number of contacts": 1.0, "friction": 0.3}},
        ),
        (
            {"spring": [{"rotational_stiffness": [1.0, 3.0, 2.0]}]},
            {"rotational spring": {"k L/EI": 3.0 * L / EI}},
        ),
        (
            {"foundation": [{"rotational_stiffness": [1.0, 3.0, 2.0], "from": 0.5}]},
            {"rotational bed, along a part": {"k L2/EI": 3.0 * L**2 / EI}},
        ),
        ({"line_moment": [{"value": [0, 0, 0.2]}]}, {"line moment": {"m L2/EI": 0.2 * L**2 / EI}}),
    ],
)  # fmt: skip
def test_families_and_their_numbers(tables, expected):
    found = families(**tables)
    assert found.keys() == expected.keys()
    for name, numbers in expected.items():
        assert found[name] == pytest.approx(numbers)


def test_loads_of_zero_are_none():
    none = {
        "moment": [{"value": [0, 0, 0]}], "force": [{"value": [0, 0, 0]}],
        "line_load": [{"value": [0, 0, 0]}],
        "line_moment": [{"value": [0, 0, 0]}], "gravity": {"acceleration": [0, 0, 0]},
        "tendon": [{"tension": 0.0, "path": [[0, 0.008, 0], [1, 0.008, 0]]}],
        "pressure": [{"value": 0.0, "chamber": CHAMBER}],
        "magnet": [{"remanence": [0.1, 0, 0], "field": [0, 0, 0]}], "spring": [{"stiffness": 0.0}],
        "foundation": [{"stiffness": 0.0}],
    }  # fmt: skip
    assert families(**none) == {}


def test_what_nobody_gave_numbers_is_a_family_of_its_own():
    """Effects and properties that come later are refused by the domain, not passed over."""
    scene = ancf.scene_from_dict({"rod": [ROD], "foundation": [{"stiffness": 3.0}]})

    @dataclass(frozen=True)
    class LaterScene(Scene):
        winds: tuple[str, ...] = ()

    @dataclass(frozen=True, eq=False)
    class LaterBed(Foundation):
        rotational: float = 0.0

    later = {field.name: getattr(scene, field.name) for field in fields(scene)}
    (bed,) = scene.foundations
    numbers = {field.name: getattr(bed, field.name) for field in fields(bed)}
    for rotational, name in ((0.0, "foundation"), (2.0, "foundation, with rotational")):
        beds = (LaterBed(**numbers, rotational=rotational),)
        assert list(families_of(scene.rods[0], replace(scene, foundations=beds))) == [name]
    windy = LaterScene(**later, winds=("north",))
    assert sorted(families_of(scene.rods[0], windy)) == ["foundation", "winds"]


# Squares of loads below 1e-150 vanish.
SIZES = st.floats(-5, 5).map(lambda v: v if abs(v) > 1e-100 else 0.0)


@given(st.lists(SIZES, min_size=3, max_size=3), st.floats(0.1, 1.0))
def test_what_is_given_in_numbers_has_these_numbers(value, share):
    """From numbers to SI and back, in the axes of the rod."""
    scene = {
        "rod": [{**ROD, "base": {}}], "force": [{"value": value, "offset": [0.3, 0.4]}],
        "gravity": {"acceleration": value},
        "tendon": [{"tension": 7.0, "path": [[0, 0.6, 0.8], [1, 0.6, 0.8]]}],
        "pressure": [{"value": 3.0, "chamber": {"centre": [0.5, 0.0], "radius": 0.25}}],
        "magnet": [{"remanence": [0.1, 0, 0], "field": [0, 2.0, 0]}],
        "spring": [{"stiffness": [1.0, 2.0, 3.0]}], "foundation": [{"stiffness": [1.0, 2.0, 3.0]}],
    }  # fmt: skip
    scene = ancf.scene_from_dict(in_units(scene, share))
    found = families_of(scene.rods[0], scene)
    parts = share * np.array([max(0.0, value[0]), max(0.0, -value[0]), math.hypot(value[1], value[2])])
    for family, name in (("force", "F L2/EI"), ("gravity", "rho A g L3/EI")):
        for numbers in (numbers for key, numbers in found.items() if key.startswith(family)):
            sizes = [numbers[f"{name} {part} the axis"] for part in ("along", "against", "across")]
            assert sizes == pytest.approx(parts, rel=1e-12, abs=1e-8 * float(np.linalg.norm(parts)))
            assert numbers.get("offset/R", 0.5) == pytest.approx(0.5)
    assert found["tendon"]["T L2/EI"] == pytest.approx(7.0 * share)
    assert found["tendon"]["offset/R"] == pytest.approx(1.0)
    assert found["pressure"] == pytest.approx(
        {"p A L2/EI": 3.0 * share, "offset/R": 0.5, "radius/R": 0.25, "number of chambers": 1.0}
    )
    assert found["magnet"] == pytest.approx({"(B_r A/mu_0) B L2/EI": 0.2 * share})
    assert found["spring"]["k L3/EI"] == pytest.approx(3.0)  # what holds the rod is no load
    assert found["foundation"]["k L4/EI"] == pytest.approx(3.0)
