"""What a cable, an axis without section and torsion, cannot carry: refused when the scene is read."""

from __future__ import annotations

import numpy as np

from ancf.errors import SceneError
from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Rod, Scene
from ancf.scene_materials import law_name
from ancf.scene_table import Table, show

ALIKE = (
    1e-9  # relative difference of the principal second moments of a section that bends alike about all axes
)
ADVICE = 'use element = "3343" or "3333", which have sections'


def check_cable(table: Table, rod: Rod, joined: bool) -> None:
    """Refuse a `[[rod]]` with element = "cable" whose section, material, shape or support a cable has not."""
    for index, part in enumerate(rod.parts):
        place = f"segments[{index}]." if rod.segments else ""
        for key, section in (("section", part.section), ("section_end", part.last_section)):
            weaker, stronger = section.principal_second_moments
            if stronger - weaker > ALIKE * stronger:
                _refuse(
                    table,
                    place + key,
                    "A cable bends alike about every axis.",
                    f"principal second moments {weaker:.4g} and {stronger:.4g} m4",
                    "nothing says how its sections turn, which would matter on one that is not alike",
                )
        if not isinstance(part.material, SaintVenantKirchhoff):
            _refuse(
                table,
                place + "material",
                "A cable knows Young's modulus only.",
                f"law = {show(law_name(part.material))}",
                "it has no section that a rubber law could strain",
                'write law = "saint-venant-kirchhoff", or ' + ADVICE,
            )
    if np.any(rod.curvature):
        _refuse(
            table,
            "curvature",
            "A cable is straight where it is free of stress.",
            f"curvature = {rod.curvature.tolist()} 1/m",
            "without sections it cannot know about which of its axes it is bent or twisted",
        )
    if rod.shear_factors != (1.0, 1.0):
        _refuse(
            table,
            "shear_factors",
            "A cable does not shear.",
            f"shear_factors = {list(rod.shear_factors)}",
            "its tangent is the normal of its sections",
            "remove shear_factors, or " + ADVICE,
        )
    if joined:
        _refuse(
            table,
            "element",
            "Joints do not hold a cable.",
            f"rod {show(rod.name)} is named by a [[joint]]",
            "a joint holds the rotation of a section or turns about its point, and a cable has no section",
            "hold the cable by `supports`, or " + ADVICE,
        )


def could_be_cable(scene: Scene, rod: Rod) -> bool:
    """Whether neither the rod nor a load on it calls for a section or torsion, so that a cable would do."""
    on_sections = (*scene.moments, *scene.line_moments, *scene.magnets, *scene.tendons, *scene.pressures)
    on_axis = (*scene.forces, *scene.line_loads)
    levers = any(load.rod == rod.name and np.any(load.offset) for load in scene.forces)
    springs = any(
        held.rod == rod.name and np.any(held.rotational_stiffness)
        for held in (*scene.springs, *scene.foundations)
    ) or any(spring.rod == rod.name and np.any(spring.offset) for spring in scene.springs)
    turning = any(load.rod == rod.name and load.direction == "follower" for load in on_axis)
    if (
        rod.element == "cable"
        or levers
        or springs
        or turning
        or any(load.rod == rod.name for load in on_sections)
    ):
        return False
    try:
        check_cable(Table({}, "", ""), rod, any(rod.name in (p.rod for p in j.places) for j in scene.joints))
    except SceneError:
        return False
    return True


def refuse_on_cable(table: Table, rod: Rod, key: str, what: str, why: str) -> None:
    """Refuse a load that needs a section where it stands on a cable."""
    if rod.element == "cable":
        value = f"{key} = {show(table.data[key])}" if key in table.data else f"rod = {show(rod.name)}"
        _refuse(table, key, what, value, why)


def _refuse(table: Table, key: str, what: str, value: str, cause: str, advice: str = ADVICE) -> None:
    table.refuse(key, what, value, cause, advice)
