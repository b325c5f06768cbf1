"""The regime of a scene: what defines it, and how hard it is, as plain words and numbers for each rod.

Thin-rod numbers, with M the largest moment, EI of the weaker axis and R the outer radius: kappa_R = M R/EI,
turn = M L/EI [rad], turn_per_element. A scene under moments alone has them before it is solved.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ancf.scene import Rod, Scene
    from ancf.solution import Solution

AXIAL = 1e-9  # share of a vector along (across) the rod from which it counts as having that part
OUTLINE_POINTS = 16
# What a scene is made of: words, each of which must have been tried.
SETTINGS: tuple[str, ...] = (
    "section",
    "reference",
    "axial_rule",
    "shear_factors",
    "supports",
    "moment",
    "places",
)
# How hard it is: harder when larger.
HARDNESS: tuple[str, ...] = ("poisson_ratio", "kappa_R", "turn", "turn_per_element", "strain")
# Problems whose cases measure the accuracy of a solved scene; the others show identities, a linear stiffness
# or iterations, and vouch for no scene.
ACCURATE = frozenset(
    {
        "cross-check", "elastica", "gap rate", "helix", "published deflection", "pure bending", "rod",
        "rubber stretch", "section stress", "uniaxial",
    }
)  # fmt: skip


def regimes(solution: Solution) -> list[dict[str, Any]]:
    """Regime of every rod of a solved scene: `regime_of` with the moments and strains that were found.

    strain is the largest Green-Lagrange component on the outline, shears doubled.
    """
    import numpy as np

    from ancf.section_stress import part_skin, section_strain

    found = []
    for model in solution.model.rods:
        here = regime_of(model.rod, solution.scene)
        here |= _thin(model.rod, _norm(solution.section_forces(model.rod.name).moment))
        strains = [
            section_strain(model, solution.q, *part_skin(model, part, OUTLINE_POINTS), part)
            for part in range(len(model.rod.parts))
        ]
        here["strain"] = max(float(np.max(np.abs(strain))) for strain in strains)
        here["known"] = True
        found.append(here)
    return found


def regime_of(rod: Rod, scene: Scene) -> dict[str, Any]:
    """What is known of a rod before it is solved.

    Returns
    -------
    element, formulation, law; loads (families); the `SETTINGS`; elements, slenderness L/R, flatness (thinnest
    wall or side by the largest measure, 1 for a disc); poisson_ratio, and the thin-rod numbers of its
    moments; known: whether moments are its only loads.
    """
    moments = [load for load in scene.moments if load.rod == rod.name and _norm(load.value)]
    points = moments + [load for load in scene.forces if load.rod == rod.name and _norm(load.value)]
    loads = loads_of(rod, scene)
    return {
        "element": rod.element,
        "formulation": rod.formulation,
        "law": _kebab(rod.material),
        "loads": loads,
        "section": _profile(rod),
        "reference": "curved" if _norm(rod.curvature) else "straight",
        "axial_rule": str(rod.axial_rule),
        "shear_factors": " ".join(f"{factor:.6g}" for factor in rod.shear_factors),
        "supports": ", ".join(f"{support.kind} at {support.at:g}" for support in rod.supports),
        "moment": " and ".join(sorted({load.definition for load in moments})) or "none",
        "places": " and ".join(sorted({_place(load) for load in points})) or "none",
        "elements": rod.elements,
        "slenderness": rod.length / rod.section.outer_radius,
        "flatness": flatness(rod),
        "poisson_ratio": float(rod.material.poisson_ratio),
        **_thin(rod, sum(_norm(load.value) for load in moments)),
        "known": all(load.split()[-1] in ("bending", "torsion") for load in loads),
    }


def loads_of(rod: Rod, scene: Scene) -> list[str]:
    """Families of the loads on a rod, "follower" in front; loads of zero are none.

    bending, torsion (moments across and along the base's axis), force, axial tension, axial compression (all
    of it along the axis, positive at the end away from it), line load, tendon, pressure, spring, foundation,
    contact, friction (of contact), gravity.
    """
    found = set()
    axis = rod.base.rotation[:, 0]
    for load in scene.moments:
        size, along = _norm(load.value), float(axis @ load.value)
        across = _norm(load.value - along * axis)
        if load.rod == rod.name and size > 0.0:
            kinds = ["torsion"] * (abs(along) > AXIAL * size) + ["bending"] * (across > AXIAL * size)
            found |= {f"{_follower(load)}{kind}" for kind in kinds}
    for load in scene.forces:
        size, along = _norm(load.value), float(axis @ load.value)
        if load.rod == rod.name and size > 0.0:
            axial = _norm(load.value - along * axis) <= AXIAL * size
            kind = ("axial tension" if along > 0.0 else "axial compression") if axial else "force"
            found.add(f"{_follower(load)}{kind}")
    found |= {
        f"{_follower(load)}line load"
        for load in scene.line_loads
        if load.rod == rod.name and _norm(load.value)
    }
    found |= {"tendon" for tendon in scene.tendons if tendon.rod == rod.name and tendon.tension}
    found |= {"pressure" for chamber in scene.pressures if chamber.rod == rod.name and chamber.value}
    found |= {"spring" for spring in scene.springs if spring.rod == rod.name}
    found |= {"contact" for contact in scene.contacts if rod.name in (contact.rod, contact.other)}
    found |= {"friction" for contact in scene.contacts if contact.rod == rod.name and contact.friction}
    found |= {"foundation" for bed in scene.foundations if bed.rod == rod.name}
    return sorted(found | ({"gravity"} if scene.gravity is not None else set()))


def flatness(rod: Rod) -> float:
    """Thinnest wall or side of the section by its largest measure: wall/radius, b/h; 1 for a disc."""
    import numpy as np

    section = rod.section
    inner = getattr(section, "inner_radius", None)
    if inner is not None:
        return float((section.outer_radius - inner) / section.outer_radius)
    low, high = np.linalg.eigvalsh(section.second_moments)
    return float(np.sqrt(low / high))


def _thin(rod: Rod, moment: float) -> dict[str, float]:
    EI = rod.material.young_modulus * rod.section.weaker_second_moment
    turn = moment * rod.length / EI
    kappa_R = moment * rod.section.outer_radius / EI
    return {"kappa_R": kappa_R, "turn": turn, "turn_per_element": turn / rod.elements}


def _norm(vectors: Any) -> float:
    """Largest length among vectors (..., 3)."""
    import numpy as np

    return float(np.max(np.linalg.norm(vectors, axis=-1)))


def _place(load: Any) -> str:
    place = "the end" if load.at == 1.0 else "between the ends"
    offset = getattr(load, "offset", None)
    return place if offset is None or not _norm(offset) else f"{place}, off the axis"


def _profile(rod: Rod) -> str:
    """The section of a plain rod; of any other the segments, which no case has unless it is alike."""
    if not rod.segments:
        return _kebab(rod.section)
    words = [
        "tapered " * part.tapered + f"{_kebab(part.section)} of {_kebab(part.material)}" for part in rod.parts
    ]
    return ", then ".join(words)


def _follower(load: Any) -> str:
    return "follower " if load.direction == "follower" else ""


def _kebab(record: object) -> str:
    """Name of a law or section as a scene file writes it: SaintVenantKirchhoff -> saint-venant-kirchhoff."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", type(record).__name__).lower()
