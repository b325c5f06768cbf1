"""The regime of a scene: what defines it, and how hard it is, as plain words and numbers for each rod.

Thin-rod numbers, with M and N the largest moment and force in a section, EI of the weaker axis, h the length
of an element and R the outer radius: kappa_R = M R/EI, turn = M L/EI [rad], turn_per_element = M h/EI,
turn_by_aspect = M h^2/(EI R), which is what elements lock by, and thrust = N L^2/EI. A scene under moments
alone has them before it is solved.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from validation.load_numbers import families_of

if TYPE_CHECKING:
    from ancf.scene import Rod, Scene
    from ancf.solution import Solution

OUTLINE_POINTS = 16
# What a scene is made of: words, each of which must have been tried.
SETTINGS: tuple[str, ...] = (
    "section",
    "reference",
    "axial_rule",
    "shear_factors",
    "supports",
)
# How hard it is: harder when larger. The numbers of its loads (load_numbers.py) follow.
HARDNESS: tuple[str, ...] = (
    "poisson_ratio",
    "kappa_R",
    "turn",
    "turn_per_element",
    "turn_by_aspect",
    "reference_turn",
    "tolerance",
    "thrust",
    "strain",
)
# Problems whose cases measure the accuracy of a solved scene; the others show identities, a linear stiffness
# or iterations, and vouch for no scene.
ACCURATE = frozenset(
    {
        "actuated", "actuated rod", "cross-check", "elastica", "gap rate", "helix", "published deflection",
        "pure bending", "rod", "rubber stretch", "section stress", "uniaxial",
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
        forces = solution.section_forces(model.rod.name)
        here |= _thin(model.rod, _norm(forces.moment))
        EI = model.rod.material.young_modulus * model.rod.section.weaker_second_moment
        here["thrust"] = _norm(forces.force) * model.rod.length**2 / EI
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
    wall or side by the largest measure, 1 for a disc); poisson_ratio, the turn of the unstressed rod, the
    solver's tolerance, and the thin-rod numbers of its moments; numbers: those of its loads, by
    "family: name"; known: whether moments are its only loads.
    """
    moments = [load for load in scene.moments if load.rod == rod.name]
    families = families_of(rod, scene)
    return {
        "element": rod.element,
        "formulation": rod.formulation,
        "law": _kebab(rod.material),
        "loads": sorted(families),
        "section": _profile(rod),
        "reference": "curved" if _norm(rod.curvature) else "straight",
        "axial_rule": str(rod.axial_rule),
        "shear_factors": " ".join(f"{factor:.6g}" for factor in rod.shear_factors),
        "supports": ", ".join(f"{support.kind} at {support.at:g}" for support in rod.supports),
        "elements": rod.elements,
        "slenderness": rod.length / rod.section.outer_radius,
        "flatness": flatness(rod),
        "poisson_ratio": float(rod.material.poisson_ratio),
        "reference_turn": _norm(rod.curvature) * rod.length,
        "tolerance": scene.solver.tolerance,
        "thrust": 0.0,
        **_thin(rod, sum(_norm(load.value) for load in moments)),
        "numbers": {
            f"{family}: {name}": float(value)
            for family, numbers in families.items()
            for name, value in numbers.items()
        },
        "known": all(load.split(",")[0].split()[-1] in ("bending", "torsion") for load in families),
    }


def loads_of(rod: Rod, scene: Scene) -> list[str]:
    """Names of the families of the loads on a rod (load_numbers.py), sorted."""
    return sorted(families_of(rod, scene))


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
    each = turn / rod.elements
    aspect = rod.length / rod.elements / rod.section.outer_radius
    return {"kappa_R": kappa_R, "turn": turn, "turn_per_element": each, "turn_by_aspect": each * aspect}


def _norm(vectors: Any) -> float:
    """Largest length among vectors (..., 3)."""
    import numpy as np

    return float(np.max(np.linalg.norm(vectors, axis=-1)))


def _profile(rod: Rod) -> str:
    """The section of a plain rod; of any other the segments, which no case has unless it is alike."""
    if not rod.segments:
        return _kebab(rod.section)
    words = [
        "tapered " * part.tapered + f"{_kebab(part.section)} of {_kebab(part.material)}" for part in rod.parts
    ]
    return ", then ".join(words)


def _kebab(record: object) -> str:
    """Name of a law or section as a scene file writes it: SaintVenantKirchhoff -> saint-venant-kirchhoff."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", type(record).__name__).lower()
