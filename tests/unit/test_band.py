"""Band storage and LU against dense linear algebra."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ancf.band import BandPattern, SingularMatrixError, cholesky, factorise


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


@given(st.integers(1, 12), st.integers(0, 11), st.integers(0, 2**20))
def test_cholesky_is_lu_where_all_eigenvalues_are_positive(n, b, seed):
    """And gives up where one is not; LU of the same storage then goes on."""
    dense, pattern, _ = band(n, min(b, n - 1), seed)
    dense = dense + dense.T
    for shift in (1.0 - np.linalg.eigvalsh(dense)[0], -0.5 - np.linalg.eigvalsh(dense)[0]):
        matrix = dense + shift * np.eye(n)
        flat = np.zeros(pattern.entries)
        i, j = np.nonzero(matrix)
        flat[pattern.slots(i, j)] = matrix[i, j]
        factor = cholesky(pattern, flat)
        if shift < 1.0 - np.linalg.eigvalsh(dense)[0]:
            assert factor is None
            continue
        assert factor is not None
        for right in (np.arange(1.0, n + 1), np.eye(n)):
            np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-10)
        lu = factorise(pattern, flat)
        assert factor.determinant_sign == lu.determinant_sign == 1
        assert factor.log_determinant == pytest.approx(lu.log_determinant, abs=1e-9)


def test_views_of_blocks_are_their_slots():
    """Blocks of 5 that begin every 3 from the second unknown on."""
    pattern = BandPattern(11, 4)
    flat = np.arange(float(pattern.entries))
    dofs = 1 + np.array([0, 3])[:, None] + np.arange(5)
    view = pattern.blocks(flat, first=1, step=3, size=5, count=2)
    np.testing.assert_array_equal(view, flat[pattern.block_slots(dofs)])


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
