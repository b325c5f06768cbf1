"""Reading of `[[rod]]` tables: size, material, base, supports and stress-free curvature.

Whatever would make the rod's equations meaningless is refused here, so that the kernels need no checks.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.mesh import reference_axis
from ancf.scene import SAME_PLACE, Frame, Rod, Support
from ancf.scene_cable import check_cable
from ancf.scene_materials import read_material
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
LARGEST_FLOOR = 1e-2  # of E I / L^2: an equilibrium with an error of one percent is none
# Among segments the rounding stays in the section forces of the stiffest and shortest, with the shape right
# to 1e-5 L. Above 1 the iteration begins to lose it, from 10 it fails (stiff insert of 1e-4 h, L/R 100).
LARGEST_SEGMENT_FLOOR = 1.0
SHEAR_FACTOR = Limit(lambda v: 1e-9 <= v <= 1e9, "> 0, and between 1e-9 and 1e9")


def default_name(index: int) -> str:
    """Name of a rod without one, by its place: "rod", "rod2", ..."""
    return "rod" if index == 0 else f"rod{index + 1}"


def read_rod(
    table: Table, index: int, joined: Collection[str] = (), meshed: bool = True, lying: Collection[str] = ()
) -> Rod:
    """Read one `[[rod]]` table; `joined` are the names of rods that joints hold, `lying` those on friction.

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
        supports=_supports(table, name in joined, name in lying),
        curvature=table.vector("curvature", 3, CURVATURE, (0.0, 0.0, 0.0), SIGNED),
        shear_factors=_shear_factors(table, element, formulation),
        any_element=not meshed and not any(key in table.data for key in ELEMENT_KEYS),
    )
    if element == "cable":
        check_cable(table, rod, name in joined)
    _check_slenderness(table, rod)
    _check_curvature(table, rod)
    if name not in joined and rod.supports:  # else the whole structure decides: scene_joints.py, or friction
        _check_rigid_motion(table, rod)
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


def _supports(table: Table, joined: bool, lying: bool) -> tuple[Support, ...]:
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
    if not supports and not joined and not lying:
        table.refuse(
            "supports",
            "The rod has no support.",
            "supports = []",
            "a free rod has no equilibrium under a load, and no joint holds this one",
            "remove the key (a clamp at 0), list at least one clamp, hold the rod by a [[joint]],"
            " or lay it on an obstacle with friction",
        )
    return tuple(supports)


def _check_slenderness(table: Table, rod: Rod) -> None:
    """Refuse a rod so slender that float64 positions leave no digits of its residual (newton.py).

    Positions are stored to eps L, a strain of eps L/h in an element of length h, and a force of E A eps L/h:
    10 eps n_el A L^2/I in units of E I/L^2 on a plain rod; the worst element counts on a rod of segments.
    """
    if rod.segments:
        _check_segments(table, rod)
        return
    slenderness = rod.length / rod.section.radius_of_gyration
    floor = 10.0 * float(np.finfo(float).eps) * max(rod.elements, 1) * slenderness**2
    if floor > LARGEST_FLOOR:
        table.refuse(
            "length",
            "The rod is too slender for double precision.",
            f"length / radius of gyration = {slenderness:.3g} with {rod.elements}"
            f" elements leaves a residual of {floor:.2g}, must be <= {LARGEST_FLOOR:g}",
            "length or section is given in the wrong unit, or a thread is modelled as a rod",
            "check length and section [m], or take fewer elements",
        )


def _check_segments(table: Table, rod: Rod) -> None:
    """`_check_slenderness` of a rod of segments: its stiffest, shortest elements against its bending."""
    bending = rod.length / sum(part.bending_compliance for part in rod.parts)
    noise = [
        part.material.young_modulus
        * max(part.section.area, part.last_section.area)
        * max(part.elements, 1)
        / part.length
        for part in rod.parts
    ]
    worst = int(np.argmax(noise))
    floor = 10.0 * float(np.finfo(float).eps) * noise[worst] * rod.length**3 / bending
    if not floor <= LARGEST_SEGMENT_FLOOR:
        table.refuse(
            f"segments[{worst}]",
            "The segments differ too much for double precision.",
            f"E A / (element length) here against E I / L^3 = {bending / rod.length**3:.3g} N/m of the rod"
            f" leaves a residual of {floor:.2g}, must be <= {LARGEST_SEGMENT_FLOOR:g}",
            "a very stiff or finely meshed segment on a very slender or soft rod, or another unit",
            "take fewer elements here, bring the moduli nearer to each other, or check all sizes [m]",
        )


def _check_curvature(table: Table, rod: Rod) -> None:
    """Refuse a stress-free curvature that folds the section (det J_0 <= 0)."""
    # x = 0 is representative: the curvature is constant in section axes, so det J_0 = 1 + k_y z - k_z y.
    bending = math.hypot(rod.curvature[1], rod.curvature[2])
    radius = max(section.outer_radius for part in rod.parts for section in (part.section, part.last_section))
    reach = bending * radius
    if reach >= 1.0:
        table.refuse(
            "curvature",
            "The rod is bent more sharply than its section is thick.",
            f"curvature {bending:g} 1/m x outer radius {radius:g} m = {reach:.3g} >= 1",
            "material on the inside would lie beyond the centre of curvature (det J_0 <= 0)",
            "reduce the curvature [1/m] or the section",
        )


def _check_rigid_motion(table: Table, rod: Rod) -> None:
    """Refuse supports that leave the rod free to move without straining.

    Either kind of clamp holds all six motions. Pins hold positions only: one pin leaves three rotations,
    pins on one line leave the spin about it, which is no motion of a straight cable; three pins off one line
    hold the rod.
    """
    if any(support.kind != "pin" for support in rod.supports):
        return
    at = np.array([support.at for support in rod.supports])
    position, _ = reference_axis(at * rod.length, rod.curvature)
    spread = np.linalg.svd((position - position.mean(axis=0)) / rod.length, compute_uv=False)
    if (len(at) >= 3 and spread[1] > LEAST_ANGLE) or (len(at) >= 2 and rod.element == "cable"):
        return
    free = (
        "one pin leaves all three rotations about it free"
        if len(at) == 1
        else f"{len(at)} pins on one line leave the spin about that line free"
    )
    table.refuse(
        "supports",
        "The supports leave the rod free to move as a rigid body.",
        f"{free}; at = {', '.join(f'{a:g}' for a in at)}",
        "a pin holds the position of the axis and no rotation",
        'make one of them a clamp: { at = 0.0, kind = "clamp" }',
    )
