"""End couple of a solid rod that is conjugate to the polar rotation of its end section.

Symbols: `W` section moments (ns, 3), `A_x` = sum_a x_a W_a^T, `R` its polar factor, `V` = A_x R^T
(symmetric), `G` = tr(V) I - V, `mu` = G^-1 M, `a` = R W_a. No rigid end plate: a plate stiffens the rod by
O(R/L) and hides the O((kappa R)^2) difference between solid and beam.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.rotation import hat

Array = NDArray[np.float64]


def section_moments(section_nodes: Array, mass: Array) -> Array:
    """First moments of the shape functions, W_a = sum_b mass_ab (X_b - X_mean).

    Takes nodes (ns, 2) [m] and mass (ns, ns) [m^2]; returns (ns, 3) [m^3], zero along x, with sum_a W_a = 0.
    """
    mean = mass.sum(axis=0) @ section_nodes / mass.sum()
    W = np.zeros((len(section_nodes), 3))
    W[:, 1:] = mass @ (section_nodes - mean)
    return W


def section_rotation(x: Array, W: Array) -> Array:
    """Rotation of a deformed section, the polar factor of int (x - x_mean)(X - X_mean)^T dA.

    Takes positions (..., ns, 3) [m]; returns (..., 3, 3) with determinant +1. The matrix has rank 2: the
    determinant decides the sign of the third direction.
    """
    U, _, Vt = np.linalg.svd(x.swapaxes(-1, -2) @ W)
    U[..., 2] *= (np.linalg.det(U) * np.linalg.det(Vt))[..., None]
    return U @ Vt


@dataclass(frozen=True, eq=False)
class SectionSpin:
    """Polar rotation of a section and its linearisation.

    `R` (3, 3), `V` (3, 3) [m^4], `G_inv` (3, 3) [m^-4], `a` (ns, 3) [m^3], `w_x` (ns, 3, 3) [1/m]: the spin
    of R is sum_a w_x[a] dx_a, from G w = sum_a a_a x dx_a.
    """

    R: Array
    V: Array
    G_inv: Array
    a: Array
    w_x: Array


def section_spin(x: Array, W: Array) -> SectionSpin:
    """Polar rotation of the section at x (ns, 3) [m] and its derivative."""
    R = section_rotation(x, W)
    V = x.T @ W @ R.T
    G_inv = np.linalg.inv(np.trace(V) * np.eye(3) - V)
    a = W @ R.T
    return SectionSpin(R, V, G_inv, a, G_inv @ hat(a))


def couple_force(spin: SectionSpin, moment: Array, follower_moment: Array) -> tuple[Array, Array]:
    """Nodal forces of a couple M = moment + R follower_moment, f_a = mu x (R W_a), and their tangent.

    Parameters
    ----------
    spin : SectionSpin
        Of the end section.
    moment : (3,) [N m]
        Fixed in space.
    follower_moment : (3,) [N m]
        Turns with R; components in the reference.

    Returns
    -------
    force : (ns, 3) [N]
        Its sum is zero and sum_a x_a x f_a = M; its power is M . w with w the spin of R.
    tangent : (3 ns, 3 ns) [N/m]
        df/dx. Unsymmetric unless the problem is planar.

    Notes
    -----
    dmu = G^-1 (dM - tr(dV) mu + dV mu), dV = dA_x R^T - V hat(w), dM = w x R follower_moment.
    """
    carried = spin.R @ follower_moment
    mu = spin.G_inv @ (moment + carried)
    mu_hat, a_hat = hat(mu), hat(spin.a)
    force = spin.a @ mu_hat.T
    stretch = mu[:, None] * spin.a[:, None, :] - (spin.a @ mu)[:, None, None] * np.eye(3)
    mu_x = -spin.G_inv @ (stretch + (hat(carried) - spin.V @ mu_hat) @ spin.w_x)
    f_w = mu_hat @ a_hat
    tangent = -np.einsum("aij,bjk->aibk", a_hat, mu_x) - np.einsum("aij,bjk->aibk", f_w, spin.w_x)
    return force, tangent.reshape(force.size, force.size)


def resultant_force(
    spin: SectionSpin, share: Array, force: Array, follower_force: Array
) -> tuple[Array, Array]:
    """Nodal forces of an even traction with the resultant force + R follower_force, and their tangent.

    f_a = share_a (force + R follower_force), df_a = share_a w x R follower_force; `share` (ns,) [-] is the
    part of the area that belongs to a node, sum 1. Returns (ns, 3) [N] and (3 ns, 3 ns) [N/m].
    """
    carried = spin.R @ follower_force
    tangent = -np.einsum("a,ij,bjk->aibk", share, hat(carried), spin.w_x)
    nodal = share[:, None] * (force + carried)
    return nodal, tangent.reshape(nodal.size, nodal.size)
