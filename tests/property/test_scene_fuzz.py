"""Whatever a scene file says, reading it gives a valid scene or a SceneError; valid ones are always read."""

from __future__ import annotations

import copy
import datetime
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings, strategies as st

from ancf.elements import ELEMENTS
from ancf.errors import SceneError
from ancf.scene import Scene
from ancf.scene_file import scene_from_dict
from ancf.scene_materials import law_name

QUIET = settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow])
sizes = st.floats(1e-3, 0.05)
loads = st.lists(st.floats(-1e300, 1e300), min_size=3, max_size=3)
fractions = st.floats(0.0, 1.0)
sections = st.one_of(
    st.fixed_dictionaries({"shape": st.just("circle"), "radius": sizes}),
    st.builds(
        lambda radius, share: {"shape": "annulus", "radius": radius, "inner_radius": share * radius},
        sizes,
        st.floats(0.01, 0.99),
    ),
    st.fixed_dictionaries({"shape": st.just("rectangle"), "height_y": sizes, "width_z": sizes}),
    st.fixed_dictionaries({"shape": st.just("ellipse"), "semi_axis_y": sizes, "semi_axis_z": sizes}),
    # A star of random radii at increasing angles is simple and counter-clockwise, whatever the radii.
    st.builds(
        lambda radii: {
            "shape": "polygon",
            "points": [
                [r * np.cos(a), r * np.sin(a)]
                for r, a in zip(radii, np.linspace(0, 2 * np.pi, len(radii), endpoint=False), strict=True)
            ],
        },
        st.lists(st.floats(0.005, 0.02), min_size=3, max_size=9),
    ),
)
moduli = st.one_of(st.floats(1e3, 1e11), st.just("0.5 MPa"))
hooke_constants = {"young_modulus": moduli, "poisson_ratio": st.floats(-0.99, 0.499999)}
materials = st.one_of(
    st.fixed_dictionaries(
        {**hooke_constants, "density": st.floats(1.0, 1e4)},
        optional={"law": st.sampled_from(["saint-venant-kirchhoff", "neo-hookean"])},
    ),
    st.fixed_dictionaries(
        {
            "law": st.just("mooney-rivlin"),
            "c10": moduli,
            "c01": st.one_of(moduli, st.just(0.0)),
            "bulk_modulus": moduli,
            "density": st.floats(1.0, 1e4),
        }
    ),
)
# 3363 knows only the continuum; the other elements know both formulations.
elements = st.one_of(
    st.fixed_dictionaries(
        {},
        optional={
            "element": st.sampled_from(["3333", "3243", "3343"]),
            "formulation": st.sampled_from(["enhanced", "continuum"]),
        },
    ),
    st.fixed_dictionaries({"element": st.just("3363")}, optional={"formulation": st.just("continuum")}),
)
rods = st.fixed_dictionaries(
    {
        "length": st.one_of(st.floats(0.1, 10.0), st.just("40 cm")),
        "elements": st.integers(4, 100),
        "section": sections,
        "material": materials,
    },
    optional={
        "axial_rule": st.one_of(st.sampled_from(["default", "full"]), st.integers(1, 10)),
        "base": st.fixed_dictionaries(
            {"position": st.lists(st.floats(-1e20, 1e20), min_size=3, max_size=3)},
            # Axes in the half planes x > 0 and y > 0 of one plane are never parallel here.
            optional={"x_axis": st.tuples(st.floats(1, 2), st.floats(-1, 0), st.just(0.0))},
        ),
        "supports": st.lists(
            st.fixed_dictionaries(
                {"at": fractions, "kind": st.sampled_from(["clamp", "free_section_clamp"])}
            ),
            min_size=1,
            max_size=3,
            unique_by=lambda support: round(support["at"], 3),
        ),
        "curvature": st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3),
    },
)
rods = st.builds(lambda rod, element: {**rod, **element}, rods, elements)
point_load = {"value": loads, "at": fractions}
directions = st.sampled_from(["fixed", "follower"])
frames = st.sampled_from(["structure", "body"])
scenes = st.fixed_dictionaries(
    {"rod": st.lists(rods, min_size=1, max_size=3)},
    optional={
        "title": st.text(max_size=20),
        "moment": st.lists(st.fixed_dictionaries(point_load, optional={"frame": frames}), max_size=3),
        "force": st.lists(st.fixed_dictionaries(point_load, optional={"direction": directions}), max_size=3),
        "line_load": st.lists(st.fixed_dictionaries({"value": loads}), max_size=2),
        "gravity": st.fixed_dictionaries({"acceleration": loads}),
        "solver": st.fixed_dictionaries({}, optional={"tolerance": st.floats(1e-14, 1e-2)}),
    },
)

COMPLETE: dict[str, Any] = {
    "title": "t",
    "rod": [
        {
            "name": "arm",
            "length": 0.4,
            "elements": 12,
            "element": "3333",
            "formulation": "enhanced",
            "axial_rule": "default",
            "section": {"shape": "polygon", "points": [[0, 0], [0.01, 0], [0.01, 0.01], [0, 0.02]]},
            "material": {
                "law": "saint-venant-kirchhoff",
                "young_modulus": 1e6,
                "poisson_ratio": 0.3,
                "density": 1e3,
            },
            "base": {"position": [0, 0, 0], "x_axis": [0, 0, 1], "y_axis": [0, 1, 0]},
            "supports": [{"at": 0.0, "kind": "clamp"}, {"at": 1.0, "kind": "pin"}],
            "curvature": [0, 0, 0.1],
            "shear_factors": [1, 1],
        },
        {
            "length": 1,
            "elements": 3,
            "section": {"shape": "annulus", "radius": 0.02, "inner_radius": 0.01},
            "material": {"young_modulus": "1 MPa", "poisson_ratio": 0, "density": 1},
        },
        {
            "name": "rubber",
            "length": 1,
            "elements": 3,
            "element": "3363",
            "section": {"shape": "rectangle", "height_y": 0.02, "width_z": 0.01},
            "material": {
                "law": "mooney-rivlin",
                "c10": "0.1 MPa",
                "c01": 2e4,
                "bulk_modulus": 1e8,
                "density": 1e3,
            },
        },
    ],
    "moment": [
        {"rod": "arm", "at": 1.0, "value": [0, 0, "3 N mm"], "frame": "body", "definition": "section"}
    ],
    "force": [{"rod": "rod2", "at": 0.5, "offset": [0, 0], "value": [0, 1, 0], "direction": "follower"}],
    "line_load": [{"rod": "arm", "value": [0, 0, -1]}],
    "gravity": {"acceleration": [0, 0, -9.81]},
    "solver": {"tolerance": 1e-10, "method": "newton", "max_steps": 5, "max_seconds": 1.0},
}

scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.sampled_from([0, -1, 0.0, -0.0, 1e300, -1e300, 1e-300, 5e-324, 10**400, 2**63]),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(
        [
            "1 m",
            "1 kg",
            "1e400 m",
            "9^9^9 m",
            "circle",
            "pin",
            "3243",
            "3363",
            "neo-hookean",
            "mooney-rivlin",
            "-1 Pa",
            "m",
            "1 1/m",
        ]
    ),
    st.dates(),
    st.just(datetime.time(1, 2)),
)
anything = st.recursive(
    scalars,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of all values inside nested tables and lists."""
    found = [path] if path else []
    entries = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    )
    for key, inner in entries:
        found += places(inner, (*path, key))
    return found


@st.composite
def mutated(draw: st.DrawFn) -> dict[str, Any]:
    """The complete scene with up to three values replaced, removed, doubled or added."""
    data = copy.deepcopy(COMPLETE)
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(places(data)))
        parent = data
        for key in path[:-1]:
            parent = parent[key]
        action = draw(st.sampled_from(["replace", "replace", "remove", "double", "add"]))
        if action == "replace":
            parent[path[-1]] = draw(anything)
        elif action == "remove":
            del parent[path[-1]]
        elif isinstance(parent, list):
            parent.insert(path[-1], copy.deepcopy(parent[path[-1]]) if action == "double" else draw(anything))
        else:
            parent[draw(st.text(max_size=6))] = draw(anything)
        if not places(data):
            break
    return data


def read(data: Any) -> Scene | None:
    """The scene, or None where it is refused with a complete message."""
    try:
        return scene_from_dict(data, "fuzz")
    except SceneError as error:
        message = error.message
        assert message.where.startswith("fuzz")
        parts = (message.what, message.where, message.value, message.cause, message.advice)
        assert all(part and isinstance(part, str) for part in parts)
        return None


@QUIET
@given(scenes)
def test_valid_scenes_are_read(data: dict[str, Any]):
    result = scene_from_dict(data)
    assert len(result.rods) == len(data["rod"])
    for rod, table in zip(result.rods, data["rod"], strict=True):
        default = "continuum" if rod.element == "3363" else "enhanced"  # interface.md, Scene file
        assert rod.formulation == table.get("formulation", default)
        assert law_name(rod.material) == table["material"].get("law", "saint-venant-kirchhoff")
        # mu > 0 and K > 0 in small strain, whatever the law
        assert rod.material.lame_mu > 0.0 and -1.0 < rod.material.poisson_ratio < 0.5
        np.testing.assert_allclose(rod.base.rotation.T @ rod.base.rotation, np.eye(3), atol=1e-14)
        assert np.linalg.det(rod.base.rotation) > 0.0


@settings(parent=QUIET, max_examples=250)
@given(mutated())
@example({**COMPLETE, "rod": [{**COMPLETE["rod"][0], "curvature": [1e308, 1e308, 1e308]}]})
@example({**COMPLETE, "rod": [{**COMPLETE["rod"][0], "length": 1e20}]})
@example({**COMPLETE, 3: 4})
@example({**COMPLETE, "rod": [{**COMPLETE["rod"][2], "formulation": "enhanced"}]})
@example(
    {**COMPLETE, "rod": [{**COMPLETE["rod"][2], "material": COMPLETE["rod"][0]["material"] | {"c10": 1}}]}
)
@example({**COMPLETE, "moment": [{"value": [1.7e308, 1.7e308, 1.7e308], "frame": "body"}]})
def test_mutated_scenes_are_read_or_refused(data: dict[str, Any]):
    scene = read(data)
    if scene is not None:
        assert scene.rods
        assert all(rod.formulation in ELEMENTS[rod.element].formulations for rod in scene.rods)
        for load in (*scene.moments, *scene.forces, *scene.line_loads):
            assert np.isfinite(load.value).all()
            assert load.rod in {rod.name for rod in scene.rods}


@QUIET
@given(anything)
def test_anything_at_all_is_refused(data: Any):
    assert read(data) is None


def test_the_complete_scene_is_valid():
    # The mutations above start from a scene that is read; otherwise they would test nothing.
    assert read(COMPLETE) is not None


@pytest.mark.parametrize("path", places(COMPLETE), ids=str)
def test_every_value_is_checked(path: tuple[Any, ...]):
    """No value of the complete scene may be replaced by a date unnoticed."""
    data = copy.deepcopy(COMPLETE)
    parent = data
    for key in path[:-1]:
        parent = parent[key]
    parent[path[-1]] = datetime.date(2023, 12, 12)
    assert read(data) is None
