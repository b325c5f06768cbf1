"""Loads of a rod as families with dimensionless numbers, and scenes whose loads are given as such numbers.

A family is a kind of load with all that makes it another case: ``follower force, off the axis``. Its numbers
are the sizes by which a rod feels it, with E I of the weaker axis, the length L and the outer radius R; the
loads of one family are added up. Units: moments E I/L, forces and tensions E I/L^2, loads per length one
power of L more, springs E I/L^3, beds E I/L^4, offsets and chambers R.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ancf.scene import Rod, Scene

Families = dict[str, dict[str, float]]
Add = Callable[[Any, str, Mapping[str, float]], None]

AXIAL = 1e-9  # share of a vector along (across) the rod from which it counts as having that part
END = 1e-12  # of the length
MU_0 = 1.25663706127e-6  # N/A2, CODATA 2022
LARGEST = ("offset/R", "radius/R", "slope", "friction", "shortening")  # of loads; the other numbers add up
KNOWN = frozenset(  # fields of a scene that are told below, or are no effects
    {
        "rods", "moments", "forces", "line_loads", "line_moments", "magnets", "gravity", "tendons",
        "pressures", "springs", "foundations", "contacts", "joints", "added", "solver", "stability", "title",
    }
)  # fmt: skip
SAID = frozenset(  # fields of the records of effects that names and numbers below tell
    {
        "rod", "at", "value", "offset", "direction", "definition", "frame", "remanence", "field",
        "acceleration", "tension", "path", "length", "friction", "centre", "radius", "start", "end",
        "stiffness", "rotational_stiffness", "anchor", "free_length", "axes", "obstacle", "other",
    }
)  # fmt: skip
POWERS = {"moment": 1, "force": 2, "line_moment": 2, "line_load": 3}  # of L in the unit of a `value`


def families_of(rod: Rod, scene: Scene) -> Families:
    """Families of the loads on a rod and their numbers; loads of zero are none.

    Moments are bending (across the base's axis) and torsion (along it); forces all of it along the axis are
    axial tension and axial compression. Forces have three numbers: along the base's axis, against and across.
    """
    found: Families = {}
    EI, L, R = _stiffness(rod), rod.length, rod.section.outer_radius
    axis = rod.base.rotation[:, 0]

    def add(load: Any, name: str, numbers: Mapping[str, float]) -> None:
        family = found.setdefault(name + _more(load), {})
        for key, value in numbers.items():
            family[key] = max(family.get(key, 0.0), value) if key in LARGEST else family.get(key, 0.0) + value

    for load in scene.moments:
        along, across = _parts(axis, load.value)
        if load.rod == rod.name and load.value.any():
            more = ", vorticity" * (load.definition == "vorticity") + _place(load)
            if along:
                add(load, f"{_follower(load)}torsion{more}", {"M L/EI": abs(along) * L / EI})
            if across:
                add(load, f"{_follower(load)}bending{more}", {"M L/EI": across * L / EI})
    for load in scene.forces:
        along, across = _parts(axis, load.value)
        if load.rod == rod.name and load.value.any():
            kind = "force" if across else "axial tension" if along > 0.0 else "axial compression"
            name = f"{_follower(load)}{kind}{_place(load)}"
            add(
                load,
                name,
                _vector("F L2/EI", along, across, L**2 / EI) | {"offset/R": _norm(load.offset) / R},
            )
    for load in scene.line_loads:
        if load.rod == rod.name and load.value.any():
            parts = _parts(axis, load.value)
            add(load, f"{_follower(load)}line load", _vector("w L3/EI", *parts, L**3 / EI))
    for load in scene.line_moments:
        if load.rod == rod.name and load.value.any():
            add(load, f"{_follower(load)}line moment", {"m L2/EI": _norm(load.value) * L**2 / EI})
    if scene.gravity is not None and scene.gravity.acceleration.any():
        weight = (rod.material.density or 0.0) * rod.section.area * scene.gravity.acceleration * L**3 / EI
        if weight.any():
            add(scene.gravity, "gravity", _vector("rho A g L3/EI", *_parts(axis, weight), 1.0))
    _add_actuators(rod, scene, add)
    _add_holders(rod, scene, add)
    for field in fields(scene):  # effects that nobody has given numbers here
        if field.name not in KNOWN and getattr(scene, field.name):
            add(None, field.name, {})
    for effect in scene.added:
        add(None, f"{effect.table} (of another package)", {"number of entries": float(len(effect.records))})
    return found


def _add_actuators(rod: Rod, scene: Scene, add: Add) -> None:
    """Tendons, chambers under pressure and magnets."""
    import numpy as np

    EI, L, R = _stiffness(rod), rod.length, rod.section.outer_radius
    for tendon in scene.tendons:
        if tendon.rod != rod.name or tendon.tension == 0.0:
            continue
        at, places = tendon.path[:, 0], tendon.path[:, 1:]
        slopes = np.linalg.norm(np.diff(places, axis=0), axis=1) / (np.diff(at) * L)
        name = "tendon"
        name += ", of given length" * (tendon.length is not None) + ", with friction" * (
            tendon.friction > 0.0
        )
        name += _part(at[0], at[-1])
        numbers = {"offset/R": _norm(places) / R, "slope": float(slopes.max()), "number of tendons": 1.0}
        if tendon.length is None:
            numbers["T L2/EI"] = float(tendon.tension or 0.0) * L**2 / EI
        else:
            path = float(np.sum(np.diff(at) * L * np.hypot(1.0, slopes)))
            numbers["shortening"] = max(0.0, path - tendon.length) / path
        if tendon.friction > 0.0:
            numbers["friction"] = tendon.friction
        add(tendon, name, numbers)
    for chamber in scene.pressures:
        if chamber.rod == rod.name and chamber.value:
            name = ("pressure" if chamber.value > 0.0 else "suction") + _part(chamber.start, chamber.end)
            thrust = abs(chamber.value) * math.pi * chamber.radius**2 * L**2 / EI
            offset = _norm(chamber.centre) / R
            sizes = {"p A L2/EI": thrust, "offset/R": offset, "radius/R": chamber.radius / R}
            add(chamber, name, sizes | {"number of chambers": 1.0})
    for magnet in scene.magnets:
        couple = _norm(magnet.remanence) * _norm(magnet.field) * rod.section.area / MU_0 * L**2 / EI
        if magnet.rod == rod.name and couple:
            add(magnet, "magnet", {"(B_r A/mu_0) B L2/EI": couple})


def _add_holders(rod: Rod, scene: Scene, add: Add) -> None:
    """Springs, beds and contact."""
    import numpy as np

    EI, L, R = _stiffness(rod), rod.length, rod.section.outer_radius
    for spring in scene.springs:
        if spring.rod == rod.name and spring.stiffness.any():
            k = float(np.linalg.norm(spring.stiffness, 2)) * L**3 / EI
            name = "spring" + " to an anchor" * (spring.anchor is not None) + _place(spring)
            add(spring, name, {"k L3/EI": k, "offset/R": _norm(spring.offset) / R})
        if spring.rod == rod.name and spring.rotational_stiffness.any():
            k = float(np.linalg.norm(spring.rotational_stiffness, 2)) * L / EI
            add(spring, f"rotational spring{_place(spring)}", {"k L/EI": k})
    for bed in scene.foundations:
        if bed.rod == rod.name and bed.stiffness.any():
            name = "foundation" + " in section axes" * (bed.axes is None) + _part(bed.start, bed.end)
            add(bed, name, {"k L4/EI": float(np.max(bed.stiffness)) * L**4 / EI})
        if bed.rod == rod.name and bed.rotational_stiffness.any():
            name = "rotational bed" + " in section axes" * (bed.axes is None) + _part(bed.start, bed.end)
            add(bed, name, {"k L2/EI": float(np.max(bed.rotational_stiffness)) * L**2 / EI})
    for contact in scene.contacts:
        if rod.name in (contact.rod, contact.other):
            rubs = {"friction": contact.friction} if contact.friction else {}
            name = "contact" + ", with friction" * bool(rubs)
            add(contact, name, {"number of contacts": 1.0} | rubs)


def in_units(scene: Mapping[str, Any], share: float = 1.0) -> dict[str, Any]:
    """The scene with its loads, given as the numbers of this module, in SI and times a share.

    gravity is the vector rho A g L^3/EI; of a magnet the remanence is in T and the field gives
    (B_r A/mu_0) B L^2/EI for a remanence of 1 T; of a chamber the value is p A L^2/EI. What holds the rod,
    springs and beds, keeps its stiffness.
    """
    import ancf

    copied = copy.deepcopy(dict(scene))
    rod = ancf.scene_from_dict({"rod": copied["rod"]}).rods[0]
    EI, L, R = _stiffness(rod), rod.length, rod.section.outer_radius
    A = rod.section.area

    def scaled(values: Any, unit: float) -> list[float]:
        return [float(v) * unit for v in values]

    for table, power in POWERS.items():
        for entry in copied.get(table, []):
            entry["value"] = scaled(entry["value"], share * EI / L**power)
            if "offset" in entry:
                entry["offset"] = scaled(entry["offset"], R)
    for entry in copied.get("tendon", []):
        entry["tension"] = share * entry["tension"] * EI / L**2
        entry["path"] = [[at, y * R, z * R] for at, y, z in entry["path"]]
    for entry in copied.get("pressure", []):
        radius = entry["chamber"]["radius"] * R
        entry["chamber"] = {"centre": scaled(entry["chamber"]["centre"], R), "radius": radius}
        entry["value"] = share * entry["value"] * EI / L**2 / (math.pi * radius**2)
    for entry in copied.get("magnet", []):
        entry["field"] = scaled(entry["field"], share * MU_0 * EI / A / L**2)
    for entry in copied.get("spring", []):
        entry["stiffness"] = scaled(entry["stiffness"], EI / L**3)
    for entry in copied.get("foundation", []):
        entry["stiffness"] = scaled(entry["stiffness"], EI / L**4)
    if "gravity" in copied:
        unit = share * EI / L**3 / (A * float(rod.material.density or math.nan))
        copied["gravity"] = {"acceleration": scaled(copied["gravity"]["acceleration"], unit)}
    return copied


def _stiffness(rod: Rod) -> float:
    return float(rod.material.young_modulus * rod.section.weaker_second_moment)


def _parts(axis: Any, value: Any) -> tuple[float, float]:
    """Component along the axis, and size of the rest; what is but rounding of the other is zero."""
    along = float(axis @ value)
    across = _norm(value - along * axis)
    least = AXIAL * math.hypot(along, across)
    return along * (abs(along) > least), across * (across > least)


def _vector(name: str, along: float, across: float, unit: float) -> dict[str, float]:
    """Numbers of a force: what pulls, what pushes, and what bends at first."""
    parts = {"along": max(0.0, along), "against": max(0.0, -along), "across": across}
    return {f"{name} {part} the axis": size * unit for part, size in parts.items()}


def _norm(vectors: Any) -> float:
    """Largest length among vectors (..., k)."""
    import numpy as np  # not at the top: the gate reads certificates without it

    return float(np.max(np.linalg.norm(vectors, axis=-1)))


def _more(record: Any) -> str:
    """What a record says beside `SAID`: whoever gives an effect one more property makes another family."""
    import numpy as np

    said = [field.name for field in fields(record)] if record is not None else []
    return "".join(f", with {name}" for name in said if name not in SAID and np.any(getattr(record, name)))


def _place(load: Any) -> str:
    place = "" if load.at == 1.0 else ", between the ends"
    offset = getattr(load, "offset", None)
    return place if offset is None or not _norm(offset) else f"{place}, off the axis"


def _part(start: float, end: float) -> str:
    return "" if start < END and end > 1.0 - END else ", along a part"


def _follower(load: Any) -> str:
    return "follower " if load.direction == "follower" else ""
