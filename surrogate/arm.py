"""The arm of the inverse problem: one straight round rod, clamped, under a moment at its tip.

Symbols
-------
L, R       length and radius [m]
unit       E I/L [N m]: a moment of one unit bends the thin rod by one radian
BCS        body axes of the rod (x along it), in which poses and moments are compared with the closed form
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.errors import InputError, Message
from ancf.scene import Frame, Moment, Rod, Scene

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arm:
    """A scene whose inverse has a closed form in the thin limit; make it by `Arm.of`."""

    scene: Scene

    @classmethod
    def of(cls, scene: Scene) -> Arm:
        """The arm of a scene.

        Raises
        ------
        InputError : the scene is more than one straight prismatic round rod, clamped at its base, under one
            moment at its tip that is fixed in space.
        """
        if len(scene.rods) != 1:
            _refuse(f"{len(scene.rods)} rods", "one rod")
        (rod,) = scene.rods
        if rod.segments or np.any(rod.curvature):
            _refuse("a rod of segments, or a curved one", "a straight prismatic rod")
        if not hasattr(rod.section, "radius") or hasattr(rod.section, "inner_radius"):
            _refuse(f"section {rod.section}", "a full circle")
        if len(rod.supports) != 1 or rod.supports[0].at != 0.0 or rod.supports[0].kind == "pin":
            _refuse(f"supports {rod.supports}", "one clamp at 0")
        others = sorted(
            name
            for name, value in vars(scene).items()
            if name not in ("rods", "moments", "title", "solver", "stability") and value
        )
        if others:
            _refuse(f"tables {', '.join(others)}", "no effect but the moment")
        if len(scene.moments) != 1 or scene.moments[0].at != 1.0 or scene.moments[0].direction != "fixed":
            _refuse(f"moments {scene.moments}", "one moment, at = 1, fixed in space")
        return cls(scene)

    @property
    def rod(self) -> Rod:
        """The rod."""
        return self.scene.rods[0]

    @property
    def moment(self) -> Moment:
        """The moment at the tip, of any value."""
        return self.scene.moments[0]

    @property
    def length(self) -> float:
        """L [m]."""
        return self.rod.length

    @cached_property
    def unit(self) -> float:
        """E I/L [N m]."""
        return self.rod.material.young_modulus * self.rod.section.weaker_second_moment / self.length

    @cached_property
    def twist_ratio(self) -> float:
        """nu of the closed form: E I/(G J) - 1, Poisson's ratio of a round section."""
        return self.rod.material.young_modulus / (2.0 * self.rod.material.lame_mu) - 1.0

    @cached_property
    def to_body(self) -> Floats:
        """Rotation (3, 3) from the frame of the moment to body axes."""
        return self.rod.base.rotation.T @ self.scene.load_axes(self.moment)

    def body_poses(self, poses: Floats) -> Floats:
        """Poses (..., 3, 4) of the scene in body axes: position from the base over L, then gradients."""
        poses = np.array(poses, dtype=float)
        poses[..., 0] -= self.rod.base.position
        poses = self.rod.base.rotation.T @ poses
        poses[..., 0] /= self.length
        return poses

    def body_moments(self, moments: Floats) -> Floats:
        """Dimensionless moments v = M L/(E I) (..., 3) in body axes of moments [N m] in their frame."""
        return np.asarray(moments) @ self.to_body.T / self.unit

    def moments(self, v: Floats) -> Floats:
        """Moments (..., 3) [N m] in their frame of dimensionless ones in body axes."""
        return np.asarray(v) @ self.to_body * self.unit

    def solve(self, moments: Floats) -> ancf.BatchSolution:
        """Equilibria under moments (B, 3) [N m] in their frame."""
        return ancf.solve_batch(self.scene, moments)


def paper_arm(
    *,
    length: float = 0.4,
    radius: float = 0.01,
    young_modulus: float = 1.0e6,
    poisson_ratio: float = 0.3,
    elements: int = 12,
    element: str = "3243",
    frame: str = "body",
) -> Arm:
    """The paper's arm (sec. 3.1, eq. 3): 40 cm along Z, 12 elements 3243, a tip moment in body axes.

    Radius, E and Poisson's ratio are unpublished; the formulation is `enhanced`, since the paper's
    `continuum` is known to lock.
    """
    table: dict[str, Any] = {
        "rod": [
            {
                "name": "arm",
                "length": length,
                "elements": elements,
                "element": element,
                "section": {"shape": "circle", "radius": radius},
                "material": {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio},
                "base": {"x_axis": [0, 0, 1], "y_axis": [0, 1, 0]},
            }
        ],
        "moment": [{"value": [0.0, 0.0, 1.0], "frame": frame}],
    }
    return Arm.of(ancf.scene_from_dict(table))


def at_other_base(arm: Arm, base: Frame) -> Arm:
    """The same arm standing elsewhere."""
    return Arm.of(replace(arm.scene, rods=(replace(arm.rod, base=base),)))


def _refuse(value: str, limit: str) -> NoReturn:
    raise InputError(
        Message(
            "The inverse is not known for this scene.",
            "scene",
            f"{value}; must be {limit}",
            "the closed form serves a straight round clamped arm under a tip moment",
            "take such a scene, or search with Solution.sensitivity",
        )
    )
