r"""Joints between sections, and of sections with the ground, by Lagrange multipliers.

A joint adds to the potential lambda . c + sum_i mu_i g_i with the conditions

    c_j = a_j . [(r_a - r_a0) - (r_b - r_b0) - l u] = 0,            the gap along a_j, as a rule x, y, z,
    g_i = sum_t w_it (R_a x_it) . (B y_it) = 0,                     what the rotations may not do,

R_a, R_b the polar rotations of the sections against their reference (rotation.py), B = R_b Exp(l phi), or on
the ground B = Exp(l phi) and r_b = r_b0: a section may be moved by u and turned by phi times the load factor
l. Between two rods u and phi are not zero where they are apart in the reference: at l = 1 they have met. With
the axes e of SCS and D = B^T R_a

    rigid   g = axial part of D, so 1/2 (D_32 - D_23) and so on: sin(angle) times its axis;
    hinge   g = (t_1 . D n, t_2 . D n), n the axis and t_1, t_2 across it; ball: none
    twist   g = n . axial part of D: with the unit quaternion (w, v) of D it is 2 w n . v, and n . v = 0 where
            D turns about an axis across n (scene_motions.py). Its moment is about n half turned with D.

D is near the identity at the solution, whatever the turns of either section, so nothing wraps. From
dg_i = m_i . (w_a - w_b) with m_i = sum_t w_it R_a x_it x B y_it, w the spins, the sections take the moments
+-m = +-sum_i mu_i m_i, and

    dm = M w_a - M^T w_b,   M = sum_i mu_i sum_t w_it hat(B y_it) hat(R_a x_it).

The result is a potential's, so its second derivative below is exact and symmetric.

Symbols
-------
lambda   force multipliers (3 as a rule) [N]: the section b pulls a by -sum_j lambda_j a_j
mu       moment multipliers (3 rigid, 2 hinge, 1 twist, 0 ball) [N m], in the axes of B
x        unknowns of one joint (nd,): nodal vectors of the element of a, of b, lambda, mu
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.constraints import Constraint, ConstraintTerms
from ancf.joint_closing import closing_motion
from ancf.rod_model import RodModel, SectionPoint
from ancf.rotation import SectionRotation, exp, hat, section_rotation
from ancf.scene import Joint, Place
from ancf.section_energy import force_weights

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

# A load step turns a section by no more [rad]: at pi a rotation and its opposite cannot be told apart.
LONGEST_TURN = 1.0
LARGEST_SWING = 2.9  # rad; at pi a twist has no sense
LONGEST_SHIFT = 0.25  # rod lengths by which a load step moves a section


@dataclass(frozen=True, eq=False)
class JointSection:
    """The section of a rod that a joint holds."""

    rod: RodModel
    point: SectionPoint
    shape: Floats  # (nodal,): position r = shape . e, as a point force acts on it (effects/force.py)

    @cached_property
    def r_0(self) -> Floats:
        """Position (3,) [m] in the reference, relative to the rod's base."""
        return self.shape @ self._reference

    @cached_property
    def _reference(self) -> Floats:
        return self.rod.q0.reshape(-1, 3)[(self.point.dofs[::3] - self.rod.first_dof) // 3]

    @cached_property
    def to_directors(self) -> Floats:
        """Map (3 directors, 3 nodal) from nodal vectors to directors."""
        return np.asarray(np.kron(self.point.N, np.eye(3)), dtype=float)

    @cached_property
    def to_position(self) -> Floats:
        """Map (3, 3 nodal) from nodal vectors to the position."""
        return np.asarray(np.kron(self.shape, np.eye(3)), dtype=float)

    @cached_property
    def held_dofs(self) -> Indices:
        """Unknowns of the model that position and rotation of the section depend on."""
        used = np.any(self.point.N != 0.0, axis=0) | (self.shape != 0.0)
        return self.point.dofs[np.repeat(used, 3)]

    def position(self, q: Floats) -> Floats:
        """Position (3,) [m] at the model's coordinates q (n,), relative to the rod's base."""
        return self.shape @ q[self.point.dofs].reshape(-1, 3)

    def rotation(self, e: Floats) -> SectionRotation:
        """Polar rotation against the reference, from the nodal vectors e (nodal, 3)."""
        return section_rotation(self.point.N @ e, self.point.W)


def joint_section(rods: list[RodModel], place: Place) -> JointSection:
    """The section at a place of the scene."""
    rod = next(model for model in rods if model.rod.name == place.rod)
    point = rod.section_point(place.at)
    shape = force_weights(rod.element, rod.rod.section_at(place.at), 0.0, 0.0) @ point.N
    return JointSection(rod, point, shape)


def turning_conditions(joint: Joint) -> tuple[Floats, Floats, Floats]:
    """Weights w (k, terms), vectors x and y (k, terms, 3) of the k conditions g_i on the rotations."""
    if joint.kind == "rigid":
        e = np.eye(3)
        pairs = [(1, 2), (2, 0), (0, 1)]
        x = np.array([[e[j], e[k]] for j, k in pairs])
        return np.tile([0.5, -0.5], (3, 1)), x, x[:, ::-1]
    if joint.kind == "twist":
        t = joint.across
        return np.array([[0.5, -0.5]]), t[None], t[None, ::-1]
    if joint.kind == "hinge":
        return np.ones((2, 1)), np.tile(joint.axis, (2, 1, 1)), joint.across[:, None]
    return np.empty((0, 1)), np.empty((0, 1, 3)), np.empty((0, 1, 3))


class JointModel(Constraint):
    """Arrays of one joint; its multipliers are the unknowns from `first` on."""

    name = "joint"

    def __init__(self, joint: Joint, rods: list[RodModel], first: int) -> None:
        self.joint = joint
        self.sections = [joint_section(rods, place) for place in joint.places]
        self.displacement, self.rotation = joint.displacement, joint.rotation
        if joint.apart:
            a, b = ((s.rod.rod, place.at) for s, place in zip(self.sections, joint.places, strict=True))
            self.displacement, self.rotation = closing_motion(*a, *b)
        if joint.kind == "ball":  # which turns nothing
            self.rotation = np.zeros(3)
        self.along = joint.along
        self.w, self.x, self.y = turning_conditions(joint)
        self.multipliers = first + np.arange(len(self.along) + len(self.w))
        self.dofs = np.concatenate([*(s.point.dofs for s in self.sections), self.multipliers])
        self.rows, self.columns = np.repeat(self.dofs, len(self.dofs)), np.tile(self.dofs, len(self.dofs))
        self.held_dofs = np.concatenate([s.held_dofs for s in self.sections])
        # By the first rod: the unit of force is its E I / L^2, of moment E I / L.
        rod = self.sections[0].rod
        self.energy = rod.bending_stiffness / rod.rod.length
        self.gap_unit = np.repeat([rod.rod.length, 1.0], [len(self.along), len(self.w)])
        self.longest_step = self._longest_step()

    def _longest_step(self) -> float:
        """Largest step of the load factor, by which the prescribed motion stays near; inf without one."""
        turn, shift = np.linalg.norm(self.rotation), np.linalg.norm(self.displacement)
        steps = [LONGEST_TURN / turn if turn else np.inf]
        steps += [LONGEST_SHIFT * s.rod.rod.length / shift if shift else np.inf for s in self.sections]
        return float(min(steps))

    def _vectors(self, x: Floats) -> list[Floats]:
        """Nodal vectors (nodal, 3) of each section."""
        cuts = np.cumsum([s.point.dofs.size for s in self.sections])
        return [part.reshape(-1, 3) for part in np.split(x, cuts)[: len(cuts)]]

    def _multipliers(self, x: Floats) -> tuple[Floats, Floats]:
        """sum_j lambda_j a_j (3,) and mu (k,)."""
        own = x[-self.conditions :]
        return own[: len(self.along)] @ self.along, own[len(self.along) :]

    def _other(self, rotations: list[SectionRotation], load_factor: float) -> Floats:
        """B (3, 3): rotation of the section b, or of the ground, and what the joint turns a against it."""
        turn = exp(load_factor * self.rotation)
        return rotations[1].R @ turn if len(rotations) > 1 else turn

    def terms(self, x: Floats, load_factor: float) -> ConstraintTerms:
        """See `Constraint.terms`."""
        e = self._vectors(x)
        rotations = [s.rotation(part) for s, part in zip(self.sections, e, strict=True)]
        force, mu = self._multipliers(x)
        R_a, B = rotations[0].R, self._other(rotations, load_factor)
        X, Y = self.x @ R_a.T, self.y @ B.T  # (k, terms, 3)
        m_i = np.einsum("it,itj->ij", self.w, np.cross(X, Y))
        m = mu @ m_i
        M = np.einsum("i,it,itjk->jk", mu, self.w, hat(Y) @ hat(X))

        size = len(x)
        g, rate, K = np.zeros(size), np.zeros(size), np.zeros((size, size))
        gap, turn = slice(size - self.conditions, size - len(mu)), slice(size - len(mu), None)
        g[gap] = -load_factor * self.along @ self.displacement
        g[turn] = np.einsum("it,itj,itj->i", self.w, X, Y)
        rate[gap] = -self.along @ self.displacement
        spins, start = [], 0
        for sign, s, rotation, part in zip((1.0, -1.0), self.sections, rotations, e, strict=False):
            here = slice(start, start + part.size)
            spin = rotation.spin().reshape(3, -1)
            dw = spin @ s.to_directors
            g[here] = (sign * (np.outer(s.shape, force) + s.point.N.T @ rotation.couple(m))).ravel()
            g[gap] += sign * self.along @ (s.shape @ part - s.r_0)
            own = sign * (M if sign > 0.0 else -M.T)
            K[here, here] = (
                s.to_directors.T @ rotation.couple_tangent(sign * m, own @ spin, spin) @ s.to_directors
            )
            rows = np.concatenate([sign * self.along @ s.to_position, sign * m_i @ dw])
            K[size - self.conditions :, here] = rows
            K[here, size - self.conditions :] = rows.T
            spins.append((here, dw))
            start += part.size
        (a, w_a), *others = spins
        for b, w_b in others:
            K[a, b] = -w_a.T @ M.T @ w_b
            K[b, a] = K[a, b].T
        # B turns with phi per load factor, in the axes of b.
        turning = rotations[1].R @ self.rotation if others else self.rotation
        rate[a] = -w_a.T @ M.T @ turning
        rate[turn] = -m_i @ turning
        for b, w_b in others:
            rate[b] = w_b.T @ M.T @ turning
        return ConstraintTerms(g, rate, K.ravel())

    def closed(self, x: Floats, load_factor: float) -> bool:
        """Whether the rotations fit, and not as the opposite that the conditions also allow."""
        e = self._vectors(x)
        rotations = [s.rotation(part) for s, part in zip(self.sections, e, strict=True)]
        D = self._other(rotations, load_factor).T @ rotations[0].R
        if self.joint.kind == "rigid":
            return float(np.trace(D)) > 1.0  # less than a right angle between them
        if self.joint.kind == "twist":
            return float(np.trace(D)) > 2.0 * np.cos(LARGEST_SWING) + 1.0
        return self.joint.kind == "ball" or float(self.joint.axis @ D @ self.joint.axis) > 0.0

    def forces(self, x: Floats, load_factor: float) -> tuple[Floats, Floats]:
        """Force [N] and moment [N m] (3,) that b, or the ground, exerts on the section a, in SCS."""
        rotations = [s.rotation(part) for s, part in zip(self.sections, self._vectors(x), strict=True)]
        X, Y = self.x @ rotations[0].R.T, self.y @ self._other(rotations, load_factor).T
        m_i = np.einsum("it,itj->ij", self.w, np.cross(X, Y))
        force, mu = self._multipliers(x)
        return -force + 0.0, -mu @ m_i  # no negative zeros
