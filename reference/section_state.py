"""State of a bar in uniform bending, twist and extension, and where it puts the far end of a rod.

All results are in the frame of the base section, whose polar rotation is the identity at s = 0, with units.
Symbols: `k` screw (3,) [1/m], `a` velocity of the mean point (3,) [-], `spin` [1/m] (`section_form`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from reference.rotation import exp, exp_integral
from reference.section_form import SectionForm, StressField
from reference.section_newton import SectionLoad, SectionPoint, SectionStatus

Array = NDArray[np.float64]

CENTRE_TOLERANCE = 1e-6  # of the size: a node nearer to the mean point is the material centre


@dataclass(frozen=True, eq=False)
class SectionPose:
    """Far section: material centre and mean point (3,) [m], polar rotation (3, 3)."""

    centre: Array
    mean: Array
    rotation: Array


@dataclass(frozen=True, eq=False)
class SectionState:
    """Solution of a section problem.

    `status` says whether the full load was reached; if not, all numbers are those of the last load step that
    converged and `fraction` of the load was reached. `turn` (3, 3) turns the bending axis of the problem
    solved, z, to that asked for (circles). `load` and `point` are without unit.
    """

    form: SectionForm
    load: SectionLoad
    point: SectionPoint
    status: SectionStatus
    message: str
    turn: Array

    @property
    def fraction(self) -> float:
        """Part of the load that was reached, 0 to 1."""
        return self.point.fraction

    @property
    def iterations(self) -> int:
        """Newton iterations, all load steps together."""
        return self.point.iterations

    @property
    def residual(self) -> float:
        """Largest unbalanced force by E size^2 [-]."""
        return self.point.residual

    @property
    def mixed(self) -> bool:
        """Whether the energy of the volume is projected."""
        return self.form.mixed

    @property
    def screw(self) -> Array:
        """Rotation of the sections per reference length, k (3,) [1/m]."""
        return self.turn @ self.point.e[3:6] / self.form.size

    @property
    def curvature(self) -> float:
        """Bending part of k, |k - (k . e_x) e_x| [1/m], with the sign of k_z unless the bar was turned."""
        k = self.point.e[3:6] / self.form.size
        return float(np.copysign(np.hypot(k[1], k[2]), k[2]))

    @property
    def spin(self) -> float:
        """Turn of the material about its own axis in the screw's frame [1/m]; circles only, else 0."""
        return float(self.point.e[6] / self.form.size)

    @property
    def twist(self) -> float:
        """Turn of the material about the normal of its section, k_x + spin [1/m]."""
        return float(self.screw[0]) + self.spin

    @property
    def velocity(self) -> Array:
        """Derivative of the mean point by the reference length, a (3,) [-]."""
        return self.turn @ self.point.e[:3]

    @property
    def couple(self) -> Array:
        """Couple int u x P_1 dA about the mean point (3,) [N m]."""
        form = self.form
        return self.turn @ self.point.forces.gradient[-4:-1] * form.stress_unit * form.size**3

    @property
    def force(self) -> Array:
        """Force int P_1 dA (3,) [N], zero but in extension."""
        form = self.form
        return self.turn @ self.point.forces.gradient[-7:-4] * form.stress_unit * form.size**2

    @property
    def energy(self) -> float:
        """Strain energy per reference length [J/m]."""
        return self.point.forces.energy * self.form.stress_unit * self.form.size**2

    @cached_property
    def nodes(self) -> Array:
        """Reference positions (ns, 2) [m] of the fields' nodes, from the mean point, turned by `turn`."""
        mass, nodes = self.form.section.mass, self.form.section.nodes
        return (nodes - mass.sum(axis=0) @ nodes / mass.sum()) @ self.turn[1:, 1:].T

    @cached_property
    def positions(self) -> Array:
        """Positions u (ns, 3) [m] of the nodes from the mean point, in the section's frame."""
        return self.form.nodal_values(self.point.u) @ self.turn.T * self.form.size

    @property
    def in_plane(self) -> Array:
        """In-plane displacement (ns, 2) [m] of the nodes in the section's frame."""
        return self.positions[:, 1:] - self.nodes

    @property
    def warping(self) -> Array:
        """Displacement out of the plane (ns,) [m]."""
        return self.positions[:, 0]

    @property
    def centre(self) -> Array:
        """Material centre from the mean point (3,) [m]; zero where the section has no material there."""
        node = self.form.section.centre
        if node is None or np.linalg.norm(self.nodes[node]) > CENTRE_TOLERANCE * self.form.size:
            return np.zeros(3)
        return self.positions[node]

    @property
    def axial_stretch(self) -> float:
        """Stretch of the fibre through the material centre, |a + k x u_centre| [-]."""
        return float(np.linalg.norm(self.velocity + np.cross(self.screw, self.centre)))

    @property
    def pitch(self) -> float:
        """Advance along the screw axis per reference length, a . k/|k| [-]; |a| where k = 0."""
        k = float(np.linalg.norm(self.screw))
        return float(self.velocity @ self.screw) / k if k else float(np.linalg.norm(self.velocity))

    @property
    def axis_radius(self) -> float:
        """Distance of the mean point from the screw axis, |k x a|/|k|^2 [m]; infinite where k = 0."""
        k = self.screw
        return float(np.linalg.norm(np.cross(k, self.velocity)) / (k @ k)) if k @ k else inf

    def rotation(self, s: float) -> Array:
        """Polar rotation (3, 3) of the section at s [m], Exp(s k) Exp(s spin e_x)."""
        return exp(s * self.screw) @ exp([s * self.spin, 0.0, 0.0])

    def pose(self, length: float) -> SectionPose:
        """Pose of the far section of a rod clamped at s = 0 with a section free to contract.

        mean(L) = -u_c + L J(L k) a, centre(L) = mean(L) + Exp(L k) u_c, with J the integral of Exp (x L k)
        over x from 0 to 1, the base's rotation the identity and its material centre at the origin.

        Parameters
        ----------
        length : float
            [m], along the undeformed rod, which lies along x.
        """
        mean = -self.centre + length * exp_integral(length * self.screw) @ self.velocity
        centre = mean + exp(length * self.screw) @ self.centre
        return SectionPose(centre, mean, self.rotation(length))

    def stress(self, points: Array | None = None) -> StressField:
        """Stress in the section's frame, at the integration points or at `points` (n, 2) [m].

        Points are places in the undeformed section, from its mean point; a `ValueError` names one outside.
        """
        form, turn = self.form, self.turn[1:, 1:]
        if points is None:
            field = form.stress_field(self.point.u, self.point.e)
        else:
            field = form.stress_at(self.point.u, self.point.e, np.asarray(points, float) @ turn)
        turned = (self.turn @ tensor @ self.turn.T for tensor in (field.F, field.pk1, field.cauchy))
        return StressField(field.points @ turn.T, field.weights, *turned)
