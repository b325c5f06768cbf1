"""What holds of every effect: exact derivatives, and forces that turn with the rod and balance."""

import numpy as np
import pytest

from ancf.rotation import exp


def blocks(model, effect, q=None):
    """Nodal vectors of the effect's blocks at q, or at the reference."""
    q = model.q0 if q is None else q
    return q[effect.dofs].reshape(len(effect.dofs), -1, 3)


def check_derivatives(model, strain, step):
    """K = dQ/de by central differences at a random state; Q = -dV/de and K symmetric where there is a V."""
    (effect,) = model.effects
    rng = np.random.default_rng(3)
    e = blocks(model, effect)
    units = blocks(model, effect, model.unit)
    e = e + strain * rng.uniform(-1, 1, e.shape) * units
    way = rng.uniform(-1, 1, e.shape) * units
    Q, K = effect.force_and_tangent(e)
    np.testing.assert_array_equal(Q, effect.force(e))
    change = (effect.force(e + step * way) - effect.force(e - step * way)) / (2 * step)
    found = np.einsum("mij,mj->mi", K, way.reshape(len(K), -1)).reshape(change.shape)
    np.testing.assert_allclose(found, change, rtol=0, atol=1e-7 * np.abs(change).max())
    if effect.potential(e) is None:
        return
    slope = (effect.potential(e + step * way) - effect.potential(e - step * way)) / (2 * step)
    assert -np.sum(Q * way) == pytest.approx(slope, rel=1e-7)
    np.testing.assert_allclose(K, np.swapaxes(K, 1, 2), rtol=0, atol=1e-12 * np.abs(K).max())


def check_rigid_motion(model, measure, numbers, same, turned, balance, arm=1.0):
    """A rigid motion leaves `measure(effect, e)`; forces turn with it, and balance by themselves.

    For 3333, whose nodes carry r, r_y, r_z. numbers : rotation vector and shift (6,). Rounding: same, of the
    measure, relative; turned, balance, of the forces [N], of couples times the arm.
    """
    (effect,) = model.effects
    q = model.q0.reshape(-1, 3)
    turn, shift = exp(np.array(numbers[:3])), np.array(numbers[3:])
    moved = q @ turn.T
    moved[::3] += shift
    here, there = (blocks(model, effect, state.ravel()) for state in (q, moved))
    assert measure(effect, there) == pytest.approx(measure(effect, here), rel=same)
    forces = [effect.force(e) for e in (here, there)]
    np.testing.assert_allclose(forces[1], forces[0] @ turn.T, rtol=0, atol=turned)
    np.testing.assert_allclose(forces[0][:, ::3].sum(axis=(0, 1)), 0.0, atol=balance)
    np.testing.assert_allclose(np.cross(here, forces[0]).sum(axis=(0, 1)), 0.0, atol=balance * arm)
