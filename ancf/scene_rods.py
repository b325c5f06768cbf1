"""Reading of `[[rod]]` tables: size, material, base, supports and stress-free curvature.

Whatever would make the rod's equations meaningless is refused here, so that the kernels need no checks.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.scene import SAME_PLACE, Frame, Rod, Support
from ancf.scene_cable import check_cable
from ancf.scene_materials import read_material
from ancf.scene_rod_checks import check_curvature, check_rigid_motion, check_slenderness
from ancf.scene_sections import read_section
from ancf.scene_segments import read_elements, read_segments
from ancf.scene_table import FRACTION, SIGNED, SIZE, Limit, Table, show
from ancf.segments import Segment
from ancf.units import CURVATURE, LENGTH, NUMBER

Floats = NDArray[np.float64]

ROD_KEYS = (
    "name",
    "length",
    "elements",
    "segments",
    "element",
    "formulation",
    "axial_rule",
    "section",
    "material",
    "base",
    "supports",
    "curvature",
    "shear_factors",
)
# Whoever gives one of these has chosen the element; `accuracy` then chooses the mesh alone.
ELEMENT_KEYS = ("element", "formulation", "axial_rule", "shear_factors")
SUPPORT_KINDS = ("clamp", "pin", "free_section_clamp")

MOST_ELEMENTS = 1_000_000  # some 20 GB of tangent; beyond it a typing error is far more likely than a rod
LEAST_ANGLE = 1e-6  # rad between x_axis and y_axis; below it half of the digits of z = x cross y are lost
SHEAR_FACTOR = Limit(lambda v: 1e-9 <= v <= 1e9, "> 0, and between 1e-9 and 1e9")


def default_name(index: int) -> str:
    """Name of a rod without one, by its place: "rod", "rod2", ..."""
    return "rod" if index == 0 else f"rod{index + 1}"


def read_rod(table: Table, index: int, joined: Collection[str] = (), meshed: bool = True) -> Rod:
    """Read one `[[rod]]` table; `joined` are the names of rods that joints hold.

    Unless it is `meshed` it has no elements yet: `accuracy` chooses them.
    """
    table.expect_keys(ROD_KEYS)
    name = _name(table, default_name(index))
    if "segments" in table.data:
        segments = read_segments(table, MOST_ELEMENTS, meshed)
    else:
        segments = (_whole(table, meshed),)
    element = table.word("element", tuple(ELEMENTS), "3333")
    formulation = _formulation(table, element)
    rod = Rod.of_segments(
        name,
        segments,
        element=element,
        formulation=formulation,
        axial_rule=_axial_rule(table),
        base=_base(table.table("base", {})),
        supports=_supports(table, name in joined),
        curvature=table.vector("curvature", 3, CURVATURE, (0.0, 0.0, 0.0), SIGNED),
        shear_factors=_shear_factors(table, element, formulation),
        any_element=not meshed and not any(key in table.data for key in ELEMENT_KEYS),
    )
    if element == "cable":
        check_cable(table, rod, name in joined)
    check_slenderness(table, rod)
    check_curvature(table, rod)
    if name not in joined:  # else the whole structure decides: scene_joints.py
        check_rigid_motion(table, rod)
    return rod


def _whole(table: Table, meshed: bool) -> Segment:
    """Read a rod without segments, which is one."""
    return Segment(
        length=table.number("length", LENGTH, limit=SIZE),
        section=read_section(table.table("section")),
        elements=read_elements(table, MOST_ELEMENTS, meshed),
        material=read_material(table.table("material")),
    )


def _name(table: Table, default: str) -> str:
    name = table.text("name", default)
    if not name.strip() or not name.isprintable():
        table.refuse(
            "name",
            "The rod's name is empty or not printable.",
            show(name),
            "results are listed by this name",
            'give a word, such as name = "arm"',
        )
    return name


def _formulation(table: Table, element: str) -> str:
    """Read the formulation: ``enhanced`` mends linear sections only, and ``continuum`` asks for a section."""
    known = ELEMENTS[element].formulations
    formulation = table.word("formulation", ("enhanced", "continuum"), known[0])
    if formulation not in known:
        table.refuse(
            "formulation",
            f"Element {element} knows no {formulation} formulation.",
            f'formulation = "{formulation}" with element = "{element}"; it knows {", ".join(known)}',
            "enhanced mends a linear section, and this section is quadratic: nothing is to be mended"
            if ELEMENTS[element].has_section
            else "the continuum is that of a section, and a cable has none",
            f'remove the key, or write formulation = "{known[0]}"',
        )
    return formulation


def _axial_rule(table: Table) -> str | int:
    if isinstance(table.get("axial_rule", "default"), str):
        return table.word("axial_rule", ("default", "full"), "default")
    return table.whole("axial_rule", 1, 10)


def _shear_factors(table: Table, element: str, formulation: str) -> tuple[float, float]:
    k_y, k_z = table.vector("shear_factors", 2, NUMBER, (1.0, 1.0), SHEAR_FACTOR)
    if formulation != "enhanced" and (k_y, k_z) != (1.0, 1.0):
        table.refuse(
            "shear_factors",
            "shear_factors belong to the enhanced formulation.",
            f'[{k_y:g}, {k_z:g}] with element = "{element}", formulation = "{formulation}"',
            "the continuum's shear stiffness follows from its law alone",
            "remove shear_factors"
            + (', or set formulation = "enhanced"' if "enhanced" in ELEMENTS[element].formulations else ""),
        )
    return float(k_y), float(k_z)


def _base(table: Table) -> Frame:
    """Read the base: BCS axes normalised, y made orthogonal to x, z = x cross y (paper eq. 2-3)."""
    table.expect_keys(("position", "x_axis", "y_axis"))
    position = table.vector("position", 3, LENGTH, (0.0, 0.0, 0.0))
    x_axis = read_direction(table, "x_axis", (1.0, 0.0, 0.0))
    y_axis = read_direction(table, "y_axis", (0.0, 1.0, 0.0))
    y_axis = y_axis - (y_axis @ x_axis) * x_axis
    sine = float(np.linalg.norm(y_axis))
    if sine < LEAST_ANGLE:
        table.refuse(
            "y_axis",
            "x_axis and y_axis are parallel.",
            f"the sine of their angle is {sine:.3g}, must be >= {LEAST_ANGLE:g}",
            "only one of the two was given and the default of the other points the same way"
            if len(table.data.keys() & {"x_axis", "y_axis"}) == 1
            else "the two axes do not span a plane",
            "give a y_axis that points along the section's y, across x_axis",
        )
    y_axis = y_axis / sine
    # A second pass removes what cancellation in the first one left along x.
    y_axis = y_axis - (y_axis @ x_axis) * x_axis
    y_axis = y_axis / np.linalg.norm(y_axis)
    return Frame(position, np.column_stack([x_axis, y_axis, np.cross(x_axis, y_axis)]))


def read_direction(table: Table, key: str, default: Any) -> Floats:
    """Read an axis (3,) and normalise it; dividing by the largest component first avoids overflow."""
    vector = table.vector(key, 3, NUMBER, default)
    largest = np.max(np.abs(vector))
    if largest == 0.0:
        table.refuse(
            key,
            f"{key} has no direction.",
            "[0, 0, 0]",
            "a zero vector",
            "give it one component at least",
        )
    vector = vector / largest
    return vector / np.linalg.norm(vector)


def _supports(table: Table, joined: bool) -> tuple[Support, ...]:
    """Read the supports; a rod without the key is clamped at its base, unless a joint holds it."""
    if "supports" not in table.data:
        return () if joined else (Support(),)
    supports = []
    for entry in table.tables("supports"):
        entry.expect_keys(("at", "kind"))
        at = entry.number("at", NUMBER, 0.0, FRACTION)
        twin = next((i for i, other in enumerate(supports) if abs(other.at - at) < SAME_PLACE), None)
        if twin is not None:
            entry.refuse(
                "at",
                "Two supports hold the same section.",
                f"at = {at:g}, as in supports[{twin}]",
                "a support was written twice",
                "keep one of them",
            )
        supports.append(Support(at, entry.word("kind", SUPPORT_KINDS, "clamp")))
    if not supports and not joined:
        table.refuse(
            "supports",
            "The rod has no support.",
            "supports = []",
            "a free rod has no equilibrium under a load, and no joint holds this one",
            "remove the key (a clamp at 0), list at least one clamp, or hold the rod by a [[joint]]",
        )
    return tuple(supports)
