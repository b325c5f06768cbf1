"""The arm of the inverse problem: one straight rod, clamped, under a moment at its tip.

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
from ancf.rotation import exp
from ancf.scene import Frame, Moment, Rod, Scene

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Arm:
    """A scene whose tip moment is sought; make it by `Arm.of`."""

    scene: Scene

    @classmethod
    def of(cls, scene: Scene) -> Arm:
        """The arm of a scene; other loads may act on it.

        Raises
        ------
        InputError : the scene is not one straight prismatic rod, clamped at its base, whose first moment acts
            at its tip.
        """
        if len(scene.rods) != 1:
            _refuse(f"{len(scene.rods)} rods", "one rod")
        (rod,) = scene.rods
        if rod.segments or np.any(rod.curvature):
            _refuse("a rod of segments, or a curved one", "a straight prismatic rod")
        if len(rod.supports) != 1 or rod.supports[0].at != 0.0 or rod.supports[0].kind == "pin":
            _refuse(f"supports {rod.supports}", "one clamp at 0")
        if not scene.moments or scene.moments[0].at != 1.0:
            _refuse(f"moments {scene.moments}", "a first moment at = 1")
        return cls(scene)

    @cached_property
    def without_closed_form(self) -> str:
        """Why the thin arm under its tip moment is not the limit of this one; empty if it is.

        The closed form is then a guess only, and the arm has not the symmetry of equivariant.py.
        """
        section, kept = self.rod.section, ("rods", "moments", "title", "solver", "stability")
        if not hasattr(section, "radius") or hasattr(section, "inner_radius"):
            return "its section is not a full circle"
        others = sorted(name for name, value in vars(self.scene).items() if name not in kept and value)
        if others:
            return f"other effects act on it ({', '.join(others)})"
        return "several moments act on it" if len(self.scene.moments) > 1 else ""

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
        """Rotation (3, 3) from the frame of the moment to body axes, at the reference."""
        return self.rod.base.rotation.T @ self.scene.load_axes(self.moment)

    def body_poses(self, poses: Floats) -> Floats:
        """Poses (..., 3, 4) of the scene in body axes: position from the base over L, then gradients."""
        poses = np.array(poses, dtype=float)
        poses[..., 0] -= self.rod.base.position
        poses = self.rod.base.rotation.T @ poses
        poses[..., 0] /= self.length
        return poses

    def body_moments(self, moments: Floats) -> Floats:
        """Dimensionless moments v = M L/(E I) (..., 3) in body axes and space, of moments [N m] as given."""
        v = np.asarray(moments) @ self.to_body.T / self.unit
        return self._turned(v, 1.0)

    def moments(self, v: Floats) -> Floats:
        """Moments (..., 3) [N m] as the scene gives them, of dimensionless ones in body axes and space."""
        return self._turned(np.asarray(v), -1.0) @ self.to_body * self.unit

    def _turned(self, v: Floats, sense: float) -> Floats:
        """Of a follower, from its value at the reference to space: M = Exp(nu tau e) M_ref, and back."""
        if self.moment.direction == "fixed":
            return v
        return (exp(sense * self.twist_ratio * v[..., :1] * np.eye(3)[0]) @ v[..., None])[..., 0]

    def largest_bending(self, bounds: Floats) -> float:
        """Largest dimensionless bending moment about one axis in the box (3, 2) [N m]."""
        return float(np.abs(bounds.T @ self.to_body.T)[:, 1:].max() / self.unit)

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
            "the search starts from a straight clamped arm under a tip moment",
            "take such a scene, or search with Solution.sensitivity",
        )
    )
