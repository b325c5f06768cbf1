"""Start values of the solid reference: a rod's centre line and sections, lifted to the mesh.

Start values only: the residual decides. All contain the lateral field of Saint Venant; without it Newton
diverges from them at nu >= 0.49 (reference study).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from reference.rotation import exp, exp_integral
from reference.solid_mesh import RodMesh

Array = NDArray[np.float64]


def bent_rod(mesh: RodMesh, curvature: float, poisson_ratio: float) -> Array:
    """Displacement (n, 3) [m] of a circular arc in the x-y plane; `curvature` [1/m]."""
    return helical_rod(mesh, np.array([0.0, 0.0, curvature]), poisson_ratio)


def helical_rod(mesh: RodMesh, curvature: Array, poisson_ratio: float) -> Array:
    """Displacement (n, 3) [m] of a rod whose twist and curvatures are the same everywhere.

    R(s) = Exp(s k), r(s) = s int_0^1 Exp(x s k) e_x dx: an arc, a helix, or a twisted straight rod.

    Parameters
    ----------
    mesh : RodMesh
        The rod.
    curvature : (3,) [1/m]
        k: twist, curvature about y, curvature about z.
    poisson_ratio : float
        [-].
    """
    s = mesh.plane_positions
    turned = s[:, None] * curvature
    position = s[:, None] * exp_integral(turned)[..., 0]
    return _lift(mesh, position, exp(turned), np.broadcast_to(curvature, (len(s), 3)), poisson_ratio)


def lifted_rod(
    mesh: RodMesh, s: Array, position: Array, rotation: Array, curvature: Array, poisson_ratio: float
) -> Array:
    """Displacement (n, 3) [m] of a rod solution given at stations, from a beam of any kind.

    Parameters
    ----------
    mesh : RodMesh
        The rod.
    s : (m,) [m]
        Stations of the reference length, rising from 0 to the length; m >= 2.
    position : (m, 3) [m]
        Centre line.
    rotation : (m, 3, 3)
        Section rotations; neighbours differ by less than pi.
    curvature : (m, 3) [1/m]
        Twist and curvatures in the section's frame; they only shape the lateral field.
    poisson_ratio : float
        [-].

    Raises
    ------
    ValueError
        When the stations do not rise from 0 to the length.
    """
    ends = np.array([s[0], s[-1] - mesh.length])
    if np.any(np.diff(s) <= 0) or np.any(np.abs(ends) > 1e-9 * mesh.length):
        raise ValueError(
            f"The stations run from {s[0]} m to {s[-1]} m; they must rise from 0 to the rod's length "
            f"{mesh.length} m. Give them in reference length."
        )
    at = np.clip(mesh.plane_positions, s[0], s[-1])
    turned = Slerp(s, Rotation.from_matrix(rotation))(at).as_matrix()
    bent = np.column_stack([np.interp(at, s, component) for component in np.asarray(curvature).T])
    return _lift(mesh, CubicSpline(s, position)(at), turned, bent, poisson_ratio)


def clamped(guess: Array, fixed: NDArray[np.bool_]) -> Array:
    """The guess (n, 3) with zero displacement in the held components, as a full clamp needs."""
    return np.where(fixed, 0.0, guess)


def _lift(mesh: RodMesh, position: Array, rotation: Array, curvature: Array, poisson_ratio: float) -> Array:
    """Displacement from the centre line and sections at the mesh's planes.

    v = nu [k_z (y^2 - z^2)/2 - k_y y z], w = nu [k_z y z + k_y (y^2 - z^2)/2]: the sections of a bar with
    the axial strain k_y z - k_z y and no transverse stress.
    """
    y, z = mesh.section.nodes.T
    k_y, k_z = curvature[:, 1, None], curvature[:, 2, None]
    saddle, product = (y**2 - z**2) / 2, y * z
    v = y + poisson_ratio * (k_z * saddle - k_y * product)
    w = z + poisson_ratio * (k_z * product + k_y * saddle)
    arm = np.stack([np.zeros_like(v), v, w], axis=-1)  # (planes, ns, 3)
    x = position[:, None] + arm @ rotation.swapaxes(-1, -2)
    return x.reshape(-1, 3) - mesh.nodes
