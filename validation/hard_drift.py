"""Drift: the same rod described otherwise must take the same shape.

A variant is a scene that describes the rod of another one in other units, axes, places, orders or directions,
with the map that takes its answer back. The drift is the largest |difference of a node's position| over L.
Positions are relative to the base, as the solver keeps them: 1e6 m away, float64 itself leaves 1e-10 m in an
absolute position.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.mesh import reference_axis
from ancf.scene_file import scene_from_dict
from ancf.solution import Solution

Floats = NDArray[np.float64]
Scene = dict[str, Any]
Shape = list[Floats]  # positions (n_nodes, 3) of every rod [m], relative to its base

# 1 m = 1e3 mm, 1 kg = 1e3 g, 1 s = 1 s, so by the dimensions of each: Pa = kg/(m s2) keeps its number.
MM_G_S = {"length": 1e3, "force": 1e6, "moment": 1e9, "line_load": 1e3, "density": 1e-6, "acceleration": 1e3}
# A turn of the whole scene about no special axis, by no special angle (rotation vector, rad).
TURN = (0.7, -1.3, 0.9)
FAR = (1e6, -1e6, 1e6)  # m
LOADS = ("moment", "force", "line_load")
STIFFNESSES = ("young_modulus", "c10", "c01", "bulk_modulus")


@dataclass(frozen=True)
class Variant:
    """A scene, and how the shape of its rods becomes that of the original's."""

    scene: Scene
    restore: Callable[[Shape], Shape]


def shape_of(solution: Solution) -> Shape:
    """Positions of the nodes of every rod, relative to its base [m]."""
    return [rod.nodal(solution.q)[:, 0] for rod in solution.model.rods]


def copied(scene: Any) -> Any:
    """A copy in which nothing is shared, not even what the scene itself shares between two rods."""
    if isinstance(scene, dict):
        return {key: copied(value) for key, value in scene.items()}
    return [copied(value) for value in scene] if isinstance(scene, list) else scene


def drift(original: Shape, other: Shape, lengths: list[float]) -> float:
    """Largest distance between the same nodes, over the length of their rod; NaN where they do not match."""
    worst = 0.0
    for a, b, length in zip(original, other, lengths, strict=True):
        if a.shape != b.shape or not np.isfinite(b).all():
            return math.nan
        worst = max(worst, float(np.linalg.norm(a - b, axis=-1).max()) / length)
    return worst


def in_millimetres(scene: Scene) -> Variant:
    """Lengths in mm, masses in g: every number of the scene in units of mm, g and s."""
    changed = copied(scene)
    for rod in changed["rod"]:
        for piece in _pieces(rod):
            piece["length"] *= MM_G_S["length"]
            for section in (piece[key] for key in ("section", "section_end") if key in piece):
                for key, value in section.items():
                    if key != "shape":
                        section[key] = (np.asarray(value, float) * MM_G_S["length"]).tolist()
            if "density" in piece["material"]:
                piece["material"]["density"] *= MM_G_S["density"]
        if "position" in rod.get("base", {}):
            rod["base"]["position"] = [x * MM_G_S["length"] for x in rod["base"]["position"]]
        if "curvature" in rod:
            rod["curvature"] = [k / MM_G_S["length"] for k in rod["curvature"]]
    for table in LOADS:
        for load in changed.get(table, []):
            load["value"] = [v * MM_G_S[table] for v in load["value"]]
            if "offset" in load:
                load["offset"] = [v * MM_G_S["length"] for v in load["offset"]]
    for load in changed.get("pressure", []):
        chamber = load["chamber"]
        chamber["radius"] *= MM_G_S["length"]
        chamber["centre"] = [v * MM_G_S["length"] for v in chamber.get("centre", (0.0, 0.0))]
    for joint in changed.get("joint", []):
        if "displacement" in joint:
            joint["displacement"] = [v * MM_G_S["length"] for v in joint["displacement"]]
    _accelerate(changed, lambda g: g * MM_G_S["acceleration"])
    return Variant(changed, lambda shape: [r / MM_G_S["length"] for r in shape])


def turned(scene: Scene) -> Variant:
    """The whole scene turned: bases, loads and gravity."""
    R = _rotation(np.array(TURN))
    changed = copied(scene)
    for rod, record in zip(changed["rod"], scene_from_dict(scene).rods, strict=True):
        axes = R @ record.base.rotation
        position = (R @ record.base.position).tolist()
        rod["base"] = {"position": position, "x_axis": axes[:, 0].tolist(), "y_axis": axes[:, 1].tolist()}
    for load in _loads(changed):
        load["value"] = (R @ np.asarray(load["value"], float)).tolist()
    for joint in changed.get("joint", []):
        for key in ("axis", "displacement", "rotation"):
            if key in joint:
                joint[key] = (R @ np.asarray(joint[key], float)).tolist()
    _accelerate(changed, lambda g: R @ g)
    return Variant(changed, lambda shape: [r @ R for r in shape])


def moved(scene: Scene) -> Variant:
    """The whole scene 1e6 m away."""
    changed = copied(scene)
    for rod, record in zip(changed["rod"], scene_from_dict(scene).rods, strict=True):
        rod["base"] = {**rod.get("base", {}), "position": (record.base.position + np.array(FAR)).tolist()}
    return Variant(changed, lambda shape: shape)


def reversed_rods(scene: Scene) -> Variant:
    """Every rod described from its other end: x' = L - x, axes turned by 180 degrees about the y axis there.

    Supports and loads at 1 - at; offsets (y, -z); with D = diag(-1, 1, -1) the frame is A(L - x') D and the
    stress-free curvature -D k = (k_x, -k_y, k_z).
    """
    changed = copied(scene)
    shifts = []
    for rod, record in zip(changed["rod"], scene_from_dict(scene).rods, strict=True):
        position, frame = reference_axis(np.array([record.length]), record.curvature)
        shift = record.base.rotation @ position[0]
        axes = record.base.rotation @ frame[0]
        shifts.append(shift)
        place = (record.base.position + shift).tolist()
        rod["base"] = {"position": place, "x_axis": (-axes[:, 0]).tolist(), "y_axis": axes[:, 1].tolist()}
        if record.supports:
            rod["supports"] = [{"at": 1.0 - s.at, "kind": s.kind} for s in record.supports]
        rod["curvature"] = (record.curvature * np.array([1.0, -1.0, 1.0])).tolist()
        if "segments" in rod:
            rod["segments"] = rod["segments"][::-1]
            for piece in (piece for piece in rod["segments"] if "section_end" in piece):
                piece["section"], piece["section_end"] = piece["section_end"], piece["section"]
    for load in _loads(changed):
        if "value" in load and load in changed.get("line_load", []):
            continue
        load["at"] = 1.0 - load.get("at", 1.0)
        if "offset" in load:
            load["offset"] = [load["offset"][0], -load["offset"][1]]
    for load in changed.get("pressure", []):
        load["from"], load["to"] = 1.0 - load.get("to", 1.0), 1.0 - load.get("from", 0.0)
        y, z = load["chamber"].get("centre", (0.0, 0.0))
        load["chamber"]["centre"] = [y, -z]
    for joint in changed.get("joint", []):
        for side in (joint[key] for key in ("a", "b") if isinstance(joint[key], dict)):
            side["at"] = 1.0 - side["at"]
    return Variant(changed, lambda shape: [r[::-1] + s for r, s in zip(shape, shifts, strict=True)])


def renumbered(scene: Scene) -> Variant:
    """Rods, load tables and supports in the opposite order, behind a rod that has nothing to do with them.

    The stranger is a copy of the first rod without point loads; it shifts every unknown of the others.
    """
    changed = copied(scene)
    names = [rod.name for rod in scene_from_dict(scene).rods]
    for rod, name in zip(changed["rod"], names, strict=True):
        rod["name"] = name
        if "supports" in rod:
            rod["supports"] = rod["supports"][::-1]
    for load in (*_loads(changed), *changed.get("pressure", [])):
        load.setdefault("rod", names[0])
    for table in (*LOADS, "pressure"):
        if table in changed:
            changed[table] = changed[table][::-1]
    stranger = {**copied(changed["rod"][0]), "name": "stranger"}
    changed["rod"] = [stranger, *changed["rod"][::-1]]
    return Variant(changed, lambda shape: shape[:0:-1])


def one_ulp(scene: Scene) -> Iterator[tuple[str, Variant]]:
    """Scenes in which one input is the next float64: length, section, stiffness, loads; by its name."""

    def kept(shape: Shape) -> Shape:
        return shape

    def after(value: float) -> float:
        return float(np.nextafter(value, math.copysign(math.inf, value))) if value else value

    def variant(change: Callable[[Scene], None]) -> Variant:
        changed = copied(scene)
        change(changed)
        return Variant(changed, kept)

    def longer(scene: Scene) -> None:
        piece = _pieces(scene["rod"][0])[0]
        piece["length"] = after(piece["length"])

    def thicker(scene: Scene) -> None:
        section = _pieces(scene["rod"][0])[0]["section"]
        section.update({key: after(v) for key, v in section.items() if isinstance(v, int | float)})

    def stiffer(scene: Scene) -> None:
        material = _pieces(scene["rod"][0])[0]["material"]
        material.update({key: after(material[key]) for key in STIFFNESSES if key in material})

    def heavier(scene: Scene) -> None:
        for load in _loads(scene):
            load["value"] = [after(v) for v in load["value"]]
        _accelerate(scene, lambda g: np.array([after(v) for v in g]))

    yield "length", variant(longer)
    yield "section", variant(thicker)
    yield "stiffness", variant(stiffer)
    if any(any(load["value"]) for load in _loads(scene)) or "gravity" in scene:
        yield "loads", variant(heavier)


def _pieces(rod: Scene) -> list[Scene]:
    """The tables with length, section and material of a rod: its segments, or itself."""
    return rod.get("segments", [rod])


def _loads(scene: Scene) -> list[Scene]:
    """All load tables that have a value; `frame` must be the structure's, whose axes the variants change."""
    found = [load for table in LOADS for load in scene.get(table, [])]
    for load in found:
        if load.get("frame", "structure") != "structure":
            raise ValueError("a variant turns loads given in the axes of the structure only")
    return found


def _accelerate(scene: Scene, change: Callable[[Floats], Floats]) -> None:
    if "gravity" in scene:
        scene["gravity"]["acceleration"] = change(
            np.asarray(scene["gravity"]["acceleration"], float)
        ).tolist()


def _rotation(v: Floats) -> Floats:
    """Rodrigues: exp(hat v), written here so that the turn is not the solver's own."""
    angle = float(np.linalg.norm(v))
    x, y, z = v / angle
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
