"""Scene files: what is read, and what is refused with file, key path, value and advice."""

# ruff: noqa: E501 - the table of refusals reads best with one case a line

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

from ancf.errors import SceneError
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.scene_file import scene_from_dict
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle

ROD: dict[str, Any] = {
    "length": 0.4,
    "elements": 12,
    "section": {"shape": "circle", "radius": 0.01},
    "material": {
        "law": "saint-venant-kirchhoff",
        "young_modulus": 1e6,
        "poisson_ratio": 0.3,
        "density": 1070.0,
    },
}
SQUARE = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def scene(**tables: Any) -> dict[str, Any]:
    """A valid scene with one rod and the given tables."""
    return {"rod": [copy.deepcopy(ROD)], **tables}


def rod(**keys: Any) -> dict[str, Any]:
    """A valid scene whose rod has some other keys; None removes a key."""
    merged = {**copy.deepcopy(ROD), **keys}
    return {"rod": [{key: value for key, value in merged.items() if value is not None}]}


def section(**keys: Any) -> dict[str, Any]:
    return rod(section=keys)


def material(**keys: Any) -> dict[str, Any]:
    return rod(material={**ROD["material"], **keys})


RUBBER = {"law": "mooney-rivlin", "c10": 1e5, "c01": 2e4, "bulk_modulus": 1e8}


def rubber(**keys: Any) -> dict[str, Any]:
    """A valid Mooney-Rivlin rod with some other constants; None removes a key."""
    return rod(material={key: value for key, value in {**RUBBER, **keys}.items() if value is not None})


def refused(data: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        scene_from_dict(data, "arm.toml")
    return caught.value


# --- what is read ------------------------------------------------------------------------------------------


def test_full_scene_is_read():
    result = scene_from_dict(
        {
            "title": "all",
            "rod": [
                {
                    **ROD,
                    "name": "arm",
                    "element": "3243",
                    "formulation": "continuum",
                    "axial_rule": "full",
                    "base": {"position": [1, 2, 3], "x_axis": [0, 0, 2], "y_axis": [0, 3, 1]},
                    "supports": [{"at": 0.0, "kind": "free_section_clamp"}, {"at": 1.0, "kind": "pin"}],
                    "curvature": [0.1, 0.2, 0.3],
                },
                {**ROD, "shear_factors": [0.9, 0.8], "axial_rule": 4},
            ],
            "moment": [{"rod": "arm", "at": 0.5, "value": [1, 2, 3], "definition": "vorticity"}],
            "force": [{"rod": "rod2", "value": [0, 1, 0], "offset": [0.005, 0], "direction": "follower"}],
            "line_load": [{"value": [0, 0, -1]}],
            "gravity": {"acceleration": [0, 0, -9.81]},
            "solver": {
                "tolerance": 1e-8,
                "tangent": "finite-difference",
                "method": "newton",
                "predictor": "none",
                "reduction": "full",
                "max_steps": 7,
                "max_seconds": 3,
            },
        }
    )
    first, second = result.rods
    assert (first.name, first.element, first.formulation, first.axial_rule) == (
        "arm",
        "3243",
        "continuum",
        "full",
    )
    assert (second.name, second.axial_rule, second.shear_factors) == ("rod2", 4, (0.9, 0.8))
    assert [(s.at, s.kind) for s in first.supports] == [(0.0, "free_section_clamp"), (1.0, "pin")]
    assert [(s.at, s.kind) for s in second.supports] == [(0.0, "clamp")]
    # x normalised; y made orthogonal to x: (0, 3, 1) minus its part along Z; z = x cross y = -X.
    np.testing.assert_array_equal(first.base.rotation, [[0, 0, -1], [0, 1, 0], [1, 0, 0]])
    np.testing.assert_array_equal(first.base.position, [1, 2, 3])
    assert result.moments[0].rod == "arm"
    assert (result.forces[0].rod, result.forces[0].at, result.forces[0].direction) == (
        "rod2",
        1.0,
        "follower",
    )
    assert result.line_loads[0].rod == "arm"
    assert result.gravity is not None and result.gravity.acceleration[2] == -9.81
    options = result.solver
    assert (options.tolerance, options.max_steps, options.max_seconds) == (1e-8, 7, 3.0)
    assert (options.tangent, options.predictor, options.reduction) == ("finite-difference", "none", "full")


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"shape": "circle", "radius": 0.01}, Circle(0.01)),
        ({"shape": "annulus", "radius": 0.01, "inner_radius": 0.004}, Annulus(0.01, 0.004)),
        ({"shape": "rectangle", "height_y": 0.01, "width_z": 0.02}, Rectangle(0.01, 0.02)),
        ({"shape": "ellipse", "semi_axis_y": 0.01, "semi_axis_z": 0.02}, Ellipse(0.01, 0.02)),
        ({"shape": "polygon", "points": SQUARE}, Polygon(tuple((float(y), float(z)) for y, z in SQUARE))),
    ],
)
def test_sections_are_read(keys: dict[str, Any], expected: object):
    assert scene_from_dict(section(**keys)).rods[0].section == expected


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"young_modulus": 1e6, "poisson_ratio": 0.3}, SaintVenantKirchhoff(1e6, 0.3)),
        ({"law": "neo-hookean", "young_modulus": "1 MPa", "poisson_ratio": 0.45}, NeoHookean(1e6, 0.45)),
        ({**RUBBER, "density": 1070}, MooneyRivlin(1e5, 2e4, 1e8, 1070.0)),
        ({**RUBBER, "c10": "0.1 MPa", "c01": 0, "bulk_modulus": "100 MPa"}, MooneyRivlin(1e5, 0.0, 1e8)),
        ({**RUBBER, "c10": 0.0}, MooneyRivlin(0.0, 2e4, 1e8)),
    ],
)
def test_laws_are_read(keys: dict[str, Any], expected: object):
    assert scene_from_dict(rod(material=keys)).rods[0].material == expected


@pytest.mark.parametrize(
    ("element", "formulation"), [("3333", "enhanced"), ("3243", "enhanced"), ("3363", "continuum")]
)
def test_an_absent_formulation_is_the_element_s_own(element: str, formulation: str):
    """interface.md: 3363 knows only the continuum."""
    assert scene_from_dict(rod(element=element)).rods[0].formulation == formulation
    assert scene_from_dict(rod(element=element, formulation="continuum")).rods[0].formulation == "continuum"


def test_a_key_of_another_law_names_that_law():
    advice = refused(rod(material={"c10": 1e5, "c01": 0.0, "bulk_modulus": 1e8})).message.advice
    assert 'law = "mooney-rivlin"' in advice
    message = refused(material(law="mooney-rivlin")).message
    assert "saint-venant-kirchhoff and neo-hookean" in message.cause
    assert "give c10, c01, bulk_modulus in place of young_modulus" in message.advice


def test_quantities_with_units_equal_numbers():
    text = rod(
        length="40 cm",
        section={"shape": "circle", "radius": "1 cm"},
        material={"young_modulus": "1 MPa", "poisson_ratio": 0.3, "density": "1.07 g/cm^3"},
    )
    read = scene_from_dict({**text, "moment": [{"value": [0, "3 N mm", 0.5]}]})
    assert read.rods[0].length == pytest.approx(0.4, rel=1e-15)
    assert read.rods[0].section.outer_radius == pytest.approx(0.01, rel=1e-15)
    assert read.rods[0].material.young_modulus == pytest.approx(1e6, rel=1e-15)
    assert read.rods[0].material.density == pytest.approx(1070.0, rel=1e-14)
    np.testing.assert_allclose(read.moments[0].value, [0, 3e-3, 0.5], rtol=1e-15)


@pytest.mark.parametrize("table", ["moment", "force", "line_load"])
def test_body_frame_is_turned_into_structure_coordinates(table: str):
    # Paper eq. 3: the arm's x is Z, its y is Y, hence its z is -X.
    data = rod(base={"x_axis": [0, 0, 1], "y_axis": [0, 1, 0]})
    data[table] = [{"value": [1.0, 2.0, 3.0], "frame": "body"}]
    (load,) = getattr(scene_from_dict(data), table + "s")
    np.testing.assert_array_equal(load.value, [-3.0, 2.0, 1.0])


@pytest.mark.parametrize("size", [0.0, 1e300, 1e-300, -1e300])
def test_loads_of_any_finite_size_are_legal(size: float):
    data = scene(force=[{"value": [size, 0, 0]}], moment=[{"value": [0, size, 0]}])
    assert scene_from_dict(data).forces[0].value[0] == size


def test_base_axes_survive_extreme_sizes():
    frame = scene_from_dict(rod(base={"x_axis": [1e300, 1e300, 0], "y_axis": [0, 1e-300, 0]})).rods[0].base
    half = math.sqrt(0.5)
    np.testing.assert_allclose(frame.rotation, [[half, -half, 0], [half, half, 0], [0, 0, 1]], atol=1e-15)


def test_pins_off_one_line_hold_a_curved_rod():
    pins = [{"at": at, "kind": "pin"} for at in (0.0, 0.5, 1.0)]
    assert len(scene_from_dict(rod(curvature=[0, 0, 3.0], supports=pins)).rods[0].supports) == 3


# --- what is refused ---------------------------------------------------------------------------------------

PIN = {"kind": "pin"}
REFUSED = [
    # scene
    ({}, "rod", "no rod", "no [[rod]] table"),
    ({"rod": []}, "rod", "no rod", "no [[rod]]"),
    ([], "", "must be a table", "a list"),
    ({"rod": ROD}, "rod", "list of tables", "single table"),
    ({"rod": [3]}, "rod[0]", "must be a table", "3 is a whole number"),
    (scene(tittle="x"), "tittle", "Unknown key", "'tittle'"),
    (scene(title=3), "title", "wrong type", "a whole number"),
    (scene(moment={"value": [0, 0, 1]}), "moment", "list of tables", "single table"),
    (scene(gravity=[{"acceleration": [0, 0, 1]}]), "gravity", "only one [gravity]", "is a list"),
    ({"rod": [ROD, {**ROD, "name": "rod"}]}, "rod[1].name", 'Two rods are named "rod"', "rod[0]"),
    # rod
    *[(rod(**{key: None}), f"rod[0].{key}", f'"{key}" is missing', "only")
      for key in ("length", "elements", "section", "material")],
    (rod(lenght=1.0), "rod[0].lenght", "Unknown key", "none of name, length"),
    (rod(name=" "), "rod[0].name", "empty", "' '"),
    *[(rod(length=value), "rod[0].length", "out of range", "must be > 0") for value in (0, 0.0, -0.4, 1e-300, 1e300)],
    *[(rod(length=value), "rod[0].length", "not finite", "finite length") for value in (math.inf, math.nan, 10**400)],
    *[(rod(length=value), "rod[0].length", "wrong type", "a number (length, m)") for value in (True, [1], {}, None)
      if value is not None],
    (rod(length="40 kg"), "rod[0].length", "no length", "'kg' measures [mass]"),
    *[(rod(elements=value), "rod[0].elements", "wrong type", "whole number >= 1") for value in (2.0, True, "12", [4])],
    *[(rod(elements=value), "rod[0].elements", "out of range", "from 1 to 1000000") for value in (0, -3, 10**7)],
    (rod(element="3334"), "rod[0].element", "Unknown element '3334'", "none of 3333, 3243, 3343, 3363, cable"),
    (rod(element=3333), "rod[0].element", "wrong type", "in quotes"),
    (rod(element="cable", section={"shape": "ellipse", "semi_axis_y": 0.01, "semi_axis_z": 0.02}), "rod[0].section",
      "bends alike", "principal second moments"),
    (rod(element="cable", material={"law": "neo-hookean", "young_modulus": 1e6, "poisson_ratio": 0.3}),
      "rod[0].material", "Young's modulus only", "neo-hookean"),
    (rod(element="cable", curvature=[0, 0, 1]), "rod[0].curvature", "A cable is straight", "[0.0, 0.0, 1.0]"),
    (rod(element="cable", shear_factors=[0.9, 1]), "rod[0].shear_factors", "does not shear", "[0.9, 1.0]"),
    (rod(element="cable", formulation="continuum"), "rod[0].formulation", "cable knows no continuum", "it knows enhanced"),
    (rod(element="cable", supports=[{"kind": "pin"}]), "rod[0].supports", "free to move", "one pin"),
    (rod(element="cable") | {"moment": [{"value": [0, 0, 1]}]}, "moment[0].rod", "carries no [[moment]]", "rod = "),
    (rod(element="cable") | {"force": [{"value": [0, 0, 1], "offset": [0.001, 0]}]}, "force[0].offset",
      "on its axis only", "[0.001, 0]"),
    (rod(element="cable") | {"force": [{"value": [0, 0, 1], "direction": "follower"}]}, "force[0].direction",
      "no follower", "follower"),
    (rod(element="cable") | {"line_load": [{"value": [0, 0, 1], "direction": "follower"}]}, "line_load[0].direction",
      "no follower", "follower"),
    (rod(element="cable") | {"joint": [{"kind": "ball", "a": {"rod": "rod", "at": 1.0}, "b": "ground"}]},
      "rod[0].element", "Joints do not hold a cable", "named by a [[joint]]"),
    (rod(formulation="enhaced"), "rod[0].formulation", "Unknown formulation", "none of enhanced, continuum"),
    (rod(element="3363", formulation="enhanced"), "rod[0].formulation", "3363 knows no enhanced", "it knows continuum"),
    (rod(element="3363", shear_factors=[0.9, 1]), "rod[0].shear_factors", "enhanced formulation", 'element = "3363"'),
    (rod(axial_rule=0), "rod[0].axial_rule", "out of range", "from 1 to 10"),
    (rod(axial_rule=11), "rod[0].axial_rule", "out of range", "from 1 to 10"),
    (rod(axial_rule=2.5), "rod[0].axial_rule", "wrong type", "whole number"),
    (rod(axial_rule="ful"), "rod[0].axial_rule", "Unknown axial_rule", "none of default, full"),
    (rod(shear_factors=[1, 0]), "rod[0].shear_factors[1]", "out of range", "> 0"),
    (rod(shear_factors=[1]), "rod[0].shear_factors", "has 1 entries", "exactly 2"),
    (rod(shear_factors=[0.9, 1], formulation="continuum"), "rod[0].shear_factors", "enhanced formulation", "continuum"),
    # places whose squares would overflow
    (rod(base={"position": [1e300, 0, 0]}), "rod[0].base.position[0]", "out of range", "between -1e20 and 1e20"),
    (scene(spring=[{"stiffness": 1, "to": "anchor", "anchor": [0, 1e200, 0]}]), "spring[0].anchor[1]", "out of range",
     "between -1e20 and 1e20"),
    *[(scene(contact=[{"with": {"shape": shape, key: [0, 0, -1e200], **rest}}]), f"contact[0].with.{key}[2]",
       "out of range", "between -1e20 and 1e20")
      for shape, key, rest in (("plane", "point", {"normal": [0, 0, 1]}), ("sphere", "centre", {"radius": 1}),
                               ("cylinder", "point", {"axis": [1, 0, 0], "radius": 1}))],
    # section
    (section(radius=0.01), "rod[0].section.shape", "missing", "radius"),
    (section(shape="disc", radius=0.01), "rod[0].section.shape", "Unknown shape 'disc'", "circle"),
    (section(shape="circle", radius=-0.01), "rod[0].section.radius", "out of range", "must be > 0"),
    (section(shape="circle", radius=0.01, inner_radius=0.001), "rod[0].section.inner_radius", "Unknown key", "none of"),
    (section(shape="annulus", radius=0.01, inner_radius=0.01), "rod[0].section.inner_radius", "no wall", "0.01 m"),
    (section(shape="annulus", radius=0.01, inner_radius=0.02), "rod[0].section.inner_radius", "no wall", "0.02 m"),
    (section(shape="rectangle", height_y=0.01), "rod[0].section.width_z", "missing", "height_y"),
    (section(shape="rectangle", height_y=1e-12, width_z=1.0), "rod[0].section", "too thin", "radius of gyration"),
    (section(shape="polygon", points=SQUARE[:2]), "rod[0].section.points", "2 corners", "3 to 1000"),
    (section(shape="polygon", points=SQUARE[::-1]), "rod[0].section.points", "clockwise", "signed area = -4"),
    (section(shape="polygon", points=[[0, 0], [1, 1], [2, 2]]), "rod[0].section.points", "no area", "area = 0"),
    (section(shape="polygon", points=[[0, 0], [2, 2], [2, 0], [0, 3]]), "rod[0].section.points", "crosses", "edges after"),
    (section(shape="polygon", points=[*SQUARE, SQUARE[0]]), "rod[0].section.points", "touches itself", "points[0]"),
    (section(shape="polygon", points=[[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]]), "rod[0].section.points", "touches", "edges"),
    (section(shape="polygon", points=[[0, 0], [2, 0], [1, 0], [1, 2]]), "rod[0].section.points", "crosses", "edges"),
    (section(shape="polygon", points=[[0, 0], [1, 0], [1]]), "rod[0].section.points[2]", "1 entries", "exactly 2"),
    (section(shape="polygon", points=[[0, 0], [1, 0], 7]), "rod[0].section.points[2]", "wrong type", "list of 2"),
    # material
    (material(law="yeoh"), "rod[0].material.law", "Unknown law 'yeoh'", "saint-venant-kirchhoff, neo-hookean, mooney-rivlin"),
    (material(law="neo-hookean", c10=1e5), "rod[0].material.c10", '"c10" is no constant of neo-hookean', "young_modulus, poisson_ratio"),
    (material(law="mooney-rivlin"), "rod[0].material.young_modulus", "no constant of mooney-rivlin", "c10, c01, bulk_modulus"),
    (rubber(poisson_ratio=0.49), "rod[0].material.poisson_ratio", "no constant of mooney-rivlin", "c10, c01, bulk_modulus"),
    (rod(material={"c10": 1e5, "c01": 0, "bulk_modulus": 1e8}), "rod[0].material.c10", "no constant of saint-venant", "young_modulus"),
    *[(rubber(**{key: None}), f"rod[0].material.{key}", f'"{key}" is missing', "only") for key in RUBBER if key != "law"],
    (rod(material={"law": "neo-hookean", "young_modulus": 1e6}), "rod[0].material.poisson_ratio", "missing", "only"),
    *[(rubber(**{key: -1e3}), f"rod[0].material.{key}", f"{key} of mooney-rivlin is negative", "-1000 Pa") for key in ("c10", "c01")],
    (rubber(c10=0, c01=0), "rod[0].material.c10", "no shear stiffness", "c10 + c01 = 0"),
    *[(rubber(bulk_modulus=value), "rod[0].material.bulk_modulus", "out of range", "> 0") for value in (0, -1e6)],
    (rubber(bulk_modulus=1e19), "rod[0].material.bulk_modulus", "too far apart", "= 4.17e+13, outside 1e-12 to 1e+12"),
    (rubber(bulk_modulus=1e-9), "rod[0].material.bulk_modulus", "too far apart", "= 4.17e-15"),
    (rubber(c10=1e31), "rod[0].material.c10", "out of range", "between 1e-30 and 1e30"),
    (rubber(c01="2 m"), "rod[0].material.c01", "no stress", "'m' measures"),
    (rubber(c11=1.0), "rod[0].material.c11", "Unknown key", "c10, c01, bulk_modulus, density"),
    (material(law="neo-hookean", poisson_ratio=0.5), "rod[0].material.poisson_ratio", "out of range", "inside (-1, 0.5)"),
    *[(material(poisson_ratio=nu), "rod[0].material.poisson_ratio", "out of range", "inside (-1, 0.5)")
      for nu in (0.5, -1, 0.7, -1.0)],
    *[(material(young_modulus=value), "rod[0].material.young_modulus", "out of range", "> 0") for value in (0, -1e6)],
    *[(material(density=value), "rod[0].material.density", "out of range", "> 0") for value in (0, -1)],
    (material(young_module=1), "rod[0].material.young_module", "Unknown key", "young_modulus"),
    # base and curvature
    (rod(base={"x_axis": [0, 0, 0]}), "rod[0].base.x_axis", "no direction", "[0, 0, 0]"),
    (rod(base={"x_axis": [0, 1, 0]}), "rod[0].base.y_axis", "parallel", "sine"),
    (rod(base={"x_axis": [1, 2, 3], "y_axis": [-2, -4, -6]}), "rod[0].base.y_axis", "parallel", "sine"),
    (rod(base={"position": [0, 0]}), "rod[0].base.position", "2 entries", "exactly 3"),
    (rod(base={"position": [0, math.nan, 0]}), "rod[0].base.position[1]", "not finite", "nan"),
    (rod(base={"z_axis": [0, 0, 1]}), "rod[0].base.z_axis", "Unknown key", "x_axis"),
    (rod(curvature=[0, 0, 100]), "rod[0].curvature", "more sharply", "= 1 >= 1"),
    (rod(curvature=[0, 60, -90], elements=999), "rod[0].curvature", "more sharply", "1.08 >= 1"),
    (rod(curvature=[100, 0, 0]), "rod[0].curvature", "too long for this curvature", "191 degrees"),
    (rod(length=1e6), "rod[0].length", "too slender", "radius of gyration = 2e+08"),
    # supports
    (rod(supports=[]), "rod[0].supports", "no support", "supports = []"),
    (rod(supports={"at": 0.0}), "rod[0].supports", "list of tables", "single table"),
    (rod(supports=[{"at": 1.5}]), "rod[0].supports[0].at", "out of range", "between 0 and 1"),
    (rod(supports=[{"kind": "glue"}]), "rod[0].supports[0].kind", "Unknown kind", "clamp, pin"),
    (rod(supports=[{"at": 0.5}, {"at": 0.5}]), "rod[0].supports[1].at", "same section", "supports[0]"),
    (rod(supports=[{"at": 0, **PIN}]), "rod[0].supports", "rigid body", "three rotations"),
    (rod(supports=[{"at": 0, **PIN}, {"at": 1, **PIN}]), "rod[0].supports", "rigid body", "2 pins on one line"),
    (rod(supports=[{"at": a, **PIN} for a in (0, 0.3, 1)]), "rod[0].supports", "rigid body", "3 pins on one line"),
    (rod(supports=[{"at": a, **PIN} for a in (0, 0.3, 1)], curvature=[5, 0, 0]), "rod[0].supports", "rigid body", "line"),
    (rod(supports=[{"at": a, **PIN} for a in (0, 1)], curvature=[0, 0, 3]), "rod[0].supports", "rigid body", "2 pins"),
    (rod(elements=2, supports=[{"at": a} for a in (0.2, 0.5, 0.8)]), "rod[0].elements", "fewer elements", "pieces = 4"),
    # loads
    (scene(moment=[{}]), "moment[0].value", "missing", "empty table"),
    (scene(moment=[{"value": [0, 0]}]), "moment[0].value", "2 entries", "exactly 3"),
    (scene(moment=[{"value": 3}]), "moment[0].value", "wrong type", "list of 3 numbers [N m]"),
    (scene(moment=[{"value": [0, "3 N", 0]}]), "moment[0].value[1]", "no moment", "'N' measures"),
    (scene(moment=[{"value": [0, 0, math.inf]}]), "moment[0].value[2]", "not finite", "inf"),
    (scene(moment=[{"value": [0, 0, 1], "at": -0.1}]), "moment[0].at", "out of range", "between 0 and 1"),
    (scene(moment=[{"value": [0, 0, 1], "frame": "local"}]), "moment[0].frame", "Unknown frame", "structure, body"),
    (scene(moment=[{"value": [0, 0, 1], "definition": "spin"}]), "moment[0].definition", "Unknown", "vorticity"),
    (scene(moment=[{"value": [0, 0, 1], "rod": "arm"}]), "moment[0].rod", "no rod named 'arm'", "none of rod"),
    (scene(force=[{"value": [0, 0, 1], "offset": [0.02, 0]}]), "force[0].offset", "outside the section", "is no point of circle"),
    (scene(force=[{"value": [0, 0, 1], "direction": "follow"}]), "force[0].direction", "Unknown", "fixed, follower"),
    (scene(force=[{"value": [0, 0, 1]}, {"valeu": [0, 0, 1]}]), "force[1].valeu", "Unknown key", "value"),
    (scene(line_load=[{"value": [0, 0, 1], "at": 1}]), "line_load[0].at", "Unknown key", "none of rod, value"),
    (scene(gravity={}), "gravity.acceleration", "missing", "empty table"),
    ({**material(density=1.0), "rod": [{**ROD, "material": {"young_modulus": 1.0, "poisson_ratio": 0}}],
      "gravity": {"acceleration": [0, 0, -9.81]}}, "rod[0].material.density", "needs a density", 'rod "rod" has none'),
    # solver
    *[(scene(solver={"tolerance": value}), "solver.tolerance", "out of range", "inside (0, 1e-2]") for value in (0, 0.1, -1)],
    (scene(solver={"method": "arc"}), "solver.method", "method", "arc"),
    (scene(stability={"modes": 0}), "stability.modes", "modes is out of range", "from 1 to 100"),
    (scene(stability={"modes": 2.5}), "stability.modes", "modes", "2.5"),
    (scene(stability={"branch": "buckle"}), "stability.branch", "branch", "buckle"),
    (scene(stability={"mode": 3}), "stability.mode", "Unknown key", "modes, branch"),
    (scene(stability=3), "stability", "must be a table", "3"),
    (scene(solver={"reduction": "flat"}), "solver.reduction", "reduction", "flat"),
    (
        scene(solver={"reduction": "planar"}, force=[{"value": [0, 1, 0]}], gravity={"acceleration": [0, 0, -9.81]}),
        "gravity",
        "not planar",
        "1 of the weight points out of the plane across (0, 0, 1)",
    ),
    (
        scene(solver={"reduction": "planar", "method": "arclength"}),
        "solver.reduction",
        "in space",
        'method = "arclength"',
    ),
    (scene(solver={"accuracy": 1e-3}), "rod[0].elements", "both given", "elements = 12 beside accuracy"),
    (scene(solver={"accuracy": 1e-9}), "solver.accuracy", "out of range", "between 1e-8 and 0.1"),
    (scene(solver={"max_steps": 0}), "solver.max_steps", "out of range", "from 1 to"),
    (scene(solver={"max_seconds": 0}), "solver.max_seconds", "out of range", "> 0"),
    (scene(solver={"tangent": "numeric"}), "solver.tangent", "Unknown tangent", "finite-difference"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("data", "path", "what", "value"), REFUSED, ids=[f"{i}-{case[1]}" for i, case in enumerate(REFUSED)]
)
def test_refusals_say_what_where_and_value(data: Any, path: str, what: str, value: str):
    message = refused(data).message
    assert message.where == (f"arm.toml: {path}" if path else "arm.toml")
    assert what in message.what
    assert value in message.value
    assert message.cause and message.advice


@pytest.mark.parametrize(
    ("data", "nearest"),
    [
        (rod(lenght=1.0), "length"),
        (rod(segment=[]), "segments"),
        (material(Young_Modulus=1), "young_modulus"),
        (scene(momnt=[]), "moment"),
        (scene(solver={"tolerence": 1e-3}), "tolerance"),
        (rod(element="3433"), "3343"),
        (material(law="neohookean"), "neo-hookean"),
        (rubber(bulk_module=1e8), "bulk_modulus"),
        (scene(force=[{"value": [0, 0, 1], "rod": "rot"}]), "rod"),
    ],
)
def test_nearest_word_is_named(data: Any, nearest: str):
    assert f'did you mean "{nearest}"?' in refused(data).message.advice


def test_message_prints_five_parts():
    lines = str(refused(rod(section={"shape": "circle", "radius": -1.0}))).splitlines()
    assert lines == [
        "radius is out of range.",
        "  where: arm.toml: rod[0].section.radius",
        "  value: -1.0; radius must be > 0, and between 1e-20 and 1e20 [m]",
        "  cause: a slip of sign, of unit or of magnitude",
        "  try:   give a length that is > 0, and between 1e-20 and 1e20 (numbers are SI: m)",
    ]
