"""What is refused of a rod as a whole: sizes that leave no digits, folded sections, rigid motions."""

from __future__ import annotations

import math

import numpy as np

from ancf.mesh import reference_axis
from ancf.scene import Rod
from ancf.scene_table import Table

LARGEST_FLOOR = 1e-2  # of E I / L^2: an equilibrium with an error of one percent is none
# Among segments the rounding stays in the section forces of the stiffest and shortest, with the shape right
# to 1e-5 L. Above 1 the iteration begins to lose it, from 10 it fails (stiff insert of 1e-4 h, L/R 100).
LARGEST_SEGMENT_FLOOR = 1.0
ON_A_LINE = 1e-6  # of the length: pins that are nearer to one line leave the spin about it


def check_slenderness(table: Table, rod: Rod) -> None:
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
    """`check_slenderness` of a rod of segments: its stiffest, shortest elements against its bending."""
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


def check_curvature(table: Table, rod: Rod) -> None:
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


def check_rigid_motion(table: Table, rod: Rod) -> None:
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
    if (len(at) >= 3 and spread[1] > ON_A_LINE) or (len(at) >= 2 and rod.element == "cable"):
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
