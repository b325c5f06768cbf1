r"""Dimensionless numbers of a rod in its scene, with the loads that it carries.

    gravity            rho g A L^3/(E I), the weight in units of E I/L^2; g of the scene, or standard gravity
    slenderness        L/R, R the largest distance of the section from the axis
    shear, extension   E I/(G A L^2), E I/(E A L^2): share of shear and stretch in the deflection
    force, moment      P L^2/(E I), M L/(E I) of the largest point or line load
    section_force, section_moment   the same of what the sections carry at the equilibrium
    section_strain     largest component of the Green-Lagrange strain there
    contact_distance   smallest gap to what the rod may touch there, over L; only where it may touch something

E I is the bending stiffness about the weaker axis. A rod that changes along its length has its mean
compliance for E I, its softest section for G A and E A, its widest for R.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancf.validity import largest_strain

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.scene import Rod
    from ancf.solution import Solution

STANDARD_GRAVITY = 9.80665  # m/s2


def rod_numbers(solution: Solution, rod: RodModel, solved: bool) -> dict[str, float | None]:
    """Numbers of one rod by name; None where a density or an equilibrium is missing."""
    scene, spec = solution.scene, rod.rod
    L, EI = spec.length, rod.bending_stiffness
    sections = [
        (section, part.material) for part in spec.parts for section in (part.section, part.last_section)
    ]
    soft_shear = min(s.area * m.young_modulus / (2.0 * (1.0 + m.poisson_ratio)) for s, m in sections)
    soft_axis = min(s.area * m.young_modulus for s, m in sections)
    g = STANDARD_GRAVITY if scene.gravity is None else float(np.linalg.norm(scene.gravity.acceleration))
    forces = [load.value for load in scene.forces if load.rod == spec.name]
    forces += [L * load.value for load in scene.line_loads if load.rod == spec.name]
    moments = [load.value for load in scene.moments if load.rod == spec.name]
    moments += [L * load.value for load in scene.line_moments if load.rod == spec.name]
    found: dict[str, float | None] = {
        "gravity": weight_number(rod, spec, g),
        "slenderness": L / max(section.outer_radius for section, _ in sections),
        "shear": EI / (min(spec.shear_factors) * soft_shear * L**2),
        "extension": EI / (soft_axis * L**2),
        "force": _largest(forces) * L**2 / EI,
        "moment": _largest(moments) * L / EI,
        "section_force": None,
        "section_moment": None,
        "section_strain": None,
    }
    if solved:
        carried = solution.section_forces(spec.name)
        found["section_force"] = _largest(carried.force) * L**2 / EI
        found["section_moment"] = _largest(carried.moment) * L / EI
        found["section_strain"] = largest_strain(solution, rod)
        if scene.contacts:
            from ancf.passive_reports import passive_reports

            entries = passive_reports(solution.model, solution.q)["contacts"]
            gaps = [entry["gap"] for entry in entries if entry["rod"] == spec.name]
            if gaps:
                found["contact_distance"] = min(gaps) / L
    # A load near the end of the number range overflows here.
    return {
        name: value if value is not None and np.isfinite(value) else None for name, value in found.items()
    }


def weight_number(rod: RodModel, spec: Rod, g: float = STANDARD_GRAVITY) -> float | None:
    """Weight of a rod, or of another `spec` of its shape, in units of E I/L^2; None without a density."""
    mass = _mass(spec)
    return None if mass is None else mass * g * rod.rod.length**2 / rod.bending_stiffness


def _largest(vectors: np.ndarray | list[np.ndarray]) -> float:
    return max((float(np.linalg.norm(vector)) for vector in vectors), default=0.0)


def _mass(rod: Rod) -> float | None:
    """Mass [kg] of a rod, None without a density; the area of a taper is quadratic along it (Simpson)."""
    total = 0.0
    for part in rod.parts:
        if part.material.density is None:
            return None
        areas = [part.section_at(at).area for at in (0.0, 0.5, 1.0)]
        total += part.material.density * part.length * float(np.dot(areas, [1.0, 4.0, 1.0])) / 6.0
    return total
