"""The domain of validity: what the cases that passed have really tried, and whether a scene lies inside it.

kappa_R is the dimensionless curvature of the thin rod, the largest section moment over E I/R (E I of the
weaker axis, R the outer radius). A scene under moments alone has that number before it is solved.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ancf.scene import Rod, Scene
    from ancf.solution import Solution

# A moment found at an integration point may be this much below the load that caused it.
ROUNDING = 1.01
AXIAL = 1e-9  # share of a moment along (across) the rod from which it counts as torsion (bending)
OUTLINE_POINTS = 16
KEY = ("element", "formulation", "law", "load")
MEASURED = ("kappa_R", "strain")


def regimes(solution: Solution) -> list[dict[str, Any]]:
    """Where a solved scene lies, one record for each rod.

    Returns
    -------
    element, formulation, law, section (shape), loads (families), elements, slenderness L/R, poisson_ratio,
    kappa_R and strain (largest Green-Lagrange component on the outline, shears doubled), both dimensionless.
    """
    import numpy as np

    from ancf.section_stress import section_strain

    found = []
    for model in solution.model.rods:
        here = regime_of(model.rod, solution.scene)
        here["kappa_R"] = _curvature(model.rod, _norm(solution.section_forces(model.rod.name).moment))
        y, z = model.rod.section.outline(OUTLINE_POINTS).T
        here["strain"] = float(np.max(np.abs(section_strain(model, solution.q, y, z))))
        found.append(here)
    return found


def regime_of(rod: Rod, scene: Scene) -> dict[str, Any]:
    """What is known of a rod before it is solved; kappa_R only where moments are its only loads."""
    here: dict[str, Any] = {
        "element": rod.element,
        "formulation": rod.formulation,
        "law": _kebab(rod.material),
        "section": _kebab(rod.section),
        "loads": loads_of(rod, scene),
        "elements": rod.elements,
        "slenderness": rod.length / rod.section.outer_radius,
        "poisson_ratio": float(rod.material.poisson_ratio),
    }
    moments = [load.value for load in scene.moments if load.rod == rod.name]
    spread = [*scene.line_loads, *scene.forces]
    if moments and scene.gravity is None and not any(load.rod == rod.name for load in spread):
        here["kappa_R"] = _curvature(rod, sum(_norm(value) for value in moments))
    return here


def loads_of(rod: Rod, scene: Scene) -> list[str]:
    """Families of the loads on a rod: bending, torsion, force, line load, gravity; "follower" in front."""
    found = set()
    axis = rod.base.rotation[:, 0]
    for load in scene.moments:
        size, along = _norm(load.value), float(axis @ load.value)
        across = _norm(load.value - along * axis)
        if load.rod == rod.name and size > 0.0:
            kinds = ["torsion"] * (abs(along) > AXIAL * size) + ["bending"] * (across > AXIAL * size)
            found |= {f"{_follower(load)}{kind}" for kind in kinds}
    found |= {f"{_follower(load)}force" for load in scene.forces if load.rod == rod.name}
    found |= {f"{_follower(load)}line load" for load in scene.line_loads if load.rod == rod.name}
    return sorted(found | ({"gravity"} if scene.gravity is not None else set()))


def domain_of(certified: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Ranges over the regimes of the cases that passed, for each element, formulation, law and load family.

    Returns
    -------
    Records with the four names; sections tried; [smallest, largest] elements, slenderness and poisson_ratio;
    largest kappa_R and strain; `front`: pairs [poisson_ratio, kappa_R], the largest kappa_R tried at that
    Poisson ratio or a higher one. A box alone would claim the largest curvature at the hardest material.
    """
    groups: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for regime in certified:
        for load in regime["loads"]:
            names = {**regime, "load": load}
            groups.setdefault(tuple(names[key] for key in KEY), []).append(regime)
    found = []
    for names, group in sorted(groups.items()):
        entry: dict[str, Any] = dict(zip(KEY, names, strict=True))
        entry["sections"] = sorted({regime["section"] for regime in group})
        for key in ("elements", "slenderness", "poisson_ratio"):
            values = [regime[key] for regime in group]
            entry[key] = [_short(min(values)), _short(max(values))]
        entry |= {key: _short(max(regime[key] for regime in group)) for key in MEASURED}
        entry["front"] = _front(group)
        found.append(entry)
    return found


def outside(domain: Iterable[Mapping[str, Any]], scene: Scene, solution: Solution | None = None) -> list[str]:
    """Why a scene is not inside the domain, one sentence each; empty when it is.

    Before a solution exists, kappa_R is judged for rods under moments alone, and strain is not.
    """
    entries = {tuple(entry[key] for key in KEY): entry for entry in domain}
    known = regimes(solution) if solution is not None else [regime_of(rod, scene) for rod in scene.rods]
    reasons = []
    for rod, here in zip(scene.rods, known, strict=True):
        for load in here["loads"]:
            names = tuple({**here, "load": load}[key] for key in KEY)
            entry = entries.get(names)
            if entry is None:
                reasons.append(f"rod {rod.name!r}: no case that passed has {', '.join(names)}")
            else:
                reasons += [f"rod {rod.name!r}, {load}: {text}" for text in _beyond(entry, here)]
    return reasons


def _beyond(entry: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """What of a regime lies outside one entry of the domain."""
    found = []
    if here["section"] not in entry["sections"]:
        found.append(f"section {here['section']} is not among {', '.join(entry['sections'])}")
    low, high = entry["slenderness"]
    if not low / ROUNDING <= here["slenderness"] <= high * ROUNDING:
        found.append(f"L/R = {here['slenderness']:.4g} is outside {low:.4g} to {high:.4g}")
    nu = here["poisson_ratio"]
    low, high = entry["poisson_ratio"]
    if not low - 1e-9 <= nu <= high + 1e-9:
        found.append(f"poisson_ratio {nu:g} is outside {low:g} to {high:g}")
    elif "kappa_R" in here:
        most = max(kappa_R for other, kappa_R in entry["front"] if other >= nu - 1e-9)
        if here["kappa_R"] > most * ROUNDING:
            found.append(
                f"kappa R = {here['kappa_R']:.3g} is above {most:.3g}, the most tried at nu >= {nu:g}"
            )
    if "strain" in here and here["strain"] > entry["strain"] * ROUNDING:
        found.append(f"largest strain {here['strain']:.3g} is above {entry['strain']:.3g}")
    if here["elements"] < entry["elements"][0]:
        found.append(f"{here['elements']} elements are fewer than {entry['elements'][0]}")
    return found


def _front(group: Iterable[Mapping[str, Any]]) -> list[list[float]]:
    """Pairs [poisson_ratio, kappa_R] that no other pair exceeds in both, by rising Poisson ratio."""
    front: list[list[float]] = []
    for nu, kappa_R in sorted(((r["poisson_ratio"], r["kappa_R"]) for r in group), reverse=True):
        if not front or _short(kappa_R) > front[-1][1]:
            front.append([nu, _short(kappa_R)])
    return front[::-1]


def _short(value: float) -> float:
    """Six digits: what two machines agree in."""
    return value if isinstance(value, int) else float(f"{value:.6g}")


def _curvature(rod: Rod, moment: float) -> float:
    import numpy as np

    EI = rod.material.young_modulus * float(np.linalg.eigvalsh(rod.section.second_moments)[0])
    return moment * rod.section.outer_radius / EI


def _norm(vectors: Any) -> float:
    """Largest length among vectors (..., 3)."""
    import numpy as np

    return float(np.max(np.linalg.norm(vectors, axis=-1)))


def _follower(load: Any) -> str:
    return "follower " if load.direction == "follower" else ""


def _kebab(record: object) -> str:
    """Name of a law or section as a scene file writes it: SaintVenantKirchhoff -> saint-venant-kirchhoff."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", type(record).__name__).lower()
