"""The result of a solve: a record with poses, section forces, reactions."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf import cable
from ancf.axis_frames import rotation_at
from ancf.errors import Message
from ancf.mesh import reference_axis
from ancf.quadrature import gauss
from ancf.rotation import section_rotation

if TYPE_CHECKING:
    from os import PathLike

    from scipy import sparse

    from ancf.accuracy_record import Accuracy
    from ancf.arclength import PathPoint
    from ancf.balance import Balance, Reaction
    from ancf.model import Model
    from ancf.newton import Iteration
    from ancf.rod_model import RodModel
    from ancf.scene import Joint, Scene
    from ancf.stability import Stability
    from ancf.tendon_state import TendonState

Floats = NDArray[np.float64]


class Status(enum.StrEnum):
    """How a solve ended; every value but `CONVERGED` comes with a reason and the last equilibrium found."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not_converged"
    LIMIT_POINT = "limit_point"
    INVERTED_ELEMENT = "inverted_element"
    NOT_FINITE = "not_finite"
    MATERIAL_UNSTABLE = "material_unstable"
    OUT_OF_TIME = "out_of_time"


@dataclass(frozen=True, eq=False)
class Pose:
    """A section in SCS: absolute position [m], position gradients, rotation of the section."""

    position: Floats  # (3,)
    r_x: Floats  # (3,)
    r_y: Floats  # (3,)
    r_z: Floats  # (3,)
    rotation: Floats  # (3, 3)


@dataclass(frozen=True, eq=False)
class SectionForces:
    """Section force n [N] and moment m [N m] in SCS at the axial integration points.

    n = dU/dr_x and m = sum_k d_k x dU/dd_k' per reference length: the resultants of the first Piola-Kirchhoff
    stress on the section, the moment about its point on the axis. Of a cable: cable.py.
    """

    x: Floats  # (m,) reference arc length [m]
    at: Floats  # (m,) fraction of the reference length
    force: Floats  # (m, 3)
    moment: Floats  # (m, 3)


@dataclass(frozen=True, eq=False)
class JointForces:
    """Force [N] and moment [N m] that section b of a joint, or the ground, exerts on section a, in SCS."""

    joint: Joint
    force: Floats  # (3,)
    moment: Floats  # (3,)

    def as_dict(self) -> dict[str, Any]:
        """Plain Python; a section is its rod and place, and b may be "ground"."""
        a, b = self.joint.a, self.joint.b
        return {
            "kind": self.joint.kind,
            **({"hold": list(self.joint.hold)} if self.joint.hold else {}),
            "a": {"rod": a.rod, "at": a.at},
            "b": "ground" if b is None else {"rod": b.rod, "at": b.at},
            "force": self.force.tolist(),
            "moment": self.moment.tolist(),
        }


@dataclass(frozen=True, eq=False)
class Solution:
    """An equilibrium, or the last one found on the way, with the account of how it was found."""

    scene: Scene
    model: Model
    q: Floats  # (n,) nodal coordinates, positions relative to each rod's base
    status: Status
    reason: str
    message: Message | None
    load_factor: float
    stable: bool | None  # whether it is a minimum of the potential; None where loads have none
    steps: int
    cutbacks: int
    residual: float
    residual_floor: float
    history: list[Iteration]
    seconds: dict[str, float]
    effects: dict[str, dict[str, float]]
    reductions: list[str] = field(default_factory=list)  # a sentence each (reductions.py)
    path: list[PathPoint] = field(default_factory=list)  # equilibria on the way, where the path was followed
    stability: Stability | None = None  # where the scene asks for it or the path was followed
    accuracy: Accuracy | None = None  # where the scene asks for it

    @cached_property
    def warnings(self) -> list[str]:
        """Known limits of element, formulation and law that this solution meets, one sentence each."""
        from ancf.validity import validity_warnings

        unmet = [] if self.accuracy is None else self.accuracy.warnings
        return unmet + validity_warnings(self)

    @property
    def iterations(self) -> int:
        """Linear solves in all."""
        return len(self.history)

    @property
    def unknowns(self) -> int:
        """Unknowns that the supports leave free."""
        return self.model.unknowns

    def _rod(self, name: str | None) -> RodModel:
        if name is None:
            return self.model.rods[0]
        for rod in self.model.rods:
            if rod.rod.name == name:
                return rod
        raise KeyError(f"the scene has no rod named {name!r}; it has {[r.rod.name for r in self.model.rods]}")

    def pose(self, name: str | None, at: float) -> Pose:
        """Pose of the section at a fraction of the reference length; the first rod if `name` is None.

        Of a cable r_y, r_z and rotation are those of the transported frame; raises `InputError` off the rod.
        """
        rod = self._rod(name)
        rod.rod.check_place(at)
        point = rod.section_point(at)
        e = self.q[point.dofs].reshape(-1, 3)
        d = point.N @ e
        if not rod.element.has_section:
            rotation = rotation_at(rod, rod.nodal(self.q), at)
            _, y_axis, z_axis = (rotation @ rod.rod.base.rotation).T
            return Pose(d[0] + rod.rod.base.position, point.N_x[0] @ e, y_axis, z_axis, rotation)
        y, z = rod.element.y_director, rod.element.z_director
        rotation = section_rotation(d, point.W).R
        return Pose(d[0] + rod.rod.base.position, point.N_x[0] @ e, d[y], d[z], rotation)

    def tip(self, name: str | None = None) -> Pose:
        """Pose of the end x = L."""
        return self.pose(name, 1.0)

    def nodes(self, name: str | None = None) -> Floats:
        """Absolute positions of the nodes (n_nodes, 3) [m]."""
        rod = self._rod(name)
        return rod.nodal(self.q)[:, 0] + rod.rod.base.position

    def displaced(self, name: str | None, at: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
        """Absolute positions (..., 3) [m] of material points (at, y, z), broadcast against each other."""
        rod = self._rod(name)
        return _material_points(rod, rod.nodal(self.q), at, y, z)

    def reference(self, name: str | None, at: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
        """Reference positions (..., 3) [m] of the same material points."""
        rod = self._rod(name)
        return _material_points(rod, rod.q0, at, y, z)

    def strain_energy(self, name: str | None = None) -> float:
        """Strain energy of a rod [J]."""
        rod = self._rod(name)
        return rod.elastic.energy(rod.element_vectors(self.q))

    @cached_property
    def support_force(self) -> Floats:
        """Generalised force (n,) that the supports exert."""
        g = self.model.residual(self.q, self.load_factor).at(self.load_factor)
        return g - self.model.system.project(g)

    def reaction(self, name: str | None = None) -> Reaction:
        """Force (3,) [N] and moment (3,) [N m] about the rod's base by its supports and joints to ground."""
        from ancf.balance import Reaction

        rod = self._rod(name)
        Q = rod.nodal(self.support_force)
        force, moment = Q[:, 0].sum(axis=0), np.cross(rod.nodal(self.q), Q).sum(axis=(0, 1))
        models = [] if self.model.constraints is None else self.model.constraints.joints
        for carried, model in zip(self.joints, models, strict=True):
            if carried.joint.b is None and carried.joint.a.rod == rod.rod.name:
                arm = model.sections[0].position(self.q)
                force, moment = force + carried.force, moment + carried.moment + np.cross(arm, carried.force)
        return Reaction(force, moment)

    def balance(self, name: str | None = None) -> Balance:
        """What is applied and what supports and ground exert, about the origin of SCS: balance.py.

        Of the whole structure, or of one rod with what its joints carry.
        """
        from ancf.balance import balance

        return balance(self, name)

    @cached_property
    def joints(self) -> list[JointForces]:
        """What each joint carries, in the order of the scene."""
        constraints = self.model.constraints
        if constraints is None:
            return []
        found = [joint.forces(self.q[joint.dofs], self.load_factor) for joint in constraints.joints]
        return [JointForces(j, *pair) for j, pair in zip(self.scene.joints, found, strict=True)]

    def tendon_lengths(self) -> list[float]:
        """Length [m] of each tendon of the scene."""
        return [tendon.length for tendon in self.tendons]

    @cached_property
    def tendons(self) -> list[TendonState]:
        """Tension, length and slack of each tendon, in the order of the scene."""
        if not self.scene.tendons:
            return []
        from ancf.tendon_state import tendon_states

        return tendon_states(self.model, self.q, self.load_factor)

    def section_forces(self, name: str | None = None) -> SectionForces:
        """Section force and moment along the rod."""
        rod = self._rod(name)
        if not rod.element.has_section:
            force = cable.forces(self.model, rod, self.q, self.load_factor).reshape(-1, 3)
            x = rod.axial_abscissae.ravel()
            return SectionForces(x, x / rod.rod.length, force, cable.moments(rod, self.q).reshape(-1, 3))
        v = rod.generalised(self.q)
        count = len(rod.element.directors)
        Q_v = rod.section_force(self.q)
        # d_k x dU/dd_k'; the axis itself (k = 0) carries force, not moment.
        moment = np.cross(v[:, :, count:], Q_v[:, :, 1:count]).sum(axis=2)
        x = rod.axial_abscissae.ravel()
        return SectionForces(x, x / rod.rod.length, Q_v[:, :, 0].reshape(-1, 3), moment.reshape(-1, 3))

    def section_axes(self, name: str | None = None) -> Floats:
        """Axes (m, 3, 3) of the turned sections at the axial integration points, columns x, y, z in SCS."""
        rod = self._rod(name)
        if not rod.element.has_section:
            return cable.section_axes(rod, self.q).reshape(-1, 3, 3)
        xi, _ = gauss(rod.axial_points)
        first, kind = rod.element_kinds
        N = np.array([rod.element.shape(xi, float(rod.mesh.h[index])) for index in first])[kind]
        d0 = N @ rod.e0[:, None]
        d = N @ rod.element_vectors(self.q)[:, None]
        rotation = section_rotation(d, rod.weights_at(xi, d0)).R
        _, frame = reference_axis(rod.axial_abscissae.ravel(), rod.rod.curvature)
        return rotation.reshape(-1, 3, 3) @ rod.rod.base.rotation @ frame

    def section_stress(self, name: str | None, at: float, y: ArrayLike, z: ArrayLike) -> Floats:
        """Cauchy stress (n, 3, 3) [Pa] at points (y, z) of a section, in the axes of the turned section.

        x is the normal of the section, y and z lie in it (`section_axes`): with the axes A (3, 3) as columns
        the stress in SCS is A stress A^T. It is evaluated at the axial integration points and taken linearly
        between and beyond them; where segments meet, those of the one with the larger section. What each law
        and formulation counts as stress: section_stress.py.

        Parameters
        ----------
        name : rod; the first if None
        at : fraction of the reference length, 0 to 1
        y, z : coordinates (n,) [m] in the reference section

        Raises
        ------
        InputError : a place that is not on the rod or not in its section.
        """
        from ancf.section_stress import along_fibres, along_rod, cauchy_stress, check_places

        rod = self._rod(name)
        y, z = np.broadcast_arrays(np.atleast_1d(np.asarray(y, float)), np.asarray(z, float))
        check_places(rod.rod, at, y, z)
        part = rod.rod.part_at(at)
        y, z = along_fibres(rod, at, part, y, z)
        axes = self.section_axes(name).reshape(-1, rod.axial_points, 3, 3)[rod.elements_of(part)]
        axes = axes.reshape(-1, 1, 3, 3)
        stress = np.swapaxes(axes, -1, -2) @ cauchy_stress(rod, self.q, y, z, part) @ axes
        return along_rod(rod, stress, at, part)

    def tangent(self) -> sparse.csr_array:
        """Tangent dg/dq on the free unknowns [SI units], sparse; the multipliers of constraints come last."""
        return self.model.supported_tangent(self.q, self.load_factor)

    def sensitivity(self, parameter: str = "moment", rod: str | None = None, index: int = 0) -> Floats:
        """Exact derivative (12, 3) or (12,) of a tip pose [r, r_x, r_y, r_z] by a load or a number of a rod.

        `parameter` is "moment", "force", "line_load" (the table `index` of the scene, in its frame),
        "gravity", "young_modulus", "radius", "length", ...: sensitivity.py.
        """
        from ancf.sensitivity import sensitivity

        return sensitivity(self.model, self.q, self.load_factor, parameter, rod, index)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the nodal state to a .npz file that `ancf.resume` reads."""
        from ancf.state import save_state

        save_state(path, self)

    def as_dict(self) -> dict[str, Any]:
        """The result in plain Python; every number is finite (result.py)."""
        from ancf.result import result_of

        return result_of(self)


def _material_points(rod: RodModel, nodal: Floats, at: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
    at, y, z = np.broadcast_arrays(np.asarray(at, float), np.asarray(y, float), np.asarray(z, float))
    points = np.empty((*at.shape, 3))
    for fraction in np.unique(at):
        rod.rod.check_place(float(fraction))
        here = at == fraction
        point = rod.section_point(float(fraction))
        first = point.dofs - rod.first_dof
        if not rod.element.has_section:
            axes = rotation_at(rod, nodal, float(fraction)) @ rod.rod.base.rotation
            axis = (point.N @ nodal.ravel()[first].reshape(-1, 3))[0]
            points[here] = axis + y[here, None] * axes[:, 1] + z[here, None] * axes[:, 2]
            continue
        phi, _, _ = rod.element.section_monomials(y[here], z[here])
        points[here] = phi @ (point.N @ nodal.ravel()[first].reshape(-1, 3))
    return points + rod.rod.base.position
