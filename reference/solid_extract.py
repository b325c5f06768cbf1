"""What a beam is compared with: centre line, section rotations, stretch and stress of a solid solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from reference.rotation import log
from reference.solid_assembly import SolidAssembly
from reference.solid_couple import section_moments, section_rotation
from reference.solid_forms import solid_form
from reference.solid_mesh import SectionMesh
from reference.solid_problem import SolidResult

Array = NDArray[np.float64]

# Node of a line (0 start, 1 middle, 2 end) that each of the 9 nodes of scikit-fem's quad lies on, in y and z.
QUAD_Y = np.array([0, 2, 2, 0, 1, 2, 1, 0, 1])
QUAD_Z = np.array([0, 0, 2, 2, 0, 1, 2, 1, 1])
INSIDE = 1e-6  # in the coordinates of a quad, whose side is 1
NEWTON_STEPS = 30


@dataclass(frozen=True, eq=False)
class SectionStates:
    """The solid read as a rod, plane by plane.

    `arc_length` (m,) [m] in the reference, `centre` (m, 3) [m] the material points on the axis (None where
    the section is hollow), `mean` (m, 3) [m] the area mean, `rotation` (m, 3, 3) the polar rotation,
    `stretch` (m,) [-] |d axis/ds|.
    """

    arc_length: Array
    centre: Array | None
    mean: Array
    rotation: Array
    stretch: Array

    @property
    def axis(self) -> Array:
        """Centre line (m, 3) [m]: the material axis, or the area mean where the section is hollow."""
        return self.mean if self.centre is None else self.centre

    @property
    def curvature(self) -> Array:
        """Twist and curvatures between neighbouring planes, log(R_i^T R_i+1)/ds (m - 1, 3) [1/m]."""
        turned = log(self.rotation[:-1].swapaxes(-1, -2) @ self.rotation[1:])
        return turned / np.diff(self.arc_length)[:, None]

    def mean_curvature(self, margin: float) -> Array:
        """Mean of `curvature` (3,) [1/m] over the planes that keep `margin` [m] from both ends.

        In uniform bending and twist this is the exact section answer: the end layers, O((kappa R)^2 R/L) of
        the tip angle, decay within a few radii.
        """
        s = self.arc_length
        inside = (s[:-1] >= margin * (1 - 1e-9)) & (s[1:] <= s[-1] - margin * (1 - 1e-9))
        if not np.any(inside):
            raise ValueError(f"margin is {margin} m; it must leave a part of the length {s[-1]} m.")
        return np.mean(self.curvature[inside], axis=0)


@dataclass(frozen=True, eq=False)
class SectionStress:
    """State of a section at points (m, 2) [m]: `F` (m, 3, 3), `pk1` and `cauchy` (m, 3, 3) [Pa]."""

    points: Array
    F: Array
    pk1: Array
    cauchy: Array


def section_states(result: SolidResult) -> SectionStates:
    """Centre line, area mean, polar rotation and axial stretch at every plane of the mesh.

    The stretch is the slope of a cubic spline through the planes.
    """
    mesh, section = result.problem.mesh, result.problem.mesh.section
    x = result.positions.reshape(-1, len(section.nodes), 3)
    mean = section.mass.sum(axis=0) @ x / section.area
    centre = None if section.centre is None else x[:, section.centre]
    s = mesh.plane_positions
    slope = CubicSpline(s, mean if centre is None else centre)(s, 1)
    rotation = section_rotation(x, section_moments(section.nodes, section.mass))
    return SectionStates(s, centre, mean, rotation, np.linalg.norm(slope, axis=-1))


def section_stress(result: SolidResult, s: float, points: Array) -> SectionStress:
    """Stress of the section at reference length `s` in given points of it.

    Parameters
    ----------
    result : SolidResult
        The solution.
    s : float
        [m], from 0 to the length.
    points : (m, 2) [m]
        y and z in the reference section.

    Returns
    -------
    SectionStress
        From the gradient of the element that holds the point; the mixed form adds its projected pressure.

    Raises
    ------
    ValueError
        When `s` or a point lies outside the rod.
    """
    problem, mesh = result.problem, result.problem.mesh
    if not 0 <= s <= mesh.length:
        raise ValueError(f"s is {s} m; it must lie between 0 and the length {mesh.length} m.")
    height = mesh.length / mesh.slices
    k = min(int(s / height), mesh.slices - 1)
    L_x, dL_x = _line(np.array(s / height - k))
    ns = len(mesh.section.nodes)
    planes = result.positions.reshape(-1, ns, 3)[2 * k : 2 * k + 3]
    quad, N, N_yz = _locate(mesh.section, np.asarray(points, float))
    x = planes[:, mesh.section.quads[quad]]  # (3, m, 9, 3)
    F = np.empty((len(quad), 3, 3))
    F[:, :, 0] = np.einsum("p,pmai,ma->mi", dL_x / height, x, N)
    F[:, :, 1:] = np.einsum("p,pmai,maJ->miJ", L_x, x, N_yz)

    law = problem.material
    if problem.formulation == "displacement":
        pk1 = law.stress(F)
    else:
        assembly = SolidAssembly(mesh, problem.fixed)
        form = solid_form(problem.formulation, law, assembly)
        X = np.column_stack([np.full(len(quad), s), points])
        u = result.positions - mesh.nodes
        element = k * len(mesh.section.quads) + quad
        p = form.pressure(assembly.deformation_gradient(u), element, X)
        pk1 = law.shape.stress(F) + np.asarray(p)[:, None, None] * law.volume_measure(F)[1]
    cauchy = pk1 @ F.swapaxes(-1, -2) / np.linalg.det(F)[:, None, None]
    return SectionStress(np.asarray(points, float), F, pk1, cauchy)


def _line(t: Array) -> tuple[Array, Array]:
    """Quadratic shape functions of the nodes 0, 1/2, 1 and their slopes at t (...); returns (..., 3) each."""
    N = np.stack([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)], axis=-1)
    return N, np.stack([4 * t - 3, 4 - 8 * t, 4 * t - 1], axis=-1)


def _quad(local: Array) -> tuple[Array, Array]:
    """Shape functions (..., 9) of a 9-node quad and their slopes (..., 9, 2) at local points (..., 2)."""
    (A, dA), (B, dB) = _line(local[..., 0]), _line(local[..., 1])
    N = A[..., QUAD_Y] * B[..., QUAD_Z]
    return N, np.stack([dA[..., QUAD_Y] * B[..., QUAD_Z], A[..., QUAD_Y] * dB[..., QUAD_Z]], axis=-1)


def _locate(section: SectionMesh, points: Array) -> tuple[NDArray[np.int64], Array, Array]:
    """Quad (m,) that holds each point, shape functions (m, 9) and their gradients (m, 9, 2) [1/m] there."""
    corners = section.nodes[section.quads]  # (n_quad, 9, 2)
    local = np.full((len(corners), len(points), 2), 0.5)
    for _ in range(NEWTON_STEPS):  # every point in every quad: sections are small
        N, N_local = _quad(local)
        missing = points - np.einsum("qma,qai->qmi", N, corners)
        jacobian = np.einsum("qmaj,qai->qmij", N_local, corners)
        local = np.clip(local + np.linalg.solve(jacobian, missing[..., None])[..., 0], -0.5, 1.5)
    missing = points - np.einsum("qma,qai->qmi", _quad(local)[0], corners)
    size = np.sqrt(section.area)
    outside = np.max(np.abs(local - 0.5), axis=-1) - 0.5 + np.linalg.norm(missing, axis=-1) / size
    quad = np.argmin(outside, axis=0)
    columns = np.arange(len(points))
    if np.any(outside[quad, columns] > INSIDE):
        first = points[np.argmax(outside[quad, columns])]
        raise ValueError(f"The point y = {first[0]} m, z = {first[1]} m lies outside the section.")
    N, N_local = _quad(local[quad, columns])
    jacobian = np.einsum("maj,mai->mij", N_local, corners[quad])
    return quad, N, N_local @ np.linalg.inv(jacobian)
