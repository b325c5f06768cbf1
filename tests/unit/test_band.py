"""Band storage and LU against dense linear algebra."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ancf.band import BandPattern, SingularMatrixError, factorise


def band(n, b, seed):
    """A random dense band matrix and the same in flat storage, filled entry by entry."""
    rng = np.random.default_rng(seed)
    dense = np.array([[rng.normal() if abs(i - j) <= b else 0.0 for j in range(n)] for i in range(n)])
    pattern = BandPattern(n, b)
    flat = np.zeros(pattern.entries)
    i, j = np.nonzero(dense)
    flat[pattern.slots(i, j)] = dense[i, j]
    return dense, pattern, flat


@given(st.integers(1, 12), st.integers(0, 11), st.integers(0, 2**20))
def test_solve_and_determinant_sign_are_the_dense_ones(n, b, seed):
    dense, pattern, flat = band(n, min(b, n - 1), seed)
    lu = factorise(pattern, flat)
    for right in (np.arange(1.0, n + 1), np.eye(n)):
        np.testing.assert_allclose(dense @ lu.solve(right), right, atol=1e-9 * np.linalg.cond(dense))
        z = lu.solve(right, transposed=True)
        np.testing.assert_allclose(dense.T @ z, right, atol=1e-9 * np.linalg.cond(dense))
    assert lu.determinant_sign == np.sign(np.linalg.det(dense))


def test_blocks_add_up_where_they_overlap():
    dofs = np.array([[0, 1, 2], [2, 3, 4]])
    pattern = BandPattern(5, 2)
    blocks = np.random.default_rng(0).normal(size=(2, 3, 3)) + 3 * np.eye(3)
    flat = np.bincount(pattern.block_slots(dofs).ravel(), blocks.ravel(), minlength=pattern.entries)
    dense = np.zeros((5, 5))
    for d, block in zip(dofs, blocks, strict=True):
        dense[np.ix_(d, d)] += block
    np.testing.assert_allclose(
        factorise(pattern, flat).solve(dense @ np.arange(5.0)), np.arange(5.0), atol=1e-12
    )


def test_singular_matrix_is_named():
    pattern = BandPattern(3, 1)
    flat = np.zeros(pattern.entries)
    flat[pattern.slots(np.array([0, 2]), np.array([0, 2]))] = 1.0
    with pytest.raises(SingularMatrixError, match="zero pivot at unknown 1"):
        factorise(pattern, flat)
