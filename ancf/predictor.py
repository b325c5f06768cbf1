r"""Start values for Newton: the rod under its moments, and extrapolation of an equilibrium path.

Moments fixed in space on a straight round rod clamped at one end give helices in closed form: the internal
moment is constant in space between loads. The same idea serves every section and reference curvature: with
M(x) known,

    R' = R hat(k_0 + C^-1 R^T M),   r' = R e_x,

with R the section frame is an initial value problem, integrated here by the exponential midpoint rule. It is
only a start value; the residual decides. Follower moments are integrated from their end, where they are known
in the section's own axes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R_YY, R_YZ, R_ZZ, R
from ancf.mesh import reference_axis
from ancf.model import Model
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rod_shape import LocalShape, from_local, node_rotations, to_local
from ancf.rotation import exp, log
from ancf.scene import Moment, Rod

Floats = NDArray[np.float64]

# Largest change of a local measure [rad] in the difference quotient that turns dq into rates.
_RATE_ANGLE = 1e-5
# Gauss points of the mean compliance between two nodes of a tapered rod; it is a start value.
COMPLIANCE_POINTS = 4
# Beyond this |M| L / E I [rad] the start is worthless: an element would carry more than a turn.
LARGEST_TURN = 1e3


def moment_start(model: Model, load_factor: float) -> Floats | None:
    """Coordinates (n,) of the rods bent by their point moments alone; None where no such start is known.

    Known for rods held by one clamp (or free-section clamp) at x = 0 whose moments are all fixed in space, or
    a single follower moment. Other rods keep their reference shape.
    """
    q = model.q0.copy()
    found = False
    for rod in model.rods:
        moments = [m for m in model.scene.moments if m.rod == rod.rod.name and np.any(m.value)]
        supports = rod.rod.supports
        held = len(supports) == 1 and supports[0].kind != "pin" and supports[0].at == 0.0
        fixed = all(m.direction == "fixed" for m in moments)
        if not (moments and held and (fixed or len(moments) == 1)):
            continue
        turns = sum(np.abs(m.value).max() for m in moments) * rod.rod.length / rod.bending_stiffness
        if not turns < LARGEST_TURN:  # also false for an overflow
            continue
        shape = _bent_by_moments(rod, moments, load_factor, follower=not fixed)
        q[rod.first_dof : rod.first_dof + rod.size] = shape.ravel()
        found = True
    return q if found else None


def _bent_by_moments(rod: RodModel, moments: list[Moment], load_factor: float, follower: bool) -> Floats:
    """Nodal vectors (n_nodes, vectors, 3) of a rod bent by its moments."""
    x = rod.mesh.node_x
    A_o = rod.rod.base.rotation
    compliance = _compliance(rod)
    total = np.array([load_factor * m.value for m in moments])
    ends = np.array([m.at * rod.rod.length for m in moments])
    rotations = np.empty((len(x), 3, 3))  # section frames in SCS
    rotations[0] = A_o
    ramp = np.diff(x)
    curvature = np.asarray(rod.rod.curvature)
    if follower:
        # Known in the axes of the loaded section: integrate back from there, then turn the whole rod to
        # its base.
        _, frame = reference_axis(np.array([ends[0]]), rod.rod.curvature)
        last = int(np.searchsorted(x, ends[0] - 1e-12 * rod.rod.length))
        value = total[0]
        rotations[last] = A_o @ frame[0]
        for i in range(last - 1, -1, -1):
            C = compliance[i]
            half = rotations[i + 1] @ _turn(-0.5 * ramp[i] * (curvature + C @ (value @ rotations[i + 1])))
            rotations[i] = rotations[i + 1] @ _turn(-ramp[i] * (curvature + C @ (value @ half)))
        turn = A_o @ rotations[0].T
        rotations[: last + 1] = turn @ rotations[: last + 1]
        for i in range(last, len(ramp)):
            rotations[i + 1] = rotations[i] @ _turn(ramp[i] * curvature)
    else:
        middle_x = 0.5 * (x[:-1] + x[1:])
        carried = (ends >= middle_x[:, None]).astype(float) @ total  # moment in each interval
        about_y = compliance[:, 1, 1]
        bending = np.abs(compliance[:, 1:, 1:] - about_y[:, None, None] * np.eye(2)).max(axis=(1, 2))
        if not np.any(curvature) and np.all(bending < 1e-12 * about_y):
            _helices(rotations, x, carried, compliance)
        else:
            for i, (length, value, C) in enumerate(zip(ramp, carried, compliance, strict=True)):
                half = rotations[i] @ _turn(0.5 * length * (curvature + C @ (value @ rotations[i])))
                rotations[i + 1] = rotations[i] @ _turn(length * (curvature + C @ (value @ half)))
    # Chord of a circular arc: shorter than the arc by sin(a/2)/(a/2).
    theta = log(np.swapaxes(rotations[:-1], -1, -2) @ rotations[1:])
    middle = rotations[:-1] @ exp(0.5 * theta)
    half_angle = 0.5 * np.linalg.norm(theta[:, 1:], axis=1)
    chord = ramp * np.sinc(half_angle / np.pi)
    r = np.concatenate([np.zeros((1, 3)), np.cumsum(chord[:, None] * middle[:, :, 0], axis=0)])
    _, frame0 = reference_axis(x, rod.rod.curvature)
    relative = rotations @ np.swapaxes(A_o @ frame0, -1, -2)
    q = np.einsum("nij,nvj->nvi", relative, rod.q0)
    q[:, rod.element.vectors.index(R)] = r
    if rod.element.quadratic_section:
        _contract(rod, q, rotations, theta / ramp[:, None] - curvature)
    return q


def _contract(rod: RodModel, q: Floats, rotations: Floats, bending: Floats) -> None:
    """Give quadratic sections the lateral field of Saint-Venant bending.

    With changes of curvature k_y, k_z (axial strain k_y z - k_z y) the section moves in its plane by

        v = nu (k_z (y^2 - z^2)/2 - k_y y z),   w = nu (k_z y z + k_y (y^2 - z^2)/2),

    so r_yy = nu (k_z e_y + k_y e_z) = -r_zz and r_yz = nu (k_z e_z - k_y e_y).

    Parameters
    ----------
    q : nodal vectors (n_nodes, vectors, 3), changed in place
    rotations : section frames (n_nodes, 3, 3)
    bending : change of curvature (n_nodes - 1, 3) [1/m] between the nodes, in section axes
    """
    # Curvature jumps at point moments: a node takes the mean of its two intervals.
    k = 0.5 * (np.concatenate([bending[:1], bending]) + np.concatenate([bending, bending[-1:]]))
    ratios = np.array([segment.material.poisson_ratio for segment in rod.rod.parts])
    nu = np.repeat(ratios[rod.part_of], len(rod.element.node_xi) - 1)
    k *= 0.5 * (np.concatenate([nu[:1], nu]) + np.concatenate([nu, nu[-1:]]))[:, None]
    vectors = rod.element.vectors
    e_y, e_z = rotations[:, :, 1], rotations[:, :, 2]
    k_y, k_z = k[:, 1:2], k[:, 2:3]
    q[:, vectors.index(R_YY)] = k_z * e_y + k_y * e_z
    q[:, vectors.index(R_ZZ)] = -q[:, vectors.index(R_YY)]
    q[:, vectors.index(R_YZ)] = k_z * e_z - k_y * e_y


def _helices(rotations: Floats, x: Floats, carried: Floats, compliance: Floats) -> None:
    """Fill in the section frames (n, 3, 3) of a straight rod with equal bending stiffnesses from the first.

    Where the moment M is constant, R(x) = Exp(M x / EI) R(0) Exp(psi x e_x) with psi = (1/GJ - 1/EI) M . t
    and the constant axial part M . t of the moment: a helix. A new one begins where M or compliance jumps.
    """
    state = np.column_stack([carried, compliance[:, 0, 0], compliance[:, 1, 1]])
    starts = np.flatnonzero(np.any(np.diff(state, axis=0) != 0.0, axis=1)) + 1
    for a, b in zip([0, *starts], [*starts, len(carried)], strict=True):
        M, C, distance = carried[a], compliance[a], (x[a : b + 1] - x[a])[:, None]
        psi = (C[0, 0] - C[1, 1]) * (M @ rotations[a, :, 0])
        bent = exp(distance * C[1, 1] * M) @ rotations[a]
        rotations[a : b + 1] = bent @ exp(distance * np.array([psi, 0.0, 0.0]))


def _turn(v: Floats) -> Floats:
    """`rotation.exp` of one vector in plain floats; array overhead would rule a step-by-step loop."""
    x, y, z = v.tolist()
    angle2 = x * x + y * y + z * z
    angle = math.sqrt(angle2)
    small = angle < 1e-4
    a = 1.0 - angle2 / 6.0 if small else math.sin(angle) / angle
    b = 0.5 - angle2 / 24.0 if small else 2.0 * (math.sin(0.5 * angle) / angle) ** 2
    return np.array(
        [
            [1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)],
        ]
    )


def _compliance(rod: RodModel) -> Floats:
    """Curvature (twist, y, z) per moment in section axes, its mean between two nodes (n - 1, 3, 3)."""
    spans = len(rod.element.node_xi) - 1
    first, kind = rod.element_kinds
    xi, weight = gauss(COMPLIANCE_POINTS)
    edges = np.array(rod.element.node_xi)
    found = np.empty((len(first), spans, 3, 3))
    for row, index in enumerate(first):
        material = rod.material_of(index)
        for span in range(spans):
            places = 0.5 * (edges[span] * (1.0 - xi) + edges[span + 1] * (1.0 + xi))
            sections = [rod.section_in(index, float(s)) for s in places]
            if all(section == sections[0] for section in sections):
                found[row, span] = _section_compliance(rod.rod.prismatic(sections[0], material))
                continue
            each = [_section_compliance(rod.rod.prismatic(section, material)) for section in sections]
            found[row, span] = 0.5 * np.tensordot(weight, each, axes=1)
    return found[kind].reshape(-1, 3, 3)


def _section_compliance(rod: Rod) -> Floats:
    """Inverse of diag-block(GJ, bending) in section axes (3, 3) of a prismatic rod."""
    material, second = rod.material, rod.section.second_moments
    stiffness = np.zeros((3, 3))
    # gamma_xy carries k_y and works on z, gamma_xz carries k_z and works on y.
    k_y, k_z = rod.shear_factors
    stiffness[0, 0] = material.lame_mu * (k_y * second[1, 1] + k_z * second[0, 0])
    # Moment about y from curvature about y: E int z^2, coupling -E int y z.
    stiffness[1:, 1:] = material.young_modulus * np.array(
        [[second[1, 1], -second[0, 1]], [-second[0, 1], second[0, 0]]]
    )
    return np.linalg.inv(stiffness).astype(float)


class Path:
    """The last equilibria of a load path, for extrapolating the next start."""

    def __init__(self, model: Model, q: Floats) -> None:
        self.model = model
        self.points: list[tuple[float, list[LocalShape], Floats]] = []
        self.add(0.0, q)

    def add(self, load_factor: float, q: Floats) -> None:
        """Append an equilibrium; only the last three are kept."""
        local = [to_local(rod, rod.nodal(q)) for rod in self.model.rods]
        self.points = [*self.points[-2:], (load_factor, local, q)]

    def from_tangent(self, dq: Floats) -> Floats:
        """Start after the increment dq (n,) of the linear problem, taken in local measures."""
        _, now, q = self.points[-1]
        small = _RATE_ANGLE / max(float(np.max(np.abs(dq / self.model.unit))), _RATE_ANGLE)
        rates = [
            (to_local(rod, rod.nodal(q + small * dq)) + here * -1.0) * (1.0 / small)
            for rod, here in zip(self.model.rods, now, strict=True)
        ]
        return self._rebuild([here + rate for here, rate in zip(now, rates, strict=True)], q + dq)

    def extrapolate(self, load_factor: float) -> Floats:
        """Start at a load factor by the polynomial through the last two or three equilibria."""
        known = np.array([point[0] for point in self.points])
        weights = [
            float(np.prod([(load_factor - b) / (a - b) for b in np.delete(known, i)]))
            for i, a in enumerate(known)
        ]
        shapes = []
        for index in range(len(self.model.rods)):
            parts = [point[1][index] * w for point, w in zip(self.points, weights, strict=True)]
            total = parts[0]
            for part in parts[1:]:
                total = total + part
            shapes.append(total)
        linear = sum(
            (point[2] * w for point, w in zip(self.points, weights, strict=True)), np.zeros(self.model.n)
        )
        return self._rebuild(shapes, linear)

    def _rebuild(self, shapes: list[LocalShape], linear: Floats) -> Floats:
        """Rods with one orienting support are rebuilt from it; the others take the linear extrapolation."""
        q = linear.copy()
        for rod, shape in zip(self.model.rods, shapes, strict=True):
            supports = rod.rod.supports
            if len(supports) != 1 or supports[0].kind == "pin":
                continue
            node = int(np.argmin(np.abs(rod.mesh.node_x - supports[0].at * rod.rod.length)))
            now = rod.nodal(self.points[-1][2])
            rotation = node_rotations(rod, now)[node]
            position = now[node, rod.element.vectors.index(R)]
            q[rod.first_dof : rod.first_dof + rod.size] = from_local(
                rod, shape, node, position, rotation
            ).ravel()
        return q
