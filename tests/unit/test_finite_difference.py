"""The paper's numerical tangent on a function with a known derivative."""

import numpy as np

from ancf.finite_difference import difference_tangent


def test_derivative_of_a_known_function():
    """Q = c sin(A e): dQ/de = c cos(A e) A; central differences with cbrt(eps) steps err by some 1e-10."""
    rng = np.random.default_rng(0)
    A, e = rng.normal(size=(2, 6, 6)), rng.normal(size=(2, 2, 3))

    def force(e):
        return np.sin(np.einsum("mij,mj->mi", A, e.reshape(2, 6))).reshape(2, 2, 3)

    expected = np.cos(np.einsum("mij,mj->mi", A, e.reshape(2, 6)))[:, :, None] * A
    np.testing.assert_allclose(difference_tangent(force, e, np.ones_like(e)), expected, atol=1e-8)


def test_steps_follow_the_units():
    """A coordinate of size 1e-6 gets a step of that size: with a step of 1e-5 the cubic would err by more
    than itself.
    """
    e, unit = np.full((1, 1, 3), 1e-6), np.array([[[1e-6, 1e-6, 1.0]]])
    K = difference_tangent(lambda e: e**3, e, unit)
    np.testing.assert_allclose(np.diagonal(K[0])[:2], 3e-12, rtol=1e-6)
