"""Scenes of cases: loads in units of the rod's stiffness, the rod's own numbers, and a scene as TOML text."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.scene import Rod, Scene
from ancf.solution import Solution
from reference.rod import RodLoads, RodProperties

Floats = NDArray[np.float64]

# Power of the length in the unit of a load when it is given as a pure number: moments in E I/L,
# forces in E I/L^2, ...
LOAD_UNITS = {"moment": 1, "force": 2, "line_load": 3}


@dataclass(frozen=True)
class Stiffness:
    """Numbers of a rod: length [m], E I (smaller) and G J of a plane section [N m2], E A [N], "
    "outer radius [m]."""

    length: float
    EI: float
    GJ: float
    EA: float
    radius: float

    @classmethod
    def of(cls, rod: Rod) -> Stiffness:
        """Read them off a rod record."""
        second = rod.section.second_moments
        material = rod.material
        G = material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))
        return cls(
            rod.length,
            float(material.young_modulus * np.linalg.eigvalsh(second)[0]),
            float(G * np.trace(second)),
            material.young_modulus * rod.section.area,
            rod.section.outer_radius,
        )


def changed(scene: Mapping[str, Any], rod: Mapping[str, Any] | None = None, **tables: Any) -> dict[str, Any]:
    """A copy of a scene with changes to its first rod and whole tables replaced."""
    copied = copy.deepcopy(dict(scene))
    copied["rod"][0].update(rod or {})
    copied.update(tables)
    return copied


def stiffness_of(scene: Mapping[str, Any]) -> Stiffness:
    """Numbers of the first rod of a scene dictionary."""
    return Stiffness.of(ancf.scene_from_dict({"rod": scene["rod"]}).rods[0])


def in_si(scene: Mapping[str, Any]) -> dict[str, Any]:
    """The scene with loads given as pure numbers (units E I/L, E I/L^2, E I/L^3) turned into SI."""
    copied = copy.deepcopy(dict(scene))
    rod = stiffness_of(scene)
    for table, power in LOAD_UNITS.items():
        for entry in copied.get(table, []):
            entry["value"] = [float(v) * rod.EI / rod.length**power for v in entry["value"]]
    return copied


def young_modulus(material: Mapping[str, Any]) -> float:
    """Young's modulus [Pa] of a material table at small strain; Mooney-Rivlin: 9 K mu/(3 K + mu)."""
    if "young_modulus" in material:
        return float(material["young_modulus"])
    mu, bulk = 2.0 * (material["c10"] + material["c01"]), material["bulk_modulus"]
    return float(9.0 * bulk * mu / (3.0 * bulk + mu))


def with_poisson_ratio(material: Mapping[str, Any], nu: float) -> dict[str, Any]:
    """The material at another Poisson ratio: of Mooney-Rivlin the bulk modulus follows, mu stays."""
    if "c10" in material:
        mu = 2.0 * (material["c10"] + material["c01"])
        return {**material, "bulk_modulus": 2.0 * mu * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))}
    return {**material, "poisson_ratio": nu}


def solve(scene: Mapping[str, Any]) -> Solution:
    """Solve a scene dictionary; raises `NoEquilibrium` when there is none, so that no case "
    "compares half a result."""
    solution = ancf.solve(ancf.scene_from_dict(scene))
    if solution.status is not ancf.Status.CONVERGED:
        raise NoEquilibrium(f"{solution.status}: {solution.reason}")
    return solution


class NoEquilibrium(RuntimeError):
    """A case's scene did not converge; the case fails with this reason."""


def bending_angle(rotation: Floats, near: float) -> float:
    """Turn about z [rad] of a rotation (3, 3), on the branch closest to `near`."""
    angle = np.arctan2(rotation[1, 0] - rotation[0, 1], rotation[0, 0] + rotation[1, 1])
    return float(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))


def twist_angle(rotation: Floats) -> float:
    """Turn about x [rad] of a rotation (3, 3), in (-pi, pi]."""
    return float(np.arctan2(rotation[2, 1] - rotation[1, 2], rotation[1, 1] + rotation[2, 2]))


def reference_rod(scene: Scene) -> tuple[RodProperties, RodLoads]:
    """The same rod and loads for the independent rod solver; only numbers pass, no code.

    Takes one rod clamped at 0, loads at the tip without offset, line load and gravity.
    """
    rod = scene.rods[0]
    second = rod.section.second_moments
    properties = RodProperties.from_section(
        rod.length,
        rod.material.young_modulus,
        rod.material.poisson_ratio,
        rod.section.area,
        I_y=float(second[1, 1]),
        I_z=float(second[0, 0]),
        shear_factors=rod.shear_factors,
        curvature=rod.curvature,
        base_position=rod.base.position,
        base_rotation=rod.base.rotation,
    )
    force = {"fixed": np.zeros(3), "follower": np.zeros(3)}
    moment = {"fixed": np.zeros(3), "follower": np.zeros(3)}
    for load in scene.forces:
        if load.at != 1.0 or np.any(load.offset):
            raise ValueError("the reference rod takes forces on the axis at the tip only")
        force[load.direction] = force[load.direction] + load.value
    for load in scene.moments:
        if load.at != 1.0:
            raise ValueError("the reference rod takes moments at the tip only")
        moment[load.direction] = moment[load.direction] + load.value
    line = np.sum([load.value for load in scene.line_loads], axis=0) if scene.line_loads else np.zeros(3)
    if scene.gravity is not None:
        line = line + (rod.material.density or 0.0) * rod.section.area * scene.gravity.acceleration
    loads = RodLoads(force["fixed"], moment["fixed"], force["follower"], moment["follower"], line)
    return properties, loads


def as_toml(scene: Mapping[str, Any]) -> str:
    """The scene as the text of a scene file."""
    lines = [f"title = {_value(scene['title'])}", ""] if "title" in scene else []
    for key, content in scene.items():
        if key == "title":
            continue
        tables = content if isinstance(content, list) else [content]
        for table in tables:
            lines.append(f"[[{key}]]" if isinstance(content, list) else f"[{key}]")
            lines += [f"{name} = {_value(value)}" for name, value in table.items()]
            lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, Sequence | np.ndarray):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, int | np.integer):
        return str(int(value))
    return repr(float(value))
