"""End couple of a solid rod that is conjugate to the polar rotation of its end section.

Symbols: `W` section moments (ns, 3), `A_x` = sum_a x_a W_a^T, `R` its polar factor, `V` = A_x R^T
(symmetric), `G` = tr(V) I - V, `mu` = G^-1 M, `a` = R W_a. No rigid end plate: a plate stiffens the rod by
O(R/L) and hides the O((kappa R)^2) difference between solid and beam.
"""

from __future__ import annotations

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

    Takes positions (ns, 3) [m]; returns (3, 3) with determinant +1. The matrix has rank 2: the determinant
    decides the sign of the third direction.
    """
    U, _, Vt = np.linalg.svd(x.T @ W)
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    return U @ np.diag([1.0, 1.0, sign]) @ Vt


def couple_force(x: Array, W: Array, moment: Array) -> tuple[Array, Array]:
    """Nodal forces of a couple that is fixed in space, f_a = mu x (R W_a), and their tangent.

    Parameters
    ----------
    x : (ns, 3) [m]
        Positions of the end section's nodes.
    W : (ns, 3) [m^3]
        Section moments.
    moment : (3,) [N m]
        The couple, components in space.

    Returns
    -------
    force : (ns, 3) [N]
        Its sum is zero and sum_a x_a x f_a = moment; its power is moment . w with w the spin of R.
    tangent : (3 ns, 3 ns) [N/m]
        df/dx. Unsymmetric unless the problem is planar.

    Notes
    -----
    G w = sum_a (R W_a) x dx_a gives the spin; dmu = -G^-1 (tr(dV) mu - dV mu), dV = dA_x R^T - V hat(w).
    """
    A_x = x.T @ W
    R = section_rotation(x, W)
    V = A_x @ R.T
    G_inv = np.linalg.inv(np.trace(V) * np.eye(3) - V)
    mu = G_inv @ moment
    a = W @ R.T
    mu_hat = hat(mu)
    force = a @ mu_hat.T

    a_hat = hat(a)
    w_x = G_inv @ a_hat  # (ns, 3, 3): spin by nodal displacement
    stretch = mu[:, None] * a[:, None, :] - (a @ mu)[:, None, None] * np.eye(3)
    mu_x = -G_inv @ (stretch - V @ mu_hat @ w_x)
    f_w = mu_hat @ a_hat
    tangent = -np.einsum("aij,bjk->aibk", a_hat, mu_x) - np.einsum("aij,bjk->aibk", f_w, w_x)
    return force, tangent.reshape(3 * len(x), 3 * len(x))
