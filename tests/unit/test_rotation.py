"""Exponential, logarithm, polar rotation of a section and its spin, against SciPy and differences."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

from ancf.rotation import exp, hat, log, section_rotation
from tests.strategies import vectors


@given(vectors(7.0))
def test_exponential_is_scipys(v):
    """SciPy's Rotation is an independent implementation."""
    np.testing.assert_allclose(exp(v), Rotation.from_rotvec(v).as_matrix(), atol=2e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 0.99e-4, 1.01e-4, 1.0, np.pi - 1e-9, np.pi])
def test_exponential_and_logarithm_through_the_thresholds(angle):
    """Series and closed form meet; the logarithm keeps its digits at pi, where the trace formula has none."""
    axis = np.array([0.48, -0.6, 0.64])
    R = exp(angle * axis)
    np.testing.assert_allclose(R, Rotation.from_rotvec(angle * axis).as_matrix(), atol=1e-15)
    back = log(R)
    if abs(angle - np.pi) < 1e-15:
        back = back * np.sign(back @ axis)  # at pi both signs are right
    np.testing.assert_allclose(back, angle * axis, atol=1e-14)


@given(vectors(3.1))
def test_logarithm_is_scipys(v):
    R = Rotation.from_rotvec(v).as_matrix()
    found = log(R)
    assert np.linalg.norm(found) <= np.pi + 1e-12
    np.testing.assert_allclose(exp(found), R, atol=1e-14)


@pytest.mark.parametrize("angle", [1e-9, 1e-6, 9e-5, 1.1e-4, 2.09, 2.1])
def test_logarithm_keeps_its_digits_where_its_formulas_meet(angle):
    """On both sides of the series for small angles and of 120 degrees."""
    v = angle * np.array([0.6, 0.0, -0.8])
    np.testing.assert_allclose(log(exp(v)), v, rtol=0, atol=1e-12 * angle)


def test_batches_are_the_single_results():
    """To rounding: numpy adds up in another order in another shape. Angles on both sides of 120 degrees."""
    v = np.random.default_rng(0).normal(size=(2, 3, 3))
    angles = np.linalg.norm(v, axis=-1)
    assert angles.min() < 2.0 < 2.2 < angles.max()
    for i in np.ndindex(2, 3):
        np.testing.assert_allclose(exp(v)[i], exp(v[i]), rtol=0, atol=1e-15)
        np.testing.assert_allclose(log(exp(v))[i], log(exp(v[i])), rtol=0, atol=1e-15)


@given(vectors(), vectors())
def test_hat_is_the_cross_product(a, b):
    np.testing.assert_allclose(hat(a) @ b, np.cross(a, b), atol=1e-15)


def weights_and_directors(seed):
    rng = np.random.default_rng(seed)
    W = np.zeros((3, 3))
    W[1:] = np.array([[2.0, 0.3], [0.3, 1.0]]) @ Rotation.random(rng=rng).as_matrix()[1:]
    return W, Rotation.random(rng=rng).as_matrix(), rng


@given(st.integers(0, 2**20))
def test_a_turned_section_has_that_rotation(seed):
    """d_k = R E_k with E the reference: the polar rotation is R, whatever the weights."""
    W, R, rng = weights_and_directors(seed)
    E = np.linalg.solve(np.array([[2.0, 0.3], [0.3, 1.0]]), W[1:])
    d = np.vstack([rng.normal(size=3), E @ R.T])
    np.testing.assert_allclose(section_rotation(d, W).R, R, atol=1e-13)


@given(st.integers(0, 2**20))
def test_the_rotation_is_the_polar_factor(seed):
    """R maximises sum_k d_k . R W_k: compare with SciPy's polar factor of A + a tiny completion along the
    normals.
    """
    W, R, rng = weights_and_directors(seed)
    d = np.vstack([np.zeros(3), np.linalg.solve(np.array([[2.0, 0.3], [0.3, 1.0]]), W[1:]) @ R.T])
    d[1:] += 0.2 * rng.normal(size=(2, 3))
    found = section_rotation(d, W)
    A = d.T @ W
    normal, reference = np.cross(d[1], d[2]), np.cross(W[1], W[2])
    completed = A + 1e-3 * np.outer(normal, reference)
    np.testing.assert_allclose(found.R, polar(completed)[0], atol=1e-10)
    assert np.linalg.det(found.R) == pytest.approx(1.0, abs=1e-13)
    np.testing.assert_allclose(found.V, found.V.T, atol=1e-13)
    np.testing.assert_allclose(found.V @ found.R, A, atol=1e-12)


@given(st.integers(0, 2**20))
def test_the_spin_is_the_derivative_of_the_rotation(seed):
    """dw from `spin` against the rotation between d + t dd and d - t dd, error of order t^2."""
    W, R, rng = weights_and_directors(seed)
    d = np.vstack([np.zeros(3), W[1:] @ R.T]) + 0.1 * rng.normal(size=(3, 3))
    dd = rng.normal(size=(3, 3))
    dw = np.einsum("ikc,kc->i", section_rotation(d, W).spin(), dd)
    errors = []
    for t in (1e-2, 5e-3):
        turn = section_rotation(d + t * dd, W).R @ section_rotation(d - t * dd, W).R.T
        errors.append(np.abs(Rotation.from_matrix(turn).as_rotvec() / (2 * t) - dw).max())
    assert errors[1] < 1e-9 or 3.4 < errors[0] / errors[1] < 4.6  # halving t divides the error by 4
    assert errors[1] < 1e-2
