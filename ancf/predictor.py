r"""Start values for Newton: a rod held at one section, bent by its moments or by all of its loads.

Moments fixed in space on a straight round rod clamped at one end give helices in closed form: the internal
moment is constant in space between loads. The same idea serves every section and reference curvature: with
M(x) known,

    R' = R hat(k_0 + C^-1 R^T M),   r' = R e_x,

with R the section frame is an initial value problem, integrated here by the exponential midpoint rule. It is
only a start value; the residual decides. Follower moments are integrated from their end, where they are known
in the section's own axes. Other loads: the Kirchhoff chain of rod_start.py.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R_YY, R_YZ, R_ZZ, R
from ancf.mesh import reference_axis
from ancf.model import Model
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rod_start import Chain, between_nodes, nodal_loads
from ancf.rotation import exp, log
from ancf.scene import Moment, Rod, Scene

Floats = NDArray[np.float64]

# Gauss points of the mean compliance between two nodes of a tapered rod; it is a start value.
COMPLIANCE_POINTS = 4
# Beyond this |M| L / E I [rad] the start is worthless: an element would carry more than a turn.
WORTHLESS_TURN = 1e3
# Axial strains that a start may have: beyond them the law is far from linear, and Newton finds its way.
STRAINS = (-0.2, 1.0)


def load_start(model: Model, deadline: float = np.inf) -> Floats | None:
    """Coordinates (n,) near the equilibrium under all loads; None where no rod has such a start.

    Known for rods held by one clamp (or free-section clamp): from their point moments alone in closed form,
    else from the equilibrium of a Kirchhoff rod (rod_start.py). Other rods keep their reference shape.
    """
    if model.scene.joints or model.scene.held_on_the_way:  # by what joints, springs, obstacles carry
        return None
    q = model.q0.copy()
    q[model.motions :], pulls = _tensions(model)
    found = False
    for rod in model.rods:
        if rod.rod.clamp is None:
            continue
        moments = [m for m in model.scene.moments if m.rod == rod.rod.name and np.any(m.value)]
        loads = nodal_loads(model.scene, rod)
        actuation = _actuation(model.scene, rod, pulls)
        spread = any(m.rod == rod.rod.name and np.any(m.value) for m in model.scene.line_moments)
        frames, axial_strain = None if spread else _frames_by_moments(rod, moments), None
        if loads.forces or actuation.any() or ((moments or spread) and frames is None):
            chain = _chain(rod)
            if model.plane is not None:
                from ancf.planar_start import in_plane

                chain, loads = in_plane(chain, loads, model.plane)
            if actuation.any():
                chain = replace(chain, k_0=chain.k_0 + actuation)
            starts = [chain.R_0] if frames is None else [chain.R_0, frames]
            shapes = (chain.equilibrium(loads, R, deadline) for R in starts)
            shape = next((shape for shape in shapes if shape is not None), None)
            if shape is not None:
                frames, axial_force = shape
                axial_strain = axial_force / between_nodes(rod, lambda s, law: law.young_modulus * s.area)
        if frames is None:
            continue
        shape = _shape(rod, frames, axial_strain)
        q[rod.first_dof : rod.first_dof + rod.size] = shape.ravel()
        found = True
    return q if found or np.any(q[model.motions :]) else None


def _frames_by_moments(rod: RodModel, moments: list[Moment]) -> Floats | None:
    """Section frames (n_nodes, 3, 3) of a rod bent by its moments alone.

    None unless it is held at x = 0 and its moments are all fixed in space, or a single follower moment.
    """
    fixed = all(m.direction == "fixed" for m in moments)
    if not moments or rod.rod.supports[0].at != 0.0 or not (fixed or len(moments) == 1):
        return None
    turns = sum(np.abs(m.value).max() for m in moments) * rod.rod.length / rod.bending_stiffness
    if not turns < WORTHLESS_TURN:  # also false for an overflow
        return None
    x = rod.mesh.node_x
    A_o = rod.rod.base.rotation
    compliance = compliance_between_nodes(rod)
    total = np.array([m.value for m in moments])
    ends = np.array([m.at * rod.rod.length for m in moments])
    rotations = np.empty((len(x), 3, 3))  # section frames in SCS
    rotations[0] = A_o
    ramp = np.diff(x)
    curvature = np.asarray(rod.rod.curvature)
    if not fixed:
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
    return rotations


def _chain(rod: RodModel) -> Chain:
    """The rod as a Kirchhoff chain between its nodes."""
    return Chain(
        h=np.diff(rod.mesh.node_x),
        C=np.linalg.inv(compliance_between_nodes(rod)).astype(float),
        k_0=np.asarray(rod.rod.curvature),
        R_0=rod.frames0,
        held=rod.node_at(rod.rod.supports[0].at),
        unit=rod.bending_stiffness / rod.rod.length,
    )


def _tensions(model: Model) -> tuple[Floats, list[float]]:
    """Estimates of the multipliers of tendons of given length, and the tensions [N] of all tendons."""
    controlled = [] if model.constraints is None else model.constraints.tendons
    found = [one.expected for one in controlled]
    pulled = iter(found)
    pulls = [max(next(pulled), 0.0) if t.tension is None else t.tension for t in model.scene.tendons]
    return np.array(found), pulls


def _actuation(scene: Scene, rod: RodModel, pulls: list[float]) -> Floats:
    """Curvature (n_nodes - 1, 3) that tendons and chambers give the rod between its nodes.

    Their couples (0, z N, -y N) turn with the sections: N = -T of a tension, p A of a chamber, at (y, z).
    `pulls` are the tensions [N] of all tendons of the scene.
    """
    x = rod.mesh.node_x
    moment = np.zeros((len(x) - 1, 3))
    if not (scene.tendons or scene.pressures):
        return moment
    middle = 0.5 * (x[:-1] + x[1:]) / rod.rod.length
    for tendon, tension in zip(scene.tendons, pulls, strict=True):
        if tendon.rod == rod.rod.name:
            at, y, z = tendon.path.T
            inside = tension * ((middle > at[0]) & (middle < at[-1]))
            moment[:, 1] -= inside * np.interp(middle, at, z)
            moment[:, 2] += inside * np.interp(middle, at, y)
    for chamber in scene.pressures:
        if chamber.rod == rod.rod.name:
            inside = (middle > chamber.start) & (middle < chamber.end)
            thrust = chamber.value * math.pi * chamber.radius**2 * inside
            moment[:, 1] += thrust * chamber.centre[1]
            moment[:, 2] -= thrust * chamber.centre[0]
    if not moment.any():
        return moment
    return np.einsum("nij,nj->ni", compliance_between_nodes(rod), moment)


def _shape(rod: RodModel, rotations: Floats, axial_strain: Floats | None) -> Floats:
    """Nodal vectors (n_nodes, vectors, 3) from section frames and axial strains (n_nodes - 1,)."""
    x = rod.mesh.node_x
    # Chord of a circular arc: shorter than the arc by sin(a/2)/(a/2).
    theta = log(np.swapaxes(rotations[:-1], -1, -2) @ rotations[1:])
    middle = rotations[:-1] @ exp(0.5 * theta)
    half_angle = 0.5 * np.linalg.norm(theta[:, 1:], axis=1)
    chord = np.diff(x) * np.sinc(half_angle / np.pi)
    if axial_strain is not None:
        chord *= 1.0 + np.clip(axial_strain, *STRAINS)
    r = np.concatenate([np.zeros((1, 3)), np.cumsum(chord[:, None] * middle[:, :, 0], axis=0)])
    relative = rotations @ np.swapaxes(rod.frames0, -1, -2)
    q = np.einsum("nij,nvj->nvi", relative, rod.q0)
    axis, held = rod.element.vectors.index(R), rod.node_at(rod.rod.supports[0].at)
    q[:, axis] = r - r[held] + rod.q0[held, axis]
    if rod.element.quadratic_section:
        _contract(rod, q, rotations, theta / np.diff(x)[:, None] - np.asarray(rod.rod.curvature))
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


def compliance_between_nodes(rod: RodModel) -> Floats:
    """Curvature (twist, y, z) per moment in section axes, its mean between two nodes (n - 1, 3, 3)."""
    spans = len(rod.element.node_xi) - 1
    first, kind = rod.element_kinds
    xi, weight = gauss(COMPLIANCE_POINTS)
    edges = np.array(rod.element.node_xi)
    found = np.empty((len(first), spans, 3, 3))
    for row, index in enumerate(first):
        material = rod.material_of(index)
        if not rod.rod.parts[int(rod.part_of[index])].tapered:
            found[row] = _section_compliance(rod.rod.prismatic(rod.section_in(index, 0.0), material))
            continue
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
